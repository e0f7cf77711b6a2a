//! Yarns of a study and their media: every table read, on the study's wavelengths.

use super::RunError;
use crate::fault::{self, Fault};
use crate::optics::{Interference, Medium, MediumSpec};
use crate::report::InputDigest;
use crate::spectrum::{Samples, Spectrum, SpectrumError, WavelengthGrid, read_spectrum, tables};
use crate::study::{EstimatorChoice, InterferenceChoice, MediumSection, NumberOrTable, Study};
use crate::transport::{Cylinder, Roulette};
use crate::yarn::{Estimator, Yarn, YarnError};
use std::path::Path;

/// The weft's yarn, if it is not the warp's. Tables of `[medium]` that it shares were read for the warp, so what is
/// wrong here is a key of `[weft]`.
pub(super) fn weft(
    study: &Study,
    grid: &WavelengthGrid,
    inputs: &mut Vec<InputDigest>,
) -> Result<Option<Yarn>, RunError> {
    let medium = study.weft.medium(&study.medium);
    let radius_mm = study.weft.radius_mm.unwrap_or(study.yarn.radius_mm);
    if medium == study.medium && radius_mm == study.yarn.radius_mm {
        return Ok(None);
    }
    let spectra = MediumSpectra::read("weft", &medium, grid)?;
    let digests = spectra.digests(&medium, grid)?.into_iter();
    inputs.extend(digests.map(|digest| InputDigest {
        name: format!("weft {}", digest.name),
        ..digest
    }));
    Ok(Some(yarn(study, "weft", radius_mm, &medium, spectra, grid)?))
}

pub(super) fn yarn(
    study: &Study,
    section: &'static str,
    radius_mm: f64,
    medium: &MediumSection,
    spectra: MediumSpectra,
    grid: &WavelengthGrid,
) -> Result<Yarn, RunError> {
    let cylinder = Cylinder::new(radius_mm).map_err(YarnError::from)?;
    let roulette =
        Roulette::new(study.trace.roulette_threshold, study.trace.roulette_survival).map_err(YarnError::from)?;
    Ok(Yarn {
        cylinder,
        medium: medium_of(medium, spectra, grid).map_err(|error| error.of_section(section, study))?,
        roulette,
        estimator: match study.trace.estimator {
            EstimatorChoice::Shared => Estimator::Shared,
            EstimatorChoice::Independent => Estimator::Independent,
        },
    })
}

/// What a medium's section says as functions of wavelength, every file read.
pub(super) struct MediumSpectra {
    host_index: Spectrum,
    host_mu_a_per_mm: Spectrum,
    particle_index: Spectrum,
    dye: Spectrum,
}

impl MediumSpectra {
    /// `section` is what errors call it.
    pub fn read(section: &'static str, of: &MediumSection, grid: &WavelengthGrid) -> Result<Self, RunError> {
        let read = |key, of| number_or_table(section, key, of, grid);
        Ok(Self {
            host_index: read("host_index", &of.host_index)?,
            host_mu_a_per_mm: read("host_mu_a_per_mm", &of.host_mu_a_per_mm)?,
            particle_index: read("particle_index", &of.particle_index)?,
            dye: dye_of(section, of, grid)?,
        })
    }

    /// Of the tables, as the grid takes them; numbers stand in the study itself.
    pub fn digests(&self, of: &MediumSection, grid: &WavelengthGrid) -> Result<Vec<InputDigest>, RunError> {
        let spectra = [
            ("dye", &self.dye, Some(of.dye.as_str())),
            ("host_index", &self.host_index, of.host_index.table()),
            ("host_mu_a_per_mm", &self.host_mu_a_per_mm, of.host_mu_a_per_mm.table()),
            ("particle_index", &self.particle_index, of.particle_index.table()),
        ];
        let mut digests = Vec::new();
        for (key, spectrum, table) in spectra {
            if let Some(name) = table {
                digests.push(InputDigest::of(
                    format!("{key} {name}"),
                    &le_bytes(spectrum.on(grid)?.values()),
                ));
            }
        }
        Ok(digests)
    }
}

/// The medium of a study's section on a grid; errors are those of the warp's.
fn medium_of(of: &MediumSection, spectra: MediumSpectra, grid: &WavelengthGrid) -> Result<Medium, RunError> {
    Medium::new(&spec_of(of, spectra, grid)?, grid).map_err(|source| RunError::Medium {
        section: "medium",
        key: source.key(),
        source: Box::new(source),
    })
}

