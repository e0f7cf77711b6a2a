//! Files in, refused by size before they are read.

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;

use super::descriptor::Descriptor;
use super::error::FormatError;
use super::registry::detect;
use crate::goniometric::Format;
use crate::input::read_rest;

/// Bytes of a file's beginning by which its format is known.
pub(super) const HEAD: usize = 64 << 10;

/// A file of a known format.
pub(super) struct Opened {
    pub(super) known: &'static Descriptor,
    file: File,
    /// Its first bytes, already read from `file`.
    head: Vec<u8>,
    /// Size of the whole file, bytes; within the sizes of its format.
    size: u64,
}

/// A file whose size its format can have.
pub(super) fn open(path: &Path) -> Result<Opened, FormatError> {
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
    let known = detect(&name, &head, size)?;
    let (format, sizes) = (known.format, &known.sizes);
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
    Ok(Opened {
        known,
        file,
        head,
        size,
    })
}

/// The bytes of a file of at most so many as its format can have, and that format.
pub(super) fn read(path: &Path) -> Result<(&'static Descriptor, Vec<u8>), FormatError> {
    let opened = open(path)?;
    Ok((opened.known, opened.into_bytes(&path.display().to_string())?))
}

impl Opened {
    /// All bytes of the file, which must not grow meanwhile: what was measured against the format's sizes is what is
    /// read.
    fn into_bytes(self, name: &str) -> Result<Vec<u8>, FormatError> {
        let Self {
            file,
            head: mut bytes,
            size,
            ..
        } = self;
        bytes.reserve_exact(size.saturating_sub(bytes.len() as u64) as usize);
        read_rest(file, size, &mut bytes).map_err(|error| match error.kind() {
            ErrorKind::FileTooLarge => {
                let expected = format!("{size} bytes, the size of the file when it was opened");
                let remedy = "wait until the program that writes the file is done";
                FormatError::file(name, expected, "more", remedy)
            }
            _ => failed(name)(error),
        })?;
        Ok(bytes)
    }
}

/// As [`read`], with the name of the format alone.
pub(crate) fn read_bytes(path: &Path) -> Result<(Format, Vec<u8>), FormatError> {
    read(path).map(|(known, bytes)| (known.format, bytes))
}

fn failed(name: &str) -> impl Fn(std::io::Error) -> FormatError + '_ {
    move |e| {
        let remedy = "check the name and the right to read it";
        FormatError::file(name, "a file that can be read", e.to_string(), remedy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::registry::descriptor;
    use std::io::Seek;

    #[test]
    fn file_that_grows_while_it_is_read_is_refused() {
        let opened = |content: &[u8]| {
            let mut file = tempfile::tempfile().unwrap();
            std::io::Write::write_all(&mut file, content).unwrap();
            file.seek(std::io::SeekFrom::Start(2)).unwrap();
            Opened {
                known: descriptor(Format::MERL),
                file,
                head: b"ab".to_vec(),
                size: 4,
            }
        };
        assert_eq!(opened(b"abcd").into_bytes("file").unwrap(), b"abcd");
        let error = opened(b"abcde").into_bytes("file").unwrap_err().to_string();
        assert!(
            error.contains("expected 4 bytes") && error.contains("found more"),
            "{error}"
        );
    }
}
