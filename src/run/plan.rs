use super::{RunError, cloth_keys};
use crate::cloth::light::{Scene, YarnSurface};
use crate::cloth::{CentreLineKind, Cloth, ClothSpec, Weave};
use crate::colour::{ColourSystem, Convention};
use crate::fault::{self, Fault};
use crate::optics::{Interference, Medium, MediumSpec};
use crate::report::InputDigest;
use crate::rig::{BeamsOfRig, Direct, Geometry, PixelSamples, Rig};
use crate::sample::{Chosen, Sample};
use crate::shading::{Distribution, FibreGloss, ShadingError, Specular};
use crate::spectrum::{Samples, Spectrum, SpectrumError, WavelengthGrid, read_spectrum, tables};
use crate::study::{
    CentreLineChoice, DistributionChoice, EstimatorChoice, InterferenceChoice, MediumSection, NumberOrTable,
    SpecularSection, Study, SurfaceChoice, TraceSection,
};
use crate::transport::{Cylinder, Roulette};
use crate::weave::WeaveDraft;
use crate::yarn::{BssrdfGrid, Effort, Estimator, IncidentGrid, SurfaceGrid, Yarn, YarnError, YarnResponseGrid};
use std::path::Path;

/// A study with every value checked, every file read and every name resolved: what a run takes.
pub struct Plan {
    pub study: Study,
    pub grid: WavelengthGrid,
    /// Of the warp, and of the weft where that is no other.
    pub yarn: Yarn,
    /// Of the weft, where `[weft]` says that it differs.
    pub weft: Option<Yarn>,
    pub incident: IncidentGrid,
    pub bssrdf_surface: SurfaceGrid,
    pub bssrdf_effort: Effort,
    pub factor_grid: YarnResponseGrid,
    pub direct_effort: Effort,
    pub cloth_spec: ClothSpec,
    /// Reflectance of what lies under the cloth; `None` where light goes on.
    pub backing: Option<Samples>,
    pub cloth: Cloth,
    pub specular: Specular,
    /// Gloss of the yarns' fibres, where they are what shines.
    pub fibres: Option<FibreGloss>,
    pub rig: Rig,
    pub pixels: PixelSamples,
    pub colour: ColourSystem,
    pub sample: Sample,
    /// Component of the sample that was asked for.
    pub(super) chosen: Chosen,
    /// Digests of the tables and files that went in.
    pub inputs: Vec<InputDigest>,
}

impl Plan {
    pub fn new(study: Study) -> Result<Self, RunError> {
        Self::with_sample(study, Chosen::default())
    }

    /// [`Plan::new`] with a component of the study's sample that is chosen.
    pub fn with_sample(study: Study, chosen: Chosen) -> Result<Self, RunError> {
        let origin = study.origin.clone();
        Self::resolve(study, chosen).map_err(|error| error.at(&origin))
    }

    fn resolve(study: Study, chosen: Chosen) -> Result<Self, RunError> {
        study.validate()?;
        let grid = WavelengthGrid::new(study.spectrum.wavelengths())?;
        let spectra = MediumSpectra::read("medium", &study.medium, &grid)?;
        let sample = Sample::load_chosen(&study.measured.sample, chosen)?;
        let mut inputs = spectra.digests(&study.medium, &grid)?;
        let weft = weft(&study, &grid, &mut inputs)?;
        inputs.push(InputDigest {
            name: format!("sample {}", study.measured.sample),
            sha256: sample.digest().to_owned(),
        });
        let convention = study.colour.convention()?;
        sample.check_convention(&convention)?;
        inputs.extend(colour_files(&convention));
        let weave = weave(&study, &mut inputs)?;
        let cloth_spec = cloth_spec(&study, weave);
        let cloth = Cloth::new(&cloth_spec).map_err(|error| match cloth_keys::at_key(&study, &cloth_spec, &error) {
            Some(error) => RunError::Study(error),
            None => RunError::Cloth(error),
        })?;
        let backing = backing(&study.cloth.backing, &grid, &mut inputs)?;
        let trace = &study.trace;
        let effort = |paths| Effort::new(study.seed, trace.batches as usize, paths);
        let specular = &study.specular;
        let pixels = study.rig.pixels_per_side as usize;
        Ok(Self {
            yarn: yarn(&study, "medium", study.yarn.radius_mm, &study.medium, spectra, &grid)?,
            weft,
            incident: incident_grid(trace)?,
            bssrdf_surface: bssrdf_surface(trace)?,
            bssrdf_effort: effort(trace.paths_bssrdf)?,
            factor_grid: factor_grid(trace)?,
            direct_effort: effort(trace.paths_direct)?,
            cloth,
            cloth_spec,
            backing,
            specular: Specular::new(
                match specular.distribution {
                    DistributionChoice::Beckmann => Distribution::Beckmann,
                    DistributionChoice::TrowbridgeReitz => Distribution::TrowbridgeReitz,
                },
                specular.roughness,
                specular.index,
                specular.weight,
            )?,
            fibres: fibres(&study)?,
            rig: Rig::new(study.rig.incidences_deg.clone(), study.rig.views_deg())?,
            pixels: PixelSamples::new(pixels, pixels)?,
            colour: ColourSystem::new(&grid, convention)?,
            sample,
            chosen,
            inputs,
            grid,
            study,
        })
    }

