use super::facets::{finite, lambert_and};
use crate::geometry::Vec3;
use crate::shading::model::DIFFUSE;
use crate::shading::{Brdf, ClassicalModel, Lobes, Parameter, ShadingError, ShadingModel};
use std::f64::consts::PI;

/// Range of the roughness; a smaller one is a rim of light that no goniophotometer resolves.
const ROUGHNESS: [f64; 2] = [0.05, 1.0];

/// Values without a fit: soft sheen of a tenth, as on felt.
const START: [f64; 3] = [1.0, 0.5, 0.1];

/// What renderers of today have for fabric.
pub(super) static MODEL: ClassicalModel = ClassicalModel {
    id: "lambert-charlie",
    label: "Lambert + Charlie sheen",
    parameters: &[
        DIFFUSE,
        Parameter {
            name: "roughness",
            unit: "",
            range: ROUGHNESS,
            meaning: "spread of the fibres about the cloth's normal",
        },
        Parameter {
            name: "weight",
            unit: "",
            range: [0.0, 1.0],
            meaning: "fraction of the light that the fibres on top reflect, white",
        },
    ],
    start: |_| START.to_vec(),
    build: |basis, values| {
        let &[diffuse, roughness, weight] = values else {
            return Err(MODEL.wrong_count(values));
        };
        if !(ROUGHNESS[0]..=ROUGHNESS[1]).contains(&roughness) {
            return Err(ShadingError::Sheen { found: roughness });
        }
        if !(0.0..=1.0).contains(&weight) {
            return Err(ShadingError::Weight { found: weight });
        }
        Ok(Box::new(LambertCharlie {
            albedo: finite(basis.normal.map(|factor| diffuse * factor))?,
            roughness,
            weight,
            visibility: visibility(roughness),
        }))
    },
};

/// Lambert under a sheen of fibres that stand on the cloth, A. C. Estevez, C. Kulla, "Production friendly microfacet
/// sheen BRDF" (SIGGRAPH 2017 course "Physically Based Shading in Theory and Practice"):
///
/// f = a/π + w D G / (4 (n·l) (n·v)), D = (2 + 1/r) sin^(1/r)θ_h / (2π), G = 1 / (1 + Λ(θ_l) + Λ(θ_v)),
///
/// Λ(θ) = exp L(cosθ) for cosθ < 0.5, exp(2 L(0.5) − L(1 − cosθ)) above, L(x) = a/(1 + b x^c) + d x + e with
/// coefficients between those of r = 0 and r = 1 by (1 − r)². Their softened terminator is left out: it is not
/// reciprocal.
struct LambertCharlie {
    albedo: [f64; 4],
    roughness: f64,
    weight: f64,
    visibility: [f64; 5],
}

/// a, b, c, d, e of L for a roughness.
fn visibility(roughness: f64) -> [f64; 5] {
    const SHARP: [f64; 5] = [25.3245, 3.32435, 0.16801, -1.27393, -4.85967];
    const SOFT: [f64; 5] = [21.5473, 3.82987, 0.19823, -1.97760, -4.32054];
    let share = (1.0 - roughness).powi(2);
    std::array::from_fn(|k| share * SHARP[k] + (1.0 - share) * SOFT[k])
}

impl LambertCharlie {
    fn lambda(&self, cos: f64) -> f64 {
        let [a, b, c, d, e] = self.visibility;
        let l = |x: f64| a / (1.0 + b * x.powf(c)) + d * x + e;
        match cos < 0.5 {
            true => l(cos).exp(),
            false => (2.0 * l(0.5) - l((1.0 - cos).max(0.0))).exp(),
        }
    }

    /// Sheen of directions above the plane.
    fn sheen(&self, omega_in: &Vec3, omega_out: &Vec3) -> Brdf {
        let (n_l, n_v) = (omega_in.z, omega_out.z);
        let cos_h = ((n_l + n_v) / (omega_in + omega_out).norm()).min(1.0);
        let sin_h = (1.0 - cos_h * cos_h).sqrt();
        let inverse = 1.0 / self.roughness;
        let d = (2.0 + inverse) * sin_h.powf(inverse) / (2.0 * PI);
        let g = 1.0 / (1.0 + self.lambda(n_l) + self.lambda(n_v));
        Brdf(self.weight * d * g / (4.0 * n_l * n_v))
    }
}

impl ShadingModel for LambertCharlie {
    fn albedo(&self) -> [f64; 4] {
        self.albedo
    }

    fn lobes(&self, omega_in: &Vec3, omega_out: &Vec3) -> Lobes {
        lambert_and(omega_in, omega_out, || self.sheen(omega_in, omega_out))
    }
}
