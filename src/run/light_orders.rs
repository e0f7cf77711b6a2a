//! What light between the yarns does to the model's row of Table 1, traced for it.

use super::light::bounces;
use super::{Plan, RunError, SpectralCurves};
use crate::cloth::light::Integrator;
use crate::compare::ColourRatios;
use crate::rig::Geometry;
use crate::yarn::{Effort, YarnResponse};

/// Share of the study's paths and particles, and their batches.
const SHARE: u64 = 4;
const BATCHES: usize = 8;

/// Traces the ratios of the model with direct light alone, and with all light between the yarns. After `traced`
/// batches, fewer than the study has, there are fewer paths here too.
///
/// # Errors
/// None for a study that a plan was made of.
pub fn light_orders(plan: &Plan, traced: usize) -> Result<[ColourRatios; 2], RunError> {
    let batches = BATCHES.min(plan.direct_effort.batches);
    let study = &plan.study.trace;
    let scaled = |paths: u64| {
        let paths = paths / SHARE * traced.min(plan.direct_effort.batches) as u64;
        (paths / plan.direct_effort.batches as u64).max(batches as u64)
    };
    let effort = Effort::new(plan.study.seed, batches, scaled(study.paths_direct))?;
    let tracers = plan.direct_tracers(effort)?;
    let particles = scaled(study.particles).div_ceil(batches as u64) as usize;
    let (camera, between) = (plan.direct(), bounces(plan, usize::MAX, particles));
    let beams = plan.beams(&[Geometry::NORMAL]);
    let wavelengths = plan.grid.len();
    let [mut direct, mut all] = [Vec::new(), Vec::new()];
    for batch in 0..batches {
        let responses: Vec<YarnResponse> = tracers.iter().map(|tracer| tracer.batch(batch).response).collect();
        let seen = camera.brightness(&responses, beams.lit(), batch)?;
        let goes_on = between.brightness(&responses, beams.lit(), batch)?;
        direct.push(beams.sum(&seen, wavelengths));
        all.push(beams.sum(seen.iter().chain(&goes_on), wavelengths));
    }
    let ratios = |diffuse| SpectralCurves::new(plan, vec![Geometry::NORMAL], diffuse).diffuse_ratios(&plan.colour, 0);
    Ok([ratios(direct)?, ratios(all)?])
}
