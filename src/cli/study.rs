//! From what was typed to a study.

use super::Options;
use specval::study::{Study, StudyError};
use std::path::{Path, PathBuf};

/// Why there is no study to run.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    #[error("{}: the study cannot be read; `specval init` writes one", path.display())]
    Read {
        path: PathBuf,
        #[source]
        cause: std::io::Error,
    },
    #[error(transparent)]
    Study(#[from] StudyError),
}

/// The study of the file, or the built-in one, with the options of the command line in it.
pub fn load(path: Option<&Path>, options: &Options) -> Result<Study, LoadError> {
    let mut study = match path {
        None => Study::default(),
        Some(path) => {
            let text = std::fs::read_to_string(path).map_err(|cause| LoadError::Read {
                path: path.to_owned(),
                cause,
            })?;
            let study = Study::from_toml(&text, &path.display().to_string())?;
            study.at_folder(path.parent().unwrap_or(Path::new("")))
        }
    };
    if let Some(seed) = options.seed {
        study.seed = seed;
    }
    if let Some(paths) = options.paths {
        study.trace.paths_bssrdf = paths.get();
        study.trace.paths_direct = paths.get();
        study.trace.particles = paths.get();
        study.trace.particles_volumetric = paths.get();
        for key in ["paths_bssrdf", "paths_direct", "particles", "particles_volumetric"] {
            study.origin.forget(&format!("trace.{key}"));
        }
    }
    study.validate()?;
    Ok(study)
}
