//! Departures of single readings from a law, judged by their standard errors.

use super::gate::{Gate, GateVerdict, Law, Where};
use statrs::distribution::{ContinuousCDF, Normal};

/// A gate whose rule is no law: what it finds leaves the verdict open.
pub(super) fn plausibility(gate: Gate, words: &str) -> Gate {
    match gate.verdict {
        GateVerdict::Broken => Gate {
            verdict: GateVerdict::Undecided,
            ..gate
        }
        .with_note(words),
        _ => gate,
    }
}

/// A departure from a law with its standard error, where it is.
pub(super) struct Departure {
    pub(super) value: f64,
    pub(super) se: f64,
    pub(super) place: Where,
}

/// Judges readings, each with a standard error of its own.
#[derive(Clone, Copy)]
pub(super) struct SampleJudge {
    /// Probability that a gate whose law holds breaks by chance.
    pub(super) level: f64,
    /// Whether the sample states its uncertainty.
    pub(super) stated: bool,
}

impl SampleJudge {
    /// Broken where a departure is beyond the tolerance and, all together, beyond chance. Without errors the tolerance
    /// alone decides.
    pub(super) fn gate(
        &self,
        law: Law,
        departures: &[Departure],
        tolerance: f64,
        size: fn(f64) -> f64,
        sides: f64,
    ) -> Gate {
        let beyond = |d: &Departure| size(d.value) - tolerance;
        let z = |d: &Departure| {
            if d.se > 0.0 {
                size(d.value) / d.se
            } else {
                f64::INFINITY
            }
        };
        let p = |d: &Departure| {
            let one = Normal::standard().sf(z(d)) * sides;
            -(departures.len() as f64 * (-one.min(1.0)).ln_1p()).exp_m1()
        };
        let breaks = |d: &&Departure| beyond(d) > 0.0 && p(d) < self.level;
        let furthest = |a: &&Departure, b: &&Departure| size(a.value).total_cmp(&size(b.value));
        let broken = departures.iter().filter(breaks).max_by(furthest);
        let Some(shown) = broken.or_else(|| departures.iter().max_by(furthest)) else {
            return Gate {
                verdict: GateVerdict::Holds,
                ..Gate::undecided(law)
            }
            .with_note("nothing to test: fewer than three views at each incidence");
        };
        Gate {
            cells: departures.len(),
            worst: shown.place.clone(),
            value: shown.value,
            se: shown.se,
            tolerance,
            largest_se: departures.iter().map(|d| d.se).fold(0.0, f64::max),
            // A reading whose error is 0 is known without chance.
            z: (self.stated && shown.se > 0.0).then(|| shown.value / shown.se),
            p: (self.stated && shown.se > 0.0).then(|| p(shown)),
            verdict: if broken.is_some() {
                GateVerdict::Broken
            } else {
                GateVerdict::Holds
            },
            ..Gate::undecided(law)
        }
    }
}
