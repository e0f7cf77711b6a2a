//! Files in, read up to a size that their kind can have.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Bytes of the largest text that is read: studies, samples and documents, a thousand times the usual.
pub const MOST_TEXT: u64 = 256 << 20;

/// The bytes of a file, or of a device or pipe until it ends.
///
/// # Errors
/// What cannot be read, and what does not end after `most` bytes.
pub fn read_file(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let file = File::open(path)?;
    let there = file.metadata()?;
    if there.is_file() && there.len() > most {
        return Err(too_large(format!(
            "{} bytes, more than the {most} that it may have",
            there.len()
        )));
    }
    read_all(file, most)
}

fn too_large(found: String) -> io::Error {
    io::Error::new(io::ErrorKind::FileTooLarge, found)
}

/// The same of what is open already.
///
/// # Errors
/// As [`read_file`].
pub fn read_all(input: impl Read, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    read_rest(input, most, &mut bytes)?;
    Ok(bytes)
}

/// As [`read_all`], behind bytes that were read before and count towards `most`.
///
/// # Errors
/// As [`read_file`].
pub fn read_rest(input: impl Read, most: u64, bytes: &mut Vec<u8>) -> io::Result<()> {
    let rest = most.saturating_sub(bytes.len() as u64);
    input.take(rest.saturating_add(1)).read_to_end(bytes)?;
    match bytes.len() as u64 > most {
        true => Err(too_large(format!("more than {most} bytes, as many as it may have"))),
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_end_is_refused_and_what_fits_is_whole() {
        assert_eq!(read_all(&b"abc"[..], 3).unwrap(), b"abc");
        for input in [&b"abcd"[..], &[0; 100]] {
            let error = read_all(input, 3).unwrap_err().to_string();
            assert!(error.contains("more than 3 bytes"), "{error}");
        }
        assert!(read_all(io::repeat(0), 1 << 20).is_err());
    }
}
