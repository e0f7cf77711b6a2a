//! A measurement, tested without any model: reciprocity, energy, coverage, jumps, uncertainty.

use super::departure::{Departure, SampleJudge, plausibility};
use super::gate::{Gate, GateVerdict, Law, Where};
use super::{CheckError, Checked, Subject};
use crate::number::shown;
use crate::report::InputDigest;
use crate::run::FileKind;
use crate::sample::{Chosen, RawReading, Sample, SampleError, Uncertainty};
use crate::study::CheckSection;
use std::path::Path;

const READINGS: Law = Law {
    name: "sample-readings",
    words: "every reading is a brightness factor of 0 or more, and no geometry has two values",
};
const UNCERTAINTY: Law = Law {
    name: "sample-uncertainty",
    words: "every reading has a standard uncertainty",
};
const COVERAGE: Law = Law {
    name: "sample-coverage",
    words: "normal incidence and view is measured, and every incidence from -45 to 45 degrees of view at least",
};
const RECIPROCITY: Law = Law {
    name: "sample-reciprocity",
    words: "β is the same with light and viewer exchanged, relative to their mean",
};
const ENERGY: Law = Law {
    name: "sample-energy",
    words: "the directional-hemispherical reflectance, or transmittance, is at most 1",
};
const ENERGY_OF_PLANE: Law = Law {
    name: "sample-energy",
    words: "plausibility: the mean of β over the views of the plane of incidence, by projected solid angle, is at most \
            1",
};
const UNITS: Law = Law {
    name: "sample-units",
    words: "plausibility: values and angles have the size that their units give them",
};
const JUMPS: Law = Law {
    name: "sample-jumps",
    words: "plausibility: no reading lies off the line between its neighbouring views, relative to the curve's largest",
};

/// Views that a curve has to reach, degrees, and gaps it may have.
const REACH_DEG: f64 = 45.0;
const GAP_DEG: f64 = 20.0;
/// Angles nearer than this are one, degrees.
const SAME_DEG: f64 = 1e-6;
/// Gates with a standard error.
const STOCHASTIC_GATES: f64 = 3.0;

/// Tests the sample of this name, folder or file. A table that the reader refuses is a broken law; one that is not
/// there an error.
///
/// # Errors
/// No such sample, or one without readings.
pub fn sample(name_or_path: &str, chosen: Chosen, tolerances: &CheckSection) -> Result<Checked, CheckError> {
    let mut subject = Subject {
        version: env!("CARGO_PKG_VERSION").into(),
        kind: "sample",
        seed: 0,
        effort: None,
        study: serde_json::Value::Null,
        inputs: Vec::new(),
    };
    let sample = match Sample::load_chosen(name_or_path, chosen) {
        Ok(sample) => sample,
        // Of a table of readings alone can a law be broken; another file is none that could be tested.
        Err(SampleError::Csv(error)) if FileKind::of(Path::new(name_or_path)) == Some(FileKind::Sample) => {
            let gate = Gate {
                verdict: GateVerdict::Broken,
                ..Gate::undecided(READINGS)
            };
            return Ok(Checked::new(
                vec![gate.with_note(error.to_string())],
                Vec::new(),
                subject,
            ));
        }
        Err(other) => return Err(other.into()),
    };
    subject.inputs.push(InputDigest {
        name: format!("sample {name_or_path}"),
        sha256: sample.digest().to_owned(),
    });
    let stated = sample.uncertainty() != Uncertainty::NotStated;
    let judge = SampleJudge {
        level: tolerances.false_alarms / STOCHASTIC_GATES,
        stated,
    };
    let curves = Curves {
        sample: &sample,
        readings: sample.raw().collect(),
        wavelengths_nm: sample.wavelengths_nm(),
        stated,
        judge,
    };
    let mut gates = vec![curves.readings(), curves.uncertainty(), curves.coverage()];
    if !curves.readings.is_empty() {
        if !sample.is_transmission() {
            gates.extend(curves.reciprocity(tolerances.sample));
        }
        gates.push(curves.energy());
        gates.push(curves.jumps(tolerances.sample));
        gates.push(curves.units());
    }
    Ok(Checked::new(gates, Vec::new(), subject))
}

struct Curves<'a> {
    sample: &'a Sample,
    readings: Vec<RawReading<'a>>,
    wavelengths_nm: Option<&'a [f64]>,
    stated: bool,
    judge: SampleJudge,
}

impl<'a> Curves<'a> {
    fn place(&self, reading: &RawReading, value: usize) -> Where {
        let geometry = format!(
            "theta_i {} deg, theta_v {} deg",
            shown(reading.theta_i_deg),
            shown(reading.theta_v_deg)
        );
        match self.wavelengths_nm {
            Some(nm) => Where::new(nm[value], geometry),
            None => Where::named(format!("{geometry}, channel {}", value + 1)),
        }
    }

