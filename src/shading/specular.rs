use super::{Brdf, ShadingError};
use crate::fault::{self, Fault};
use crate::geometry::Vec3;
use crate::optics::fresnel;
use std::f64::consts::PI;

/// Distribution D(α) of the facets' normals, α from the cloth's normal, per steradian and area of the cloth, so that
/// ∫ D cosα dω = 1 over the hemisphere. m is the roughness.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Distribution {
    /// exp(−tan²α / m²) / (π m² cos⁴α); m is the r.m.s. slope.
    #[default]
    Beckmann,
    /// m² / (π (1 + (m² − 1) cos²α)²), with long tails.
    TrowbridgeReitz,
}

impl Distribution {
    /// D for the cosine of α, 1/sr. Zero for facets that face down.
    pub fn density(self, cos_alpha: f64, roughness: f64) -> f64 {
        if cos_alpha <= 0.0 {
            return 0.0;
        }
        let wide = if fault::active(Fault::FacetSlope) { 2.0 } else { 1.0 };
        let m2 = roughness * roughness;
        let cos2 = cos_alpha * cos_alpha;
        match self {
            Self::Beckmann => (-(1.0 - cos2) / (wide * cos2 * m2)).exp() / (PI * m2 * cos2 * cos2),
            Self::TrowbridgeReitz => m2 / (PI * (1.0 + (m2 - 1.0) * cos2).powi(2)),
        }
    }
}

/// Mirror facets of a dielectric, after R. L. Cook, K. E. Torrance, ACM Trans. Graph. 1 (1982) 7, with the geometric
/// attenuation as J. F. Blinn writes it (SIGGRAPH 1977, 192): f = w F D G / (4 (n·l) (n·v)) in 1/sr.
///
/// The 4 is the Jacobian: the mirrored direction sweeps 4 (v·h) steradians a steradian of facet normals. Cook and
/// Torrance print π, for a D that is π times the normalised one here, which leaves them four times too bright; with
/// the 4 the albedo never exceeds 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Specular {
    distribution: Distribution,
    roughness: f64,
    index: f64,
    weight: f64,
}

impl Specular {
    /// `roughness` from 0.001 to 1, `index` of refraction at least 1, `weight` from 0 (no gloss) to 1 (gloss all over).
    pub fn new(distribution: Distribution, roughness: f64, index: f64, weight: f64) -> Result<Self, ShadingError> {
        if !(0.001..=1.0).contains(&roughness) {
            return Err(ShadingError::Roughness { found: roughness });
        }
        if !(index >= 1.0 && index.is_finite()) {
            return Err(ShadingError::Index { found: index });
        }
        if !(0.0..=1.0).contains(&weight) {
            return Err(ShadingError::Weight { found: weight });
        }
        Ok(Self {
            distribution,
            roughness,
            index,
            weight,
        })
    }

    /// Distribution of the facets' normals.
    pub fn distribution(&self) -> Distribution {
        self.distribution
    }

    /// Roughness m of the distribution.
    pub fn roughness(&self) -> f64 {
        self.roughness
    }

    /// Refractive index of the facets.
    pub fn index(&self) -> f64 {
        self.index
    }

    /// Weight of the gloss, from 0 to 1.
    pub fn weight(&self) -> f64 {
        self.weight
    }

    /// Zero when the light or the viewer is in the cloth's plane or below it.
    pub fn brdf(&self, omega_in: &Vec3, omega_out: &Vec3) -> Brdf {
        let blinn = |facet: &Facet| (2.0 * facet.n_h * facet.n_v.min(facet.n_l) / facet.v_h).min(1.0);
        self.brdf_with(omega_in, omega_out, blinn)
    }

    /// [`Self::brdf`] with another geometric attenuation.
    pub(super) fn brdf_with(&self, omega_in: &Vec3, omega_out: &Vec3, attenuation: impl Fn(&Facet) -> f64) -> Brdf {
        let (n_l, n_v) = (omega_in.z, omega_out.z);
        if n_l <= 0.0 || n_v <= 0.0 {
            return Brdf(0.0);
        }
        // Twice the cosine of the angle between h and either direction. Both are above the plane, so it does not
        // vanish.
        let sum = omega_in + omega_out;
        let length = sum.norm();
        let (n_h, v_h) = (sum.z / length, 0.5 * length);
        let d = self.distribution.density(n_h, self.roughness);
        let g = attenuation(&Facet { n_l, n_v, n_h, v_h });
        let f = fresnel::reflectance(v_h.min(1.0), self.index);
        let twice = if fault::active(Fault::GlossDoubled) { 2.0 } else { 1.0 };
        Brdf(twice * (self.weight * f * d * g / (4.0 * n_l * n_v)))
    }
}

/// Cosines at the facet that mirrors the light to the viewer: of light, viewer and facet normal from the cloth's
/// normal, and of the angle between either direction and the facet's normal.
pub(super) struct Facet {
    pub(super) n_l: f64,
    pub(super) n_v: f64,
    pub(super) n_h: f64,
    pub(super) v_h: f64,
}