    /// Axes of the stored BSSRDF of a yarn.
    pub fn bssrdf_grid(&self, yarn: &Yarn) -> Result<BssrdfGrid, RunError> {
        let z_cells = self.study.trace.z_cells as usize;
        Ok(BssrdfGrid::new(yarn, self.incident, self.bssrdf_surface, z_cells)?)
    }

    /// The warp's yarn of another medium.
    pub fn yarn_of(&self, medium: &MediumSection) -> Result<Yarn, RunError> {
        yarn(
            &self.study,
            "medium",
            self.study.yarn.radius_mm,
            medium,
            MediumSpectra::read("medium", medium, &self.grid)?,
            &self.grid,
        )
    }

    /// What becomes of light that the yarns reflect, if it goes on: a mirror sends it on but for a study of fibres.
    pub(crate) fn surface(&self, goes_on: bool) -> YarnSurface {
        match self.fibres {
            _ if !goes_on => YarnSurface::Lost,
            Some(gloss) => YarnSurface::Fibres(gloss),
            None => YarnSurface::Smooth,
        }
    }

    /// What light meets. Whether what the yarns' surface reflects goes on, and whether the cloth lies on the study's
    /// backing.
    pub fn scene(&self, surface_goes_on: bool, on_backing: bool) -> Scene<'_> {
        Scene {
            cloth: &self.cloth,
            yarns: self.yarns(),
            backing: self.backing.as_ref().filter(|_| on_backing).map(Samples::values),
            surface: self.surface(surface_goes_on),
            seed: self.study.seed,
        }
    }

    /// The study's camera on its cloth.
    pub fn direct(&self) -> Direct<'_> {
        Direct::new(
            &self.scene(false, false),
            self.different_yarns().count(),
            self.factor_grid,
            self.pixels,
        )
    }

    /// The beams of geometries, and the views that look at what each lights.
    pub fn beams(&self, geometries: &[Geometry]) -> BeamsOfRig {
        let half_angle = self.study.rig.aperture_half_angle_deg.to_radians();
        BeamsOfRig::new(geometries, self.study.cloth.azimuth_deg, half_angle)
    }

    /// Of warp and weft.
    pub fn yarns(&self) -> [&Yarn; 2] {
        let weft = self.weft.as_ref().filter(|_| !fault::active(Fault::WeftAsWarp));
        [&self.yarn, weft.unwrap_or(&self.yarn)]
    }

    /// Those of them that differ, the warp's first: f* is traced once for each.
    pub fn different_yarns(&self) -> impl Iterator<Item = &Yarn> {
        std::iter::once(&self.yarn).chain(&self.weft)
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

pub(super) fn incident_grid(trace: &TraceSection) -> Result<IncidentGrid, YarnError> {
    IncidentGrid::new(
        trace.zenith_cells as usize,
        trace.azimuth_cells as usize,
        trace.fold_symmetry,
    )
}

/// Axes of f*.
pub(super) fn factor_grid(trace: &TraceSection) -> Result<YarnResponseGrid, YarnError> {
    let surface = SurfaceGrid::new(
        trace.exit_azimuth_cells as usize,
        trace.exit_theta_cells as usize,
        trace.exit_phi_cells as usize,
    )?;
    YarnResponseGrid::new(trace.tilts as usize, surface)
}

/// Where and in what direction light leaves in the stored BSSRDF.
pub(super) fn bssrdf_surface(trace: &TraceSection) -> Result<SurfaceGrid, YarnError> {
    SurfaceGrid::new(
        trace.bssrdf_azimuth_cells as usize,
        trace.bssrdf_exit_theta_cells as usize,
        trace.bssrdf_exit_phi_cells as usize,
    )
}

/// The weft's yarn, if it is not the warp's. Tables of `[medium]` that it shares were read for the warp, so what is
/// wrong here is a key of `[weft]`.
fn weft(study: &Study, grid: &WavelengthGrid, inputs: &mut Vec<InputDigest>) -> Result<Option<Yarn>, RunError> {
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

fn yarn(
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
struct MediumSpectra {
    host_index: Spectrum,
    host_mu_a_per_mm: Spectrum,
    particle_index: Spectrum,
    dye: Spectrum,
}

impl MediumSpectra {
    /// `section` is what errors call it.
    fn read(section: &'static str, of: &MediumSection, grid: &WavelengthGrid) -> Result<Self, RunError> {
        let read = |key, of| number_or_table(section, key, of, grid);
        Ok(Self {
            host_index: read("host_index", &of.host_index)?,
            host_mu_a_per_mm: read("host_mu_a_per_mm", &of.host_mu_a_per_mm)?,
            particle_index: read("particle_index", &of.particle_index)?,
            dye: dye_of(section, of, grid)?,
        })
    }

    /// Of the tables, as the grid takes them; numbers stand in the study itself.
    fn digests(&self, of: &MediumSection, grid: &WavelengthGrid) -> Result<Vec<InputDigest>, RunError> {
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

/// Digests of the files that stand for the observer and the illuminant.
fn colour_files(convention: &Convention) -> Vec<InputDigest> {
    let digest = |key, path: &str, bytes: &[u8]| InputDigest::of(format!("{key} {path}"), bytes);
    let observer = convention
        .observer
        .file()
        .map(|f| digest("observer", &f.path, &f.bytes));
    let illuminant = convention
        .illuminant
        .file()
        .map(|f| digest("illuminant", &f.path, &f.bytes));
    observer.into_iter().chain(illuminant).collect()
}

/// The weave by its name, or the repeat of the draft, whose drawdown goes into the inputs' digests.
fn weave(study: &Study, inputs: &mut Vec<InputDigest>) -> Result<Weave, RunError> {
    let name_or_path = &study.cloth.weave;
    if let Some(weave) = Weave::named(name_or_path) {
        return Ok(weave);
    }
    let draft = WeaveDraft::load(name_or_path)?;
    let [wefts, warps] = draft.repeat();
    let crossings = (0..wefts).flat_map(|i| (0..warps).map(move |j| (i, j)));
    let mut drawdown: Vec<u8> = format!("{wefts} {warps} ").into_bytes();
    drawdown.extend(crossings.map(|(i, j)| if draft.warp_on_top(i, j) { b'X' } else { b'.' }));
    inputs.push(InputDigest::of(format!("draft {name_or_path}"), &drawdown));
    let draft = draft.draft().map_err(|error| cloth_keys::of_weave(study, &error))?;
    Ok(Weave::Custom(draft))
}

/// A word, or a file of reflectances from 0 to 1.
fn backing(of: &str, grid: &WavelengthGrid, inputs: &mut Vec<InputDigest>) -> Result<Option<Samples>, RunError> {
    let even = |reflectance| Samples::new(of, grid, vec![reflectance; grid.len()]);
    match of {
        "none" => return Ok(None),
        "black" => return Ok(Some(even(0.0)?)),
        "white" => return Ok(Some(even(1.0)?)),
        _ => {}
    }
    let reflectance = read_spectrum(Path::new(of), 0.0..=1.0)
        .and_then(|spectrum| spectrum.on(grid))
        .map_err(|source| RunError::Backing { source })?;
    inputs.push(InputDigest::of(
        format!("backing {of}"),
        &le_bytes(reflectance.values()),
    ));
    Ok(Some(reflectance))
}

fn fibres(study: &Study) -> Result<Option<FibreGloss>, ShadingError> {
    let specular = &study.specular;
    if specular.surface != SurfaceChoice::Fibres {
        return Ok(None);
    }
    FibreGloss::new(
        study.yarn.twist_deg.unwrap_or(0.0).to_radians(),
        specular.roughness,
        specular.roughness_across.unwrap_or(SpecularSection::ROUGHNESS_ACROSS),
    )
    .map(Some)
}

fn cloth_spec(study: &Study, weave: Weave) -> ClothSpec {
    let cloth = &study.cloth;
    let warp_radius_mm = study.yarn.radius_mm;
    let weft_radius_mm = study.weft.radius_mm.unwrap_or(warp_radius_mm);
    let mean_diameter_mm = warp_radius_mm + weft_radius_mm;
    let weft_spacing_diameters = study.weft.spacing_diameters.unwrap_or(cloth.spacing_diameters);
    let centre_line = match (cloth.centre_line, cloth.sinusoid_amplitude_mm) {
        (CentreLineChoice::Sinusoid, Some(amplitude_mm)) => CentreLineKind::Sinusoid { amplitude_mm },
        _ => CentreLineKind::Peirce,
    };
    let spec = ClothSpec {
        weave,
        centre_line,
        warp_radius_mm,
        weft_radius_mm,
        warp_spacing_mm: mean_diameter_mm * cloth.spacing_diameters,
        weft_spacing_mm: mean_diameter_mm * weft_spacing_diameters,
        warp_flattening: cloth.warp_flattening,
        weft_flattening: cloth.weft_flattening,
        radius_variation: cloth.radius_variation,
        spacing_variation: cloth.spacing_variation,
        repeats: [cloth.repeats as usize; 2],
        variation_seed: cloth.variation_seed,
    };
    match (cloth.centre_line, cloth.sinusoid_amplitude_mm) {
        (CentreLineChoice::Sinusoid, None) => spec.with_least_amplitude(),
        _ => spec,
    }
}