fn spec_of(of: &MediumSection, spectra: MediumSpectra, grid: &WavelengthGrid) -> Result<MediumSpec, RunError> {
    let kappa = spectra
        .dye
        .on(grid)?
        .values()
        .iter()
        .map(|share| of.kappa_peak * share)
        .collect();
    Ok(MediumSpec {
        host_index: spectra.host_index,
        particle_index: spectra.particle_index,
        particle_kappa: Spectrum::Table {
            name: of.dye.clone(),
            samples: Samples::new(&of.dye, grid, kappa)?,
        },
        host_mu_a_per_mm: spectra.host_mu_a_per_mm,
        particle_diameter_nm: of.particle_diameter_nm,
        volume_fraction: of.volume_fraction,
        interference: match of.interference {
            InterferenceChoice::Independent => Interference::Independent,
            InterferenceChoice::PercusYevick => Interference::PercusYevick,
        },
    })
}

/// What the warp's medium of a study is made of, on a grid.
pub(crate) fn medium_spec(study: &Study, grid: &WavelengthGrid) -> Result<MediumSpec, RunError> {
    spec_of(&study.medium, MediumSpectra::read("medium", &study.medium, grid)?, grid)
}

/// The medium of a valid study alone.
pub fn medium(study: &Study) -> Result<Medium, RunError> {
    study.validate()?;
    let grid = WavelengthGrid::new(study.spectrum.wavelengths())?;
    MediumSpectra::read("medium", &study.medium, &grid)
        .and_then(|spectra| medium_of(&study.medium, spectra, &grid))
        .map_err(|error| error.at(&study.origin))
}

/// A number of a medium, or the table from the file that it names; `key` is without the section.
fn number_or_table(
    section: &'static str,
    key: &'static str,
    of: &NumberOrTable,
    grid: &WavelengthGrid,
) -> Result<Spectrum, RunError> {
    let path = match of {
        NumberOrTable::Number(value) => return Ok(Spectrum::Constant(*value)),
        NumberOrTable::Table(path) => path,
    };
    let at_key = |source| RunError::Table { section, key, source };
    let table = read_spectrum(Path::new(path), ..).map_err(at_key)?;
    if let Spectrum::Table { samples, .. } = &table {
        Study::check_medium_table(section, key, path, samples)?;
    }
    table.on(grid).map_err(at_key)?;
    Ok(table)
}

/// Shape of the study's dye on its grid.
pub(crate) fn dye_on(study: &Study, grid: &WavelengthGrid) -> Result<Samples, RunError> {
    Ok(dye_of("medium", &study.medium, grid)?.on(grid)?)
}

/// The dye of a medium, which has values on the grid. One that absorbs nothing needs none there.
fn dye_of(section: &'static str, of: &MediumSection, grid: &WavelengthGrid) -> Result<Spectrum, RunError> {
    let dye = dye(section, &of.dye)?;
    match dye.on(grid) {
        Err(SpectrumError::OutsideTable { .. }) if of.kappa_peak == 0.0 => Ok(Spectrum::Constant(0.0)),
        Err(source @ SpectrumError::OutsideTable { .. }) => Err(RunError::DyeRange { section, source }),
        Err(source) => Err(RunError::Table {
            section,
            key: "dye",
            source,
        }),
        Ok(_) => Ok(dye),
    }
}

/// A built-in dye by its name, else one from a file.
fn dye(section: &'static str, name: &str) -> Result<Spectrum, RunError> {
    if fault::active(Fault::DyeScale)
        && let Spectrum::Table { name, samples } = tables::dye(name)?
    {
        let stronger = samples.values().iter().map(|value| 1.02 * value).collect();
        return Ok(Spectrum::Table {
            name: name.clone(),
            samples: Samples::new(name, samples.grid(), stronger)?,
        });
    }
    let unknown = match tables::dye(name) {
        Ok(dye) => return Ok(dye.clone()),
        Err(source) => source,
    };
    let path = Path::new(name);
    if path.exists() {
        return read_spectrum(path, 0.0..=1.0).map_err(|source| RunError::Table {
            section,
            key: "dye",
            source,
        });
    }
    Err(RunError::Dye {
        section,
        source: unknown,
    })
}

pub(super) fn le_bytes(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}
