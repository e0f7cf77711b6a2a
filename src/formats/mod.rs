//! Goniometric files: what the field's instruments, archives and renderers read and write.
//!
//! Every reader gives one [`Goniometric`], whose values stay in the file's own quantity, parameters and nodes; every writer
//! takes one. Formats are told by content. Conventions of each format: `docs/formats.md`.

mod axis;
mod columns;
mod cosine;
mod csv_readings;
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

pub(crate) use error::remedy;
pub(crate) use source::read as read_bytes;
pub(crate) use text::{Text, decode, quoted};
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
    /// Below it values that differ are taken as rounded.
    const SEAM: f64 = 1e-3;
    let mut data = parse_values(format, path, bytes, options)?;
    pole::give_one_value(&mut data);
    for component in &data.components {
        if let Table::Grid(grid) = &component.table
            && grid.seam() > SEAM
        {
            data.warnings.push(format!(
                "values at azimuths 360 degrees apart, which are one direction, differ by up to {:.1} %: both are kept, with a \
                 jump between them",
                100.0 * grid.seam()
            ));
        }
    }
    data.warnings = counted(std::mem::take(&mut data.warnings));
    Ok(data)
}

/// Each once, with how often it was there.
fn counted(all: Vec<String>) -> Vec<String> {
    let mut times: Vec<(String, usize)> = Vec::new();
    for words in all {
        match times.iter_mut().find(|(known, _)| *known == words) {
            Some((_, count)) => *count += 1,
            None => times.push((words, 1)),
        }
    }
    let told = |(words, count): (String, usize)| {
        if count == 1 {
            words
        } else {
            format!("{words} ({count} times)")
        }
    };
    times.into_iter().map(told).collect()
}

fn parse_values(format: Format, path: &str, bytes: &[u8], options: &ReadOptions) -> Result<Goniometric, FormatError> {
    let decoded = match format {
        Format::Ddr | Format::Sdr | Format::Astm | Format::Zemax | Format::LightTools | Format::RadianceXml => {
            decode(path, bytes)?
        }
        Format::Csv => return csv_readings::read(path, bytes),
        Format::Ssdd => return ssdd::read(path, bytes),
        Format::Merl => return merl::read(path, bytes),
        Format::Rgl => return rgl::read(path, bytes),
        Format::Utia => return utia::read(path, bytes, options),
        Format::Wif => {
            return Err(FormatError::file(
                path,
                "a goniometric file",
                "a weave draft (WIF)",
                "print it with `specval weave`, or name it as `weave` in `[cloth]` of a study",
            ));
        }
    };
    let text = Text::new(path, &decoded.text);
    let mut data = match format {
        Format::Ddr => integra::read_diffuse(text, options),
        Format::Sdr => integra::read_specular(text, options),
        Format::Astm => columns::read_astm(text, options),
        Format::Zemax => zemax::read_zemax(text),
        Format::LightTools => zemax::read_lighttools(text),
        _ => radiance::read(text),
    }?;
    data.warnings.extend(decoded.notice);
    Ok(data)
}
