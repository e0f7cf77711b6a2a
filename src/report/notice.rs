//! Notices and fallbacks of a result. The result holds them as data; their wording is here alone.

use crate::compare::Geometry;
use crate::number::{nan_from_null, shown, significant, time_in_words};
use crate::sample::SampleNotice;
use crate::spectrum::Doubt;
use crate::study::OldKey;
use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};

/// An incidence at which shading with f* gains energy.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GrazingGain {
    pub theta_i_deg: f64,
    /// Reflected and transmitted fraction of a white cloth, above 1.
    pub white_albedo: f64,
}

/// A medium in which paths are long.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LongPaths {
    /// Mean number of particles that a path meets in a yarn, to two digits.
    pub particles: f64,
    /// Largest scattering coefficient over the wavelengths, 1/mm, to two digits.
    pub mu_s_per_mm: f64,
    pub host_index: f64,
}

/// The source that a ratio to red is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RatioOf {
    Sample,
    Model,
}

/// A ratio of Table 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TableRatio {
    BlueOverRed,
    GreenOverRed,
}

/// What the reader of a result must know.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "id", rename_all = "kebab-case")]
pub enum Notice {
    /// `report --quick`.
    Quick,
    /// `--max-time` takes more batches than the study, each `parts` times smaller.
    SmallerBatches {
        batches: u32,
        parts: u32,
    },
    /// Incidences at which a white cloth would send out more light than falls on it.
    GrazingGain {
        gains: Vec<GrazingGain>,
    },
    /// An old key in the study's file.
    OldKey {
        key: OldKey,
    },
    /// A diameter in the section of the study, nm, that looks like micrometres.
    ParticleDiameter {
        section: String,
        doubt: Doubt,
    },
    /// Angles of a key of the study that look like radians.
    StudyAngles {
        key: String,
        doubt: Doubt,
    },
    LongPaths {
        paths: LongPaths,
    },
    /// Before the run. `longest`: the key that lengthens it most and its value.
    LongRun {
        seconds: Option<f64>,
        paths: Option<LongPaths>,
        longest: Option<(String, u64)>,
    },
    /// The wavelengths of the study carry its colours badly.
    ModelColours {
        why: String,
    },
    /// Those of the sample do.
    MeasuredColours {
        why: String,
    },
    WarpAndWeftDiffer,
    /// What the reader of the sample assumed, left out or found implausible.
    Sample {
        notice: SampleNotice,
    },
    /// Hue in degrees and chroma, CIE Lab at equal luminance.
    AnotherCloth {
        model_hue_deg: f64,
        measured_hue_deg: f64,
        model_chroma: f64,
        measured_chroma: f64,
    },
    /// The model is known too badly for verdicts.
    VerdictsWithheld,
    /// Paths a tilt, and those from which verdicts are given.
    FewPaths {
        paths: usize,
        least: usize,
    },
    /// Every batch of the model is black at every geometry.
    NoModelLight,
    /// Rows of the energy ledger with fractions beyond 0 to 1.
    LedgerNoise {
        noisy: usize,
        rows: usize,
    },
    /// BLUE/RED of the model is known to `relative_se` after `paths` a tilt; 5 % take `times` as many.
    MorePaths {
        relative_se: f64,
        times: f64,
        paths: usize,
    },
    Sweep {
        media: usize,
        paths: usize,
        batches: usize,
    },
    /// Red is as good as 0.
    NoRatio {
        of: RatioOf,
        #[serde(deserialize_with = "nan_from_null")]
        red: f64,
        #[serde(deserialize_with = "nan_from_null")]
        red_se: f64,
    },
    /// Media of sweep and study whose red is as good as 0, and how many there are in all.
    MediaWithoutRatio {
        without: usize,
        media: usize,
    },
    /// The sweep's range beside the preprint's.
    SweepRange {
        ratio: TableRatio,
        range: [f64; 2],
        preprint: [f64; 2],
    },
    RgbSample,
}

impl From<SampleNotice> for Notice {
    fn from(notice: SampleNotice) -> Self {
        Self::Sample { notice }
    }
}

