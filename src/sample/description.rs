//! What is said of a sample beside its readings, and which component of a file it is.

use serde::{Deserialize, Serialize};

use crate::goniometric::{Scatter, Side};

/// How the numbers came about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SampleKind {
    /// Readings of an instrument.
    Measured,
    /// A function fitted to readings, evaluated.
    Fit,
    /// Made by a computation, for trials.
    Synthetic,
}

/// What `sample.toml` says of the data beside it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Description {
    pub name: String,
    /// Publication, instrument, or file.
    pub source: String,
    pub licence: String,
    /// None for a bare CSV file, which does not say.
    pub kind: Option<SampleKind>,
    /// Standard uncertainty of each reading relative to its value; used where the data have no `_se` columns.
    pub relative_standard_uncertainty: Option<f64>,
    /// What the RGB columns are, in words.
    pub colour: Option<String>,
    /// The file of the readings, beside `sample.toml`; `data.csv` if it is not stated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub data: Option<String>,
    /// What the one channel of a file without colour is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub channel: Option<OneChannel>,
    /// Whether the sample scatters alike at every azimuth of the plane of incidence, so that a model's mean over the
    /// cloth's azimuth is to be compared with it. Not stated: not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub isotropic: Option<bool>,
}

/// What one channel is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum OneChannel {
    /// Luminous: weighted by an illuminant and the CIE's ȳ(λ).
    Luminance,
}

/// Where the standard errors of a sample's readings come from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Uncertainty {
    /// `_se` columns of the data.
    Columns,
    /// `relative_standard_uncertainty` of `sample.toml`.
    Relative(f64),
    /// Neither is given: every standard error is 0, so a comparison knows only the Monte Carlo error. A report has to
    /// say so.
    NotStated,
}

/// Which component of a goniometric file is the sample; without it reflection, and light from the front.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Chosen {
    pub scatter: Option<Scatter>,
    pub side: Option<Side>,
}

impl Chosen {
    pub(super) const REMEDY: &str = "choose one that the file has: --scatter and --side of `report`, `check --sample` \
                                     and `colour` say which, or `specval convert FILE OUT` with them writes it as a \
                                     file of its own";

    pub(super) fn or_default(self) -> (Scatter, Side) {
        (
            self.scatter.unwrap_or(Scatter::Reflection),
            self.side.unwrap_or(Side::Front),
        )
    }

    pub(super) fn words(self) -> String {
        let (scatter, side) = self.or_default();
        let scatter = match scatter {
            Scatter::Reflection => "reflection",
            Scatter::Transmission => "transmission",
        };
        let side = if side == Side::Front { "front" } else { "back" };
        format!("{scatter} of light from the {side}")
    }
}
