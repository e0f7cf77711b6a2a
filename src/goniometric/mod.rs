//! Goniometric data in memory: tables in the parameters of their files, evaluation and hemispherical values.

mod axis;
mod chart;
mod cosine;
mod data;
mod direction;
mod grid;
mod hemispherical;
mod kinds;
mod klems;
mod notice;
mod parameters;
mod pole;
mod scattered;
mod specular;
mod tensor_tree;
mod warped;

pub use axis::Axis;
pub use data::{Component, Evaluation, Goniometric, Table};
pub use direction::direction;
pub use grid::Grid;
pub(crate) use hemispherical::Hemisphere;
pub use hemispherical::Hemispherical;
pub use kinds::{ChannelSet, FileProvenance, Format, Placement, Quantity, Scatter, Side};
pub use klems::{KlemsBasis, KlemsMatrix};
pub use notice::ReadNotice;
pub use parameters::{Fold, Parameters};
pub use scattered::{Directions, Scattered};
pub use specular::SpecularTable;
pub use tensor_tree::TensorTree;
pub use warped::Warped;

pub(crate) use cosine::divide_by_cosine;
pub(crate) use direction::{angles_of, degrees, radians, rounded_deg};
pub(crate) use parameters::{about_z, from_specular};
pub(crate) use pole::give_one_value;
pub(crate) use tensor_tree::Node;
pub(crate) use warped::{Arrays, unwarped_node};
