//! The physical model of a study as a function of the keys that a fit varies.

use super::media::{MediumSpectra, yarn};
use super::plan::{cloth_spec, fibres, weave};
use super::{RunError, cloth_keys};
use crate::cloth::light::YarnSurface;
use crate::cloth::{Cloth, Weave};
use crate::colour::ColourSystem;
use crate::fit::{
    BetaTables, Channel, FitError, FitReadings, ForwardModel, ForwardRun, FreeParameter, Prior, Scale, ScatteringNode,
    TableEffort,
};
use crate::number::shown;
use crate::rig::{Geometry, omega_in, omega_out};
use crate::spectrum::{Samples, WavelengthGrid};
use crate::study::{DyeChoice, FreeKey, KeyScale, MediumSection, NumberOrTable, Study, StudyError};
use crate::yarn::Yarn;
use ndarray::Array2;

/// A study as a [`ForwardModel`] for the readings of a sample.
pub struct StudyForward {
    study: Study,
    weave: Weave,
    geometries: Vec<Geometry>,
    grid: WavelengthGrid,
    to_channels: Array2<f64>,
    nodes_nm: Vec<f64>,
    backing: Option<Samples>,
    traced: Vec<FreeParameter>,
    traced_keys: Vec<FreeKey>,
    gloss_parameters: Vec<FreeParameter>,
    gloss_keys: Vec<FreeKey>,
    effort: TableEffort,
}

/// Wavelengths at which scattering is traced, as shares of the range in the logarithm of wavelength: Chebyshev nodes of
/// three, slightly moved inwards, as little light counts at the ends.
const NODES: [f64; 3] = [0.08, 0.5, 0.92];
const BATCHES: usize = 8;
/// Section in which a study says what shines.
const GLOSS: &str = "specular.";
const SPACING: &str = "cloth.spacing_diameters";

impl StudyForward {
    /// `isotropic`: whether the sample is, so that β is the mean over the cloth's azimuth.
    ///
    /// # Errors
    /// A key that no forward model has, and errors of the study.
    pub fn new(study: Study, readings: &FitReadings, isotropic: bool) -> Result<Self, RunError> {
        study.validate()?;
        let mut inputs = Vec::new();
        let weave = weave(&study, &mut inputs)?;
        let wavelengths: Vec<f64> = (readings.channels.iter())
            .filter_map(|channel| match channel {
                Channel::Wavelength(nm) => Some(*nm),
                _ => None,
            })
            .collect();
        let spectral = !wavelengths.is_empty();
        let grid = WavelengthGrid::new(if spectral {
            wavelengths
        } else {
            study.spectrum.wavelengths()
        })?;
        let to_channels = match spectral {
            true => Array2::eye(grid.len()),
            false => {
                let system = ColourSystem::new(&grid, study.colour.convention()?)?;
                system.require()?;
                let weights = system.channel_weights();
                let column = |channel: &Channel| match channel {
                    Channel::Red => 0,
                    Channel::Green => 1,
                    Channel::Blue => 2,
                    Channel::Luminance | Channel::Wavelength(_) => 3,
                };
                let columns: Vec<usize> = readings.channels.iter().map(column).collect();
                Array2::from_shape_fn((columns.len(), grid.len()), |(c, w)| weights[w][columns[c]])
            }
        };
        let backing = super::plan::backing(&study.cloth.backing, &grid, &mut inputs)?;
        let (first, last) = (grid.nm()[0].ln(), grid.nm()[grid.len() - 1].ln());
        let nodes_nm = match grid.len() {
            0..3 => grid.nm().to_vec(),
            _ => NODES.map(|share| (first + share * (last - first)).exp()).to_vec(),
        };
        let effort = TableEffort {
            particles: study.fit.particles as usize,
            batches: BATCHES,
            azimuths: if isotropic { study.fit.azimuths as usize } else { 1 },
            order: study.fit.expansion_order as usize,
        };
        let mut forward = Self {
            geometries: readings.geometries.clone(),
            weave,
            grid,
            to_channels,
            nodes_nm,
            backing,
            traced: Vec::new(),
            traced_keys: Vec::new(),
            gloss_parameters: Vec::new(),
            gloss_keys: Vec::new(),
            effort,
            study,
        };
        forward.take_keys()?;
        forward.cloth(&forward.study)?;
        Ok(forward)
    }

