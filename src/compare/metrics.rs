use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::fault::{self, Fault};

use super::propagation::{Channels, PropagatedEstimate, Propagation, check};
use super::{Channel, CompareError, Compared, Geometry, Inputs, RmseRatio, SourceId, Verdict};
use crate::sample::Reading;

/// Which values a function of (model mean, measured) takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Slot {
    /// The mean of the model that the errors are propagated of.
    Model,
    /// A classical shading by its place.
    Classical(usize),
    Measured,
}

/// Curves of all sources beside one sample, as functions of (model mean, measured) that [`Propagation`] turns into
/// estimates.
pub(super) struct Curves<'a> {
    geometries: &'a [Geometry],
    classical: Vec<&'a [Channels]>,
    /// Which reading exists; the values come with every call.
    measured: Vec<bool>,
    reference: usize,
    normalised: bool,
}

impl<'a> Curves<'a> {
    /// Without a sample nothing is normalised. `model_means` are those of the inputs' models.
    pub(super) fn new(
        inputs: &Inputs<'a>,
        model_means: &[&[Channels]],
        sample: Option<&Compared<'a, Option<Reading>>>,
    ) -> Result<Self, CompareError> {
        let count = inputs.geometries.len();
        for shading in inputs.classical {
            check(shading.source.id.as_str(), shading.values, count)?;
        }
        let classical: Vec<&[Channels]> = inputs.classical.iter().map(|shading| shading.values).collect();
        let Some(sample) = sample else {
            return Ok(Self {
                geometries: inputs.geometries,
                classical,
                measured: vec![false; count],
                reference: 0,
                normalised: false,
            });
        };
        if sample.values.len() != count {
            return Err(CompareError::Length {
                what: sample.source.id.to_string(),
                expected: count,
                found: sample.values.len(),
            });
        }
        let reference = reference(inputs.geometries, sample.values).ok_or(CompareError::NoReading)?;
        let y = Channel::Y as usize;
        let measured = sample.values[reference].map_or(0.0, |reading| reading.beta[y]);
        let others = model_means.iter().chain(&classical);
        Ok(Self {
            geometries: inputs.geometries,
            normalised: measured > 0.0 && others.into_iter().all(|values| values[reference][y] > 0.0),
            classical,
            measured: sample.values.iter().map(Option::is_some).collect(),
            reference,
        })
    }

    /// Where sources are normalised and colour ratios taken.
    pub(super) fn reference(&self) -> usize {
        self.reference
    }

    /// Whether every source has light there; else values are absolute.
    pub(super) fn normalised(&self) -> bool {
        self.normalised
    }

    pub(super) fn theta_v_deg(&self, j: usize) -> f64 {
        self.geometries[j].theta_v_deg
    }

