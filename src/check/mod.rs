//! The laws that a study's physics obeys, each tested: gates for a CI. Equations and tolerances: `docs/checks.md`.
//!
//! [`study`] tests a study, [`sample`](fn@sample) a measurement, [`Baseline`] against what an earlier check found; a
//! [`Checked`] is rendered by [`table`], [`junit`], [`annotations`] and serde.

mod attenuation;
mod baseline;
mod bounces;
mod camera;
mod cells;
mod cloth;
mod cylinder;
mod estimates;
mod gate;
mod ledger;
mod medium;
mod output;
mod particles;
mod reabsorption;
mod rig;
mod sample;
mod symmetry;
mod tables;
mod weave;
mod woven;

pub use baseline::{Baseline, BaselineError, Drift, Moved};
pub use gate::{Gate, Judge, Law, Place, Verdict};
pub use output::{annotations, junit, table};
pub use sample::sample;

use crate::colour::ColourError;
use crate::optics::{OpticsError, PhaseError};
use crate::report::InputDigest;
use crate::run::{Plan, Progress, RunError};
use crate::sample::SampleError;
use crate::spectrum::SpectrumError;
use crate::transport::TransportError;
use crate::yarn::{Estimator, YarnError};
use cloth::ClothEnergy;
use gate::estimates;
use serde::{Deserialize, Serialize};