    /// Sorts the free keys by whether light must be traced anew for them.
    fn take_keys(&mut self) -> Result<(), RunError> {
        for free in self.study.fit.free.clone() {
            let refuse = |expected: &str, remedy: &str| {
                Err(RunError::Study(StudyError::Value {
                    place: self.study.origin.place("fit.free"),
                    key: "fit.free".into(),
                    expected: expected.into(),
                    found: format!("`{}`", free.key),
                    remedy: remedy.into(),
                }))
            };
            for name in free.keys() {
                let section = name.split('.').next().unwrap_or_default();
                if !["medium", "yarn", "weft", "cloth", "specular"].contains(&section) {
                    return refuse(
                        "keys of [medium], [yarn], [weft], [cloth] and [specular]",
                        "leave it out",
                    );
                }
                let of_dye = ["kappa_peak", "host_mu_a_per_mm"].iter().any(|key| name.ends_with(key));
                if of_dye && self.study.fit.dye == DyeChoice::Free {
                    return refuse(
                        "no key of absorption beside a free dye, which takes its place",
                        "leave it out, or set fit.dye = \"fixed\"",
                    );
                }
            }
            let parameter = parameter_of(&free)?;
            if free.key.starts_with(GLOSS) && !self.study.specular.surface.is_of_yarns() {
                self.gloss_parameters.push(parameter);
                self.gloss_keys.push(free);
            } else {
                self.traced.push(parameter);
                self.traced_keys.push(free);
            }
        }
        Ok(())
    }

    /// Whether the absorption is fitted.
    pub fn is_dye_free(&self) -> bool {
        self.study.fit.dye == DyeChoice::Free
    }

    /// The study at a point of the traced coordinates, and the values of its traced keys.
    ///
    /// # Errors
    /// Values that contradict each other.
    pub fn study_at(&self, point: &[f64]) -> Result<(Study, Vec<f64>), RunError> {
        let mut study = self.study.clone();
        let mut values = vec![0.0; point.len()];
        let is_spacing = |k: &usize| self.traced_keys[*k].key == SPACING;
        let order = || 0..point.len();
        // The least spacing depends on the other keys.
        for k in order().filter(|k| !is_spacing(k)).chain(order().filter(is_spacing)) {
            let (parameter, free) = (&self.traced[k], &self.traced_keys[k]);
            let mut bounds = parameter.bounds;
            if is_spacing(&k) {
                bounds[0] = self.least_spacing(&study, bounds)?;
            }
            let bounded = FreeParameter {
                bounds,
                ..parameter.clone()
            };
            values[k] = bounded.at_share(point[k]);
            study = set(&study, free, values[k])?;
        }
        Ok((study, values))
    }

    /// The study with values of the gloss.
    ///
    /// # Errors
    /// Values that the gloss cannot have.
    pub fn with_gloss(&self, study: &Study, values: &[f64]) -> Result<Study, RunError> {
        let mut study = study.clone();
        for (free, value) in self.gloss_keys.iter().zip(values) {
            study = set(&study, free, *value)?;
        }
        Ok(study)
    }

    /// Least spacing within bounds at which the yarns can be woven, slightly enlarged.
    fn least_spacing(&self, study: &Study, [low, high]: [f64; 2]) -> Result<f64, RunError> {
        const STEPS: usize = 16;
        let free = |spacing: f64| -> Result<bool, RunError> {
            let mut tried = study.clone();
            tried.cloth.spacing_diameters = spacing;
            Ok(Cloth::new(&cloth_spec(&tried, self.weave.clone())).is_ok())
        };
        if free(low)? {
            return Ok(low);
        }
        let (mut jammed, mut woven) = (low, high);
        for _ in 0..STEPS {
            let middle = 0.5 * (jammed + woven);
            if free(middle)? {
                woven = middle;
            } else {
                jammed = middle;
            }
        }
        Ok((woven * 1.001).min(high))
    }

    fn cloth(&self, study: &Study) -> Result<Cloth, RunError> {
        let spec = cloth_spec(study, self.weave.clone());
        Cloth::new(&spec).map_err(|error| match cloth_keys::at_key(study, &spec, &error) {
            Some(error) => RunError::Study(error),
            None => RunError::Cloth(error),
        })
    }

    /// Sections of the media of warp and weft, without absorption where it is free.
    fn media(&self, study: &Study, added: f64) -> [MediumSection; 2] {
        let clear = |mut medium: MediumSection| {
            if self.is_dye_free() {
                medium.kappa_peak = 0.0;
                medium.host_mu_a_per_mm = NumberOrTable::Number(added);
            }
            medium
        };
        [study.medium.clone(), study.weft.medium(&study.medium)].map(clear)
    }

    fn yarns(&self, study: &Study, added: f64, grid: &WavelengthGrid) -> Result<[Yarn; 2], RunError> {
        let [warp, weft] = self.media(study, added);
        let radius_mm = study.yarn.radius_mm;
        let of = |section, radius_mm, medium: &MediumSection| {
            yarn(
                study,
                section,
                radius_mm,
                medium,
                MediumSpectra::read(section, medium, grid)?,
                grid,
            )
        };
        Ok([
            of("medium", radius_mm, &warp)?,
            of("weft", study.weft.radius_mm.unwrap_or(radius_mm), &weft)?,
        ])
    }

