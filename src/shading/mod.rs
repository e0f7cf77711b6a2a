//! Shading about the normal of a flat cloth, as renderers do it: Cook–Torrance, and its sum with Lambert, the classical
//! model that a physical one has to beat. And the gloss of a yarn of fibres about its own surface.
//!
//! Directions are unit vectors from the surface, the normal is +z: in the cloth's coordinates, of fibres in the yarn's.

mod classical;
mod fibre_gloss;
mod specular;

pub use classical::Classical;
pub use fibre_gloss::FibreGloss;
pub use specular::{Distribution, Specular};

use crate::geometry::Vec3;
use std::f64::consts::PI;

/// A model of how a flat cloth reflects light about its normal, as renderers have it.
pub trait ShadingModel {
    /// Brightness factor π L / E in red, green, blue and luminance towards `omega_out` for light from `omega_in`, unit vectors
    /// from the surface with the normal +z; 0 with either in the plane or below it. `white` holds the channels of the perfect
    /// diffuser, of which gloss takes its colour.
    fn eval(&self, omega_in: &Vec3, omega_out: &Vec3, white: &[f64; 4]) -> [f64; 4];
}

/// Radiance per irradiance of the surface, 1/sr.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Brdf(pub f64);

impl Brdf {
    /// π f: radiance relative to that of a perfect diffuser under the same light.
    pub fn brightness_factor(self) -> BrightnessFactor {
        BrightnessFactor(PI * self.0)
    }
}

/// π L / E with E the irradiance of the cloth's plane; 1 for a perfect diffuser.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct BrightnessFactor(pub f64);

impl BrightnessFactor {
    /// The BRDF that shows this factor, 1/sr.
    pub fn brdf(self) -> Brdf {
        Brdf(self.0 / PI)
    }
}

/// Which parameter of a shading model is out of range.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ShadingError {
    #[error("specular roughness: expected 0.001 to 1 (slope of the facets, no unit), found {found}")]
    Roughness { found: f64 },
    #[error("twist of the fibres: expected -π/2 to π/2 radians from the yarn's axis, found {found_rad}")]
    Twist { found_rad: f64 },
    #[error("specular index: expected a refractive index of at least 1, found {found}")]
    Index { found: f64 },
    #[error("specular weight: expected a fraction from 0 to 1, found {found}")]
    Weight { found: f64 },
    #[error("normal/normal reading of the sample: expected finite brightness factors r, g, b, y, found {found:?}")]
    Factor { found: [f64; 4] },
}
