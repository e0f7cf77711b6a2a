//! Vectors, local frames of a yarn's surface, and grids on the sphere with exact solid angles.

mod frame;
mod hemisphere;
mod sectors;

pub use frame::Frame;
pub use hemisphere::{Bilinear, CellFinder, HemisphereGrid};
pub use sectors::Sectors;

/// Vector in double precision, mm for positions, unit length for directions.
pub type Vec3 = nalgebra::Vector3<f64>;
