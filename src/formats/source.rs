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
        return Err(FormatError::file(&name, "a file", found));
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
        return Err(FormatError::file(&name, expected, format!("{size} bytes")));
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

fn failed(name: &str) -> impl Fn(std::io::Error) -> FormatError + '_ {
    move |e| FormatError::file(name, "a file that can be read", e.to_string())
}
