use crate::geometry::Vec3;
use crate::shading::{Basis, ClassicalModel, Parameter, ShadingError, ShadingModel, Specular};

/// The preprint's classical model.
pub(super) static MODEL: ClassicalModel = ClassicalModel {
    id: "lambert-cook-torrance",
    label: "Lambert + Cook–Torrance",
    parameters: &[
        Parameter {
            name: "diffuse",
            unit: "",
            range: [0.0, 2.0],
            meaning: "Lambert part, in units of the sample's brightness factor at the normal",
        },
        Parameter {
            name: "roughness",
            unit: "",
            range: [0.001, 1.0],
            meaning: "slope of the facets",
        },
        Parameter {
            name: "index",
            unit: "",
            range: [1.0, 3.0],
            meaning: "refractive index of the facets",
        },
        Parameter {
            name: "weight",
            unit: "",
            range: [0.0, 1.0],
            meaning: "fraction of the area that is facets",
        },
    ],
    start: |Basis { specular, .. }| vec![1.0, specular.roughness(), specular.index(), specular.weight()],
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
        if normal.iter().all(|factor| factor.is_finite()) {
            Ok(Self { normal, specular })
        } else {
            Err(ShadingError::Factor { found: normal })
        }
    }
}

impl ShadingModel for LambertCookTorrance {
    fn eval(&self, omega_in: &Vec3, omega_out: &Vec3, white: &[f64; 4]) -> [f64; 4] {
        if omega_in.z <= 0.0 || omega_out.z <= 0.0 {
            return [0.0; 4];
        }
        let gloss = self.specular.brdf(omega_in, omega_out).brightness_factor().0;
        std::array::from_fn(|channel| self.normal[channel] + gloss * white[channel])
    }
}
