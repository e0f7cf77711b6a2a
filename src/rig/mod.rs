//! The virtual goniophotometer: a parallel beam, an orthographic camera on the cloth's unit cell, and the full BSDF.
//!
//! Angles are from the cloth's normal (+z). The plane of incidence contains the normal and is at azimuth a from x.
//! Light comes from ω_in = (−sinθ_i cos a, −sinθ_i sin a, cosθ_i); the signed view angle is negative on the light's
//! side: ω_out = (sinθ_v cos a, sinθ_v sin a, cosθ_v), so the mirror direction of θ_i is θ_v = +θ_i.

pub mod bsdf;
mod direct;
mod geometry;
mod view;

pub use direct::{CameraBatch, Direct};
pub use geometry::{BeamsOfRig, Geometry, number_of};
pub use view::{Interaction, PixelSamples, view_cell};

use crate::fault::{self, Fault};
use crate::geometry::Vec3;
use crate::shading::BrightnessFactor;
use std::f64::consts::PI;

/// Angles of a measurement in one plane of incidence.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    incidences_deg: Vec<f64>,
    views_deg: Vec<f64>,
}

impl Default for Rig {
    /// Incidences 0°, 30°, 60°; views −60° to 70° in steps of 5°: preprint 63 (2008), graphs 1 to 6.
    fn default() -> Self {
        Self {
            incidences_deg: vec![0.0, 30.0, 60.0],
            views_deg: (-12..=14).map(|k| 5.0 * f64::from(k)).collect(),
        }
    }
}

impl Rig {
    /// Incidences in degrees, from 0 to below 90, and signed view angles, strictly between −90 and 90; at least one
    /// each.
    ///
    /// # Errors
    /// [`RigError`] if an angle is out of range or a list is empty.
    pub fn new(incidences_deg: Vec<f64>, views_deg: Vec<f64>) -> Result<Self, RigError> {
        if incidences_deg.is_empty() || views_deg.is_empty() {
            return Err(RigError::NoAngles);
        }
        if let Some(&found) = incidences_deg.iter().find(|a| !(0.0..90.0).contains(*a)) {
            return Err(RigError::Incidence { found });
        }
        if let Some(&found) = views_deg.iter().find(|a| a.is_nan() || a.abs() >= 90.0) {
            return Err(RigError::View { found });
        }
        Ok(Self {
            incidences_deg,
            views_deg,
        })
    }

    /// Angles of incidence, degrees.
    pub fn incidences_deg(&self) -> &[f64] {
        &self.incidences_deg
    }

    /// Signed view angles, degrees.
    pub fn views_deg(&self) -> &[f64] {
        &self.views_deg
    }
}

/// Unit vector towards the light.
pub fn omega_in(theta_i_deg: f64, azimuth_deg: f64) -> Vec3 {
    let side = if fault::active(Fault::LightMirrored) { 1.0 } else { -1.0 };
    omega_out(side * theta_i_deg, azimuth_deg)
}

/// Unit vector towards the viewer at a signed view angle.
pub fn omega_out(theta_v_deg: f64, azimuth_deg: f64) -> Vec3 {
    let azimuth_deg = if fault::active(Fault::AzimuthIgnored) {
        0.0
    } else {
        azimuth_deg
    };
    let (sin_theta, cos_theta) = theta_v_deg.to_radians().sin_cos();
    let (sin_azimuth, cos_azimuth) = azimuth_deg.to_radians().sin_cos();
    Vec3::new(sin_theta * cos_azimuth, sin_theta * sin_azimuth, cos_theta)
}

/// Brightness factor π L / (E⊥ cosθ_i) from the mean radiance over the cell per irradiance normal to the beam, L / E⊥
/// in 1/sr. The mean over the cell is the radiance of the cloth seen from a distance; it already includes the division
/// by cosθ_v that the preprint applies to its sum over pixels.
pub fn brightness_factor(mean_radiance_per_normal_irradiance: f64, cos_theta_i: f64) -> BrightnessFactor {
    BrightnessFactor(PI * mean_radiance_per_normal_irradiance / cos_theta_i)
}

/// Invalid rig.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RigError {
    #[error("the rig needs at least one incidence and one view angle")]
    NoAngles,
    #[error("incidences_deg: expected angles from 0 to below 90 degrees from the normal, found {found}")]
    Incidence { found: f64 },
    #[error("views_deg: expected signed angles between -90 and 90 degrees (both excluded), found {found}")]
    View { found: f64 },
    #[error(
        "a full measurement of {found} values is more than {most}; take larger --theta-step and --phi-step, or fewer \
         wavelengths"
    )]
    TooManyValues { found: usize, most: usize },
    #[error("pixel samples: expected 1 to 65536 along x and along y, found {along_x} by {along_y}")]
    Samples { along_x: usize, along_y: usize },
}
