//! Goniometric files: what the field's instruments, archives and renderers read and write.
//!
//! Every reader gives one [`Goniometric`], whose values stay in the file's own quantity, parameters and nodes; every writer
//! takes one. Formats are told by content. Conventions of each format: `docs/formats.md`.

mod axis;
mod columns;
mod cosine;
mod detect;
mod error;
mod goniometric;
mod grid;
mod hemispherical;
mod integra;
mod klems;
mod merl;
mod pole;
mod radiance;
mod rgl;
mod scattered;
mod source;
mod specular;
mod ssdd;
mod tensor_tree;
mod text;
mod utia;
mod warped;
mod write;
mod zemax;

use std::path::Path;

pub use axis::Axis;
pub use detect::Format;
pub use error::{FormatError, Place};
pub use goniometric::{
    Channels, Component, Evaluation, Goniometric, Placement, Provenance, Quantity, Scatter, Side, Table, direction,
};
pub use grid::{Fold, Grid, Parameters};
pub use hemispherical::Hemispherical;
pub use klems::{KlemsBasis, KlemsMatrix};
pub use scattered::{Directions, Scattered};
pub use specular::SpecularTable;
pub use tensor_tree::TensorTree;
pub use warped::Warped;
pub use write::{Encoding, WriteError, WriteOptions, Written, write};

pub(crate) use source::read as read_bytes;
pub(crate) use text::{Text, quoted};
pub(crate) use write::resampled_nodes;

/// What some formats leave open, stated by the user.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Of Integra and ASTM files, which differ by name alone.
    pub scatter: Option<Scatter>,
    /// Of ASTM files; radians if not stated.
    pub angle_unit: Option<AngleUnit>,
    /// Factor from a UTIA file's numbers to f in 1/sr.
    pub scale: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AngleUnit {
    Radians,
    Degrees,
}

/// Reads a file of any format.
///
/// # Errors
/// The first place where the file departs from its format; a file that is too large for its format is refused before
/// it is read.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Goniometric, FormatError> {
    let (format, bytes) = source::read(path)?;
    parse_as(format, &path.display().to_string(), &bytes, options)
}

/// The format of a file, by its first bytes.
///
/// # Errors
/// No file that can be read, or of no known format, or larger than its format can be.
pub fn format_of(path: &Path) -> Result<Format, FormatError> {
    source::open(path).map(|(format, ..)| format)
}

/// Reads the bytes of a file; `path` is what errors call them, and tells reflection from transmission where the content
/// does not.
///
/// # Errors
/// As [`read`].
pub fn parse(path: &str, bytes: &[u8], options: &ReadOptions) -> Result<Goniometric, FormatError> {
    let head = &bytes[..bytes.len().min(source::HEAD)];
    parse_as(detect::detect(path, head, bytes.len() as u64)?, path, bytes, options)
}

fn parse_as(format: Format, path: &str, bytes: &[u8], options: &ReadOptions) -> Result<Goniometric, FormatError> {
    let mut data = match format {
        Format::Csv => columns::read_csv(Text::new(path, bytes)?),
        Format::Ddr => integra::read_diffuse(Text::new(path, bytes)?, options),
        Format::Sdr => integra::read_specular(Text::new(path, bytes)?, options),
        Format::Ssdd => ssdd::read(path, bytes),
        Format::Astm => columns::read_astm(Text::new(path, bytes)?, options),
        Format::Merl => merl::read(path, bytes),
        Format::Rgl => rgl::read(path, bytes),
        Format::Zemax => zemax::read_zemax(Text::new(path, bytes)?),
        Format::LightTools => zemax::read_lighttools(Text::new(path, bytes)?),
        Format::RadianceXml => radiance::read(Text::new(path, bytes)?),
        Format::Utia => utia::read(path, bytes, options),
        Format::Wif => Err(FormatError::file(
            path,
            "a goniometric file; `specval weave` reads drafts",
            "a weave draft (WIF)",
        )),
    }?;
    pole::give_one_value(&mut data);
    Ok(data)
}
