use crate::geometry::Vec3;

/// Number of uniform random numbers in [0, 1) from which an entry point and direction are drawn. The first is
/// stratified over the paths of a batch.
pub const ENTRY_COORDINATES: usize = 4;

/// Entry point of a path on the body, and the direction it comes from.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    pub position: Vec3,
    /// Outward unit normal.
    pub normal: Vec3,
    /// Unit vector towards the light, above the surface.
    pub omega_in: Vec3,
}

/// Part of a path's flux that leaves the body.
#[derive(Clone, Copy, Debug)]
pub struct Exit<'w> {
    /// Index of the path among the paths of the trace.
    pub path: usize,
    /// Position where the path entered the body, and unit vector towards the light there.
    pub entry: Vec3,
    pub omega_in: Vec3,
    pub position: Vec3,
    /// Outward unit normal.
    pub normal: Vec3,
    /// Unit direction outside, away from the body.
    pub direction: Vec3,
    /// Fraction of the path's incident flux at each wavelength of the interior.
    pub weights: &'w [f64],
    /// Whether the light was scattered; if not it is ballistic, and its direction is a delta.
    pub scattered: bool,
    /// Length of the path inside, mm.
    pub length_mm: f64,
}
