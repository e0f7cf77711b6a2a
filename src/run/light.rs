use super::{Plan, Progress, RunError};
use crate::cloth::{System, Tubes};
use crate::compare::Geometry;
use crate::fault::{self, Fault};
use crate::geometry::Vec3;
use crate::rig::{omega_in, omega_out};
use crate::spectrum::Samples;
use crate::woven::{Beam, Bounces, ClothBatch, ClothLedger, Detector, Onlookers, Places, Sight, ViewCones, Volumetric};
use crate::yarn::{DirectTracer, Estimator, Sharing, YarnResponse, YarnSampler};
use rayon::prelude::*;
use std::iter::zip;

/// Light that comes onto the cloth at one of the rig's angles, and the views that look at it.
pub(crate) struct LitViews {
    pub beam: Beam,
    pub cones: ViewCones,
    /// Of the views among the geometries.
    pub places: Vec<usize>,
}

/// The geometries by incidence, in the order in which incidences first come up.
pub(super) fn lit_views(plan: &Plan, geometries: &[Geometry]) -> Vec<LitViews> {
    let azimuth_deg = plan.study.cloth.azimuth_deg;
    let half_angle = plan.study.rig.aperture_half_angle_deg.to_radians();
    let mut incidences: Vec<f64> = Vec::new();
    for geometry in geometries {
        if !incidences.contains(&geometry.theta_i_deg) {
            incidences.push(geometry.theta_i_deg);
        }
    }
    incidences
        .into_iter()
        .map(|theta_i_deg| {
            let places: Vec<usize> = (0..geometries.len())
                .filter(|&place| geometries[place].theta_i_deg == theta_i_deg)
                .collect();
            let views = places
                .iter()
                .map(|&place| omega_out(geometries[place].theta_v_deg, azimuth_deg));
            LitViews {
                beam: Beam {
                    omega_in: omega_in(theta_i_deg, azimuth_deg),
                    // Of an angle the number is the same whatever else the rig measures.
                    number: (theta_i_deg * 1e6).round() as usize,
                },
                cones: ViewCones::new(views.collect(), half_angle),
                places,
            }
        })
        .collect()
}

/// The woven cloth with light traced through the medium of its yarns.
pub struct VolumetricCloth<'a> {
    tubes: Tubes,
    /// Groups of wavelengths that share paths, in the media of warp and weft.
    sharing: Vec<[Sharing<'a>; 2]>,
    plan: &'a Plan,
    particles: usize,
    surface_reflection: bool,
    backing: Option<&'a [f64]>,
}

impl<'a> VolumetricCloth<'a> {
    /// `particles` in a batch; whether light that the yarns' surface reflects on its way in goes on, spread by the study's fibres if
    /// it has any.
    pub fn new(plan: &'a Plan, particles: usize, surface_reflection: bool) -> Result<Self, RunError> {
        // Paths go through both media, so one that parts the wavelengths parts them in both.
        let shared = plan
            .yarns()
            .iter()
            .all(|yarn| yarn.estimator_in_use() == Estimator::Shared);
        let estimator = if shared {
            Estimator::Shared
        } else {
            Estimator::Independent
        };
        let [warp, weft] = plan.yarns();
        let both = zip(warp.sharing_by(estimator)?, weft.sharing_by(estimator)?);
        Ok(Self {
            surface_reflection,
            backing: None,
            tubes: Tubes::new(&plan.cloth_spec)?,
            sharing: both.map(|(warp, weft)| [warp, weft]).collect(),
            plan,
            particles,
        })
    }

    /// On the study's backing.
    pub fn on_backing(self) -> Self {
        Self {
            backing: self.plan.backing.as_ref().map(Samples::values),
            ..self
        }
    }

