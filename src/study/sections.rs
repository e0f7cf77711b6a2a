//! What sections of a study say beyond the values of their keys.

use super::choices::{GeometryChoice, NumberOrTable};
use super::keys::{
    ColourSection, FitSection, MediumSection, RigSection, SpectrumSection, SpecularSection, WeftSection,
};
use crate::colour::{ColourError, Convention, Illuminant, Observer};

impl SpectrumSection {
    /// The wavelengths in nm, ascending in a valid study.
    pub fn wavelengths(&self) -> Vec<f64> {
        match &self.wavelengths_nm {
            Some(list) => list.clone(),
            None => steps(self.wavelength_min_nm, self.wavelength_max_nm, self.wavelength_step_nm),
        }
    }
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

impl FitSection {
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

impl SpecularSection {
    /// Of fibres 0.6 times as high as wide that lie flat, as those of cotton do; round ones have 1.
    pub const ROUGHNESS_ACROSS: f64 = 0.6;
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

/// low, low + step, … up to high, to within a rounding of the number of steps.
fn steps(low: f64, high: f64, step: f64) -> Vec<f64> {
    let last = ((high - low) / step + 1e-9).floor() as u32;
    (0..=last).map(|i| low + f64::from(i) * step).collect()
}
