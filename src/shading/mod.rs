//! Shading of a flat cloth about its normal, as in renderers: Cook–Torrance, and a registry of the classical models
//! with which the physical model is compared. Also the gloss of a yarn of fibres about its own surface.
//!
//! Directions are unit vectors from the surface; the normal is +z, in the coordinates of the cloth, or of the yarn for
//! fibres.

mod fibre_gloss;
mod model;
mod registry;
mod specular;

pub use fibre_gloss::FibreGloss;
pub use model::{Basis, ClassicalModel, Lobes, Parameter, Shading, ShadingModel};
pub use registry::{DEFAULT_MODELS, LambertCookTorrance, classical_model, classical_models};
pub use specular::{Distribution, Specular};

use crate::spectrum::UnknownName;
use std::f64::consts::PI;

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
    /// The BRDF with this brightness factor, 1/sr.
    pub fn brdf(self) -> Brdf {
        Brdf(self.0 / PI)
    }
}

/// Invalid parameters of a shading model.
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
    #[error("slope of the grooves: expected 0 to 90 degrees, found {found_deg}")]
    Slope { found_deg: f64 },
    #[error("roughness of the sheen: expected 0.05 to 1 (no unit), found {found}")]
    Sheen { found: f64 },
    #[error("normal/normal reading of the sample: expected finite brightness factors r, g, b, y, found {found:?}")]
    Factor { found: [f64; 4] },
    #[error("{model}: expected a value for each of {}, found {found} values", expected.join(", "))]
    Parameters {
        model: &'static str,
        expected: Vec<&'static str>,
        found: usize,
    },
    #[error(transparent)]
    Unknown(#[from] UnknownName),
}
