//! The shape of a cloth: centre lines of its yarns, their smooth surfaces, and rays that meet them.

mod centre_line;
mod interpenetration;
mod layout;
mod piece;
mod rays;
mod tube;

pub use centre_line::{CentreLine, PeirceSegment};
pub use rays::{Cloth, Hit};
