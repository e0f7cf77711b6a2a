//! The sections of a study file as types. Meaning, unit and range of every key: [`super::keys`].

use serde::{Deserialize, Serialize};

use crate::colour::{Adaptation, ColourError, Convention, Illuminant, Observer, RgbSpace};

/// `[spectrum]`: the wavelengths at which everything is computed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SpectrumSection {
    pub wavelength_min_nm: f64,
    pub wavelength_max_nm: f64,
    pub wavelength_step_nm: f64,
    /// Used in place of the three above where given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wavelengths_nm: Option<Vec<f64>>,
}

impl SpectrumSection {
    /// The wavelengths in nm, ascending in a valid study.
    pub fn wavelengths(&self) -> Vec<f64> {
        match &self.wavelengths_nm {
            Some(list) => list.clone(),
            None => steps(self.wavelength_min_nm, self.wavelength_max_nm, self.wavelength_step_nm),
        }
    }
}

impl Default for SpectrumSection {
    fn default() -> Self {
        Self {
            wavelength_min_nm: 390.0,
            wavelength_max_nm: 730.0,
            wavelength_step_nm: 10.0,
            wavelengths_nm: None,
        }
    }
}

/// `[medium]`: what fills the yarn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MediumSection {
    pub host_index: NumberOrTable,
    pub host_mu_a_per_mm: NumberOrTable,
    pub particle_index: NumberOrTable,
    pub particle_diameter_nm: f64,
    pub volume_fraction: f64,
    pub kappa_peak: f64,
    pub dye: String,
    pub interference: InterferenceChoice,
}

impl Default for MediumSection {
    fn default() -> Self {
        Self {
            host_index: NumberOrTable::Number(1.557),
            host_mu_a_per_mm: NumberOrTable::Number(0.0),
            particle_index: NumberOrTable::Number(1.61),
            particle_diameter_nm: 150.0,
            volume_fraction: 0.14,
            kappa_peak: 0.0065,
            dye: "preprint-red".into(),
            interference: InterferenceChoice::Independent,
        }
    }
}

/// A quantity that may depend on wavelength.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum NumberOrTable {
    /// The same at every wavelength.
    Number(f64),
    /// Path to a CSV file with the columns `wavelength_nm,value`, values in the unit of the key.
    Table(String),
}

impl NumberOrTable {
    /// The number, if it is one for all wavelengths.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(*value),
            Self::Table(_) => None,
        }
    }

    /// The path, if it is a table.
    pub fn table(&self) -> Option<&str> {
        match self {
            Self::Number(_) => None,
            Self::Table(path) => Some(path),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum InterferenceChoice {
    Independent,
    PercusYevick,
}

/// `[yarn]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct YarnSection {
    pub radius_mm: f64,
    /// Angle of the fibres to the yarn's axis; 0 where there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub twist_deg: Option<f64>,
}

impl Default for YarnSection {
    fn default() -> Self {
        Self {
            radius_mm: 0.15,
            twist_deg: None,
        }
    }
}

/// `[weft]`: in what the weft's yarn differs from the warp's, which `[medium]` and `[yarn]` describe.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WeftSection {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius_mm: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spacing_diameters: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub host_index: Option<NumberOrTable>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub host_mu_a_per_mm: Option<NumberOrTable>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub particle_index: Option<NumberOrTable>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub particle_diameter_nm: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub volume_fraction: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kappa_peak: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dye: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interference: Option<InterferenceChoice>,
}

impl WeftSection {
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Whether this key is set, in which the weft may differ from the warp.
    pub fn sets(&self, key: &str) -> bool {
        toml::Table::try_from(self).is_ok_and(|keys| keys.contains_key(key))
    }

    /// The weft's medium, beside a warp's.
    pub fn medium(&self, warp: &MediumSection) -> MediumSection {
        let of = |own: &Option<NumberOrTable>, warp: &NumberOrTable| own.as_ref().unwrap_or(warp).clone();
        MediumSection {
            host_index: of(&self.host_index, &warp.host_index),
            host_mu_a_per_mm: of(&self.host_mu_a_per_mm, &warp.host_mu_a_per_mm),
            particle_index: of(&self.particle_index, &warp.particle_index),
            particle_diameter_nm: self.particle_diameter_nm.unwrap_or(warp.particle_diameter_nm),
            volume_fraction: self.volume_fraction.unwrap_or(warp.volume_fraction),
            kappa_peak: self.kappa_peak.unwrap_or(warp.kappa_peak),
            dye: self.dye.as_ref().unwrap_or(&warp.dye).clone(),
            interference: self.interference.unwrap_or(warp.interference),
        }
    }
}

