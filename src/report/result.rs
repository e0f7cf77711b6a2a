//! The result that a report is drawn from.

use super::{Approximations, EnergyRow, Fallback, Notice};
use crate::compare::{
    Coefficient, CurvePoint, Geometry, HueComparison, Peak, Rmse, RmseRatio, Role, Source, SourceId, Table1Row,
    first_sample, is_first_sample,
};
use crate::sample::{Sample, SampleKind, Uncertainty};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Everything a report shows. No clock, host name or path stands in it outside [`Provenance`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReportData {
    /// Wavelength grid of the study, nm, ascending.
    pub wavelengths_nm: Vec<f64>,
    /// Colour convention of the curves and of `table1`: observer, illuminant, RGB space, adaptation.
    pub colour_convention: String,
    /// Models, classical shadings and samples; curves, errors and the other lists name them by their ids.
    pub sources: Vec<Source>,
    pub curves: Vec<CurvePoint>,
    pub table1: Vec<Table1Row>,
    /// The same ratios under every other convention.
    pub conventions: Vec<ConventionRatios>,
    pub energy: Vec<EnergyRow>,
    /// None without a measured sample, and then nothing is normalised. Curves have the first sample's.
    pub normalisation: Vec<Coefficient>,
    /// Against the measured sample, in brightness factors and relative to its mean.
    pub rmse: Vec<Rmse>,
    pub peaks: Vec<Peak>,
    /// RMSE(classical)/RMSE(model).
    pub rmse_ratios: Vec<RmseRatio>,
    /// What the samples are, the first sample first; one at least.
    pub samples: Vec<SampleNote>,
    /// What became of every reading of the first sample.
    pub readings: ReadingCount,
    /// Hue of the first model and the first sample at the geometry of normalisation; `None` without a comparison.
    pub hue: Option<HueComparison>,
    /// `None` where the ways to follow light in the cloth were not compared.
    pub approximations: Option<Approximations>,
    pub provenance: Provenance,
}

impl ReportData {
    /// The sources of a role, in order.
    pub fn sources_of(&self, role: Role) -> impl Iterator<Item = &Source> {
        self.sources.iter().filter(move |source| source.role == role)
    }

    /// What the sample of this id is; `None` of other sources.
    pub fn sample(&self, id: &SourceId) -> Option<&SampleNote> {
        self.samples.iter().find(|sample| sample.id == *id)
    }
}

/// Table 1 under one colour convention.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConventionRatios {
    /// Observer, illuminant, RGB space, adaptation.
    pub convention: String,
    pub rows: Vec<Table1Row>,
}

/// What became of the readings of a sample: every one is used, interpolated, outside the plane of incidence, outside
/// the rig, or without a value of the model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReadingCount {
    pub total: usize,
    /// Compared as they are.
    pub used: usize,
    /// Used only to interpolate between two of them.
    pub interpolated: usize,
    pub outside_plane: usize,
    /// At geometries that the rig does not ask for.
    pub outside_rig: usize,
    /// The first of them.
    pub examples_outside_rig: Vec<Geometry>,
    /// Used, but the model shows no light there.
    pub no_model_value: usize,
    /// Readings that were combined with others of the same geometry before they were counted.
    pub combined: usize,
    /// Readings whose angles, as an encoder read them, were taken as the nominal ones, and the largest difference in
    /// degrees.
    pub moved: usize,
    pub largest_move_deg: f64,
    /// So far a reading may lie from the geometry it is compared at.
    pub tolerance_deg: f64,
    /// Whether the geometries are the sample's own, not the study's.
    pub geometries_of_sample: bool,
    /// Where model and classical shading are normalised; `None` where nothing is.
    pub normalised_at: Option<Geometry>,
}

impl ReadingCount {
    /// Geometries outside the rig that are named.
    pub const EXAMPLES: usize = 12;
}

