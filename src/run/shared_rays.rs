//! Camera rays that several media in the same cloth are seen with: traced once, shaded with the f* of each.

use super::Plan;
use crate::cloth::ClothSpec;
use crate::rig::{BeamsOfRig, CameraBatch, Geometry, PixelSamples};
use crate::yarn::{DirectTracer, YarnResponse, YarnResponseGrid};

/// Direct light at some geometries of a cloth, batch by batch. The rays depend on the weave, the rig, the seed and the
/// axes of f* alone, so points that differ in the medium share them: that saves time, and the points have the same
/// error of the camera.
pub struct SharedRays {
    of: RayKey,
    beams: BeamsOfRig,
    seen: Vec<CameraBatch>,
}

/// What the rays depend on.
#[derive(Clone, PartialEq)]
struct RayKey {
    cloth: ClothSpec,
    beams: BeamsOfRig,
    grid: YarnResponseGrid,
    responses: usize,
    pixels: PixelSamples,
    seed: u64,
    batches: usize,
}

impl RayKey {
    fn of(plan: &Plan, geometries: &[Geometry], batches: usize) -> Self {
        Self {
            cloth: plan.cloth_spec.clone(),
            beams: plan.beams(geometries),
            grid: plan.factor_grid,
            responses: plan.different_yarns().count(),
            pixels: plan.pixels,
            seed: plan.study.seed,
            batches,
        }
    }
}

impl SharedRays {
    pub fn new(plan: &Plan, geometries: &[Geometry], batches: usize) -> Self {
        let (camera, beams) = (plan.direct(), plan.beams(geometries));
        let seen = (0..batches).map(|batch| camera.look(beams.lit(), batch)).collect();
        Self {
            of: RayKey::of(plan, geometries, batches),
            beams,
            seen,
        }
    }

    /// Whether the rays are those of this plan too.
    pub fn serve(&self, plan: &Plan, geometries: &[Geometry], batches: usize) -> bool {
        self.of == RayKey::of(plan, geometries, batches)
    }

    /// Diffuse β of yarns with these f*, `[batch][geometry][wavelength]`.
    pub fn shade(&self, tracers: &[DirectTracer], wavelengths: usize) -> Vec<Vec<Vec<f64>>> {
        let of_batch = |(batch, seen): (usize, &CameraBatch)| {
            let responses: Vec<YarnResponse> = tracers.iter().map(|tracer| tracer.batch(batch).response).collect();
            self.beams.sum_of(&seen.shade(&responses), wavelengths)
        };
        self.seen.iter().enumerate().map(of_batch).collect()
    }
}
