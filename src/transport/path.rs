use crate::geometry::Vec3;

/// Uniform random numbers in [0, 1) from which an entry point and direction are drawn. The first is stratified over the paths of a
/// batch.
pub const ENTRY_COORDINATES: usize = 4;

/// Where and whence light meets the body.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    pub position: Vec3,
    /// Outward unit normal.
    pub normal: Vec3,
    /// Unit vector towards the light, above the surface.
    pub omega_in: Vec3,
}

/// A part of a path's light that leaves the body.
#[derive(Clone, Copy, Debug)]
pub struct Exit<'w> {
    /// Where and whence the path met the body.
    pub entry: Vec3,
    pub omega_in: Vec3,
    pub position: Vec3,
    /// Outward unit normal.
    pub normal: Vec3,
    /// Unit direction outside, away from the body.
    pub direction: Vec3,
    /// Fraction of the path's incident flux at each wavelength of the interior.
    pub weights: &'w [f64],
    /// Whether it met a particle; if not it is ballistic, and its direction a delta.
    pub scattered: bool,
    /// Length of the path inside, mm.
    pub length_mm: f64,
}
