//! The study's sweep: colour ratios of other media, each traced anew.

use super::shared_rays::SharedRays;
use super::{Plan, Progress, RunError, SpectralCurves};
use crate::compare::ColourRatios;
use crate::rig::Geometry;
use crate::study::{MediumSection, NumberOrTable};
use crate::yarn::{DirectTracer, Effort};

/// Least effort of a point of the sweep: batches, and the share of the study's paths.
const BATCHES: usize = 4;
const PATHS_SHARE: u64 = 20;

/// Ratios of the model over the sweep.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// One a medium.
    pub ratios: Vec<ColourRatios>,
    /// Paths a tilt of each medium.
    pub paths: usize,
    pub batches: usize,
}

impl Sweep {
    /// Traces each of the sweep's values alone in place of the study's, in the yarns of the warp where the weft's are
    /// of another medium. After `traced` batches, fewer than the study has, there are fewer paths here in proportion: a
    /// run that was short of time is short of it here too.
    ///
    /// # Errors
    /// A value of the sweep that is no medium.
    pub fn trace(plan: &Plan, traced: usize, progress: Progress) -> Result<Self, RunError> {
        let media = media(plan);
        let batches = BATCHES.min(plan.direct_effort.batches);
        let paths = plan.study.trace.paths_direct / PATHS_SHARE;
        let paths = match plan.direct_effort.batches {
            study if traced < study => paths / study as u64 * traced as u64,
            _ => paths,
        };
        let effort = Effort::new(plan.study.seed, batches, paths.max(1))?;
        let rays = SharedRays::new(plan, &[Geometry::NORMAL], effort.batches);
        let share = 1.0 / media.len().max(1) as f64;
        let ratios = media.iter().map(|medium| -> Result<_, RunError> {
            let warp = plan.yarn_of(medium)?;
            let tracers = std::iter::once(&warp)
                .chain(&plan.weft)
                .map(|yarn| DirectTracer::new(yarn, plan.factor_grid, effort, None))
                .collect::<Result<Vec<_>, _>>()?;
            let diffuse = rays.shade(&tracers, plan.grid.len());
            let curves = SpectralCurves::new(plan, vec![Geometry::NORMAL], diffuse);
            progress(share);
            Ok(curves.diffuse_ratios(&plan.colour, 0)?)
        });
        Ok(Self {
            ratios: ratios.collect::<Result<_, _>>()?,
            paths: effort.batches * effort.paths_per_batch,
            batches: effort.batches,
        })
    }
}

/// The study's medium with one value of the sweep each; none of the values that it has itself.
fn media(plan: &Plan) -> Vec<MediumSection> {
    let base = &plan.study.medium;
    let of = &plan.study.sweep;
    let mut media: Vec<MediumSection> = Vec::new();
    let mut vary = |values: &[f64], own: Option<f64>, set: fn(&mut MediumSection, f64)| {
        for &value in values.iter().filter(|v| Some(**v) != own) {
            let mut medium = base.clone();
            set(&mut medium, value);
            media.push(medium);
        }
    };
    vary(&of.kappa_peak, Some(base.kappa_peak), |m, v| m.kappa_peak = v);
    vary(&of.volume_fraction, Some(base.volume_fraction), |m, v| {
        m.volume_fraction = v
    });
    vary(&of.particle_diameter_nm, Some(base.particle_diameter_nm), |m, v| {
        m.particle_diameter_nm = v
    });
    vary(&of.particle_index, base.particle_index.number(), |m, v| {
        m.particle_index = NumberOrTable::Number(v)
    });
    media
}
