//! The same distribution as an earlier result?

use super::gate::{Gate, GateVerdict, Law, Where};
use super::{BaselineError, CheckEffort, Checked, CheckedQuantity, Drift, Moved};
use crate::input::{MOST_TEXT, read_file};
use serde::Deserialize;
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::path::{Path, PathBuf};

const BASELINE: Law = Law {
    name: "baseline",
    words: "every quantity has the distribution it has in the baseline",
};

/// Listed as moved from here on, whatever the joint verdict.
const LISTED_FROM: f64 = 3.0;

/// Differences of this size are of rounding, 1 being all light.
const ROUNDING: f64 = 1e-12;

#[derive(Debug, Deserialize)]
struct Document {
    quantities: Vec<CheckedQuantity>,
    subject: DocumentSubject,
}

#[derive(Debug, Deserialize)]
struct DocumentSubject {
    version: String,
    seed: u64,
    effort: Option<CheckEffort>,
    study: serde_json::Value,
}

/// The document that an earlier `check --json` printed.
#[derive(Debug)]
pub struct Baseline {
    path: PathBuf,
    document: Document,
}

impl Baseline {
    pub fn read(path: &Path) -> Result<Self, BaselineError> {
        let bytes = read_file(path, MOST_TEXT).map_err(|cause| BaselineError::Read {
            path: path.to_owned(),
            cause,
        })?;
        let document = serde_json::from_slice(&bytes).map_err(|cause| BaselineError::NotACheck {
            path: path.to_owned(),
            cause,
        })?;
        Ok(Self {
            path: path.to_owned(),
            document,
        })
    }

    /// Adds the gate and the drift. With one seed both sides share random numbers, which makes their difference smaller
    /// than its error says, never larger; the same run has the same bits.
    ///
    /// # Errors
    /// Quantities of other wavelengths or incidences.
    pub fn compare(&self, checked: &mut Checked, level: f64) -> Result<(), BaselineError> {
        let Document { quantities, subject } = &self.document;
        let mut moved = Vec::with_capacity(checked.quantities.len());
        let mut same_bits = quantities.len() == checked.quantities.len();
        let mut worst = (1.0, 0);
        for (i, here) in checked.quantities.iter().enumerate() {
            let same = |there: &&CheckedQuantity| there.name == here.name && there.wavelength_nm == here.wavelength_nm;
            let there = quantities
                .iter()
                .find(same)
                .ok_or_else(|| BaselineError::OtherQuantities {
                    path: self.path.clone(),
                    missing: format!("{} at {} nm", here.name, here.wavelength_nm),
                })?;
            same_bits &= here.value.to_bits() == there.value.to_bits() && here.se.to_bits() == there.se.to_bits();
            let sigmas = (here.value - there.value) / here.se.hypot(there.se).hypot(ROUNDING);
            let one = two_sided(sigmas, here, there);
            if one < worst.0 || one.is_nan() {
                worst = (one, i);
            }
            moved.push(Moved {
                name: here.name.clone(),
                wavelength_nm: here.wavelength_nm,
                value: here.value,
                baseline: there.value,
                sigmas,
            });
        }
        let own = &checked.subject;
        let same_run = subject.version == own.version
            && subject.seed == own.seed
            && subject.effort == own.effort
            && subject.study == own.study;
        let p = -(moved.len() as f64 * (-worst.0).ln_1p()).exp_m1();
        let gate = self.gate(&moved, worst.1, p, level);
        let gate = match (same_run, same_bits) {
            (true, true) => gate.with_note("same bits as the baseline"),
            (true, false) => gate.with_note("other bits than the baseline, though of the same version, seed and study"),
            (false, _) => gate.with_note("the baseline is of another version, seed, effort or study"),
        };
        checked.add(gate);
        moved.retain(|one| one.sigmas.is_nan() || one.sigmas.abs() >= LISTED_FROM);
        moved.sort_by(|a, b| b.sigmas.abs().total_cmp(&a.sigmas.abs()));
        checked.drift = Some(Drift {
            same_bits,
            same_run,
            moved,
        });
        Ok(())
    }

    fn gate(&self, all: &[Moved], worst: usize, p: f64, level: f64) -> Gate {
        let Some(furthest) = all.get(worst) else {
            return Gate::undecided(BASELINE).with_note("there is nothing to compare: no quantity was traced");
        };
        let difference = furthest.value - furthest.baseline;
        let se = (difference / furthest.sigmas).abs();
        let se = if se.is_finite() { se } else { 0.0 };
        Gate {
            cells: all.len(),
            worst: Where::new(furthest.wavelength_nm, furthest.name.clone()),
            value: difference,
            se,
            largest_se: se,
            z: Some(furthest.sigmas),
            p: Some(p),
            verdict: if p >= level {
                GateVerdict::Holds
            } else {
                GateVerdict::Broken
            },
            ..Gate::undecided(BASELINE)
        }
    }
}

/// Student's t with the degrees of freedom of Welch (1947) and Satterthwaite (1946).
fn two_sided(t: f64, here: &CheckedQuantity, there: &CheckedQuantity) -> f64 {
    let variances = [here.se.powi(2), there.se.powi(2)];
    let freedom = [here.batches, there.batches].map(|batches| batches.saturating_sub(1).max(1) as f64);
    let sum = variances[0] + variances[1];
    let apart = variances[0].powi(2) / freedom[0] + variances[1].powi(2) / freedom[1];
    let degrees = if apart > 0.0 { sum * sum / apart } else { freedom[0] };
    match StudentsT::new(0.0, 1.0, degrees) {
        Ok(student) if !t.is_nan() => (2.0 * student.sf(t.abs())).min(1.0),
        _ => f64::NAN,
    }
}
