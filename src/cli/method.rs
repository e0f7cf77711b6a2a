//! `--method` of `measure` and `bsdf`.

use super::Options;
use super::study::{self, LoadError};
use specval::study::{MethodChoice, Study};
use std::path::Path;

/// How light in the cloth is simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Method {
    /// Yarns scatter by their f*; `[cloth] bounces` says how often light goes on.
    RadianceFactor,
    /// Traced through the medium of every yarn that light meets.
    Volumetric,
}

impl Method {
    /// The study of the file, or the built-in one, with the options of the command line and this method, if any, in it.
    pub fn study(method: Option<Self>, path: Option<&Path>, options: &Options) -> Result<Study, LoadError> {
        let mut study = study::load(path, options)?;
        if let Some(method) = method {
            study.cloth.method = method.choice();
            study.origin.give("cloth.method", "--method");
        }
        Ok(study)
    }

    pub fn choice(self) -> MethodChoice {
        match self {
            Self::RadianceFactor => MethodChoice::RadianceFactor,
            Self::Volumetric => MethodChoice::Volumetric,
        }
    }
}
