use super::{Brdf, BrightnessFactor, ShadingError, Specular};
use crate::geometry::Vec3;
use crate::spectrum::{Samples, WavelengthGrid};

/// Diffuse reflection that looks the same from everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambert {
    factor: BrightnessFactor,
}

impl Lambert {
    /// A finite factor of at least 0. More than 1 is allowed: a measured factor includes gloss and noise.
    pub fn new(factor: BrightnessFactor) -> Result<Self, ShadingError> {
        if factor.0.is_finite() && factor.0 >= 0.0 {
            Ok(Self { factor })
        } else {
            Err(ShadingError::Factor {
                name: "Lambert".into(),
                found: factor.0,
            })
        }
    }

    /// Zero when the light or the viewer is in the cloth's plane or below it.
    pub fn brdf(&self, omega_in: &Vec3, omega_out: &Vec3) -> Brdf {
        if omega_in.z > 0.0 && omega_out.z > 0.0 {
            self.factor.brdf()
        } else {
            Brdf(0.0)
        }
    }
}

/// What a renderer would do with the sample: Lambert with the sample's own brightness factor at normal incidence and
/// view, plus the same gloss as the physical model.
///
/// The gloss is added on top, so before normalisation the model is brighter than the sample at normal/normal by the
/// gloss there.
#[derive(Clone, Debug, PartialEq)]
pub struct Classical {
    grid: WavelengthGrid,
    diffuse: Vec<Lambert>,
    specular: Specular,
}

impl Classical {
    /// `normal_normal`: the sample's brightness factors with light and viewer on the normal, each at least 0.
    pub fn new(normal_normal: &Samples, specular: Specular) -> Result<Self, ShadingError> {
        let grid = normal_normal.grid().clone();
        let diffuse = normal_normal
            .values()
            .iter()
            .zip(grid.nm())
            .map(|(&found, nm)| {
                Lambert::new(BrightnessFactor(found)).map_err(|_| ShadingError::Factor {
                    name: format!("normal/normal value of the sample at {nm} nm"),
                    found,
                })
            })
            .collect::<Result<_, _>>()?;
        Ok(Self {
            grid,
            diffuse,
            specular,
        })
    }

    pub fn grid(&self) -> &WavelengthGrid {
        &self.grid
    }

    /// One value a wavelength of [`Self::grid`].
    pub fn brightness_factors(
        &self,
        omega_in: &Vec3,
        omega_out: &Vec3,
    ) -> impl ExactSizeIterator<Item = BrightnessFactor> {
        let gloss = self.specular.brdf(omega_in, omega_out);
        let (omega_in, omega_out) = (*omega_in, *omega_out);
        self.diffuse
            .iter()
            .map(move |lambert| (lambert.brdf(&omega_in, &omega_out) + gloss).brightness_factor())
    }
}
