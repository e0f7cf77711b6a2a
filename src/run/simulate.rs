use super::light::{LightBetween, LitBatch, LitViews, lit_views};
use super::{
    CameraBatch, Gather, Outcome, Plan, Precision, RunError, Schedule, SpectralCurves, Stage, StateFile, StopRule,
    VolumetricCloth, Watch, check_memory, gather,
};
use crate::compare::Geometry;
use crate::report::{AskedEffort, EffortNote, EnergyRow, PathsPerBatch, ReachedPrecision};
use crate::study::{MethodChoice, ShadeWith};
use crate::transport::{Ledger, LedgerEntry};
use crate::woven::ClothLedger;
use crate::yarn::{DirectTracer, EnergyTracer, IncidentGrid, PatchTracer, Yarn, YarnResponse};

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
    plan: &'a Plan,
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
    pub const ROUND: usize = 4;

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

/// All batches of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulation {
    pub curves: SpectralCurves,
    /// [batch][traced incident direction × wavelength].
    pub ledgers: Vec<Vec<Ledger>>,
    /// [batch][incidence × wavelength]; empty batches where light is not followed from yarn to yarn.
    pub cloth: Vec<Vec<ClothLedger>>,
    /// How much was traced and why no more.
    pub effort: EffortNote,
}

/// Batches of a simulation so far.
struct Simulating<'a> {
    simulator: &'a Simulator<'a>,
    watch: Watch<'a>,
    state: &'a StateFile,
    done: Vec<Batch>,
}

impl Gather for Simulating<'_> {
    type Batch = Batch;
    type Error = RunError;

    fn batches(&self) -> usize {
        self.done.len()
    }

    fn make(&self, batch: usize) -> Result<Batch, RunError> {
        self.simulator.batch(batch)
    }

    fn accept(&mut self, batch: Batch) {
        self.watch.add(&batch.diffuse);
        self.done.push(batch);
    }

    fn largest_error(&self) -> Option<f64> {
        self.watch.largest_error()
    }

    fn save(&self) -> Result<(), RunError> {
        self.state.save(self.simulator, &self.done)
    }
}

/// Traces, shades and measures until the schedule's rule says stop. `resumed` are batches an earlier run has made, from
/// number 0 on; as many of them count as a run without them would have made.
pub fn simulate(
    simulator: &Simulator,
    watch: Watch,
    resumed: Vec<Batch>,
    state: &StateFile,
    schedule: &Schedule,
) -> Result<Simulation, RunError> {
    let rule = schedule.rule;
    let mut done = Simulating {
        simulator,
        watch,
        state,
        done: Vec::new(),
    };
    for batch in resumed {
        if rule.reached(done.batches(), || done.largest_error()).is_some() {
            break;
        }
        done.accept(batch);
    }
    let outcome = gather(&mut done, schedule)?;
    let plan = simulator.plan;
    let watched = done.watch.precision();
    let (mut ledgers, mut diffuse, mut cloth) = (Vec::new(), Vec::new(), Vec::new());
    for batch in done.done {
        ledgers.push(batch.ledgers);
        diffuse.push(batch.diffuse);
        cloth.push(batch.cloth);
    }
    Ok(Simulation {
        curves: SpectralCurves::new(plan, simulator.geometries.clone(), diffuse),
        ledgers,
        cloth,
        effort: effort_note(plan, rule, &outcome, watched),
    })
}

/// What a run under this rule did; `watched` is what its largest error is of.
pub(super) fn effort_note(plan: &Plan, rule: &StopRule, outcome: &Outcome, watched: Precision) -> EffortNote {
    EffortNote {
        batches: outcome.batches,
        paths_per_batch: PathsPerBatch {
            bssrdf: plan.bssrdf_effort.paths_per_batch,
            direct: plan.direct_effort.paths_per_batch,
        },
        stopped_by: outcome.stopped_by.word().into(),
        asked: AskedEffort {
            until: rule.precision.map(|precision| precision.to_string()),
            max_time_s: rule.max_time.map(|time| time.as_secs_f64()),
            batches: rule.batches,
        },
        reached: outcome.reached.map(|largest_error| ReachedPrecision {
            tolerance: watched.tolerance.word().into(),
            of: watched.of.word().into(),
            largest_error: Some(largest_error).filter(|error| error.is_finite()),
        }),
    }
}

/// The ledger of every wavelength and incident direction, mirrored ones included, from that of every batch.
pub fn energy_rows(wavelength_nm: &[f64], incident: &IncidentGrid, batches: &[Vec<Ledger>]) -> Vec<EnergyRow> {
    let wavelengths = wavelength_nm.len();
    let entries: Vec<LedgerEntry> = (0..incident.traced() * wavelengths)
        .map(|i| LedgerEntry::from_batches(&batches.iter().map(|batch| batch[i]).collect::<Vec<_>>()))
        .collect();
    let mut rows = Vec::with_capacity(wavelengths * incident.len());
    for (wavelength, &wavelength_nm) in wavelength_nm.iter().enumerate() {
        for direction in 0..incident.len() {
            let entry = &entries[incident.representative(direction).0 * wavelengths + wavelength];
            let [theta_in_deg, phi_in_deg] = incident.angles_deg(direction);
            let [
                reflected_se,
                ballistic_se,
                scattered_se,
                absorbed_se,
                _,
                sharing_se,
                residual_se,
                roulette_se,
            ] = entry.se;
            rows.push(EnergyRow {
                wavelength_nm,
                theta_in_deg,
                phi_in_deg,
                reflected: entry.mean.reflected,
                reflected_se,
                ballistic: entry.mean.ballistic,
                ballistic_se,
                scattered: entry.mean.scattered,
                scattered_se,
                absorbed: entry.mean.absorbed,
                absorbed_se,
                roulette: entry.mean.games(),
                roulette_se,
                residual: entry.mean.residual(),
                residual_se,
                sharing: entry.mean.sharing,
                sharing_se,
            });
        }
    }
    rows
}
