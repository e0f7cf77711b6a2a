use super::CheckError;
use super::gate::{Gate, GateVerdict};
use crate::report::InputDigest;
use serde::{Deserialize, Serialize};

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
    pub(super) const BATCHES: usize = 64;
    pub(super) const CLOTH_BATCHES: usize = 16;

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

    /// Factor on the tolerances: `--quick` has too few paths for the usual ones, so it tests wider ones and states them.
    pub(super) fn widening(self) -> f64 {
        if self == Self::quick() { 8f64.sqrt() } else { 1.0 }
    }
}

/// A result of the study, for comparison with later ones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CheckedQuantity {
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
    pub verdict: GateVerdict,
    pub gates: Vec<Gate>,
    /// Drift from the baseline, where there was one.
    pub drift: Option<Drift>,
    pub quantities: Vec<CheckedQuantity>,
    pub subject: Subject,
}

impl Checked {
    pub(super) fn new(gates: Vec<Gate>, quantities: Vec<CheckedQuantity>, subject: Subject) -> Self {
        Self {
            verdict: GateVerdict::of_all(gates.iter().map(|gate| gate.verdict)),
            gates,
            drift: None,
            quantities,
            subject,
        }
    }

    pub(super) fn add(&mut self, gate: Gate) {
        self.gates.push(gate);
        self.verdict = GateVerdict::of_all(self.gates.iter().map(|gate| gate.verdict));
    }
}

/// How far a check is from its baseline.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Drift {
    /// All quantities have the very bits; only of meaning where version, seed, study and effort are the same.
    pub same_bits: bool,
    /// Whether they are, so that the same bits are due.
    pub same_run: bool,
    /// Of 3 standard errors and more, furthest first.
    pub moved: Vec<Moved>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Moved {
    pub name: String,
    pub wavelength_nm: f64,
    pub value: f64,
    pub baseline: f64,
    /// Difference over both standard errors.
    pub sigmas: f64,
}
