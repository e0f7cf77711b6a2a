use super::{Plan, Progress, RunError};
use crate::cloth::light::{Beam, Bounces, ClothBatch, Detector, Scene, Volumetric, YarnToYarn};
use crate::yarn::YarnSampler;
use std::iter::zip;

/// Light between the yarns of a study's cloth where they scatter by f*: up to `most` yarns after the first, `particles`
/// of a beam in a batch.
pub(super) fn bounces(plan: &Plan, most: usize, particles: usize) -> Bounces<'_> {
    let scene = plan.scene(plan.study.specular.surface.is_of_yarns(), true);
    Bounces::new(scene, most, particles, plan.pixels.count())
}

/// The woven cloth with light that goes from yarn to yarn by their f*, for light from anywhere: f* of every batch,
/// traced once.
pub struct FactorCloth<'a> {
    scene: Scene<'a>,
    /// Of each batch, f* of [`Plan::different_yarns`].
    scatter: Vec<Vec<YarnSampler>>,
    particles: usize,
}

impl<'a> FactorCloth<'a> {
    /// Traces f*. `particles` of a beam in a batch.
    ///
    /// # Errors
    /// None for a study that a plan was made of.
    pub fn new(plan: &'a Plan, particles: usize, progress: Progress) -> Result<Self, RunError> {
        let tracers = plan.direct_tracers(plan.direct_effort)?;
        let batches = plan.direct_effort.batches;
        let mut scatter = Vec::with_capacity(batches);
        for batch in 0..batches {
            let of_yarns =
                zip(plan.different_yarns(), &tracers).map(|(yarn, tracer)| tracer.batch(batch).response.sampler(yarn));
            scatter.push(of_yarns.collect::<Result<Vec<_>, _>>()?);
            progress(1.0 / batches as f64);
        }
        Ok(Self {
            scene: plan.scene(true, false),
            scatter,
            particles,
        })
    }

    /// One batch of a beam, of all wavelengths of the study. Of batches that were not traced there is no f* and no
    /// light.
    pub fn batch<D: Detector>(&self, beam: &Beam, detector: &D, batch: usize) -> ClothBatch {
        let of_yarns = self.scatter.get(batch).map(Vec::as_slice).unwrap_or_default();
        let [Some(warp), Some(weft)] = [of_yarns.first(), of_yarns.last()] else {
            return ClothBatch {
                ledger: Vec::new(),
                caught: vec![Vec::new(); detector.bins()],
            };
        };
        let light = YarnToYarn {
            scene: self.scene,
            scatter: [warp, weft],
            most: usize::MAX,
        };
        light.batch(beam, detector, batch, self.particles)
    }
}

/// The woven cloth with light traced through the media of its yarns, for light from anywhere.
pub fn volumetric_cloth(plan: &Plan, particles: usize) -> Result<Volumetric<'_>, RunError> {
    Ok(Volumetric::new(plan.scene(true, false), particles)?)
}