/// Description of a sample, for the captions of graphs and the footnotes of tables.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SampleNote {
    /// Left out of files where it is the first sample's.
    #[serde(default = "first_sample", skip_serializing_if = "is_first_sample")]
    pub id: SourceId,
    pub name: String,
    /// "measured", "fit of a measurement", "synthetic".
    pub kind: String,
    pub source: String,
    pub licence: String,
    /// Whether its readings have standard errors.
    pub uncertainty_stated: bool,
    /// Its standard uncertainty and its RGB space.
    pub caption: String,
}

impl SampleNote {
    pub fn of(id: SourceId, sample: &Sample) -> Self {
        let of = sample.description();
        let kind = match of.kind {
            Some(SampleKind::Measured) => "measured",
            Some(SampleKind::Fit) => "fit of a measurement",
            Some(SampleKind::Synthetic) => "synthetic",
            None => "not stated",
        };
        let uncertainty = match sample.uncertainty() {
            Uncertainty::Columns => "standard errors from its own columns".to_owned(),
            Uncertainty::Relative(share) => format!("{:.3} % standard uncertainty", share * 100.0).replace(".000", ""),
            Uncertainty::NotStated => "uncertainty not stated".to_owned(),
        };
        let colour = of.colour.as_deref().map(|words| format!("; {words}"));
        Self {
            id,
            name: of.name.clone(),
            kind: kind.into(),
            source: of.source.clone(),
            licence: of.licence.clone(),
            uncertainty_stated: sample.uncertainty() != Uncertainty::NotStated,
            caption: format!("{uncertainty}{}", colour.unwrap_or_default()),
        }
    }

    /// Of the samples of a report, which have their ids by their places.
    pub fn of_all(samples: &[&Sample]) -> Vec<Self> {
        let note =
            |(place, sample): (usize, &&Sample)| Self::of(Source::numbered(Role::Measured, place, "").id, sample);
        samples.iter().enumerate().map(note).collect()
    }

    /// The sample as a source; a report of several samples names each in its legends.
    pub fn source_of(&self, samples: usize) -> Source {
        let name = if samples == 1 { "measured" } else { &self.name };
        Source {
            id: self.id.clone(),
            role: Role::Measured,
            label: format!("{name} ({})", self.kind),
        }
    }
}

/// SHA-256 of one input.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
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

/// How much was traced, what was asked for and what was reached. Runs that were resumed say the same as others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EffortNote {
    /// Batches made, all of the same size.
    pub batches: usize,
    pub paths_per_batch: PathsPerBatch,
    /// "paths", "precision" or "time"; "nothing hit" where a precision was asked for and all that it is of is 0 in
    /// every batch, "precision out of reach" where it would take more batches than a run may make.
    pub stopped_by: Cow<'static, str>,
    pub asked: AskedEffort,
    pub reached: Option<ReachedPrecision>,
}

/// For each direction, and for each wavelength if they share no paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PathsPerBatch {
    /// From a patch: ledger and BSSRDF.
    pub bssrdf: usize,
    /// In a parallel beam on the whole yarn, at each tilt.
    pub direct: usize,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AskedEffort {
    /// Such as "rel 0.01 curves".
    pub until: Option<String>,
    pub max_time_s: Option<f64>,
    /// Batches at most.
    pub batches: usize,
}

/// Largest Monte Carlo standard error of what was watched.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReachedPrecision {
    /// "rel" if it is over its value, "abs" if not.
    pub tolerance: Cow<'static, str>,
    /// "curves", the luminance of the model's points, "ratios", its row of Table 1, or "scattered", that fraction of
    /// the ledger.
    pub of: Cow<'static, str>,
    /// `None` where it is not known: some of it is 0 in every batch, or a ratio of such.
    pub largest_error: Option<f64>,
}

/// How the result came about. The number of threads is left out: results do not depend on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    pub version: String,
    /// The command, word by word.
    pub command: Vec<String>,
    /// The study with every default filled in.
    pub study: serde_json::Value,
    pub seed: u64,
    pub inputs: Vec<InputDigest>,
    pub effort: EffortNote,
    /// What was done in another way than the study asks.
    pub fallbacks: Vec<Fallback>,
    /// What a reader of the result must know, such as a range that the sweep does not reach.
    pub notices: Vec<Notice>,
}
