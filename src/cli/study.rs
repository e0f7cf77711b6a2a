//! From the study's file to the inputs of the first stage.

use super::Failure;
use specval::optics::{Interference, Medium, MediumSpec};
use specval::spectrum::{Samples, Spectrum, SpectrumError, WavelengthGrid, read_csv_spectrum, tables};
use specval::study::{InterferenceChoice, Study, StudyError};
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
    #[error("`medium.dye`: {source}; nor is there a file of that name")]
    Dye { source: SpectrumError },
}

/// The study of the file, or the built-in one.
pub fn load(path: Option<&Path>) -> Result<Study, LoadError> {
    let Some(path) = path else {
        return Ok(Study::default());
    };
    let text = std::fs::read_to_string(path).map_err(|cause| LoadError::Read {
        path: path.to_owned(),
        cause,
    })?;
    Ok(Study::from_toml(&text, &path.display().to_string())?)
}

/// The medium of a valid study, on its wavelengths.
pub fn medium(study: &Study) -> Result<Medium, Failure> {
    let grid = WavelengthGrid::new(study.spectrum.wavelengths())?;
    let of = &study.medium;
    let absorption = dye(&of.dye)?.on(&grid)?;
    let kappa = absorption.values().iter().map(|share| of.kappa_peak * share).collect();
    let spec = MediumSpec {
        host_index: Spectrum::Constant(of.host_index),
        particle_index: Spectrum::Constant(of.particle_index),
        particle_kappa: Spectrum::Table {
            name: of.dye.clone(),
            samples: Samples::new(&of.dye, &grid, kappa)?,
        },
        host_mu_a_per_mm: Spectrum::Constant(of.host_mu_a_per_mm),
        particle_diameter_nm: of.particle_diameter_nm,
        volume_fraction: of.volume_fraction,
        interference: match of.interference {
            InterferenceChoice::Independent => Interference::Independent,
            InterferenceChoice::PercusYevick => Interference::PercusYevick,
        },
    };
    Ok(Medium::new(&spec, &grid)?)
}

/// A built-in dye by its name, else one from a file.
fn dye(name: &str) -> Result<Spectrum, Failure> {
    let unknown = match tables::dye(name) {
        Ok(dye) => return Ok(dye.clone()),
        Err(source) => source,
    };
    let path = Path::new(name);
    if path.exists() {
        return Ok(read_csv_spectrum(path)?);
    }
    Err(LoadError::Dye { source: unknown }.into())
}
