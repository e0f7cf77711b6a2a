//! Goniometric files: what the field's instruments, archives and renderers read and write.
//!
//! Every reader gives one [`Goniometric`], whose values stay in the file's own quantity, parameters and nodes; every
//! writer takes one. Formats are recognised by content; `registry` lists them. Conventions of each format: `docs/formats.md`.

mod byte_order;
mod descriptor;
mod error;
mod merl_table;
mod notices;
mod options;
mod read;
pub mod registry;
mod rgl_arrays;
mod rgl_read;
mod source;
mod text;
mod write;
mod written;

pub use crate::goniometric::{
    Axis, ChannelSet, Component, Directions, Evaluation, FileProvenance, Fold, Format, Goniometric, Grid,
    Hemispherical, KlemsBasis, KlemsMatrix, Parameters, Placement, Quantity, ReadNotice, Scatter, Scattered, Side,
    SpecularTable, Table, TensorTree, Warped, direction,
};
pub use descriptor::{Descriptor, FormatWriter, Holds};
pub use error::{FormatError, Location};
pub use options::{AngleUnit, Encoding, ReadOptions, WriteOptions};
pub use read::{format_of, parse, read};
pub use write::{WriteError, WriteNotice};
pub use written::{Written, write};

pub(crate) use error::remedy;
pub(crate) use source::read_bytes;
pub(crate) use text::{Text, decode, quoted};
pub(crate) use write::resampled_nodes;
