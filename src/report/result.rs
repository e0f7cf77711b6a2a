//! The one plain result everything in this room is a pure function of.

use serde::Serialize;
use std::collections::BTreeMap;

/// Everything a report shows. No clock, host name or path stands in it outside [`Provenance`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReportData {
    /// Wavelength grid of the study, nm, ascending.
    pub wavelengths_nm: Vec<f64>,
    /// The convention the curves and `table1` are in, in words: observer, illuminant, RGB space, adaptation.
    pub colour_convention: String,
    pub curves: Vec<CurvePoint>,
    pub table1: Vec<Table1Row>,
    /// The same ratios under every other convention.
    pub conventions: Vec<Convention>,
    pub energy: Vec<EnergyRow>,
    /// Coefficient every value of the source was multiplied by; a perfect model has 1.
    pub normalisation: BTreeMap<Source, Estimate>,
    /// RMSE against the measured sample, in brightness factors.
    pub rmse: Vec<Metric>,
    /// RMSE divided by the mean measured brightness factor, dimensionless.
    pub relative_rmse: Vec<Metric>,
    /// Signed view angle of the highest brightness factor, degrees.
    pub peak_angle_deg: Vec<Metric>,
    /// RMSE(classical)/RMSE(model).
    pub rmse_ratio: Vec<RmseRatio>,
    pub sample: SampleNote,
    pub provenance: Provenance,
}

/// Where a brightness factor comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Source {
    Model,
    Classical,
    Measured,
}

impl Source {
    pub fn name(self) -> &'static str {
        match self {
            Source::Model => "model",
            Source::Classical => "classical",
            Source::Measured => "measured",
        }
    }
}

/// Linear RGB channel, or luminance Y.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Channel {
    R,
    G,
    B,
    Y,
}

impl Channel {
    pub fn name(self) -> &'static str {
        match self {
            Channel::R => "R",
            Channel::G => "G",
            Channel::B => "B",
            Channel::Y => "Y",
        }
    }
}

/// A value with its standard error (one standard deviation), in the unit of the value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    pub value: f64,
    pub se: f64,
}

/// One point of one curve; β is dimensionless, 1 for a perfect diffuser.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CurvePoint {
    pub theta_i_deg: f64,
    /// Signed: negative on the light's side of the normal.
    pub theta_v_deg: f64,
    pub source: Source,
    pub channel: Channel,
    pub beta: f64,
    pub se: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Table1Name {
    Published,
    Measured,
    Model,
    ModelLow,
    ModelHigh,
}

/// Ratios of linear RGB at normal illumination and view; `None` where there is no such value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Table1Row {
    pub row: Table1Name,
    pub blue_over_red: Option<f64>,
    pub blue_over_red_se: Option<f64>,
    pub green_over_red: Option<f64>,
    pub green_over_red_se: Option<f64>,
}

/// Table 1 under one colour convention.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Convention {
    /// In words: observer, illuminant, RGB space, adaptation.
    pub convention: String,
    pub rows: Vec<Table1Row>,
}

/// Energy ledger of one wavelength and incident direction: fractions of the incident flux, each with its standard
/// error. `residual` is 1 minus the sum of the others.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct EnergyRow {
    pub wavelength_nm: f64,
    pub theta_in_deg: f64,
    pub phi_in_deg: f64,
    pub reflected: f64,
    pub reflected_se: f64,
    pub ballistic: f64,
    pub ballistic_se: f64,
    pub scattered: f64,
    pub scattered_se: f64,
    pub absorbed: f64,
    pub absorbed_se: f64,
    pub roulette: f64,
    pub roulette_se: f64,
    pub residual: f64,
    pub residual_se: f64,
}

/// One number about one curve; the field that holds it names its unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Metric {
    pub theta_i_deg: f64,
    pub source: Source,
    pub channel: Channel,
    pub value: f64,
    pub se: f64,
}

/// What an interval of RMSE(classical)/RMSE(model) says about the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The whole interval lies above 1.
    Better,
    /// The whole interval lies below 1.
    Worse,
    /// The interval holds 1.
    CannotTell,
}

impl Verdict {
    pub fn words(self) -> &'static str {
        match self {
            Verdict::Better => "better",
            Verdict::Worse => "worse",
            Verdict::CannotTell => "cannot tell",
        }
    }
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RmseRatio {
    pub theta_i_deg: f64,
    pub channel: Channel,
    pub value: f64,
    pub low: f64,
    pub high: f64,
    /// Probability content of `low..high`, such as 0.95.
    pub confidence: f64,
    pub verdict: Verdict,
}

/// What the sample is, in words that go below every graph and table it appears in.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SampleNote {
    pub name: String,
    /// "measured", "fit of a measurement", "synthetic".
    pub kind: String,
    pub source: String,
    pub licence: String,
    /// One or two sentences: what it is, its standard uncertainty, its RGB space.
    pub caption: String,
}

/// SHA-256 of one input.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct InputDigest {
    /// What the input is called in the study: a table's name or the file as typed.
    pub name: String,
    /// Lower-case hexadecimal.
    pub sha256: String,
}

impl InputDigest {
    pub fn of(name: impl Into<String>, bytes: &[u8]) -> Self {
        use sha2::{Digest, Sha256};
        let sha256 = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        Self {
            name: name.into(),
            sha256,
        }
    }
}

/// How the result came about. The number of threads is left out: results do not depend on it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Provenance {
    pub version: String,
    /// The command, word by word.
    pub command: Vec<String>,
    /// The study with every default filled in.
    pub study: serde_json::Value,
    pub seed: u64,
    pub inputs: Vec<InputDigest>,
    /// Everything that was done in another way than the study asks.
    pub fallbacks: Vec<String>,
    /// What the reader must know, such as a range the sweep does not reach.
    pub notices: Vec<String>,
}
