use super::facets::{INDEX, ROUGHNESS, WEIGHT, finite, lambert_and, start};
use crate::geometry::Vec3;
use crate::shading::model::DIFFUSE;
use crate::shading::{ClassicalModel, Lobes, ShadingError, ShadingModel, Specular};

/// The preprint's classical model.
pub(super) static MODEL: ClassicalModel = ClassicalModel {
    id: "lambert-cook-torrance",
    label: "Lambert + Cook–Torrance",
    parameters: &[DIFFUSE, ROUGHNESS, INDEX, WEIGHT],
    start,
    build: |basis, values| {
        let &[diffuse, roughness, index, weight] = values else {
            return Err(MODEL.wrong_count(values));
        };
        let specular = Specular::new(basis.specular.distribution(), roughness, index, weight)?;
        let normal = basis.normal.map(|factor| diffuse * factor);
        Ok(Box::new(LambertCookTorrance::new(normal, specular)?))
    },
};

/// Lambert with the sample's own brightness factor at normal incidence and view, plus the gloss of the physical model.
/// Works in the colour channels red, green, blue and luminance: colour is linear in the spectrum, so the sum may be
/// taken there.
///
/// The gloss is added on top, so before normalisation the model is brighter than the sample at normal/normal by the
/// gloss there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LambertCookTorrance {
    normal: [f64; 4],
    specular: Specular,
}

impl LambertCookTorrance {
    /// `normal`: brightness factors of the Lambert part, finite.
    ///
    /// # Errors
    /// Factors that are not finite.
    pub fn new(normal: [f64; 4], specular: Specular) -> Result<Self, ShadingError> {
        let normal = finite(normal)?;
        Ok(Self { normal, specular })
    }
}

impl ShadingModel for LambertCookTorrance {
    fn albedo(&self) -> [f64; 4] {
        self.normal
    }

    fn lobes(&self, omega_in: &Vec3, omega_out: &Vec3) -> Lobes {
        lambert_and(omega_in, omega_out, || self.specular.brdf(omega_in, omega_out))
    }
}
