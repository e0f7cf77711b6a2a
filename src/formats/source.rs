//! Files in, refused by size before they are read.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::FormatError;
use super::detect::{Format, detect};

/// Bytes of a file's beginning by which its format is known.
pub(super) const HEAD: usize = 64 << 10;

/// A file's format, the file, its first bytes and its size, which its format can have.
pub(super) fn open(path: &Path) -> Result<(Format, File, Vec<u8>, u64), FormatError> {
    let name = path.display().to_string();
    let fail = failed(&name);
    // Asked before opening: to open a named pipe is to wait for ever.
    let there = std::fs::metadata(path).map_err(&fail)?;
    if !there.is_file() {
        let found = if there.is_dir() { "a folder" } else { "a device or pipe" };
        let remedy = "name the file itself; what a device or pipe gives, write into a file first";
        return Err(FormatError::file(&name, "a file", found, remedy));
    }
    let mut file = File::open(path).map_err(&fail)?;
    let size = there.len();
    let mut head = Vec::new();
    file.by_ref().take(HEAD as u64).read_to_end(&mut head).map_err(&fail)?;
    let format = detect(&name, &head, size)?;
    let sizes = format.sizes();
    if !sizes.contains(&size) {
        let expected = if sizes.start() == sizes.end() {
            format!("{} bytes, as every file of the format {format} has", sizes.end())
        } else {
            format!("at most {} bytes in a file of the format {format}", sizes.end())
        };
        let remedy = if sizes.start() == sizes.end() {
            "copy the file again in binary mode; a variant of the format with other counts is not read"
        } else {
            "write fewer angles or wavelengths, or split the file by wavelength"
        };
        return Err(FormatError::file(&name, expected, format!("{size} bytes"), remedy));
    }
    Ok((format, file, head, size))
}

/// The bytes of a file of at most so many as its format can have, and that format.
pub(crate) fn read(path: &Path) -> Result<(Format, Vec<u8>), FormatError> {
    let (format, file, mut bytes, size) = open(path)?;
    // Not more than promised, should the file grow meanwhile.
    let rest = size.saturating_sub(bytes.len() as u64);
    bytes.reserve_exact(rest as usize);
    let name = path.display().to_string();
    file.take(rest).read_to_end(&mut bytes).map_err(failed(&name))?;
    Ok((format, bytes))
}

/// Whether most numbers that are not 0 are of no magnitude that scattering has, as those with their bytes reversed are.
pub(super) fn is_implausible(values: impl Iterator<Item = f64>) -> bool {
    let (mut all, mut odd) = (0usize, 0usize);
    for value in values.filter(|v| *v != 0.0) {
        all += 1;
        odd += usize::from(!(1e-12..=1e12).contains(&value.abs()));
    }
    2 * odd > all
}

/// The error of numbers that [`is_implausible`] tells.
pub(super) fn swapped(path: &str, offset: usize) -> FormatError {
    let found = "numbers most of which are beyond 1e-12 to 1e12, as with their bytes in reversed order";
    let remedy = "reverse the bytes of each number, or copy the original file again in binary mode";
    FormatError::byte(path, offset, "little-endian numbers", found, remedy)
}

fn failed(name: &str) -> impl Fn(std::io::Error) -> FormatError + '_ {
    move |e| {
        let remedy = "check the name and the right to read it";
        FormatError::file(name, "a file that can be read", e.to_string(), remedy)
    }
}
