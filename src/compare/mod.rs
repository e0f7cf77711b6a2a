//! Model and classical shading against the measurement: curves, errors, colour ratios, each with its standard error,
//! and a verdict.

mod hue;
mod metrics;
mod propagation;

pub use hue::{HueComparison, hue};
pub use metrics::reference;
pub use propagation::{Channels, Estimate, Propagation};

use crate::number::nan_from_null;
use serde::{Deserialize, Serialize};

use crate::sample::Reading;
use metrics::{Curves, peak_angle_deg, ratio_of};

/// Direction of light and of view in the plane of incidence.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Geometry {
    /// From the cloth's normal, 0 or more.
    pub theta_i_deg: f64,
    /// Signed, negative on the light's side of the normal.
    pub theta_v_deg: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Source {
    Model,
    Classical,
    Measured,
}

/// Linear red, green, blue and luminance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Channel {
    R,
    G,
    B,
    Y,
}

impl Channel {
    pub const ALL: [Self; 4] = [Self::R, Self::G, Self::B, Self::Y];
}

/// Brightness factors β to compare; the lists run along `geometries`. At least one was measured.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    pub geometries: &'a [Geometry],
    /// Independent Monte Carlo batches of equal weight, two or more; the model's value is their mean.
    pub model_batches: &'a [Vec<Channels>],
    /// Free of Monte Carlo error.
    pub classical: &'a [Channels],
    /// `None` where nothing was measured.
    pub measured: &'a [Option<Reading>],
}

/// measured/model luminance at the reading nearest to normal incidence and view, one scalar a source; a perfect model has 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Normalisation {
    pub model: Estimate,
    pub classical: Estimate,
}

/// β of one source at one geometry, multiplied by the source's normalisation coefficient. The standard error of model
/// and classical values includes that of the coefficient, hence of the measured luminance at the normal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurvePoint {
    pub theta_i_deg: f64,
    pub theta_v_deg: f64,
    pub source: Source,
    pub channel: Channel,
    #[serde(deserialize_with = "nan_from_null")]
    pub beta: f64,
    #[serde(deserialize_with = "nan_from_null")]
    pub se: f64,
    /// A measured value that is linear between neighbouring views.
    pub interpolated: bool,
}

/// Departure of a normalised source from the measurement over the views of one incidence. Measurement noise of
/// relative size s adds to it: it does not fall below s for a perfect model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rmse {
    pub theta_i_deg: f64,
    pub source: Source,
    pub channel: Channel,
    /// Root of the mean squared difference in β.
    #[serde(flatten)]
    pub rmse: Estimate,
    /// The same over the mean measured β of these views; `None` if that is not positive.
    pub relative: Option<Estimate>,
    /// Views that were measured.
    pub views: usize,
}

/// View angle in degrees at which a curve is highest, by the parabola through its highest value and the two beside.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Peak {
    pub theta_i_deg: f64,
    pub source: Source,
    pub channel: Channel,
    /// `None` for a flat curve, which has no peak.
    pub angle_deg: Option<Estimate>,
    /// The highest value is at the first or last view: the curve may rise further outside.
    pub at_edge: bool,
}

/// How the model does beside classical shading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Verdict {
    #[serde(rename = "better")]
    Better,
    #[serde(rename = "worse")]
    Worse,
    #[serde(rename = "cannot tell")]
    CannotTell,
}

/// RMSE(classical)/RMSE(model), above 1 where the model is nearer to the measurement. The Monte Carlo noise in the
/// model's mean square is taken off first, so the ratio may lie a little above that of the two [`Rmse`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RmseRatio {
    pub theta_i_deg: f64,
    pub channel: Channel,
    #[serde(deserialize_with = "nan_from_null")]
    pub ratio: f64,
    /// 95 % interval, symmetric in the logarithm, Student's t with the effective degrees of freedom of the batches
    /// (Welch–Satterthwaite). `None` if an RMSE is exactly 0 or `too_few_paths`. Measurement noise adds to both RMSE and draws the ratio
    /// towards 1, so the verdict errs on the side of `CannotTell`.
    pub interval: Option<[f64; 2]>,
    /// The model's luminance at this incidence, or its normalisation, is known to no better than a quarter: no verdict.
    pub too_few_paths: bool,
    /// Better or worse if the interval leaves out 1. Each verdict has its own chance of a false alarm, about 5 % (4 to
    /// 6 % in trials with 8 batches and noise up to half of the departures); they are not corrected for their number.
    pub verdict: Verdict,
}

