//! What models share: the parameters of a gloss of facets, and a Lambert base under it.

use crate::geometry::Vec3;
use crate::shading::{Basis, Brdf, Lobes, Parameter, ShadingError};

pub(super) const ROUGHNESS: Parameter = Parameter {
    name: "roughness",
    unit: "",
    range: [0.001, 1.0],
    meaning: "slope of the facets",
};

pub(super) const INDEX: Parameter = Parameter {
    name: "index",
    unit: "",
    range: [1.0, 3.0],
    meaning: "refractive index of the facets",
};

pub(super) const WEIGHT: Parameter = Parameter {
    name: "weight",
    unit: "",
    range: [0.0, 1.0],
    meaning: "fraction of the area that is facets",
};

/// The sample's albedo and the study's gloss.
pub(super) fn start(Basis { specular, .. }: &Basis) -> Vec<f64> {
    vec![1.0, specular.roughness(), specular.index(), specular.weight()]
}

/// Albedos as they are.
///
/// # Errors
/// One that is not finite.
pub(super) fn finite(albedo: [f64; 4]) -> Result<[f64; 4], ShadingError> {
    match albedo.iter().all(|factor| factor.is_finite()) {
        true => Ok(albedo),
        false => Err(ShadingError::Factor { found: albedo }),
    }
}

/// A Lambert base with a gloss that is added to it.
pub(super) fn lambert_and(omega_in: &Vec3, omega_out: &Vec3, gloss: impl Fn() -> Brdf) -> Lobes {
    if omega_in.z <= 0.0 || omega_out.z <= 0.0 {
        return Lobes::default();
    }
    Lobes {
        base: 1.0,
        gloss: gloss().brightness_factor().0,
    }
}
