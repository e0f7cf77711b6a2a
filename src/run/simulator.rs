use super::light::bounces;
use super::memory::BATCHES_UNDER_WAY;
use super::{Plan, RunError, Stage, check_memory};
use crate::cloth::light::{ClothLedger, Integrator, LitBatch, Volumetric};
use crate::rig::{BeamsOfRig, Geometry};
use crate::study::{MethodChoice, ShadeWith};
use crate::transport::Ledger;
use crate::yarn::{DirectTracer, EnergyTracer, PatchTracer, Yarn, YarnResponse};

/// What one batch of light through yarn, cloth and rig gives. Nothing in it grows with the number of paths.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// Energy ledgers: traced incident direction × wavelength, wavelength fastest.
    pub ledgers: Vec<Ledger>,
    /// Diffuse β at `[geometry][wavelength]`.
    pub diffuse: Vec<Vec<f64>>,
    /// Where light went in the cloth, where it was followed from yarn to yarn: [incidence × wavelength].
    pub cloth: Vec<ClothLedger>,
}

/// Makes batches: each traces the yarn and shades the cloth with what it found.
pub struct Simulator<'a> {
    pub(super) plan: &'a Plan,
    geometries: Vec<Geometry>,
    energy: EnergyTracer<'a>,
    /// One for each f* that differs; none where light goes through the media.
    tracers: Vec<ResponseTracer<'a>>,
    /// Ways to follow light whose brightness factors add up.
    integrators: Vec<Box<dyn Integrator + 'a>>,
    /// Whether one of them keeps a ledger.
    follows: bool,
    beams: BeamsOfRig,
}

/// What traces the f* of one yarn that the study shades with.
enum ResponseTracer<'a> {
    Direct(DirectTracer<'a>),
    Bssrdf(PatchTracer<'a>),
}

impl<'a> Simulator<'a> {
    /// Batches to have under way at once; each holds a table of f*.
    pub const ROUND: usize = BATCHES_UNDER_WAY;

    /// # Errors
    /// A study whose tables do not fit into the memory that is free.
    pub fn new(plan: &'a Plan, geometries: Vec<Geometry>) -> Result<Self, RunError> {
        check_memory(&plan.study, Stage::Views)?;
        let shading = |yarn: &'a Yarn| -> Result<ResponseTracer<'a>, RunError> {
            Ok(match plan.study.trace.shade_with {
                ShadeWith::Direct => {
                    ResponseTracer::Direct(DirectTracer::new(yarn, plan.factor_grid, plan.direct_effort, None)?)
                }
                ShadeWith::Bssrdf => ResponseTracer::Bssrdf(PatchTracer::new(
                    yarn,
                    plan.bssrdf_grid(yarn)?,
                    plan.factor_grid,
                    plan.bssrdf_effort,
                )?),
            })
        };
        let batches = u64::from(plan.study.trace.batches);
        let of_batch = |particles: u64| particles.div_ceil(batches) as usize;
        let most = plan.study.cloth.bounces.most();
        let shines = plan.study.specular.surface.is_of_yarns();
        let goes_on = plan.light_goes_on();
        let mut integrators: Vec<Box<dyn Integrator + 'a>> = Vec::new();
        let mut tracers = Vec::new();
        match plan.study.cloth.method {
            MethodChoice::RadianceFactor => {
                tracers = plan.different_yarns().map(shading).collect::<Result<_, _>>()?;
                integrators.push(Box::new(plan.direct()));
                if goes_on {
                    integrators.push(Box::new(bounces(plan, most, of_batch(plan.study.trace.particles))));
                }
            }
            MethodChoice::Volumetric => {
                let particles = of_batch(plan.study.trace.particles_volumetric);
                integrators.push(Box::new(Volumetric::new(plan.scene(shines, true), particles)?));
            }
        }
        Ok(Self {
            beams: plan.beams(&geometries),
            tracers,
            integrators,
            follows: goes_on || plan.study.cloth.method == MethodChoice::Volumetric,
            plan,
            geometries,
            energy: EnergyTracer::new(&plan.yarn, plan.incident, plan.bssrdf_effort, None)?,
        })
    }

    pub fn geometries(&self) -> &[Geometry] {
        &self.geometries
    }

    /// Incidences and wavelengths of the ledgers of a batch's cloth; no incidence where light is not followed from yarn
    /// to yarn.
    pub fn cloth_shape(&self) -> [usize; 2] {
        let incidences = if self.follows { self.beams.lit().len() } else { 0 };
        [incidences, self.plan.grid.len()]
    }

    /// Incidences in the order of [`Batch::cloth`], degrees.
    pub fn incidences_deg(&self) -> Vec<f64> {
        let of_geometry = |place: usize| self.geometries[place].theta_i_deg;
        self.beams.first_of_beams().map(of_geometry).collect()
    }

    /// Traced incident directions and wavelengths of a batch's ledgers.
    pub fn ledger_shape(&self) -> [usize; 2] {
        [self.plan.incident.traced(), self.plan.grid.len()]
    }

    /// Batch number `batch`, the same whenever and wherever it is made.
    ///
    /// # Errors
    /// None for a study that a plan was made of.
    pub fn batch(&self, batch: usize) -> Result<Batch, RunError> {
        let ledgers = self.energy.batch(batch).ledgers;
        let (diffuse, cloth) = self.light(batch)?;
        Ok(Batch {
            ledgers,
            diffuse,
            cloth,
        })
    }

    /// [`Simulator::batch`] without the energy ledger of the yarn: diffuse β at `[geometry][wavelength]`, and where the
    /// light went in the cloth.
    ///
    /// # Errors
    /// None for a study that a plan was made of.
    pub fn light(&self, batch: usize) -> Result<(Vec<Vec<f64>>, Vec<ClothLedger>), RunError> {
        let response = |tracer: &ResponseTracer| match tracer {
            ResponseTracer::Direct(tracer) => tracer.batch(batch).response,
            ResponseTracer::Bssrdf(tracer) => tracer.batch(batch).response,
        };
        let responses: Vec<YarnResponse> = self.tracers.iter().map(response).collect();
        let mut parts: Vec<LitBatch> = Vec::new();
        for integrator in &self.integrators {
            parts.extend(integrator.brightness(&responses, self.beams.lit(), batch)?);
        }
        let diffuse = self.beams.sum(&parts, self.plan.grid.len());
        Ok((diffuse, parts.into_iter().flat_map(|part| part.ledger).collect()))
    }
}
