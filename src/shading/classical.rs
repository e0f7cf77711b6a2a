use super::{ShadingError, ShadingModel, Specular};
use crate::geometry::Vec3;

/// What a renderer would do with the sample: Lambert with the sample's own brightness factor at normal incidence and
/// view, plus the same gloss as the physical model. Works in the colour channels red, green, blue and luminance: colour
/// is linear in the spectrum, so the sum may be taken there.
///
/// The gloss is added on top, so before normalisation the model is brighter than the sample at normal/normal by the
/// gloss there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Classical {
    normal: [f64; 4],
    specular: Specular,
}

impl Classical {
    /// `normal`: the sample's brightness factors with light and viewer on the normal. Finite; below 0 where the sample's
    /// colour is outside the gamut, above 1 where it shines.
    pub fn new(normal: [f64; 4], specular: Specular) -> Result<Self, ShadingError> {
        if normal.iter().all(|factor| factor.is_finite()) {
            Ok(Self { normal, specular })
        } else {
            Err(ShadingError::Factor { found: normal })
        }
    }
}

impl ShadingModel for Classical {
    fn eval(&self, omega_in: &Vec3, omega_out: &Vec3, white: &[f64; 4]) -> [f64; 4] {
        if omega_in.z <= 0.0 || omega_out.z <= 0.0 {
            return [0.0; 4];
        }
        let gloss = self.specular.brdf(omega_in, omega_out).brightness_factor().0;
        std::array::from_fn(|channel| self.normal[channel] + gloss * white[channel])
    }
}