/// What was done in another way than the study asks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "id", rename_all = "kebab-case")]
pub enum Fallback {
    /// The rig lacks normal incidence and view, which Table 1 is of.
    NormalAdded,
    /// A dispersive host parts the wavelengths.
    IndependentEstimator,
    /// f* of a round yarn in place of that of an elliptical or uneven one.
    RoundYarnResponse,
    /// The yarns have their own gloss, so the model has none about the cloth's normal.
    YarnsShine,
    /// The sample has ratios alone.
    PublishedRatiosAlone {
        sample: String,
    },
    /// No reading at any geometry of the rig.
    NothingCompared {
        sample: String,
        incidences_deg: Vec<f64>,
    },
    /// Model or sample has no light at the reference.
    NotNormalised,
    /// The reference is not normal incidence and view.
    OtherReference {
        at: Geometry,
    },
    UncertaintyNotStated,
    /// Of a draft only the interlacement.
    InterlacementAlone {
        draft: String,
    },
}

impl Display for Notice {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Self::Quick => {
                f.write_str("--quick: paths and camera rays are reduced; `study` holds the numbers that were used")
            }
            Self::SmallerBatches { batches, parts } => write!(
                f,
                "--max-time: {batches} batches of 1/{parts} of the study's size each, so that the time can be kept"
            ),
            Self::GrazingGain { gains } => {
                let at = |gain: &GrazingGain| format!("{} deg (factor {:.2})", gain.theta_i_deg, gain.white_albedo);
                write!(
                    f,
                    "shading with f* gains energy at grazing incidence: a white cloth would send out more light than \
                     falls on it at {}; brightness factors there are too high, method = \"volumetric\" in [cloth] has \
                     no such limit",
                    gains.iter().map(at).collect::<Vec<_>>().join(", ")
                )
            }
            Self::OldKey { key } => key.fmt(f),
            Self::ParticleDiameter { section, doubt } => write!(f, "`{section}.particle_diameter_nm`: {doubt}"),
            Self::StudyAngles { key, doubt } => write!(f, "`{key}`: {doubt}"),
            Self::LongPaths { paths } => paths.fmt(f),
            Self::LongRun {
                seconds,
                paths,
                longest,
            } => {
                let mut words = Vec::new();
                words.extend(seconds.map(|seconds| {
                    format!(
                        "a long run: by an estimate it takes {} on one core",
                        time_in_words(seconds)
                    )
                }));
                words.extend(paths.map(|paths| paths.to_string()));
                words.extend(
                    longest
                        .as_ref()
                        .map(|(key, value)| format!("most of it for `{key}` = {value}")),
                );
                f.write_str(&words.join("; "))
            }
            Self::ModelColours { why } => write!(
                f,
                "the model's colours are doubtful: the study has few wavelengths for them: {why}; take [spectrum] \
                 390..730 nm in steps of 10 nm"
            ),
            Self::MeasuredColours { why } => write!(
                f,
                "the measured colours, and those of the classical shading made from them, are doubtful: {why}; measure \
                 400..700 nm in steps of 20 nm at most"
            ),
            Self::WarpAndWeftDiffer => {
                f.write_str("warp and weft differ: the energy ledger and the sweep are of the warp's yarn")
            }
            Self::Sample { notice } => notice.fmt(f),
            Self::AnotherCloth {
                model_hue_deg,
                measured_hue_deg,
                model_chroma,
                measured_chroma,
            } => write!(
                f,
                "model and sample plainly differ in colour: hue {model_hue_deg:.0} against {measured_hue_deg:.0} \
                 degrees, chroma {model_chroma:.0} against {measured_chroma:.0} (CIE Lab at equal luminance): the \
                 verdicts compare two different cloths; give the study the sample's dye (`medium.dye`)"
            ),
            Self::VerdictsWithheld => f.write_str(
                "too few paths: the model's luminance is known to no better than a quarter of its value, so verdicts \
                 are withheld; take more --paths",
            ),
            Self::FewPaths { paths, least } => write!(
                f,
                "too few paths: {paths} a tilt leave out the rare bright ones, so that standard errors are too small \
                 and verdicts are withheld; take --paths {least} or more"
            ),
            Self::NoModelLight => {
                f.write_str("the model sends no light to any view: there is nothing to normalise or to compare")
            }
            Self::LedgerNoise { noisy, rows } => write!(
                f,
                "too few paths: fractions of the energy ledger beyond 0 to 1 in {noisy} of {rows} rows, see their \
                 standard errors; more paths (`trace.paths_bssrdf`, or --paths) narrow them"
            ),
            Self::MorePaths {
                relative_se,
                times,
                paths,
            } => write!(
                f,
                "BLUE/RED of the model has a standard error of {1:.1} %: for 5 % it takes about {times:.1} times the \
                 paths of this run, {0} a tilt in place of {paths} (`--paths {0}`), and as many times the tracing time",
                (*paths as f64 * times).ceil(),
                100.0 * relative_se,
            ),
            Self::Sweep { media, paths, batches } => {
                write!(
                    f,
                    "sweep: {media} media, each with {paths} paths a tilt in {batches} batches"
                )
            }
            Self::NoRatio { of, red, red_se } => {
                let whose = match of {
                    RatioOf::Sample => "the sample",
                    RatioOf::Model => "the model",
                };
                write!(
                    f,
                    "red of {whose}, {} with standard error {}, is as good as 0 beside its other components: no ratio \
                     to it is shown",
                    significant(*red, 3),
                    significant(*red_se, 2)
                )
            }
            Self::MediaWithoutRatio { without, media } => write!(
                f,
                "{without} of the {media} media of the sweep and the study have no ratio to red, which is as good as \
                 0: they are not in the model's range"
            ),
            Self::SweepRange {
                ratio,
                range: [low, high],
                preprint: [from, to],
            } => {
                let name = match ratio {
                    TableRatio::BlueOverRed => "blue/red",
                    TableRatio::GreenOverRed => "green/red",
                };
                let covered = if low <= from && high >= to {
                    "covers"
                } else {
                    "does not cover"
                };
                write!(
                    f,
                    "the sweep's {name} range {low:.4}..{high:.4} {covered} the preprint's {from}..{to}"
                )
            }
            Self::RgbSample => f.write_str(
                "the sample is RGB, not spectral: its ratios have one convention, its own, and its luminance is the \
                 study's RGB space's luminance of its RGB",
            ),
        }
    }
}