    /// One batch of a beam, of all wavelengths of the study.
    pub fn batch<D: Detector>(&self, beam: &Beam, detector: &D, batch: usize) -> ClothBatch {
        let mut all = ClothBatch {
            ledger: Vec::new(),
            caught: vec![Vec::new(); detector.bins()],
        };
        for [warp, weft] in &self.sharing {
            let first = warp.first;
            let light = Volumetric {
                tubes: &self.tubes,
                interiors: [&warp.interior, &weft.interior],
                backing: self
                    .backing
                    .map(|values| &values[first..first + warp.interior.wavelengths()]),
                roulette: self.plan.yarn.roulette,
                surface: self.plan.surface(self.surface_reflection),
                seed: self.plan.study.seed,
            };
            let part = light.batch(beam, detector, first, batch, self.particles);
            all.ledger.extend(part.ledger);
            all.caught
                .iter_mut()
                .zip(part.caught)
                .for_each(|(all, more)| all.extend(more));
        }
        all
    }

    /// β of all light at the views of each incidence, and where the light went.
    pub(crate) fn brightness(&self, lit: &[LitViews], batch: usize) -> Vec<LitBatch> {
        lit.par_iter()
            .map(|LitViews { beam, cones, .. }| {
                let ClothBatch { ledger, mut caught } = self.batch(beam, cones, batch);
                for (k, caught) in caught.iter_mut().enumerate() {
                    let lost = if fault::active(Fault::ApertureLoss) { 0.97 } else { 1.0 };
                    let factor = lost * std::f64::consts::PI / cones.projected_solid_angle(k);
                    caught.iter_mut().for_each(|c| *c *= factor);
                }
                LitBatch { beta: caught, ledger }
            })
            .collect()
    }
}

/// The woven cloth with light that goes from yarn to yarn by their f*, for light from anywhere.
pub struct FactorCloth<'a> {
    tubes: Tubes,
    plan: &'a Plan,
    /// f* of [`Plan::different_yarns`] in each batch.
    scatter: Vec<Vec<YarnSampler>>,
    particles: usize,
    surface_reflection: bool,
}

impl<'a> FactorCloth<'a> {
    /// Traces f*. `particles` in a batch; whether light that the yarns' surface reflects goes on.
    pub fn new(
        plan: &'a Plan,
        particles: usize,
        surface_reflection: bool,
        progress: Progress,
    ) -> Result<Self, RunError> {
        let tracers = plan
            .different_yarns()
            .map(|yarn| DirectTracer::new(yarn, plan.factor_grid, plan.direct_effort, None))
            .collect::<Result<Vec<_>, _>>()?;
        let batches = plan.direct_effort.batches;
        let mut scatter = Vec::with_capacity(batches);
        for batch in 0..batches {
            let of_yarns =
                zip(plan.different_yarns(), &tracers).map(|(yarn, tracer)| tracer.batch(batch).response.sampler(yarn));
            scatter.push(of_yarns.collect::<Result<Vec<_>, _>>()?);
            progress(1.0 / batches as f64);
        }
        Ok(Self {
            tubes: Tubes::new(&plan.cloth_spec)?,
            plan,
            scatter,
            particles,
            surface_reflection,
        })
    }

    /// One batch of a beam, of all wavelengths of the study. Of batches that were not traced there is no f* and no light.
    pub fn batch<D: Detector>(&self, beam: &Beam, detector: &D, batch: usize) -> ClothBatch {
        let of_yarns = self.scatter.get(batch).map(Vec::as_slice).unwrap_or_default();
        let [Some(warp), Some(weft)] = [of_yarns.first(), of_yarns.last()] else {
            return ClothBatch {
                ledger: Vec::new(),
                caught: vec![Vec::new(); detector.bins()],
            };
        };
        let light = Bounces {
            tubes: &self.tubes,
            yarns: self.plan.yarns(),
            scatter: [warp, weft],
            backing: None,
            surface: self.plan.surface(self.surface_reflection),
            most: usize::MAX,
            seed: self.plan.study.seed,
        };
        light.batch(beam, detector, batch, self.particles)
    }
}

/// What one batch of light from one incidence gives.
pub(crate) struct LitBatch {
    /// [view][wavelength].
    pub beta: Vec<Vec<f64>>,
    /// At each wavelength.
    pub ledger: Vec<ClothLedger>,
}

