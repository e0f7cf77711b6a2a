//! What a comparison takes and what it says.

use super::source::{first_classical, first_model, first_sample, is_first_classical, is_first_model, is_first_sample};
use super::{Channels, PropagatedEstimate, Source, SourceId};
use crate::number::nan_from_null;
use crate::rig::Geometry;
use crate::sample::Reading;
use serde::{Deserialize, Serialize};

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

/// A source and its brightness factors β along the geometries of [`Inputs`].
#[derive(Clone, Debug)]
pub struct Compared<'a, T> {
    pub source: &'a Source,
    pub values: &'a [T],
}

impl<'a, T> Compared<'a, T> {
    pub fn new(source: &'a Source, values: &'a [T]) -> Self {
        Self { source, values }
    }
}

/// What there is to compare.
#[derive(Clone, Debug)]
pub struct Inputs<'a> {
    pub geometries: &'a [Geometry],
    /// Independent Monte Carlo batches of equal weight, two or more; a model's value is their mean. Models err
    /// independently.
    pub models: &'a [Compared<'a, Vec<Channels>>],
    /// Free of Monte Carlo error.
    pub classical: &'a [Compared<'a, Channels>],
    /// `None` where nothing was measured.
    pub measured: &'a [Compared<'a, Option<Reading>>],
}

/// measured/source luminance at the sample's reading nearest to normal incidence and view; a perfect model has 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coefficient {
    pub source: SourceId,
    pub sample: SourceId,
    /// Of that reading.
    pub at: Geometry,
    #[serde(flatten)]
    pub factor: PropagatedEstimate,
}

/// β of one source at one geometry, multiplied by the source's normalisation coefficient. The standard error of model
/// and classical values includes that of the coefficient, hence of the measured luminance at the normal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurvePoint {
    pub theta_i_deg: f64,
    pub theta_v_deg: f64,
    pub source: SourceId,
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rmse {
    pub theta_i_deg: f64,
    pub source: SourceId,
    pub channel: Channel,
    /// Root of the mean squared difference in β.
    #[serde(flatten)]
    pub rmse: PropagatedEstimate,
    /// The same over the mean measured β of these views; `None` if that is not positive.
    pub relative: Option<PropagatedEstimate>,
    /// Views that were measured.
    pub views: usize,
    /// With which it is compared; left out where that is the first.
    #[serde(default = "first_sample", skip_serializing_if = "is_first_sample")]
    pub sample: SourceId,
}

/// View angle in degrees at which a curve is highest, by the parabola through its highest value and the two beside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Peak {
    pub theta_i_deg: f64,
    pub source: SourceId,
    pub channel: Channel,
    /// `None` for a flat curve, which has no peak.
    pub angle_deg: Option<PropagatedEstimate>,
    /// The highest value is at the first or last view: the curve may rise further outside.
    pub at_edge: bool,
    /// With which it is compared; left out where that is the first.
    #[serde(default = "first_sample", skip_serializing_if = "is_first_sample")]
    pub sample: SourceId,
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
/// model's mean square is subtracted first, so the ratio may lie a little above that of the two [`Rmse`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RmseRatio {
    pub theta_i_deg: f64,
    pub channel: Channel,
    /// Each is left out where it is the first of its kind.
    #[serde(default = "first_model", skip_serializing_if = "is_first_model")]
    pub model: SourceId,
    #[serde(default = "first_classical", skip_serializing_if = "is_first_classical")]
    pub classical: SourceId,
    #[serde(default = "first_sample", skip_serializing_if = "is_first_sample")]
    pub sample: SourceId,
    #[serde(deserialize_with = "nan_from_null")]
    pub ratio: f64,
    /// 95 % interval, symmetric in the logarithm, Student's t with the effective degrees of freedom of the batches
    /// (Welch–Satterthwaite). `None` if an RMSE is exactly 0 or `too_few_paths`. Measurement noise adds to both RMSE
    /// and draws the ratio towards 1, so the verdict errs on the side of `CannotTell`.
    pub interval: Option<[f64; 2]>,
    /// The model's luminance at this incidence, or its normalisation, is known to no better than a quarter, or paths
    /// are too few for their spread to tell: no verdict.
    pub too_few_paths: bool,
    /// Better or worse if the interval leaves out 1. Each verdict has its own chance of a false alarm, about 5 % (4 to
    /// 6 % in trials with 8 batches and noise up to half of the departures); they are not corrected for their number.
    pub verdict: Verdict,
}

/// Blue/red and green/red at one geometry; normalisation cancels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ColourRatios {
    pub blue_over_red: PropagatedEstimate,
    pub green_over_red: PropagatedEstimate,
    pub red: PropagatedEstimate,
    /// Red is within two of its standard errors of 0, or below 2 % of the largest component: a ratio to it means
    /// nothing.
    pub red_is_zero: bool,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SourceRatios {
    pub source: SourceId,
    /// At whose reference.
    #[serde(default = "first_sample", skip_serializing_if = "is_first_sample")]
    pub sample: SourceId,
    #[serde(flatten)]
    pub ratios: ColourRatios,
}

impl RmseRatio {
    /// Takes the verdict back: the batches are too few or too small for their spread to tell.
    fn withhold(&mut self) {
        self.too_few_paths = true;
        self.interval = None;
        self.verdict = Verdict::CannotTell;
    }
}

/// All that the report says of models, classical shadings and samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// Models, classical shadings and samples, in the order of the inputs.
    pub sources: Vec<Source>,
    /// Of models and classical shadings to each sample; none of a sample where a source has no light at the reference:
    /// then all values beside it are absolute.
    pub normalisation: Vec<Coefficient>,
    /// Of each sample the measured geometry nearest to normal incidence and view: of its normalisation and its colour
    /// ratios.
    pub references: Vec<Geometry>,
    /// Normalised to the first sample.
    pub curves: Vec<CurvePoint>,
    pub rmse: Vec<Rmse>,
    pub peaks: Vec<Peak>,
    pub rmse_ratios: Vec<RmseRatio>,
    pub colour_ratios: Vec<SourceRatios>,
}

impl Comparison {
    /// Takes every verdict back, where paths are too few for any.
    pub fn withhold_verdicts(&mut self) {
        self.rmse_ratios.iter_mut().for_each(RmseRatio::withhold);
    }
}
