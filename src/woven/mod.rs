//! Light in a woven cloth, from yarn to yarn, in the endless weave of smooth tubes: a parallel beam comes in, and every
//! particle of it is followed until it has left above or below, or is absorbed.
//!
//! Inside a yarn the light is either traced through the medium itself ([`Volumetric`]) or scattered by the yarn's
//! response f*. What happens in the air is the same for both.

mod air;
mod bounces;
mod detector;
mod ledger;
mod passage;
mod scattering;
mod sights;
mod straight;
mod surface;
mod volumetric;

pub use bounces::Onlookers;
pub use detector::{Detector, HemisphereNodes, ViewCones};
pub use ledger::{ClothFraction, ClothLedger};
pub use scattering::Bounces;
pub use sights::{Places, Sight};
pub use surface::YarnSurface;
pub use volumetric::{Inside, Volumetric};

use crate::cloth::Tubes;
use crate::geometry::Vec3;
use rand::{Rng, RngExt};

/// A parallel beam onto the whole cloth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Unit vector towards the light.
    pub omega_in: Vec3,
    /// Tells the random streams of a study's beams apart.
    pub number: usize,
}

impl Beam {
    /// Where `particles` of it set out, over the cloth and evenly spread over the cell of its plane: strata along x in order, along
    /// y at the golden ratio's multiples.
    fn origins(&self, tubes: &Tubes, particles: usize, rng: &mut impl Rng) -> Vec<Vec3> {
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let [cell_x, cell_y] = tubes.cell_mm();
        let away = self.omega_in * (2.0 * tubes.top_mm() / self.omega_in.z.abs());
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

/// What one batch of particles of one beam gives.
#[derive(Clone, Debug, PartialEq)]
pub struct ClothBatch {
    /// At each wavelength.
    pub ledger: Vec<ClothLedger>,
    /// Fraction of the beam that the detector's bins caught: [bin][wavelength].
    pub caught: Vec<Vec<f64>>,
}
