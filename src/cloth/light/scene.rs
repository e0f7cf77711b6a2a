use super::YarnSurface;
use crate::cloth::Cloth;
use crate::yarn::Yarn;

/// Cloth, yarns, surface and backing that light meets. Independent of the method that traces the light.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    pub cloth: &'a Cloth,
    /// Yarns of warp and weft, with the same wavelengths.
    pub yarns: [&'a Yarn; 2],
    /// Reflectance, at each wavelength, of a Lambertian plane directly under the cloth; `None` without a backing.
    pub backing: Option<&'a [f64]>,
    /// How the outer surface of a yarn reflects light.
    pub surface: YarnSurface,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl Scene<'_> {
    /// Number of wavelengths.
    pub fn wavelengths(&self) -> usize {
        self.yarns[0].medium.grid().len()
    }
}
