use super::assessment::{Assessment, Bound, Indistinct};
use super::error::FitError;
use super::parameter::FreeParameter;
use super::readings::{FitReadings, rms};
use crate::rig::Geometry;
use ndarray::Array2;
use serde::Serialize;

/// A model that can be fitted to readings, physical or classical.
pub trait Candidate {
    /// Short name in tables and files.
    fn id(&self) -> &str;

    /// Name in legends.
    fn label(&self) -> &str;

    /// # Errors
    /// [`FitError`] if the readings do not determine the model, or it fails.
    fn fit(&self, readings: &FitReadings) -> Result<Box<dyn Fitted>, FitError>;
}

/// A model with the parameters that a fit found.
pub trait Fitted {
    /// Fitted parameters; those that were held fixed are none of them.
    fn parameters(&self) -> &[FittedParameter];

    /// β in the channels of the readings that were fitted, `[geometry][channel]`, at any geometries.
    ///
    /// # Errors
    /// Those of the model.
    fn predict(&self, geometries: &[Geometry]) -> Result<Array2<f64>, FitError>;

    /// The same from each Monte Carlo batch alone, whose mean is the prediction; empty for a formula.
    ///
    /// # Errors
    /// Those of the model.
    fn batches(&self, _geometries: &[Geometry]) -> Result<Vec<Array2<f64>>, FitError> {
        Ok(Vec::new())
    }

    /// Parameters that the readings cannot tell apart.
    fn indistinct(&self) -> &[Indistinct];

    /// Whether the search ended by its tolerance.
    fn converged(&self) -> bool;

    /// Number of fitted parameters.
    fn count(&self) -> usize {
        self.parameters().len()
    }

    /// Rms of (model − measured) / uncertainty over readings, those of the fit or others.
    ///
    /// # Errors
    /// Those of the model.
    fn misfit(&self, readings: &FitReadings) -> Result<f64, FitError> {
        Ok(rms(readings.residuals(&self.predict(&readings.geometries)?)))
    }
}

/// A parameter's fitted value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FittedParameter {
    pub name: String,
    pub unit: String,
    pub value: f64,
    /// Standard error for the readings' uncertainty; none on a bound or where the readings do not determine it.
    pub se: Option<f64>,
    pub at_bound: Option<Bound>,
}

impl FittedParameter {
    /// Values with what the data say of each.
    pub fn all(parameters: &[FreeParameter], values: &[f64], assessment: &Assessment) -> Vec<Self> {
        let of = |place: usize| Self {
            name: parameters[place].name.clone(),
            unit: parameters[place].unit.clone(),
            value: values[place],
            se: assessment.se[place],
            at_bound: assessment.at_bound[place],
        };
        (0..parameters.len()).map(of).collect()
    }
}
