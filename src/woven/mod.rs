//! Light in a woven cloth, from yarn to yarn, in the endless weave of smooth tubes: a parallel beam comes in, and every
//! particle of it is followed until it has left above or below, or is absorbed.
//!
//! Inside a yarn the light is either traced through the medium itself ([`Volumetric`]) or scattered by the yarn's
//! radiance factor. What happens in the air is the same for both.

mod air;
mod bounces;
mod detector;
mod ledger;
mod surface;
mod volumetric;

pub use bounces::Bounces;
pub use detector::{Detector, HemisphereNodes, ViewCones};
pub use ledger::ClothLedger;
pub use surface::YarnSurface;
pub use volumetric::{Inside, Volumetric};

use crate::geometry::Vec3;

/// A parallel beam onto the whole cloth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Unit vector towards the light.
    pub omega_in: Vec3,
    /// Tells the random streams of a study's beams apart.
    pub number: usize,
}

/// What one batch of particles of one beam gives.
#[derive(Clone, Debug, PartialEq)]
pub struct ClothBatch {
    /// At each wavelength.
    pub ledger: Vec<ClothLedger>,
    /// Fraction of the beam that the detector's bins caught: [bin][wavelength].
    pub caught: Vec<Vec<f64>>,
}
