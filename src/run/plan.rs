use super::media::{MediumSpectra, le_bytes, weft, yarn};
use super::{RunError, cloth_keys};
use crate::cloth::light::{Scene, YarnSurface};
use crate::cloth::{CentreLineKind, Cloth, ClothSpec, Weave};
use crate::colour::{ColourSystem, Convention};
use crate::fault::{self, Fault};
use crate::report::InputDigest;
use crate::rig::{BeamsOfRig, Direct, Geometry, PixelSamples, Rig};
use crate::sample::{Chosen, Sample};
use crate::shading::{Distribution, FibreGloss, ShadingError, Specular};
use crate::spectrum::{Samples, WavelengthGrid, read_spectrum};
use crate::study::{
    CentreLineChoice, DistributionChoice, MediumSection, SpecularSection, Study, SurfaceChoice, TraceSection,
};
use crate::weave::WeaveDraft;
use crate::yarn::{BssrdfGrid, DirectTracer, Effort, IncidentGrid, SurfaceGrid, Yarn, YarnError, YarnResponseGrid};
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
    /// Reflectance of what lies under the cloth; `None` where light passes into free space.
    pub backing: Option<Samples>,
    pub cloth: Cloth,
    pub specular: Specular,
    /// Gloss of the yarns' fibres, for studies with `surface = "fibres"`.
    pub fibres: Option<FibreGloss>,
    pub rig: Rig,
    pub pixels: PixelSamples,
    pub colour: ColourSystem,
    pub sample: Sample,
    /// Component of the sample that the user chose.
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
            specular: specular(&study.specular)?,
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

    /// What happens to light that the yarns' surface reflects: lost, or followed from a mirror or from fibres.
    pub(crate) fn surface(&self, goes_on: bool) -> YarnSurface {
        match self.fibres {
            _ if !goes_on => YarnSurface::Lost,
            Some(gloss) => YarnSurface::Fibres(gloss),
            None => YarnSurface::Smooth,
        }
    }

    /// The scene of the cloth. The arguments say whether light that the yarns' surface reflects is followed, and whether
    /// the cloth lies on the study's backing.
    pub fn scene(&self, surface_goes_on: bool, on_backing: bool) -> Scene<'_> {
        Scene {
            cloth: &self.cloth,
            yarns: self.yarns(),
            backing: self.backing.as_ref().filter(|_| on_backing).map(Samples::values),
            surface: self.surface(surface_goes_on),
            seed: self.study.seed,
        }
    }

    /// Whether light that left the first yarn it met is followed, where yarns scatter by f*.
    pub(super) fn light_goes_on(&self) -> bool {
        let reflects = |backing: &Samples| backing.values().iter().any(|r| *r > 0.0);
        self.study.cloth.bounces.most() > 0
            || self.study.specular.surface.is_of_yarns()
            || self.backing.as_ref().is_some_and(reflects)
    }

    /// Tracers of the f* of [`Self::different_yarns`].
    pub(super) fn direct_tracers(&self, effort: Effort) -> Result<Vec<DirectTracer<'_>>, YarnError> {
        self.different_yarns()
            .map(|yarn| DirectTracer::new(yarn, self.factor_grid, effort, None))
            .collect()
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
pub(super) fn weave(study: &Study, inputs: &mut Vec<InputDigest>) -> Result<Weave, RunError> {
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
pub(super) fn backing(
    of: &str,
    grid: &WavelengthGrid,
    inputs: &mut Vec<InputDigest>,
) -> Result<Option<Samples>, RunError> {
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

/// Gloss about the cloth's normal.
pub(super) fn specular(of: &SpecularSection) -> Result<Specular, ShadingError> {
    let distribution = match of.distribution {
        DistributionChoice::Beckmann => Distribution::Beckmann,
        DistributionChoice::TrowbridgeReitz => Distribution::TrowbridgeReitz,
    };
    Specular::new(distribution, of.roughness, of.index, of.weight)
}

pub(super) fn fibres(study: &Study) -> Result<Option<FibreGloss>, ShadingError> {
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

pub(super) fn cloth_spec(study: &Study, weave: Weave) -> ClothSpec {
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
