//! Woven cloth: draft, centre lines of the yarns, their smooth surfaces, rays through the endless periodic weave, and
//! light in it.
//!
//! The cloth lies in the x–y plane around z = 0, its outer normal is +z. Warp yarns run along x, weft yarns along y.
//! The first warp of the cell is at y = ½ warp spacing, the first weft at x = ½ weft spacing. Lengths are in mm.

mod draft;
mod error;
mod geometry;
pub mod light;
mod spec;
mod system;

pub use draft::{Draft, Weave};
pub use error::ClothError;
pub use geometry::{CentreLine, Cloth, Hit, PeirceSegment};
pub use spec::{CentreLineKind, ClothSpec};
pub use system::{System, YarnId};
