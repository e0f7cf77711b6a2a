use super::{ClothLedger, ViewCones};
use crate::cloth::Cloth;
use crate::geometry::Vec3;
use rand::{Rng, RngExt};

/// A parallel beam onto the whole cloth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Unit vector towards the light.
    pub omega_in: Vec3,
    /// Number of the beam, which separates the random streams of a study's beams.
    pub number: usize,
}

impl Beam {
    /// Starting points of `particles` particles above the cloth, uniform over the unit cell: stratified along x, at
    /// multiples of the golden ratio along y.
    pub(super) fn origins(&self, cloth: &Cloth, particles: usize, rng: &mut impl Rng) -> Vec<Vec3> {
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let [cell_x, cell_y] = cloth.cell_mm();
        let away = self.omega_in * (2.0 * cloth.top_mm() / self.omega_in.z.abs());
        let shift: f64 = rng.random();
        (0..particles)
            .map(|k| {
                let x = (k as f64 + rng.random::<f64>()) / particles as f64;
                let y = (shift + GOLDEN * k as f64).fract();
                Vec3::new(x * cell_x, y * cell_y, 0.0) + away
            })
            .collect()
    }
}

/// Result of one batch of particles of one beam.
#[derive(Clone, Debug, PartialEq)]
pub struct ClothBatch {
    /// Ledger at each wavelength.
    pub ledger: Vec<ClothLedger>,
    /// Fraction of the beam that the detector's bins caught: `[bin][wavelength]`.
    pub caught: Vec<Vec<f64>>,
}

/// A beam, and the views of the cloth it illuminates.
#[derive(Clone, Debug, PartialEq)]
pub struct LitViews {
    pub beam: Beam,
    pub cones: ViewCones,
    /// Number of each view, which separates their random streams whatever else is measured.
    pub numbers: Vec<usize>,
}

/// Result of one batch at the views of one beam.
#[derive(Clone, Debug, PartialEq)]
pub struct LitBatch {
    /// Brightness factor, π L/(E⊥ cosθ_i), at `[view][wavelength]`.
    pub beta: Vec<Vec<f64>>,
    /// Ledger at each wavelength; empty if the light is not traced beyond the first yarn.
    pub ledger: Vec<ClothLedger>,
}
