use crate::cloth::{CentreLineKind, Cloth, ClothError, ClothSpec, Weave};
use crate::colour::{ColourError, ColourSystem};
use crate::compare::{CompareError, Geometry};
use crate::optics::{Interference, Medium, MediumSpec, OpticsError};
use crate::report::{InputDigest, ReportError};
use crate::rig::{PixelSamples, Rig, RigError};
use crate::sample::{Sample, SampleError};
use crate::shading::{Distribution, ShadingError, Specular};
use crate::spectrum::{Samples, Spectrum, SpectrumError, WavelengthGrid, read_csv_spectrum, tables};
use crate::study::{
    CentreLineChoice, DistributionChoice, InterferenceChoice, MediumSection, Study, StudyError, WeaveChoice,
};
use crate::transport::{Cylinder, Roulette};
use crate::yarn::{Effort, IncidentGrid, RadianceFactorGrid, SurfaceGrid, Yarn, YarnError};
use std::path::Path;

/// Why a study cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    #[error(transparent)]
    Study(#[from] StudyError),
    #[error("`medium.dye`: {source}; nor is there a file of that name")]
    Dye { source: SpectrumError },
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    #[error(transparent)]
    Optics(#[from] OpticsError),
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
    #[error("`measured.sample`: {0}")]
    Sample(#[from] SampleError),
    #[error(transparent)]
    Compare(#[from] CompareError),
    #[error(transparent)]
    Report(#[from] ReportError),
}

/// A study with every value checked, every file read and every name resolved: what a run takes.
pub struct Plan {
    pub study: Study,
    pub grid: WavelengthGrid,
    pub yarn: Yarn,
    pub incident: IncidentGrid,
    pub bssrdf_surface: SurfaceGrid,
    pub bssrdf_effort: Effort,
    pub factor_grid: RadianceFactorGrid,
    pub direct_effort: Effort,
    pub cloth: Cloth,
    pub specular: Specular,
    pub rig: Rig,
    pub pixels: PixelSamples,
    pub colour: ColourSystem,
    pub sample: Sample,
    /// Digests of the tables and files that went in.
    pub inputs: Vec<InputDigest>,
}

impl Plan {
    pub fn new(study: Study) -> Result<Self, RunError> {
        study.validate()?;
        let grid = WavelengthGrid::new(study.spectrum.wavelengths())?;
        let dye = dye(&study.medium.dye)?;
        let sample = Sample::load(&study.measured.sample)?;
        let inputs = vec![
            InputDigest::of(format!("dye {}", study.medium.dye), &le_bytes(dye.on(&grid)?.values())),
            InputDigest {
                name: format!("sample {}", study.measured.sample),
                sha256: sample.digest().to_owned(),
            },
        ];
        let trace = &study.trace;
        let cells = |n: u32| n as usize;
        let surface = |theta, phi| SurfaceGrid::new(cells(trace.exit_azimuth_cells), cells(theta), cells(phi));
        let factor_grid = RadianceFactorGrid::new(
            cells(trace.tilts),
            surface(trace.exit_theta_cells, trace.exit_phi_cells)?,
        )?;
        let effort = |paths| Effort::new(study.seed, cells(trace.batches), paths);
        let specular = &study.specular;
        let pixels = cells(study.rig.pixels_per_side);
        Ok(Self {
            yarn: yarn(&study, &study.medium, &dye, &grid)?,
            incident: IncidentGrid::new(
                cells(trace.zenith_cells),
                cells(trace.azimuth_cells),
                trace.fold_symmetry,
            )?,
            bssrdf_surface: surface(trace.bssrdf_exit_theta_cells, trace.bssrdf_exit_phi_cells)?,
            bssrdf_effort: effort(trace.paths_bssrdf)?,
            factor_grid,
            direct_effort: effort(trace.paths_direct)?,
            cloth: Cloth::new(&cloth_spec(&study))?,
            specular: Specular::new(
                match specular.distribution {
                    DistributionChoice::Beckmann => Distribution::Beckmann,
                    DistributionChoice::TrowbridgeReitz => Distribution::TrowbridgeReitz,
                },
                specular.roughness,
                specular.index,
                specular.weight,
            )?,
            rig: Rig::new(study.rig.incidences_deg.clone(), study.rig.views_deg())?,
            pixels: PixelSamples::new(pixels, pixels)?,
            colour: ColourSystem::new(&grid, study.colour)?,
            sample,
            inputs,
            grid,
            study,
        })
    }

    /// The same yarn of another medium.
    pub fn yarn_of(&self, medium: &MediumSection) -> Result<Yarn, RunError> {
        yarn(&self.study, medium, &dye(&medium.dye)?, &self.grid)
    }

    /// Every pair of incidence and view of the rig.
    pub fn geometries(&self) -> Vec<Geometry> {
        let views = self.rig.views_deg();
        self.rig
            .incidences_deg()
            .iter()
            .flat_map(|&theta_i_deg| {
                views.iter().map(move |&theta_v_deg| Geometry {
                    theta_i_deg,
                    theta_v_deg,
                })
            })
            .collect()
    }
}

fn le_bytes(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn yarn(study: &Study, medium: &MediumSection, dye: &Spectrum, grid: &WavelengthGrid) -> Result<Yarn, RunError> {
    let radius = Cylinder::new(study.yarn.radius_mm).map_err(YarnError::from)?;
    let roulette =
        Roulette::new(study.trace.roulette_threshold, study.trace.roulette_survival).map_err(YarnError::from)?;
    Ok(Yarn {
        cylinder: radius,
        medium: medium_of(medium, dye, grid)?,
        roulette,
    })
}

/// The medium of a study's section on a grid.
fn medium_of(of: &MediumSection, dye: &Spectrum, grid: &WavelengthGrid) -> Result<Medium, RunError> {
    let kappa = dye
        .on(grid)?
        .values()
        .iter()
        .map(|share| of.kappa_peak * share)
        .collect();
    let spec = MediumSpec {
        host_index: Spectrum::Constant(of.host_index),
        particle_index: Spectrum::Constant(of.particle_index),
        particle_kappa: Spectrum::Table {
            name: of.dye.clone(),
            samples: Samples::new(&of.dye, grid, kappa)?,
        },
        host_mu_a_per_mm: Spectrum::Constant(of.host_mu_a_per_mm),
        particle_diameter_nm: of.particle_diameter_nm,
        volume_fraction: of.volume_fraction,
        interference: match of.interference {
            InterferenceChoice::Independent => Interference::Independent,
            InterferenceChoice::PercusYevick => Interference::PercusYevick,
        },
    };
    Ok(Medium::new(&spec, grid)?)
}

/// The medium of a valid study alone.
pub fn medium(study: &Study) -> Result<Medium, RunError> {
    study.validate()?;
    let grid = WavelengthGrid::new(study.spectrum.wavelengths())?;
    medium_of(&study.medium, &dye(&study.medium.dye)?, &grid)
}

/// A built-in dye by its name, else one from a file.
fn dye(name: &str) -> Result<Spectrum, RunError> {
    let unknown = match tables::dye(name) {
        Ok(dye) => return Ok(dye.clone()),
        Err(source) => source,
    };
    let path = Path::new(name);
    if path.exists() {
        return Ok(read_csv_spectrum(path)?);
    }
    Err(RunError::Dye { source: unknown })
}

fn cloth_spec(study: &Study) -> ClothSpec {
    let cloth = &study.cloth;
    let radius_mm = study.yarn.radius_mm;
    let spacing_mm = 2.0 * radius_mm * cloth.spacing_diameters;
    ClothSpec {
        weave: match cloth.weave {
            WeaveChoice::Plain => Weave::Plain,
            WeaveChoice::Twill21 => Weave::Twill21,
            WeaveChoice::Twill31 => Weave::Twill31,
            WeaveChoice::Satin5 => Weave::Satin5,
        },
        centre_line: match cloth.centre_line {
            CentreLineChoice::Peirce => CentreLineKind::Peirce,
            CentreLineChoice::Sinusoid => CentreLineKind::Sinusoid {
                amplitude_mm: cloth.sinusoid_amplitude_mm.unwrap_or(radius_mm),
            },
        },
        warp_radius_mm: radius_mm,
        weft_radius_mm: radius_mm,
        warp_spacing_mm: spacing_mm,
        weft_spacing_mm: spacing_mm,
        segments_around: cloth.segments_around as usize,
        segments_along: cloth.segments_along as usize,
    }
}