/// Light that goes on from yarn to yarn where they scatter by f*.
pub(super) struct LightBetween<'a> {
    plan: &'a Plan,
    tubes: Tubes,
    places: Places,
    most: usize,
    particles: usize,
}

/// Pieces of yarn, and squares of the backing, within which light forgets where it came in, in radii of the thinner yarn: far
/// shorter than light goes along a yarn before it leaves, and than what yarns let through is wide.
const PIECE_RADII: f64 = 0.125;
const SQUARE_RADII: f64 = 0.25;

/// Rays of a view in a batch, however many the camera has: each point they end at takes memory for every wavelength.
const MOST_RAYS: usize = 4096;
const CROSSINGS_OF_PLAIN: usize = 4;

impl<'a> LightBetween<'a> {
    /// `most` yarns after the first; `particles` in a batch.
    pub fn new(plan: &'a Plan, most: usize, particles: usize) -> Result<Self, RunError> {
        let tubes = Tubes::new(&plan.cloth_spec)?;
        let radius_mm = plan.cloth_spec.warp_radius_mm.min(plan.cloth_spec.weft_radius_mm);
        Ok(Self {
            plan,
            places: Places::new(&tubes, PIECE_RADII * radius_mm, SQUARE_RADII * radius_mm),
            tubes,
            most,
            particles,
        })
    }

    /// β, at the views of each incidence, of light that the first yarn it met has not scattered, or not alone; the ledger is of
    /// all light. `responses` are those of the batch, one for each of [`Plan::different_yarns`].
    pub fn brightness(
        &self,
        responses: &[YarnResponse],
        lit: &[LitViews],
        batch: usize,
    ) -> Result<Vec<LitBatch>, RunError> {
        let plan = self.plan;
        let scatter = zip(plan.different_yarns(), responses)
            .map(|(yarn, response)| response.sampler(yarn))
            .collect::<Result<Vec<_>, _>>()?;
        let [Some(warp), Some(weft)] = [scatter.first(), scatter.last()] else {
            return Ok(Vec::new());
        };
        let light = Bounces {
            tubes: &self.tubes,
            yarns: plan.yarns(),
            scatter: [warp, weft],
            backing: plan.backing.as_ref().map(Samples::values),
            surface: plan.surface(plan.study.specular.surface.is_of_yarns()),
            most: self.most,
            seed: plan.study.seed,
        };
        let mut views: Vec<Vec3> = Vec::new();
        for view in lit.iter().flat_map(|lit| lit.cones.views()) {
            if !views.contains(view) {
                views.push(*view);
            }
        }
        // As many for a piece of yarn, so that a particle finds one as often, as in the cell of a plain weave.
        let crossings = [System::Warp, System::Weft].map(|system| self.tubes.yarns(system));
        let cells = (crossings[0] * crossings[1]).div_ceil(CROSSINGS_OF_PLAIN);
        let rays = plan.pixels.count().saturating_mul(cells).min(MOST_RAYS);
        let sights: Vec<Sight> = views
            .par_iter()
            .map(|view| Sight::new(&light, &self.places, view, direction_number(view), batch, rays))
            .collect();
        let between = |LitViews { beam, cones, .. }: &LitViews| {
            let sight_of = |view: &Vec3| zip(&views, &sights).find(|(known, _)| *known == view);
            let onlookers = Onlookers {
                places: &self.places,
                sights: cones
                    .views()
                    .iter()
                    .filter_map(sight_of)
                    .map(|(_, sight)| sight)
                    .collect(),
                cones,
                sunlit: true,
            };
            let (beta, ledger) = light.between(beam, &onlookers, batch, self.particles);
            LitBatch { beta, ledger }
        };
        Ok(lit.par_iter().map(between).collect())
    }
}

/// Tells views apart, whatever else the rig measures.
fn direction_number(view: &Vec3) -> usize {
    let [x, y] = [view.x, view.y].map(|c| (c * 1e6).round() as isize as usize & 0xff_ffff);
    x << 24 | y
}