    fn trace_study(&self, point: &[f64], added: &[f64], share: f64) -> Result<ForwardRun, RunError> {
        let (study, values) = self.study_at(point)?;
        let cloth = self.cloth(&study)?;
        let mut nodes = Vec::new();
        for (nm, added) in self.nodes_nm.iter().zip(added) {
            let grid = WavelengthGrid::new(vec![*nm])?;
            let yarns = self.yarns(&study, *added, &grid)?;
            let [mu_a, of_weft] = [0, 1].map(|k: usize| yarns[k].medium.mu_a_per_mm()[0]);
            if (mu_a - of_weft).abs() > 1e-9 * mu_a.max(1e-9) {
                return Err(RunError::Study(StudyError::Value {
                    place: study.origin.place("fit.dye"),
                    key: "fit.dye".into(),
                    expected: "equal absorption of warp and weft where it is fixed".into(),
                    found: format!(
                        "{} and {} 1/mm at {} nm",
                        shown(mu_a),
                        shown(of_weft),
                        shown(nm.round())
                    ),
                    remedy: "set fit.dye = \"free\", or give both the same dye".into(),
                }));
            }
            let backing = self.backing.as_ref().map(|reflectance| interpolated(reflectance, *nm));
            nodes.push(ScatteringNode {
                yarns,
                backing,
                mu_a_per_mm: mu_a,
            });
        }
        let mu_a_per_mm = match self.is_dye_free() {
            true => vec![0.0; self.grid.len()],
            false => self.yarns(&study, 0.0, &self.grid)?[0].medium.mu_a_per_mm().to_vec(),
        };
        let surface = match fibres(&study)? {
            _ if !study.specular.surface.is_of_yarns() => YarnSurface::Lost,
            Some(gloss) => YarnSurface::Fibres(gloss),
            None => YarnSurface::Smooth,
        };
        let particles = (share * self.effort.particles as f64).ceil() as usize;
        let effort = TableEffort {
            particles,
            ..self.effort.clone()
        };
        let azimuth = study.cloth.azimuth_deg;
        let tables = BetaTables::trace(&cloth, surface, &nodes, &self.geometries, azimuth, &effort, study.seed)?;
        Ok(ForwardRun {
            point: point.to_vec(),
            values,
            tables,
            share,
            mu_a_per_mm,
        })
    }
}

impl ForwardModel for StudyForward {
    fn geometries(&self) -> &[Geometry] {
        &self.geometries
    }

    fn wavelengths_nm(&self) -> &[f64] {
        self.grid.nm()
    }

    fn to_channels(&self) -> &Array2<f64> {
        &self.to_channels
    }

    fn nodes_nm(&self) -> &[f64] {
        &self.nodes_nm
    }

    fn traced(&self) -> &[FreeParameter] {
        &self.traced
    }

    fn gloss_parameters(&self) -> &[FreeParameter] {
        &self.gloss_parameters
    }

    fn gloss(&self, values: &[f64]) -> Result<Vec<f64>, FitError> {
        let mut of = self.study.specular.clone();
        if of.surface.is_of_yarns() {
            return Ok(vec![0.0; self.geometries.len()]);
        }
        for (free, value) in self.gloss_keys.iter().zip(values) {
            match free.key.as_str() {
                "specular.weight" => of.weight = *value,
                "specular.roughness" => of.roughness = *value,
                "specular.index" => of.index = *value,
                _ => {}
            }
        }
        let specular = super::plan::specular(&of)?;
        let at = |geometry: &Geometry| {
            let (light, view) = (
                omega_in(geometry.theta_i_deg, 0.0),
                omega_out(geometry.theta_v_deg, 0.0),
            );
            specular.brdf(&light, &view).brightness_factor().0
        };
        Ok(self.geometries.iter().map(at).collect())
    }

    fn trace(&self, point: &[f64], added_mu_a_per_mm: &[f64], share: f64) -> Result<ForwardRun, FitError> {
        self.trace_study(point, added_mu_a_per_mm, share)
            .map_err(|error| FitError::Model(error.to_string()))
    }
}

/// A reflectance between the wavelengths of its grid.
fn interpolated(samples: &Samples, nm: f64) -> f64 {
    let grid = samples.grid().nm();
    let above = grid.partition_point(|at| *at < nm).clamp(1, grid.len().max(2) - 1);
    if grid.len() < 2 {
        return samples.values()[0];
    }
    let share = ((nm - grid[above - 1]) / (grid[above] - grid[above - 1])).clamp(0.0, 1.0);
    samples.values()[above - 1] * (1.0 - share) + samples.values()[above] * share
}

fn set(study: &Study, free: &FreeKey, value: f64) -> Result<Study, StudyError> {
    let mut study = study.clone();
    for name in free.keys() {
        study = study.with_number(name, value, "fit.free")?;
    }
    Ok(study)
}

fn parameter_of(free: &FreeKey) -> Result<FreeParameter, StudyError> {
    Ok(FreeParameter {
        name: free.key.clone(),
        unit: Study::unit_of(&free.key, "fit.free")?.into(),
        bounds: [free.min, free.max],
        scale: match free.scale {
            KeyScale::Linear => Scale::Linear,
            KeyScale::Log => Scale::Log,
        },
        prior: free.prior_mean.zip(free.prior_sd).map(|(mean, sd)| Prior { mean, sd }),
    })
}