/// `[trace]`: the Monte Carlo of the yarn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TraceSection {
    pub estimator: EstimatorChoice,
    pub batches: u32,
    pub paths_bssrdf: u64,
    pub paths_direct: u64,
    pub particles: u64,
    pub particles_volumetric: u64,
    pub roulette_threshold: f64,
    pub roulette_survival: f64,
    pub zenith_cells: u32,
    pub azimuth_cells: u32,
    pub exit_azimuth_cells: u32,
    pub exit_theta_cells: u32,
    pub exit_phi_cells: u32,
    pub bssrdf_azimuth_cells: u32,
    pub bssrdf_exit_theta_cells: u32,
    pub bssrdf_exit_phi_cells: u32,
    pub z_cells: u32,
    pub tilts: u32,
    pub fold_symmetry: bool,
    pub shade_with: ShadeWith,
}

impl Default for TraceSection {
    fn default() -> Self {
        Self {
            estimator: EstimatorChoice::Shared,
            batches: 16,
            paths_bssrdf: 20_000,
            paths_direct: 600_000,
            particles: 48_000,
            particles_volumetric: 2_000_000,
            roulette_threshold: 0.1,
            roulette_survival: 0.2,
            zenith_cells: 9,
            azimuth_cells: 16,
            exit_azimuth_cells: 36,
            exit_theta_cells: 12,
            exit_phi_cells: 24,
            bssrdf_azimuth_cells: 20,
            bssrdf_exit_theta_cells: 6,
            bssrdf_exit_phi_cells: 12,
            z_cells: 8,
            tilts: 10,
            fold_symmetry: true,
            shade_with: ShadeWith::Direct,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EstimatorChoice {
    /// One path for all wavelengths that share a host index.
    Shared,
    /// A path for each wavelength.
    Independent,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ShadeWith {
    Direct,
    Bssrdf,
}

/// `[cloth]`: the weave.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ClothSection {
    pub weave: String,
    pub centre_line: CentreLineChoice,
    pub spacing_diameters: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sinusoid_amplitude_mm: Option<f64>,
    pub segments_around: u32,
    pub segments_along: u32,
    pub azimuth_deg: f64,
    pub method: MethodChoice,
    pub bounces: Bounces,
    pub backing: String,
    pub warp_flattening: f64,
    pub weft_flattening: f64,
    pub radius_variation: f64,
    pub spacing_variation: f64,
    pub repeats: u32,
    pub variation_seed: u64,
}

impl Default for ClothSection {
    fn default() -> Self {
        Self {
            weave: "plain".into(),
            centre_line: CentreLineChoice::Peirce,
            spacing_diameters: 1.8,
            sinusoid_amplitude_mm: None,
            segments_around: 48,
            segments_along: 24,
            azimuth_deg: 0.0,
            method: MethodChoice::RadianceFactor,
            bounces: Bounces::Most(0),
            backing: "none".into(),
            warp_flattening: 1.0,
            weft_flattening: 1.0,
            radius_variation: 0.0,
            spacing_variation: 0.0,
            repeats: 1,
            variation_seed: 1,
        }
    }
}

/// How light in the cloth is simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MethodChoice {
    /// Yarns scatter by their f*.
    RadianceFactor,
    /// Light is traced through the medium of every yarn.
    Volumetric,
}

/// Yarns that light may go on to after the first it met.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Bounces {
    Most(u32),
    Word(BouncesWord),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BouncesWord {
    All,
}

impl Bounces {
    /// However many.
    pub const ALL: Self = Self::Word(BouncesWord::All);

    /// The number, with no end for all.
    pub fn most(self) -> usize {
        match self {
            Self::Most(most) => most as usize,
            Self::Word(BouncesWord::All) => usize::MAX,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CentreLineChoice {
    Peirce,
    Sinusoid,
}

/// `[specular]`: the gloss of the cloth, Cook–Torrance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SpecularSection {
    pub roughness: f64,
    pub distribution: DistributionChoice,
    pub index: f64,
    pub weight: f64,
    pub surface: SurfaceChoice,
    /// [`SpecularSection::ROUGHNESS_ACROSS`] where there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roughness_across: Option<f64>,
}

impl SpecularSection {
    /// Of fibres 0.6 times as high as wide that lie flat, as those of cotton do; round ones have 1.
    pub const ROUGHNESS_ACROSS: f64 = 0.6;
}

/// What shines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SurfaceChoice {
    /// The cloth as a whole, about its normal.
    Cloth,
    /// The smooth surface of each yarn.
    Yarn,
    /// The fibres in the surface of each yarn.
    Fibres,
}

impl SurfaceChoice {
    /// Whether the yarns shine by themselves.
    pub fn is_of_yarns(self) -> bool {
        self != Self::Cloth
    }
}

impl Default for SpecularSection {
    fn default() -> Self {
        Self {
            surface: SurfaceChoice::Cloth,
            roughness: 0.4,
            distribution: DistributionChoice::Beckmann,
            index: 1.557,
            weight: 0.25,
            roughness_across: None,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DistributionChoice {
    Beckmann,
    TrowbridgeReitz,
}

/// `[rig]`: the virtual goniophotometer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RigSection {
    pub geometries: GeometryChoice,
    pub incidences_deg: Vec<f64>,
    pub view_min_deg: f64,
    pub view_max_deg: f64,
    pub view_step_deg: f64,
    pub pixels_per_side: u32,
    pub aperture_half_angle_deg: f64,
}

/// Whose geometries a report measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GeometryChoice {
    /// The sample's own, unless the section's angles differ from the built-in ones.
    Auto,
    /// Those of the section's angles.
    Rig,
}

impl RigSection {
    /// Keys of the angles: a text that has one of them and not `geometries` means them.
    pub(super) const ANGLES: [&str; 4] = ["incidences_deg", "view_min_deg", "view_max_deg", "view_step_deg"];

    /// Whether a report measures the geometries of the sample.
    pub fn takes_the_samples(&self) -> bool {
        let built_in = Self::default();
        self.geometries == GeometryChoice::Auto
            && self.incidences_deg == built_in.incidences_deg
            && self.views_deg() == built_in.views_deg()
    }

    /// The signed view angles in degrees, ascending in a valid study.
    pub fn views_deg(&self) -> Vec<f64> {
        steps(self.view_min_deg, self.view_max_deg, self.view_step_deg)
    }
}

impl Default for RigSection {
    fn default() -> Self {
        Self {
            geometries: GeometryChoice::Auto,
            incidences_deg: vec![0.0, 30.0, 60.0],
            view_min_deg: -60.0,
            view_max_deg: 70.0,
            view_step_deg: 5.0,
            pixels_per_side: 32,
            aperture_half_angle_deg: 5.0,
        }
    }
}

/// `[colour]`: from spectra to colours.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ColourSection {
    /// A CIE observer's name, or the path of a table.
    pub observer: String,
    /// A CIE illuminant's name, or the path of a table.
    pub illuminant: String,
    pub rgb: RgbSpace,
    pub adaptation: Adaptation,
}

impl ColourSection {
    /// Names resolved and files read.
    pub fn convention(&self) -> Result<Convention, ColourError> {
        Ok(Convention {
            observer: Observer::load(&self.observer)?,
            illuminant: Illuminant::load(&self.illuminant)?,
            rgb: self.rgb,
            adaptation: self.adaptation,
        })
    }
}

impl Default for ColourSection {
    fn default() -> Self {
        let Convention {
            observer,
            illuminant,
            rgb,
            adaptation,
        } = Convention::default();
        Self {
            observer: observer.to_string(),
            illuminant: illuminant.to_string(),
            rgb,
            adaptation,
        }
    }
}

/// `[measured]`: the sample to compare with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MeasuredSection {
    pub sample: String,
}

impl Default for MeasuredSection {
    fn default() -> Self {
        Self {
            sample: "merl-red-fabric".into(),
        }
    }
}

/// `[sweep]`: values each varied alone, the rest as in the study; an empty list leaves a parameter alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SweepSection {
    pub kappa_peak: Vec<f64>,
    pub volume_fraction: Vec<f64>,
    pub particle_diameter_nm: Vec<f64>,
    pub particle_index: Vec<f64>,
}

impl Default for SweepSection {
    fn default() -> Self {
        Self {
            kappa_peak: vec![0.002, 0.0065, 0.012],
            volume_fraction: vec![0.07, 0.14, 0.21],
            particle_diameter_nm: vec![100.0, 150.0, 300.0],
            particle_index: vec![1.59, 1.61, 1.63],
        }
    }
}

/// `[check]`: departures from a law that `specval check` must not miss.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CheckSection {
    pub false_alarms: f64,
    pub rounding: f64,
    pub sharing: f64,
    pub roulette: f64,
    pub scattering_angle: f64,
    pub cylinder: f64,
    pub two_roads: f64,
    pub reciprocity: f64,
    pub cloth: f64,
    pub sample: f64,
}

impl Default for CheckSection {
    fn default() -> Self {
        Self {
            false_alarms: 1e-3,
            rounding: 1e-12,
            sharing: 0.05,
            roulette: 0.002,
            scattering_angle: 0.01,
            cylinder: 0.002,
            two_roads: 0.02,
            reciprocity: 0.002,
            cloth: 0.02,
            sample: 0.1,
        }
    }
}

/// low, low + step, … up to high, to within a rounding of the number of steps.
fn steps(low: f64, high: f64, step: f64) -> Vec<f64> {
    let last = ((high - low) / step + 1e-9).floor() as u32;
    (0..=last).map(|i| low + f64::from(i) * step).collect()
}
