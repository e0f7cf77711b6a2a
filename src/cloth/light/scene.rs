use super::YarnSurface;
use crate::cloth::Cloth;
use crate::yarn::Yarn;

/// What light meets: a cloth, what its yarns are, and what lies under it. It knows no way to follow light.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    pub cloth: &'a Cloth,
    /// Of warp and weft, with the same wavelengths.
    pub yarns: [&'a Yarn; 2],
    /// Reflectance, at each wavelength, of a perfectly rough plane right under the cloth; `None` where light goes on.
    pub backing: Option<&'a [f64]>,
    /// What becomes of light that the outer surface of a yarn reflects.
    pub surface: YarnSurface,
    /// Of all random numbers.
    pub seed: u64,
}

impl Scene<'_> {
    pub fn wavelengths(&self) -> usize {
        self.yarns[0].medium.grid().len()
    }
}