    /// Incidences that were measured, ascending, with the geometries measured at each, by ascending view.
    pub(super) fn incidences(&self) -> Vec<(f64, Vec<usize>)> {
        let mut order: Vec<usize> = (0..self.geometries.len()).filter(|&j| self.measured[j]).collect();
        let angles = |j: usize| (self.geometries[j].theta_i_deg, self.geometries[j].theta_v_deg);
        order.sort_by(|&a, &b| {
            let (a, b) = (angles(a), angles(b));
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        order
            .chunk_by(|&a, &b| angles(a).0 == angles(b).0)
            .map(|views| (angles(views[0]).0, views.to_vec()))
            .collect()
    }

    /// measured/source luminance at the reference; 1 for the measurement itself and where nothing is normalised.
    pub(super) fn coefficient(&self, slot: Slot, model: &[Channels], measured: &[Option<Channels>]) -> f64 {
        let channel = if fault::active(Fault::NormalisedByRed) {
            Channel::R
        } else {
            Channel::Y
        };
        let raw = |slot| self.raw(slot, self.reference, channel, model, measured);
        match slot {
            Slot::Measured => 1.0,
            _ if !self.normalised => 1.0,
            _ => raw(Slot::Measured) / raw(slot),
        }
    }

    /// Normalised β.
    pub(super) fn value(
        &self,
        slot: Slot,
        j: usize,
        channel: Channel,
        model: &[Channels],
        measured: &[Option<Channels>],
    ) -> f64 {
        self.coefficient(slot, model, measured) * self.raw(slot, j, channel, model, measured)
    }

    fn raw(&self, slot: Slot, j: usize, channel: Channel, model: &[Channels], measured: &[Option<Channels>]) -> f64 {
        let c = channel as usize;
        match slot {
            Slot::Model => model[j][c],
            Slot::Classical(place) => self.classical[place][j][c],
            Slot::Measured => measured[j].map_or(f64::NAN, |beta| beta[c]),
        }
    }

    pub(super) fn rmse(
        &self,
        slot: Slot,
        channel: Channel,
        views: &[usize],
        model: &[Channels],
        measured: &[Option<Channels>],
    ) -> f64 {
        let coefficient = self.coefficient(slot, model, measured);
        let square = |&j: &usize| {
            let value = coefficient * self.raw(slot, j, channel, model, measured);
            (value - self.raw(Slot::Measured, j, channel, model, measured)).powi(2)
        };
        (views.iter().map(square).sum::<f64>() / views.len() as f64).sqrt()
    }

    pub(super) fn mean_measured(&self, channel: Channel, views: &[usize], measured: &[Option<Channels>]) -> f64 {
        let sum: f64 = views
            .iter()
            .map(|&j| self.raw(Slot::Measured, j, channel, &[], measured))
            .sum();
        sum / views.len() as f64
    }
}

/// Angle of the highest value, by the parabola through it and its neighbours; an end of the range if it is there, NaN
/// for a flat or undefined curve. Of equal heights the first counts.
pub(super) fn peak_angle_deg(angles_deg: &[f64], values: &[f64]) -> f64 {
    /// Differences of this size, relative, are rounding.
    const FLAT: f64 = 1e-12;
    let highest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let lowest = values.iter().copied().fold(f64::INFINITY, f64::min);
    let Some(top) = values.iter().position(|v| *v == highest) else {
        return f64::NAN;
    };
    if highest - lowest <= FLAT * highest.abs() {
        return f64::NAN;
    }
    if top == 0 || top + 1 == values.len() {
        return angles_deg[top];
    }
    let (left, right) = (
        angles_deg[top] - angles_deg[top - 1],
        angles_deg[top + 1] - angles_deg[top],
    );
    let (drop_left, drop_right) = (highest - values[top - 1], highest - values[top + 1]);
    let bend = left * drop_right + right * drop_left;
    angles_deg[top] + 0.5 * (right * right * drop_left - left * left * drop_right) / bend
}

/// Relative Monte Carlo error of the model's luminance above which no verdict is given: the jackknife of a ratio holds
/// for small errors alone, and few paths leave out the rare bright ones.
const LARGEST_MODEL_ERROR: f64 = 0.25;

/// Place of the reading nearest to normal incidence and view, by the squares of its two angles, of those with light if
/// there is one.
pub fn reference(geometries: &[Geometry], measured: &[Option<Reading>]) -> Option<usize> {
    let distance = |j: usize| geometries[j].theta_i_deg.hypot(geometries[j].theta_v_deg);
    let nearest = |lit: bool| {
        let readings = std::iter::zip(0..geometries.len(), measured);
        readings
            .filter(|(_, reading)| reading.is_some_and(|reading| !lit || reading.beta[Channel::Y as usize] > 0.0))
            .map(|(j, _)| j)
            .min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
    };
    nearest(true).or_else(|| nearest(false))
}

/// Interval and verdict from ln(RMSE classical) − ln(RMSE model).
pub(super) fn ratio_of(
    log: &PropagatedEstimate,
    propagation: &Propagation,
    theta_i_deg: f64,
    channel: Channel,
    model_error: f64,
    [model, classical, sample]: [&SourceId; 3],
) -> RmseRatio {
    let too_few_paths = model_error.is_nan() || model_error > LARGEST_MODEL_ERROR;
    let half = t_quantile(log, propagation.batches()) * log.se;
    let interval = [(log.value - half).exp(), (log.value + half).exp()];
    let defined = !too_few_paths && log.value.is_finite() && interval.iter().all(|end| end.is_finite());
    RmseRatio {
        theta_i_deg,
        channel,
        model: model.clone(),
        classical: classical.clone(),
        sample: sample.clone(),
        ratio: log.value.exp(),
        interval: defined.then_some(interval),
        too_few_paths,
        verdict: match interval {
            [low, _] if defined && low > 1.0 => Verdict::Better,
            [_, high] if defined && high < 1.0 => Verdict::Worse,
            _ => Verdict::CannotTell,
        },
    }
}

/// 97.5 % quantile of Student's t. Only the Monte Carlo part was estimated from few numbers: its B − 1 degrees of
/// freedom count in proportion to its share (Welch–Satterthwaite), the measurement's errors are given.
fn t_quantile(estimate: &PropagatedEstimate, batches: usize) -> f64 {
    const NORMAL: f64 = 1.959_963_984_540_054;
    /// From here on the t quantile exceeds the normal one by less than 3e-6.
    const MANY: f64 = 1e6;
    if estimate.se_monte_carlo == 0.0 {
        return NORMAL;
    }
    let freedom = (batches as f64 - 1.0) * (estimate.se / estimate.se_monte_carlo).powi(4);
    match StudentsT::new(0.0, 1.0, freedom) {
        Ok(t) if freedom < MANY => t.inverse_cdf(0.975),
        Ok(_) => NORMAL,
        Err(_) => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parabola_peak_is_exact_on_uneven_steps() {
        let angles = [-40.0, -10.0, 5.0, 15.0, 60.0];
        let parabola = angles.map(|a: f64| 3.0 - 0.001 * (a - 7.3).powi(2));
        assert!((peak_angle_deg(&angles, &parabola) - 7.3).abs() < 1e-12);
        assert_eq!(peak_angle_deg(&angles, &angles), 60.0);
        assert_eq!(peak_angle_deg(&angles, &angles.map(|a| -a)), -40.0);
        assert!(peak_angle_deg(&angles, &[0.3; 5]).is_nan());
        assert!(peak_angle_deg(&angles, &[f64::NAN; 5]).is_nan());
        assert!(peak_angle_deg(&[], &[]).is_nan());
    }

    #[test]
    fn t_quantile_matches_tables() {
        let estimate = |mc: f64, measurement: f64| PropagatedEstimate {
            value: 0.0,
            se: mc.hypot(measurement),
            bias_monte_carlo: 0.0,
            se_monte_carlo: mc,
            se_measurement: measurement,
        };
        // Two-sided 5 % points, 7 degrees of freedom 2.3646, 28 (7 times 2 squared) 2.0484.
        assert!((t_quantile(&estimate(1.0, 0.0), 8) - 2.3646).abs() < 5e-5);
        assert!((t_quantile(&estimate(1.0, 1.0), 8) - 2.0484).abs() < 5e-5);
        assert!((t_quantile(&estimate(0.0, 1.0), 8) - 1.95996).abs() < 5e-6);
        assert!((t_quantile(&estimate(1e-3, 1.0), 8) - 1.95996).abs() < 5e-6);
    }
}
