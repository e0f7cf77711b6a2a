use super::facets::{INDEX, ROUGHNESS, WEIGHT, finite, lambert_and, start};
use crate::geometry::Vec3;
use crate::shading::model::DIFFUSE;
use crate::shading::specular::Facet;
use crate::shading::{ClassicalModel, Distribution, Lobes, ShadingModel, Specular};

/// What renderers of today have for a rough dielectric.
pub(super) static MODEL: ClassicalModel = ClassicalModel {
    id: "lambert-ggx",
    label: "Lambert + GGX",
    parameters: &[DIFFUSE, ROUGHNESS, INDEX, WEIGHT],
    start,
    build: |basis, values| {
        let &[diffuse, roughness, index, weight] = values else {
            return Err(MODEL.wrong_count(values));
        };
        let specular = Specular::new(Distribution::TrowbridgeReitz, roughness, index, weight)?;
        let albedo = finite(basis.normal.map(|factor| diffuse * factor))?;
        Ok(Box::new(LambertGgx { albedo, specular }))
    },
};

/// Lambert under a gloss of facets with the slopes of Trowbridge and Reitz ("GGX") and Smith's masking and shadowing,
/// as B. Walter, S. R. Marschner, H. Li, K. E. Torrance write it (Eurographics Symposium on Rendering 2007, 195; eqs.
/// 20, 33 and 34):
///
/// f = a/π + w F D G₁(l) G₁(v) / (4 (n·l) (n·v)), G₁(ω) = 2 / (1 + √(1 + m² tan²θ)),
///
/// a the albedo, w the weight, F Fresnel's reflectance at the facet, m the roughness.
struct LambertGgx {
    albedo: [f64; 4],
    specular: Specular,
}

impl ShadingModel for LambertGgx {
    fn albedo(&self) -> [f64; 4] {
        self.albedo
    }

    fn lobes(&self, omega_in: &Vec3, omega_out: &Vec3) -> Lobes {
        let m2 = self.specular.roughness().powi(2);
        let smith = |cos: f64| 2.0 / (1.0 + (1.0 + m2 * (1.0 / (cos * cos) - 1.0)).sqrt());
        let attenuation = |facet: &Facet| smith(facet.n_l) * smith(facet.n_v);
        lambert_and(omega_in, omega_out, || {
            self.specular.brdf_with(omega_in, omega_out, attenuation)
        })
    }
}
