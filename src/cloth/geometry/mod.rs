//! Geometry of a cloth: centre lines of the yarns, their smooth surfaces, and intersection with rays.

mod centre_line;
mod interpenetration;
mod layout;
mod piece;
mod rays;
mod tube;

pub use centre_line::{CentreLine, PeirceSegment};
pub use rays::{Cloth, Hit};
