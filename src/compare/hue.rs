use crate::number::nan_from_null;
use serde::{Deserialize, Serialize};

use super::{Channels, PropagatedEstimate, Propagation};
use crate::colour::{ColourSystem, LinearRgb};

/// Hue and chroma of model and sample at one geometry, in CIE 1976 Lab, both at the sample's luminance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HueComparison {
    /// Hue angles, 0..360 degrees.
    #[serde(deserialize_with = "nan_from_null")]
    pub model_hue_deg: f64,
    #[serde(deserialize_with = "nan_from_null")]
    pub measured_hue_deg: f64,
    /// Model less sample, −180..180 degrees.
    pub difference_deg: PropagatedEstimate,
    pub model_chroma: PropagatedEstimate,
    pub measured_chroma: PropagatedEstimate,
    /// Both are coloured (chroma above 10) and 30 degrees or more apart in hue, or one is coloured (above 20) and the
    /// other neutral (below 5); each by more than two standard errors.
    pub plainly_different: bool,
}

/// Compares the hues at a geometry, given by its place; `None` where there is no reading, no light, or no Lab.
pub fn hue(propagation: &Propagation, place: usize, colour: &ColourSystem) -> Option<HueComparison> {
    const COLOURED: f64 = 10.0;
    const STRONG: f64 = 20.0;
    const NEUTRAL: f64 = 5.0;
    const APART_DEG: f64 = 30.0;
    const SIGMAS: f64 = 2.0;
    let lab = |beta: Channels, luminance: f64| {
        let scale = luminance / beta[3];
        let rgb = LinearRgb([beta[0] * scale, beta[1] * scale, beta[2] * scale]);
        colour.lab_of_rgb(rgb).map_or([f64::NAN; 3], |lab| lab.0)
    };
    let labs = |model: &[Channels], measured: &[Option<Channels>]| {
        let sample = measured[place].unwrap_or([f64::NAN; 4]);
        [lab(model[place], sample[3]), lab(sample, sample[3])]
    };
    let chroma = |of: usize| {
        propagation.estimate(|model, measured| {
            let [_, a, b] = labs(model, measured)[of];
            a.hypot(b)
        })
    };
    let hue = |[_, a, b]: [f64; 3]| b.atan2(a).to_degrees();
    let difference = propagation.estimate(|model, measured| {
        let [model, sample] = labs(model, measured);
        (hue(model) - hue(sample) + 180.0).rem_euclid(360.0) - 180.0
    });
    let (model, sample) = (chroma(0), chroma(1));
    if !(difference.value.is_finite() && difference.se.is_finite()) {
        return None;
    }
    let above = |e: &PropagatedEstimate, limit: f64| e.value - SIGMAS * e.se > limit;
    let below = |e: &PropagatedEstimate, limit: f64| e.value + SIGMAS * e.se < limit;
    let apart = difference.value.abs() - SIGMAS * difference.se > APART_DEG;
    let one_neutral = |a: &PropagatedEstimate, b: &PropagatedEstimate| above(a, STRONG) && below(b, NEUTRAL);
    let measured: Vec<Option<Channels>> = propagation.measured_values();
    let angles = labs(propagation.model_mean(), &measured).map(|lab| hue(lab).rem_euclid(360.0));
    Some(HueComparison {
        model_hue_deg: angles[0],
        measured_hue_deg: angles[1],
        difference_deg: difference,
        model_chroma: model,
        measured_chroma: sample,
        plainly_different: apart && above(&model, COLOURED) && above(&sample, COLOURED)
            || one_neutral(&model, &sample)
            || one_neutral(&sample, &model),
    })
}