/// Why a check cannot run.
#[derive(Debug, thiserror::Error)]
pub enum CheckError {
    #[error(transparent)]
    Run(Box<RunError>),
    #[error(transparent)]
    Yarn(#[from] YarnError),
    #[error(transparent)]
    Transport(#[from] TransportError),
    #[error(transparent)]
    Optics(#[from] OpticsError),
    #[error(transparent)]
    Phase(#[from] PhaseError),
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    #[error(transparent)]
    Colour(#[from] ColourError),
    #[error(transparent)]
    Sample(#[from] SampleError),
    #[error(transparent)]
    Baseline(#[from] BaselineError),
    #[error("the study cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
    #[error("the JUnit file cannot be written: {0}")]
    Xml(#[from] std::io::Error),
    #[error("--paths: expected at least {least}, found {found}; with fewer the spread of the batches means nothing")]
    TooFewPaths { least: u64, found: u64 },
}

impl From<RunError> for CheckError {
    fn from(error: RunError) -> Self {
        Self::Run(Box::new(error))
    }
}

/// How much a check traces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CheckEffort {
    /// Paths of the shared ledger for each traced direction; the other gates take shares or multiples of them.
    pub paths: u64,
}

impl CheckEffort {
    const STANDARD: u64 = 96_000;
    const LEAST: u64 = 64 * Self::BATCHES as u64;
    /// Enough for a standard error that is itself good to 9 %.
    const BATCHES: usize = 64;
    const CLOTH_BATCHES: usize = 16;

    pub fn standard() -> Self {
        Self { paths: Self::STANDARD }
    }

    /// An eighth of the paths.
    pub fn quick() -> Self {
        Self {
            paths: Self::STANDARD / 8,
        }
    }

    /// # Errors
    /// Too few for the batches.
    pub fn of_paths(paths: u64) -> Result<Self, CheckError> {
        if paths < Self::LEAST {
            return Err(CheckError::TooFewPaths {
                least: Self::LEAST,
                found: paths,
            });
        }
        Ok(Self { paths })
    }

    /// Of tolerances: --quick asks for less, and says so, instead of not telling.
    fn widening(self) -> f64 {
        if self == Self::quick() { 8f64.sqrt() } else { 1.0 }
    }
}

/// What the gates of a study need.
pub struct Context<'a> {
    plan: &'a Plan,
    judge: Judge,
    batches: usize,
    cloth_batches: usize,
    /// Factor of the stochastic tolerances.
    widening: f64,
}

/// What shared paths carry is good to parts in 10⁶ of the incident flux (`transport::spectral`), what the others carry to
/// rounding.
const SINGLE_PRECISION: f64 = 1e-6;
const DOUBLE_PRECISION: f64 = 1e-12;

/// Laws in the mean, which have a chance to break: the false alarms of a run are divided between them.
const IN_THE_MEAN: [Law; 11] = [
    medium::ANGLE,
    cylinder::LAW,
    ledger::SHARING,
    ledger::ROULETTE,
    tables::ROADS,
    symmetry::RECIPROCITY,
    symmetry::MIRROR,
    bounces::BOUNCES,
    bounces::VIEWS,
    cloth::ENERGY,
    cloth::ALBEDO,
];

impl<'a> Context<'a> {
    fn new(plan: &'a Plan, effort: CheckEffort) -> Self {
        Self {
            plan,
            judge: Judge {
                level: plan.study.check.false_alarms / IN_THE_MEAN.len() as f64,
                paths: effort.paths,
                precision: match plan.yarn.estimator_in_use() {
                    Estimator::Shared => SINGLE_PRECISION,
                    Estimator::Independent => DOUBLE_PRECISION,
                },
            },
            batches: CheckEffort::BATCHES,
            cloth_batches: CheckEffort::CLOTH_BATCHES,
            widening: effort.widening(),
        }
    }

    /// `shares` times the paths that a batch of the ledger has.
    fn share(&self, shares: u64) -> u64 {
        shares * (self.judge.paths / self.batches as u64)
    }

    /// Paths that cost as much as so many shared ones.
    fn of_estimator(&self, paths: u64) -> u64 {
        match self.plan.yarn.estimator_in_use() {
            Estimator::Shared => paths,
            Estimator::Independent => (paths / self.plan.grid.len() as u64).max(self.batches as u64),
        }
    }

    /// One quantity at every wavelength, from [batch][wavelength].
    fn quantities(&self, name: &str, batches: &[Vec<f64>]) -> Vec<Quantity> {
        let nm = self.plan.grid.nm();
        let estimates = estimates(batches).into_iter().zip(nm);
        estimates
            .map(|([value, se], &wavelength_nm)| Quantity {
                name: name.into(),
                wavelength_nm,
                value,
                se,
                batches: batches.len(),
            })
            .collect()
    }
}

/// A result of the study, for comparison with later ones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quantity {
    pub name: String,
    pub wavelength_nm: f64,
    pub value: f64,
    pub se: f64,
    /// Batches behind the standard error.
    pub batches: usize,
}

/// What was checked.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Subject {
    pub version: String,
    /// "study" or "sample".
    pub kind: &'static str,
    pub seed: u64,
    pub effort: Option<CheckEffort>,
    /// The study with every default; null for a sample.
    pub study: serde_json::Value,
    pub inputs: Vec<InputDigest>,
}

/// All gates of a check.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Checked {
    pub verdict: Verdict,
    pub gates: Vec<Gate>,
    /// Drift from the baseline, where there was one.
    pub drift: Option<Drift>,
    pub quantities: Vec<Quantity>,
    pub subject: Subject,
}

impl Checked {
    fn new(gates: Vec<Gate>, quantities: Vec<Quantity>, subject: Subject) -> Self {
        Self {
            verdict: Verdict::of_all(gates.iter().map(|gate| gate.verdict)),
            gates,
            drift: None,
            quantities,
            subject,
        }
    }

    fn add(&mut self, gate: Gate) {
        self.gates.push(gate);
        self.verdict = Verdict::of_all(self.gates.iter().map(|gate| gate.verdict));
    }
}

/// Laws of which nothing can be said of a medium that amplifies: no light can be traced in it.
const TRACED: Law = Law {
    name: "traced-laws",
    words: "ledgers, tables, symmetries and cloth of the study",
};

/// Tests every law on the study of a plan.
///
/// # Errors
/// What tracing refuses; see [`CheckError`].
pub fn study(plan: &Plan, effort: CheckEffort, progress: Progress) -> Result<Checked, CheckError> {
    let context = &Context::new(plan, effort);
    let subject = Subject {
        version: env!("CARGO_PKG_VERSION").into(),
        kind: "study",
        seed: plan.study.seed,
        effort: Some(effort),
        study: serde_json::to_value(&plan.study)?,
        inputs: plan.inputs.clone(),
    };
    let mut passive = medium::passive(&plan.yarn.medium, context);
    if plan.weft.is_some() && passive.note.is_none() {
        passive =
            passive.with_note("warp and weft differ: laws are tested on the warp's yarn, and on a cloth of it alone");
    }
    let mut gates = vec![passive.clone()];
    gates.extend(medium::tables(context)?);
    gates.extend([
        rig::whites(context)?,
        rig::diffuser(context),
        rig::shading(context),
        rig::lookup(context),
        camera::pixels(context)?,
        camera::rig_directions(context),
        camera::mirror_gloss(context)?,
    ]);
    gates.extend(weave::gates(context)?);
    gates.extend([
        cells::lookup(context),
        estimates::standard_errors(context)?,
        estimates::normalisation(context)?,
    ]);
    gates.extend(particles::gates(context)?);
    progress(0.05);
    if passive.verdict == Verdict::Broken {
        gates.push(Gate::undecided(TRACED).with_note("not traced: the medium is not passive"));
        return Ok(Checked::new(gates, Vec::new(), subject));
    }
    gates.extend(attenuation::gates(context)?);
    gates.push(cells::straight(context)?);
    gates.push(reabsorption::gate(context)?);
    gates.push(medium::angles(context)?);
    gates.push(cylinder::closed_forms(context)?);
    progress(0.1);
    let (ledgers, mut quantities) = ledger::gates(context)?;
    gates.extend(ledgers);
    progress(0.5);
    gates.push(tables::bssrdf(context)?);
    let mut cloth = ClothEnergy::new(context);
    gates.extend(tables::direct(context, |batch| cloth.add(batch))?);
    gates.push(tables::two_roads(context)?);
    progress(0.2);
    gates.extend(symmetry::gates(context)?);
    gates.push(woven::ledger(context)?);
    gates.push(woven::furnace(context, &ledger::white_yarn(context)?)?);
    gates.push(woven::aperture(context)?);
    gates.extend(bounces::gates(context)?);
    let (energy, of_cloth) = cloth.gates();
    gates.extend(energy);
    quantities.extend(of_cloth);
    progress(0.15);
    Ok(Checked::new(gates, quantities, subject))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::Study;
    use std::collections::BTreeSet;

    #[test]
    fn false_alarms_are_divided_between_just_the_laws_in_the_mean() {
        let mut study = Study::default();
        study.spectrum.wavelengths_nm = Some(vec![450.0, 650.0]);
        study.trace.zenith_cells = 2;
        study.trace.azimuth_cells = 4;
        study.rig.pixels_per_side = 4;
        let plan = Plan::new(study).unwrap();
        let checked = self::study(&plan, CheckEffort::of_paths(4096).unwrap(), &|_| ()).unwrap();
        let random: BTreeSet<&str> = checked
            .gates
            .iter()
            .filter(|gate| gate.p.is_some())
            .map(|gate| gate.name)
            .collect();
        assert_eq!(random, IN_THE_MEAN.iter().map(|law| law.name).collect());
    }
}
