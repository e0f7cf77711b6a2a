use super::candidate::{Candidate, FittedParameter};
use super::error::FitError;
use super::readings::{FitReadings, rms};
use ndarray::{Array2, Axis};

/// What a model predicts of an incidence that it was not fitted to.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    pub theta_i_deg: f64,
    /// Parameters of the fit without that incidence.
    pub parameters: Vec<FittedParameter>,
    /// The prediction, at the geometries of that incidence in the order of the readings, `[geometry][channel]`.
    pub prediction: Array2<f64>,
    /// The same from each Monte Carlo batch alone; empty for a formula.
    pub batches: Vec<Array2<f64>>,
    /// Rms of (prediction − measured) / uncertainty there.
    pub misfit: f64,
}

/// For each incidence: a fit to all others, and its prediction there. None for readings of one incidence, which leave
/// nothing to fit.
///
/// # Errors
/// Those of the fits and predictions.
pub fn left_out(candidate: &dyn Candidate, readings: &FitReadings) -> Result<Vec<LeftOut>, FitError> {
    let incidences = readings.incidences_deg();
    if incidences.len() < 2 {
        return Ok(Vec::new());
    }
    let of = |theta_i_deg: f64| {
        let others = readings.subset(|geometry| geometry.theta_i_deg != theta_i_deg);
        let unseen = readings.subset(|geometry| geometry.theta_i_deg == theta_i_deg);
        let fitted = candidate.fit(&others)?;
        let prediction = fitted.predict(&unseen.geometries)?;
        Ok(LeftOut {
            theta_i_deg,
            parameters: fitted.parameters().to_vec(),
            misfit: rms(unseen.residuals(&prediction)),
            batches: fitted.batches(&unseen.geometries)?,
            prediction,
        })
    };
    incidences.into_iter().map(of).collect()
}

/// Predictions of all incidences together, in the order of the readings: the mean, and each Monte Carlo batch alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Predictions {
    pub beta: Array2<f64>,
    pub batches: Vec<Array2<f64>>,
}

impl Predictions {
    /// None if an incidence of the readings is missing. Of batches, as many as every incidence has.
    pub fn of(left_out: &[LeftOut], readings: &FitReadings) -> Option<Self> {
        let batches = left_out.iter().map(|part| part.batches.len()).min()?;
        let beta = joined(left_out, readings, |part| &part.prediction)?;
        let of_batch = |batch: usize| joined(left_out, readings, |part| &part.batches[batch]);
        Some(Self {
            beta,
            batches: (0..batches).map(of_batch).collect::<Option<_>>()?,
        })
    }
}

fn joined(left_out: &[LeftOut], readings: &FitReadings, of: impl Fn(&LeftOut) -> &Array2<f64>) -> Option<Array2<f64>> {
    let mut all = Array2::zeros(readings.beta.dim());
    let mut next = vec![0; left_out.len()];
    for (geometry, mut row) in readings.geometries.iter().zip(all.axis_iter_mut(Axis(0))) {
        let place = left_out
            .iter()
            .position(|part| part.theta_i_deg == geometry.theta_i_deg)?;
        let values = of(&left_out[place]);
        if next[place] >= values.nrows() {
            return None;
        }
        row.assign(&values.row(next[place]));
        next[place] += 1;
    }
    Some(all)
}
