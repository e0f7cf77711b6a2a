use super::light::{LightBetween, LitBatch, LitViews, lit_views};
use super::memory::BATCHES_UNDER_WAY;
use super::{CameraBatch, Plan, RunError, Stage, VolumetricCloth, check_memory};
use crate::compare::Geometry;
use crate::study::{MethodChoice, ShadeWith};
use crate::transport::Ledger;
use crate::woven::ClothLedger;
use crate::yarn::{DirectTracer, EnergyTracer, PatchTracer, Yarn, YarnResponse};

/// What one batch of light through yarn, cloth and rig gives. Nothing in it grows with the number of paths.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// Energy ledgers: traced incident direction × wavelength, wavelength fastest.
    pub ledgers: Vec<Ledger>,
    /// Diffuse β at [geometry][wavelength].
    pub diffuse: Vec<Vec<f64>>,
    /// Where light went in the cloth, where it was followed from yarn to yarn: [incidence × wavelength].
    pub cloth: Vec<ClothLedger>,
}

/// Makes batches: each traces the yarn and shades the cloth with what it found.
pub struct Simulator<'a> {
    pub(super) plan: &'a Plan,
    geometries: Vec<Geometry>,
    energy: EnergyTracer<'a>,
    light: Light<'a>,
    lit: Vec<LitViews>,
}

/// How the light of a batch is simulated.
enum Light<'a> {
    /// f* in the sun, and, where it is asked for, what goes on from yarn to yarn.
    RadianceFactor(Vec<Shading<'a>>, Option<LightBetween<'a>>),
    Volumetric(VolumetricCloth<'a>),
}

/// The road to the f* of one yarn that the study shades with.
enum Shading<'a> {
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
        let shading = |yarn: &'a Yarn| -> Result<Shading<'a>, RunError> {
            Ok(match plan.study.trace.shade_with {
                ShadeWith::Direct => {
                    Shading::Direct(DirectTracer::new(yarn, plan.factor_grid, plan.direct_effort, None)?)
                }
                ShadeWith::Bssrdf => Shading::Bssrdf(PatchTracer::new(
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
        let goes_on = most > 0
            || shines
            || plan
                .backing
                .as_ref()
                .is_some_and(|b| b.values().iter().any(|r| *r > 0.0));
        let light = match plan.study.cloth.method {
            MethodChoice::RadianceFactor => {
                let between = || LightBetween::new(plan, most, of_batch(plan.study.trace.particles));
                let shading = plan.different_yarns().map(shading).collect::<Result<_, _>>()?;
                Light::RadianceFactor(shading, goes_on.then(between).transpose()?)
            }
            MethodChoice::Volumetric => {
                let particles = of_batch(plan.study.trace.particles_volumetric);
                Light::Volumetric(VolumetricCloth::new(plan, particles, shines)?.on_backing())
            }
        };
        Ok(Self {
            lit: lit_views(plan, &geometries),
            light,
            plan,
            geometries,
            energy: EnergyTracer::new(&plan.yarn, plan.incident, plan.bssrdf_effort, None)?,
        })
    }

    pub fn geometries(&self) -> &[Geometry] {
        &self.geometries
    }

    /// Incidences and wavelengths of the ledgers of a batch's cloth; no incidence where light is not followed from yarn to yarn.
    pub fn cloth_shape(&self) -> [usize; 2] {
        let incidences = match &self.light {
            Light::RadianceFactor(_, None) => 0,
            _ => self.lit.len(),
        };
        [incidences, self.plan.grid.len()]
    }

    /// Incidences in the order of [`Batch::cloth`], degrees.
    pub fn incidences_deg(&self) -> Vec<f64> {
        let first = |lit: &LitViews| lit.places.first().map(|&place| self.geometries[place].theta_i_deg);
        self.lit.iter().filter_map(first).collect()
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
        let (mut diffuse, followed) = match &self.light {
            Light::RadianceFactor(shading, between) => {
                let response = |of: &Shading| match of {
                    Shading::Direct(tracer) => tracer.batch(batch).response,
                    Shading::Bssrdf(tracer) => tracer.batch(batch).response,
                };
                let responses: Vec<YarnResponse> = shading.iter().map(response).collect();
                let sunlit = CameraBatch::trace(self.plan, &self.geometries, batch).shade(&responses);
                let between = between
                    .as_ref()
                    .map(|light| light.brightness(&responses, &self.lit, batch));
                (sunlit, between.transpose()?.unwrap_or_default())
            }
            Light::Volumetric(cloth) => {
                let dark = vec![vec![0.0; self.plan.grid.len()]; self.geometries.len()];
                (dark, cloth.brightness(&self.lit, batch))
            }
        };
        let mut cloth = Vec::new();
        for (LitViews { places, .. }, LitBatch { beta, ledger }) in std::iter::zip(&self.lit, followed) {
            for (&place, beta) in places.iter().zip(beta) {
                diffuse[place].iter_mut().zip(beta).for_each(|(sum, beta)| *sum += beta);
            }
            cloth.extend(ledger);
        }
        Ok(Batch {
            ledgers,
            diffuse,
            cloth,
        })
    }
}
