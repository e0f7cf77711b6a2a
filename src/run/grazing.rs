use super::Plan;
use crate::geometry::Vec3;
use crate::report::{GrazingGain, Notice};
use crate::rig::{PixelSamples, RigError, omega_in, view_cell};
use crate::study::MethodChoice;
use crate::transport::{Purpose, Stream};
use crate::yarn::{ResponseWeights, WeightTally, YarnResponse};
use rand::{Rng, RngExt};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Strata of the hemisphere of views, even in cos²θ and azimuth, and of the cell, a side.
const POLAR: usize = 6;
const AROUND: usize = 12;
const PIXELS: usize = 6;
/// In place of a view, apart from the other streams of cameras.
const STREAM: usize = 1 << 40;

/// Weights of f* in ∫ L cosθ_v dω / (E⊥ cosθ_i) over the views on one side of the cloth, `side` 1 that of the light, −1
/// the other. Of shading with f* alone: L = f* E⊥ V over camera rays.
pub(crate) fn hemisphere(
    plan: &Plan,
    samples: &PixelSamples,
    rng: &mut impl Rng,
    theta_i_deg: f64,
    side: f64,
) -> ResponseWeights {
    let mut tally = WeightTally::new(plan.factor_grid);
    let exit_grid = plan.factor_grid.surface().exit();
    let light = omega_in(theta_i_deg, plan.study.cloth.azimuth_deg);
    for polar in 0..POLAR {
        for around in 0..AROUND {
            let cos2: f64 = (polar as f64 + rng.random::<f64>()) / POLAR as f64;
            let (sin_phi, cos_phi) = (TAU * (around as f64 + rng.random::<f64>()) / AROUND as f64).sin_cos();
            // Not in the plane of the cloth itself, where a ray has no place to begin.
            let cos = cos2.sqrt().max(1e-3);
            let sin = (1.0 - cos * cos).sqrt();
            let view = Vec3::new(sin * cos_phi, sin * sin_phi, side * cos);
            let mut points = Vec::with_capacity(samples.count());
            view_cell(&plan.cloth, &view, samples, rng, |interaction| {
                points.extend(interaction)
            });
            for point in points {
                if let Some(light) = point.light(&plan.cloth, &light) {
                    tally.add(&light, &exit_grid.bilinear(&point.omega_out_local));
                }
            }
        }
    }
    // Directions even in cos²θ have the density cosθ/π.
    tally.drain(PI / (POLAR * AROUND * samples.count()) as f64 / theta_i_deg.to_radians().cos())
}

/// Fraction of the light at an incidence that shading with f* would reflect and transmit if the yarns were white and
/// scattered with equal radiance in all directions: f* = cosψ/π², whose integral ∮∫ f* cosθ dω R dφ is the 2R cosψ that
/// a yarn meets.
///
/// f* is the response of a yarn alone in the beam, applied wherever the point in view is not shadowed. At grazing
/// incidence the yarns shadow each other in part, which f* does not contain: the fraction then exceeds 1. It depends on
/// weave and incidence alone and has a standard error near 1 %.
///
/// # Errors
/// None for a study that a plan was made of.
pub fn white_albedo(plan: &Plan, theta_i_deg: f64) -> Result<f64, RigError> {
    let grid = plan.factor_grid;
    let white = YarnResponse::from_fn(grid, 1, |[tilt, ..]| grid.mean_cosine(tilt) / (PI * PI));
    let samples = PixelSamples::new(PIXELS, PIXELS)?;
    let number = STREAM + (theta_i_deg * 1e6).round() as usize;
    let sides = [1.0, -1.0].map(|side| {
        let mut rng = Stream::open(plan.study.seed, Purpose::Camera, number, usize::from(side > 0.0), 0);
        hemisphere(plan, &samples, &mut rng, theta_i_deg, side).contract(&white)[0]
    });
    Ok(sides.iter().sum())
}

/// Incidences of which [`white_albedo`] exceeds 1, where the study shades with f*.
///
/// # Errors
/// None for a study that a plan was made of.
pub fn grazing_gains(plan: &Plan) -> Result<Vec<GrazingGain>, RigError> {
    if plan.study.cloth.method == MethodChoice::Volumetric {
        return Ok(Vec::new());
    }
    let incidences = plan.rig.incidences_deg();
    let albedos: Vec<f64> = incidences
        .par_iter()
        .map(|&theta_i_deg| white_albedo(plan, theta_i_deg))
        .collect::<Result<_, _>>()?;
    let gain = |(&theta_i_deg, white_albedo)| GrazingGain {
        theta_i_deg,
        white_albedo,
    };
    let all = incidences.iter().zip(albedos).map(gain);
    Ok(all.filter(|gain| gain.white_albedo > 1.0).collect())
}

/// The notice of these gains, if there are any.
pub fn grazing_notice(gains: &[GrazingGain]) -> Option<Notice> {
    (!gains.is_empty()).then(|| Notice::GrazingGain { gains: gains.to_vec() })
}