    /// Of each incidence, ascending by view.
    fn by_incidence(&self) -> impl Iterator<Item = &[RawReading<'a>]> {
        self.readings
            .chunk_by(|a, b| (a.theta_i_deg - b.theta_i_deg).abs() < SAME_DEG)
    }

    fn find(&self, theta_i_deg: f64, theta_v_deg: f64) -> Option<&RawReading<'a>> {
        let near = |a: f64, b: f64| (a - b).abs() < SAME_DEG;
        self.readings
            .iter()
            .find(|r| near(r.theta_i_deg, theta_i_deg) && near(r.theta_v_deg, theta_v_deg))
    }

    fn readings(&self) -> Gate {
        // The reader has refused all else.
        let cells = self.readings.iter().map(|reading| reading.beta.len()).sum();
        let gate = Gate::undecided(READINGS);
        match cells {
            0 => gate.with_note("published ratios alone, no curves"),
            _ => Gate {
                cells,
                verdict: GateVerdict::Holds,
                ..gate
            },
        }
    }

    /// What the reader said of units, signs and values.
    fn units(&self) -> Gate {
        let gate = Gate::undecided(UNITS);
        let notices: Vec<String> = self.sample.notices().iter().map(ToString::to_string).collect();
        match self.sample.implausible() {
            true => gate.with_note(notices.join("; ")),
            false => Gate {
                cells: self.readings.len(),
                verdict: GateVerdict::Holds,
                note: (!notices.is_empty()).then(|| notices.join("; ")),
                ..gate
            },
        }
    }

    fn uncertainty(&self) -> Gate {
        let gate = Gate::undecided(UNCERTAINTY);
        if !self.stated {
            return gate.with_note(
                "none is stated: add _se columns, or relative_standard_uncertainty to sample.toml; comparisons would \
                 know the Monte Carlo error alone",
            );
        }
        let without = |reading: &&RawReading| {
            reading
                .beta
                .iter()
                .zip(reading.se)
                .any(|(b, se)| *b > 0.0 && *se <= 0.0)
        };
        let missing = self.readings.iter().filter(without).count();
        Gate {
            cells: self.readings.len(),
            value: missing as f64,
            verdict: if missing == 0 {
                GateVerdict::Holds
            } else {
                GateVerdict::Broken
            },
            note: (missing > 0).then(|| format!("{missing} readings above 0 have the error 0")),
            ..gate
        }
    }

    fn coverage(&self) -> Gate {
        let gate = Gate::undecided(COVERAGE);
        let mut lacks = Vec::new();
        if self.find(0.0, 0.0).is_none() {
            lacks.push(
                "no reading at normal incidence and view: the nearest one normalises, and has its gloss in it"
                    .to_owned(),
            );
        }
        for curve in self.by_incidence() {
            let views: Vec<f64> = curve.iter().map(|reading| reading.theta_v_deg).collect();
            let (low, high) = (views[0], views[views.len() - 1]);
            let gap = views.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
            if low > -REACH_DEG || high < REACH_DEG || gap > GAP_DEG {
                lacks.push(format!(
                    "incidence {} has views {} to {}, gaps of {} degrees at most",
                    shown(curve[0].theta_i_deg),
                    shown(low),
                    shown(high),
                    shown(gap)
                ));
            }
        }
        match lacks.is_empty() {
            true => Gate {
                cells: self.readings.len(),
                verdict: GateVerdict::Holds,
                ..gate
            },
            false => gate.with_note(lacks.join("; ")),
        }
    }

    /// The light stands at −θ_i of the signed angle, the viewer at θ_v. Exchanged, the light stands at θ_v: for a view
    /// on the light's side that is the geometry (−θ_v, −θ_i), else, turned by 180° about the normal, (θ_v, θ_i). None
    /// without pairs.
    fn reciprocity(&self, tolerance: f64) -> Option<Gate> {
        let mut departures = Vec::new();
        for reading in &self.readings {
            let (i, v) = (reading.theta_i_deg, reading.theta_v_deg);
            let (i_other, v_other) = if v < 0.0 { (-v, -i) } else { (v, i) };
            // Each pair once, and none with itself.
            if i_other <= i + SAME_DEG {
                continue;
            }
            let Some(other) = self.find(i_other, v_other) else {
                continue;
            };
            for (k, (here, there)) in reading.beta.iter().zip(other.beta).enumerate() {
                let mean = 0.5 * (here + there);
                if mean > 0.0 {
                    departures.push(Departure {
                        value: (here - there) / mean,
                        se: reading.se[k].hypot(other.se[k]) / mean,
                        place: self.place(reading, k),
                    });
                }
            }
        }
        (!departures.is_empty()).then(|| self.judge.gate(RECIPROCITY, &departures, tolerance, f64::abs, 2.0))
    }

    /// By the hemisphere where the sample has one. In the plane of incidence alone, as if the other views were like
    /// those: ∫ β |sinθ| cosθ dθ over the same without β, by the trapezoidal rule; a narrow lobe fills the plane and
    /// not the hemisphere, so that bound is a plausibility and breaks nothing.
    fn energy(&self) -> Gate {
        let hemispheres = self.hemispheres();
        if !hemispheres.is_empty() {
            return self.judge.gate(ENERGY, &hemispheres, 0.0, |x| x, 1.0);
        }
        let mut departures = Vec::new();
        for curve in self.by_incidence() {
            let weights: Vec<f64> = (0..curve.len())
                .map(|k| {
                    let at = |k: usize| curve[k].theta_v_deg.to_radians();
                    let width = at((k + 1).min(curve.len() - 1)) - at(k.saturating_sub(1));
                    // The floor keeps a curve of one view, or of the normal alone.
                    width.max(1e-9) * (at(k).sin().abs() * at(k).cos()).max(1e-3)
                })
                .collect();
            let total: f64 = weights.iter().sum();
            for k in 0..curve[0].beta.len() {
                let terms = curve.iter().zip(&weights);
                let mean: f64 = terms.clone().map(|(r, w)| w * r.beta[k]).sum::<f64>() / total;
                // One instrument's errors go together.
                let se: f64 = terms.map(|(r, w)| w * r.se[k]).sum::<f64>() / total;
                departures.push(Departure {
                    value: mean - 1.0,
                    se,
                    place: self.place(&curve[0], k),
                });
            }
        }
        plausibility(
            self.judge.gate(ENERGY_OF_PLANE, &departures, 0.0, |x| x, 1.0),
            "more than 1 in the plane of incidence: a narrow lobe may do that, per cent in place of fractions does",
        )
    }

    /// Directional-hemispherical reflectance less 1 at every incidence that is read over half of the hemisphere or
    /// more; what was not read counts as dark, so the law errs on the side of holding.
    fn hemispheres(&self) -> Vec<Departure> {
        const LEAST_SHARE: f64 = 0.5;
        let mut departures = Vec::new();
        for curve in self.by_incidence() {
            let Some((values, share)) = self.sample.hemispherical(curve[0].theta_i_deg) else {
                continue;
            };
            if share < LEAST_SHARE {
                continue;
            }
            for (k, value) in values.iter().enumerate() {
                // One instrument's errors go together: relative as those of the curve.
                let [beta, se] = [|r: &RawReading, k: usize| r.beta[k], |r: &RawReading, k: usize| r.se[k]]
                    .map(|of| curve.iter().map(|r| of(r, k)).sum::<f64>());
                departures.push(Departure {
                    value: value - 1.0,
                    se: if beta > 0.0 { value * se / beta } else { 0.0 },
                    place: match self.wavelengths_nm {
                        Some(nm) => Where::new(nm[k], format!("theta_i {} deg", shown(curve[0].theta_i_deg))),
                        None => Where::named(format!(
                            "theta_i {} deg, channel {}",
                            shown(curve[0].theta_i_deg),
                            k + 1
                        )),
                    },
                });
            }
        }
        departures
    }

    fn jumps(&self, tolerance: f64) -> Gate {
        let mut departures = Vec::new();
        for curve in self.by_incidence() {
            for k in 0..curve[0].beta.len() {
                let largest = curve.iter().map(|reading| reading.beta[k]).fold(0.0, f64::max);
                if largest <= 0.0 {
                    continue;
                }
                for near in curve.windows(3) {
                    let share =
                        (near[1].theta_v_deg - near[0].theta_v_deg) / (near[2].theta_v_deg - near[0].theta_v_deg);
                    let line = near[0].beta[k] + share * (near[2].beta[k] - near[0].beta[k]);
                    let sides = ((1.0 - share) * near[0].se[k]).hypot(share * near[2].se[k]);
                    departures.push(Departure {
                        value: (near[1].beta[k] - line) / largest,
                        se: near[1].se[k].hypot(sides) / largest,
                        place: self.place(&near[1], k),
                    });
                }
            }
        }
        plausibility(
            self.judge.gate(JUMPS, &departures, tolerance, f64::abs, 2.0),
            "an outlier, or a peak narrower than the steps of the views",
        )
    }
}