/// Blue/red and green/red at one geometry; normalisation cancels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ColourRatios {
    pub blue_over_red: Estimate,
    pub green_over_red: Estimate,
    pub red: Estimate,
    /// Red is within two of its standard errors of 0, or below 2 % of the largest component: a ratio to it means nothing.
    pub red_is_zero: bool,
}

impl ColourRatios {
    /// From r, g and b as functions of (model, measured).
    fn new(propagation: &Propagation, component: impl Fn(Channel, &[Channels], &[Option<Channels>]) -> f64) -> Self {
        /// Errors and share of the largest component within which red counts as 0.
        const SIGMAS: f64 = 2.0;
        const SHARE: f64 = 0.02;
        let [red, green, blue] =
            [Channel::R, Channel::G, Channel::B].map(|c| propagation.estimate(|a, b| component(c, a, b)));
        let over_red = |c| propagation.estimate(|a, b| component(c, a, b) / component(Channel::R, a, b));
        let largest = red.value.abs().max(green.value.abs()).max(blue.value.abs());
        Self {
            blue_over_red: over_red(Channel::B),
            green_over_red: over_red(Channel::G),
            red,
            red_is_zero: !(red.value - red.se).is_finite() || red.value.abs() <= (SIGMAS * red.se).max(SHARE * largest),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SourceRatios {
    pub source: Source,
    #[serde(flatten)]
    pub ratios: ColourRatios,
}

/// All that the report says of model, classical shading and measurement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// `None` where a source has no light at the reference: then all values are absolute.
    pub normalisation: Option<Normalisation>,
    /// The measured geometry nearest to normal incidence and view: of normalisation and colour ratios.
    pub reference: Geometry,
    pub curves: Vec<CurvePoint>,
    pub rmse: Vec<Rmse>,
    pub peaks: Vec<Peak>,
    pub rmse_ratios: Vec<RmseRatio>,
    pub colour_ratios: Vec<SourceRatios>,
}

impl Comparison {
    pub fn new(inputs: &Inputs) -> Result<Self, CompareError> {
        let propagation = Propagation::new(inputs.model_batches, inputs.measured)?;
        let curves = Curves::new(inputs, propagation.model_mean())?;
        let coefficient = |source| propagation.estimate(|model, measured| curves.coefficient(source, model, measured));
        let mut comparison = Self {
            normalisation: curves.normalised().then(|| Normalisation {
                model: coefficient(Source::Model),
                classical: coefficient(Source::Classical),
            }),
            reference: inputs.geometries[curves.reference()],
            curves: curve_points(inputs, &propagation, &curves),
            rmse: Vec::new(),
            peaks: Vec::new(),
            rmse_ratios: Vec::new(),
            colour_ratios: [Source::Model, Source::Classical, Source::Measured]
                .map(|source| SourceRatios {
                    source,
                    ratios: reference_ratios(&propagation, &curves, source),
                })
                .to_vec(),
        };
        for (theta_i_deg, views) in curves.incidences() {
            let error = comparison.model_error(&propagation, &curves, &views);
            for channel in Channel::ALL {
                comparison.add_metrics(&propagation, &curves, theta_i_deg, &views, channel, error);
            }
        }
        Ok(comparison)
    }

    /// Relative Monte Carlo error of the model's luminance over the views, rms over mean, or of its coefficient, if larger.
    fn model_error(&self, propagation: &Propagation, curves: &Curves, views: &[usize]) -> f64 {
        let estimates = views.iter().map(|&j| {
            propagation.estimate(|model, measured| curves.value(Source::Model, j, Channel::Y, model, measured))
        });
        let (squares, sum) = estimates.fold((0.0, 0.0), |(squares, sum), e| {
            (squares + e.se_monte_carlo.powi(2), sum + e.value)
        });
        let count = views.len() as f64;
        let of_views = (squares / count).sqrt() / (sum / count);
        let of_coefficient = self
            .normalisation
            .map_or(0.0, |n| n.model.se_monte_carlo / n.model.value);
        // f64::max would pass over NaN.
        if of_coefficient > of_views {
            of_coefficient
        } else {
            of_views
        }
    }

    fn add_metrics(
        &mut self,
        propagation: &Propagation,
        curves: &Curves,
        theta_i_deg: f64,
        views: &[usize],
        channel: Channel,
        model_error: f64,
    ) {
        for source in [Source::Model, Source::Classical] {
            let relative = propagation.estimate(|model, measured| {
                curves.rmse(source, channel, views, model, measured) / curves.mean_measured(channel, views, measured)
            });
            self.rmse.push(Rmse {
                theta_i_deg,
                source,
                channel,
                rmse: propagation.estimate(|model, measured| curves.rmse(source, channel, views, model, measured)),
                relative: (relative.value.is_finite() && relative.value >= 0.0).then_some(relative),
                views: views.len(),
            });
        }
        for source in [Source::Measured, Source::Model, Source::Classical] {
            let angles_deg: Vec<f64> = views.iter().map(|&j| curves.theta_v_deg(j)).collect();
            let peak = |model: &[Channels], measured: &[Option<Channels>]| {
                let values: Vec<f64> = views
                    .iter()
                    .map(|&j| curves.value(source, j, channel, model, measured))
                    .collect();
                peak_angle_deg(&angles_deg, &values)
            };
            let angle = propagation.estimate(peak);
            self.peaks.push(Peak {
                theta_i_deg,
                source,
                channel,
                angle_deg: angle.value.is_finite().then_some(angle),
                at_edge: angles_deg.first() == Some(&angle.value) || angles_deg.last() == Some(&angle.value),
            });
        }
        let square = |source, model: &[Channels], measured: &[Option<Channels>]| {
            curves.rmse(source, channel, views, model, measured).powi(2)
        };
        // Monte Carlo noise is in the model's mean square alone and would count against the model. It is taken off, but
        // no more than half: a model that is nothing but noise away from the measurement keeps a finite ratio.
        let mean_square = propagation.estimate(|model, measured| square(Source::Model, model, measured));
        let noise = mean_square.bias_monte_carlo.clamp(0.0, mean_square.value / 2.0);
        let log_ratio = propagation.estimate(|model, measured| {
            let [model, classical] = [Source::Model, Source::Classical].map(|source| square(source, model, measured));
            (classical.ln() - (model - noise).ln()) / 2.0
        });
        self.rmse_ratios
            .push(ratio_of(&log_ratio, propagation, theta_i_deg, channel, model_error));
    }
}

/// Colour ratios of a model alone, from its batches at normal incidence and view: a row of Table 1.
pub fn model_colour_ratios(batches: &[Channels]) -> Result<ColourRatios, CompareError> {
    let batches: Vec<Vec<Channels>> = batches.iter().map(|batch| vec![*batch]).collect();
    let propagation = Propagation::new(&batches, &[None])?;
    Ok(ColourRatios::new(&propagation, |channel, model, _| {
        model[0][channel as usize]
    }))
}

fn reference_ratios(propagation: &Propagation, curves: &Curves, source: Source) -> ColourRatios {
    ColourRatios::new(propagation, |channel, model, measured| {
        curves.value(source, curves.reference(), channel, model, measured)
    })
}

fn curve_points(inputs: &Inputs, propagation: &Propagation, curves: &Curves) -> Vec<CurvePoint> {
    let mut points = Vec::new();
    for source in [Source::Model, Source::Classical, Source::Measured] {
        for channel in Channel::ALL {
            for (j, geometry) in inputs.geometries.iter().enumerate() {
                let (estimate, interpolated) = match (source, &inputs.measured[j]) {
                    (Source::Measured, None) => continue,
                    (Source::Measured, Some(reading)) => {
                        let c = channel as usize;
                        ((reading.beta[c], reading.se()[c]), reading.interpolated)
                    }
                    _ => {
                        let e =
                            propagation.estimate(|model, measured| curves.value(source, j, channel, model, measured));
                        ((e.value, e.se), false)
                    }
                };
                points.push(CurvePoint {
                    theta_i_deg: geometry.theta_i_deg,
                    theta_v_deg: geometry.theta_v_deg,
                    source,
                    channel,
                    beta: estimate.0,
                    se: estimate.1,
                    interpolated,
                });
            }
        }
    }
    points
}

/// Why there is nothing to compare.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CompareError {
    #[error("a standard error needs 2 or more Monte Carlo batches, found {found}; trace in more batches")]
    TooFewBatches { found: usize },
    #[error("{what}: expected {expected} geometries, found {found}")]
    Length {
        what: String,
        expected: usize,
        found: usize,
    },
    #[error("{what}, geometry {index}: expected finite values, found {found:?}")]
    NotFinite {
        what: String,
        index: usize,
        found: Vec<f64>,
    },
    #[error("nothing of the sample was measured at the rig's geometries: expected one reading or more")]
    NoReading,
}
