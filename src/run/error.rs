use super::shard::ShardError;
use crate::artefact::ArtefactError;
use crate::cloth::ClothError;
use crate::colour::ColourError;
use crate::compare::CompareError;
use crate::fit::FitError;
use crate::optics::OpticsError;
use crate::output::OutputError;
use crate::report::ReportError;
use crate::rig::RigError;
use crate::sample::SampleError;
use crate::shading::ShadingError;
use crate::spectrum::SpectrumError;
use crate::study::{FileLine, Origin, Study, StudyError};
use crate::weave::WeaveError;
use crate::yarn::YarnError;
use std::path::PathBuf;

/// Why a study cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    #[error(transparent)]
    Study(#[from] StudyError),
    #[error(
        "`{section}.dye`: {source}; nor is there a file of that name in the study's folder: take one of these names, \
         or the path of a table wavelength_nm,value"
    )]
    Dye {
        section: &'static str,
        source: SpectrumError,
    },
    /// A dye without values at the study's wavelengths.
    #[error(
        "`{section}.dye`: {source}, or set `{section}.kappa_peak` to 0, which needs no dye, and absorb by \
         `{section}.host_mu_a_per_mm`"
    )]
    DyeRange {
        section: &'static str,
        source: SpectrumError,
    },
    /// A table that stands for the dye or a number of a medium: not there, no table of a spectrum, or not over the
    /// study's wavelengths.
    #[error("`{section}.{key}`: {source}")]
    Table {
        section: &'static str,
        key: &'static str,
        source: SpectrumError,
    },
    #[error(
        "`cloth.backing`: {source}; take \"none\", \"black\", \"white\" or the path of a spectrum of reflectances from \
         0 to 1"
    )]
    Backing { source: SpectrumError },
    /// What is wrong with the value of a key, and where the key stands.
    #[error("{place}: {source}")]
    At {
        place: Box<FileLine>,
        source: Box<RunError>,
    },
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// A medium that its keys do not make; `key` is the one that the error is of.
    #[error("`{section}.{key}`: {source}")]
    Medium {
        section: &'static str,
        key: &'static str,
        source: Box<OpticsError>,
    },
    #[error(transparent)]
    Yarn(#[from] YarnError),
    #[error(transparent)]
    Cloth(#[from] ClothError),
    #[error(transparent)]
    Shading(#[from] ShadingError),
    #[error(transparent)]
    Rig(#[from] RigError),
    #[error(transparent)]
    Colour(#[from] ColourError),
    /// Wavelengths of the study that carry no colour.
    #[error(
        "`spectrum.{key}`: {source}; `specval measure`, and `specval bsdf` to ssdd or csv, write spectra and need no \
         colour"
    )]
    Wavelengths {
        key: &'static str,
        source: Box<ColourError>,
    },
    #[error("`cloth.weave`: {0}")]
    Weave(#[from] WeaveError),
    #[error("`measured.sample`: {0}")]
    Sample(#[from] SampleError),
    #[error(transparent)]
    Fit(#[from] FitError),
    #[error(transparent)]
    Compare(#[from] CompareError),
    #[error(transparent)]
    Report(#[from] ReportError),
    #[error(transparent)]
    Output(#[from] OutputError),
    #[error(transparent)]
    Artefact(#[from] ArtefactError),
    /// A change of absorption that cannot be made.
    #[error("re-absorption: expected {expected}, found {found}; {remedy}")]
    Reabsorption {
        expected: &'static str,
        found: String,
        remedy: &'static str,
    },
    #[error(transparent)]
    Shard(#[from] ShardError),
    #[error(
        "{}: expected the state of at most {most} batches, with which this run would end, found {found}; ask for as \
         much as the run that left it, or remove it and start from the beginning", path.display()
    )]
    StateTooFar { path: PathBuf, found: usize, most: usize },
    #[error(
        "the ratios of Table 1 are of normal incidence and view: expected both in `[rig]`, found none; add incidence 0 \
         and view 0, or ask for the precision of `curves`"
    )]
    NoNormal,
}

impl RunError {
    /// What is wrong, wherever the key stands.
    pub fn unplaced(&self) -> &Self {
        match self {
            Self::At { source, .. } => source.unplaced(),
            other => other,
        }
    }

    /// The error of a medium in the section that sets what is wrong: a weft has from the warp what it does not set.
    pub(super) fn of_section(self, section: &'static str, study: &Study) -> Self {
        match self {
            Self::Medium { key, source, .. } if section == "weft" && study.weft.sets(key) => {
                Self::Medium { section, key, source }
            }
            other => other,
        }
    }

    /// With the place of the key that the error is of, if it has one there.
    pub(super) fn at(self, origin: &Origin) -> Self {
        let key = match &self {
            Self::Dye { section, .. } | Self::DyeRange { section, .. } => format!("{section}.dye"),
            Self::Table { section, key, .. } | Self::Medium { section, key, .. } => format!("{section}.{key}"),
            Self::Backing { .. } => "cloth.backing".into(),
            Self::Wavelengths { key, .. } => format!("spectrum.{key}"),
            Self::Weave(_) => "cloth.weave".into(),
            Self::Sample(_) => "measured.sample".into(),
            Self::Colour(ColourError::File { kind, .. }) => format!("colour.{kind}"),
            Self::Colour(ColourError::NoSuch(unknown)) => format!("colour.{}", unknown.kind),
            Self::Study(error) => return Self::Study(origin.locate(error.clone())),
            _ => return self,
        };
        match origin.place(&key) {
            Some(place) => Self::At {
                place,
                source: Box::new(self),
            },
            None => self,
        }
    }
}