impl Display for LongPaths {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        write!(
            f,
            "a path meets about {} particles in a yarn (3 in the default study), so tracing takes that much longer: \
             mu_s is up to {} 1/mm, and of light in a host of index {} total reflection keeps most inside; bring \
             `host_index` nearer to `particle_index`, lower `volume_fraction` or `radius_mm`, or trace fewer paths",
            shown(self.particles),
            shown(self.mu_s_per_mm),
            shown(self.host_index)
        )
    }
}

impl Display for Fallback {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Self::NormalAdded => {
                f.write_str("the rig has no normal incidence and view; it was added for the model's rows of Table 1")
            }
            Self::IndependentEstimator => f.write_str(
                "the host is dispersive: wavelengths part at the surface and cannot share paths; the independent \
                 estimator was used",
            ),
            Self::RoundYarnResponse => f.write_str(
                "yarns are elliptical or of varying radius: f* is that of the round yarn of the mean radius; the \
                 volumetric method has their shape",
            ),
            Self::YarnsShine => f.write_str(
                "the yarns shine by themselves: the model has no gloss about the cloth's normal, the classical shading \
                 has",
            ),
            Self::PublishedRatiosAlone { sample } => write!(
                f,
                "sample {sample} has published ratios and no readings: no classical model, no normalisation, no verdict"
            ),
            Self::NothingCompared { sample, incidences_deg } => {
                let incidences: Vec<String> = incidences_deg.iter().map(f64::to_string).collect();
                write!(
                    f,
                    "sample {sample} has no reading at any geometry of the study's [rig]: nothing is compared; its \
                     incidences are {} degrees: set `rig.incidences_deg` to these, or `rig.geometries = \"auto\"` with \
                     the built-in angles",
                    incidences.join(", ")
                )
            }
            Self::NotNormalised => f.write_str(
                "the model or the sample has no light where it would be normalised: values are compared as they are",
            ),
            Self::OtherReference { at } => write!(
                f,
                "the sample has no reading with light at normal incidence and view: normalisation, the classical \
                 shading and the sample's row of Table 1 are of the nearest one, incidence {} and view {} degrees",
                at.theta_i_deg, at.theta_v_deg
            ),
            Self::UncertaintyNotStated => {
                f.write_str("the sample states no uncertainty: its standard errors are taken as 0")
            }
            Self::InterlacementAlone { draft } => write!(
                f,
                "of the draft {draft} the interlacement alone is taken: warp and weft have the study's yarns, and \
                 colours, spacings and thicknesses of the file are left out"
            ),
        }
    }
}
