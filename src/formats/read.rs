//! Files into data.

use std::path::Path;

use super::descriptor::{Descriptor, Input};
use super::error::FormatError;
use super::notices::counted;
use super::options::ReadOptions;
use super::{registry, source};
use crate::goniometric::{Format, Goniometric, ReadNotice, Table, give_one_value};

/// Reads a file of any format.
///
/// # Errors
/// The first place where the file departs from its format; a file that is too large for its format is refused before
/// it is read.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Goniometric, FormatError> {
    let (known, bytes) = source::read(path)?;
    parse_as(known, &path.display().to_string(), &bytes, options)
}

/// The format of a file, by its first bytes.
///
/// # Errors
/// No file that can be read, or of no known format, or larger than its format can be.
pub fn format_of(path: &Path) -> Result<Format, FormatError> {
    source::open(path).map(|opened| opened.known.format)
}

/// Reads the bytes of a file; `path` is what errors call them, and tells reflection from transmission where the content
/// does not.
///
/// # Errors
/// As [`read`].
pub fn parse(path: &str, bytes: &[u8], options: &ReadOptions) -> Result<Goniometric, FormatError> {
    let head = &bytes[..bytes.len().min(source::HEAD)];
    parse_as(registry::detect(path, head, bytes.len() as u64)?, path, bytes, options)
}

fn parse_as(known: &Descriptor, path: &str, bytes: &[u8], options: &ReadOptions) -> Result<Goniometric, FormatError> {
    /// Below it values that differ are taken as rounded.
    const SEAM: f64 = 1e-3;
    let mut data = registry::read(known, &Input { path, bytes, options })?;
    give_one_value(&mut data);
    for component in &data.components {
        if let Table::Grid(grid) = &component.table
            && grid.seam() > SEAM
        {
            data.warnings.push(ReadNotice::Seam {
                difference: grid.seam(),
            });
        }
    }
    data.warnings = counted(std::mem::take(&mut data.warnings), |notice, times| {
        ReadNotice::Several {
            notice: Box::new(notice),
            times,
        }
    });
    Ok(data)
}
