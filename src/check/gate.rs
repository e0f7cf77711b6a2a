use crate::number::significant;
use serde::{Deserialize, Serialize};

/// What a gate found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GateVerdict {
    Holds,
    /// The law is broken, by more than chance or rounding.
    Broken,
    /// Not broken as far as can be seen, but a departure of the tolerance might have been missed.
    Undecided,
}

impl GateVerdict {
    pub fn word(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Broken => "broken",
            Self::Undecided => "undecided",
        }
    }

    /// Of several together: one broken law breaks the whole.
    pub fn of_all(verdicts: impl IntoIterator<Item = Self>) -> Self {
        verdicts.into_iter().fold(Self::Holds, |all, one| match (all, one) {
            (Self::Broken, _) | (_, Self::Broken) => Self::Broken,
            (Self::Undecided, _) | (_, Self::Undecided) => Self::Undecided,
            _ => Self::Holds,
        })
    }
}

/// Where among a gate's cells.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Where {
    pub wavelength_nm: Option<f64>,
    /// The rest in words: direction, tilt, quantity.
    pub at: String,
}

impl Where {
    pub fn new(wavelength_nm: f64, at: impl Into<String>) -> Self {
        Self {
            wavelength_nm: Some(wavelength_nm),
            at: at.into(),
        }
    }

    /// At no wavelength.
    pub fn named(at: impl Into<String>) -> Self {
        Self {
            wavelength_nm: None,
            at: at.into(),
        }
    }
}

impl std::fmt::Display for Where {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.wavelength_nm {
            Some(nm) if self.at.is_empty() => write!(f, "{nm} nm"),
            Some(nm) => write!(f, "{nm} nm {}", self.at),
            None => f.write_str(&self.at),
        }
    }
}

/// A law, by the name scripts know and in words.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    pub name: &'static str,
    pub words: &'static str,
}

/// A law tested.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gate {
    pub name: &'static str,
    pub law: &'static str,
    /// Values that the law was tested on, all together.
    pub cells: usize,
    /// The cell furthest from the law: by size for laws that hold to rounding, by size over error for the others.
    pub worst: Where,
    /// Departure of that cell from the law, in the unit of the tolerance.
    pub value: f64,
    /// Its standard error; 0 where nothing is random.
    pub se: f64,
    pub tolerance: f64,
    /// Largest standard error of all cells.
    pub largest_se: f64,
    /// value / se; `None` where nothing is random.
    pub z: Option<f64>,
    /// Probability of a departure as large anywhere among the cells, if the law holds.
    pub p: Option<f64>,
    pub verdict: GateVerdict,
    /// For `--paths`: how many would tell.
    pub paths_to_tell: Option<u64>,
    /// What else is to be known.
    pub note: Option<String>,
}

impl Gate {
    /// A law of which nothing is known.
    pub fn undecided(law: Law) -> Self {
        Self {
            name: law.name,
            law: law.words,
            cells: 0,
            worst: Where::default(),
            value: 0.0,
            se: 0.0,
            tolerance: 0.0,
            largest_se: 0.0,
            z: None,
            p: None,
            verdict: GateVerdict::Undecided,
            paths_to_tell: None,
            note: None,
        }
    }

    pub fn with_note(self, note: impl Into<String>) -> Self {
        Self {
            note: Some(note.into()),
            ..self
        }
    }

    /// One line: where, how far, and what may be done.
    pub fn message(&self) -> String {
        let mut text = String::new();
        if self.cells > 0 {
            let place = self.worst.to_string();
            let gap = if place.is_empty() { "" } else { ", " };
            text = format!("worst of {}: {place}{gap}{}", self.cells, significant(self.value, 4));
            text += &match (self.z, self.p) {
                (Some(z), Some(p)) => {
                    let [se, z, p] = [(self.se, 2), (z, 3), (p, 3)].map(|(number, digits)| significant(number, digits));
                    format!(" ± {se} (z {z}, joint p {p})")
                }
                _ => format!(", tolerance {}", significant(self.tolerance, 2)),
            };
        }
        if self.verdict == GateVerdict::Undecided && self.cells > 0 {
            text += &format!("; a departure of {} might be missed", significant(self.tolerance, 2));
        }
        if let Some(paths) = self.paths_to_tell {
            text += &format!(": --paths {paths} would tell");
        }
        if let Some(note) = &self.note {
            let gap = if text.is_empty() { "" } else { "; " };
            text += &format!("{gap}{note}");
        }
        text
    }
}
