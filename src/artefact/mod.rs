//! Files of large arrays: artefacts, shards of one, and the state a run resumes from.
//!
//! A file is, in this order:
//!
//! 1. the line `specval-artefact 1`, `specval-shard 1` or `specval-state 1`: its [`ArtefactKind`] and the format's
//!    version;
//! 2. one line of JSON: `version` (of the program), `identity` (everything that must be equal for two files to belong
//!    together, see [`Identity`]), `header` (added by the caller), and `arrays`, each with `name`, `unit`, `axes`,
//!    `shape`, `element` (`f64`, `f32` or `u64`), `offset` and `length`, both in bytes, the offset counted from the end
//!    of this line;
//! 3. the arrays, one after the other in that order, little-endian, last axis fastest;
//! 4. the SHA-256 of everything before it, 32 bytes.
//!
//! [`Writer`] writes a file whole or not at all, and [`Reader`] returns no value before it has verified the file's size
//! and checksum. Neither holds more of an array in memory than its caller does.

mod error;
mod identity;
mod kind;
mod layout;
mod reader;
mod writer;

pub use error::{ArtefactError, Difference};
pub use identity::Identity;
pub use kind::ArtefactKind;
pub use layout::{ArrayInfo, Element, ElementType};
pub use reader::Reader;
pub use writer::Writer;

use sha2::{Digest, Sha256};
use std::io;

/// Bytes read or written at a time.
const BUFFER: usize = 1 << 16;

/// Bytes of a SHA-256.
const CHECKSUM: usize = 32;

/// Forwards bytes and updates their checksum.
#[derive(Debug)]
struct Hashed<W> {
    inner: W,
    hash: Sha256,
}

impl<W> Hashed<W> {
    fn new(inner: W) -> Self {
        Self {
            inner,
            hash: Sha256::new(),
        }
    }

    fn finish(self) -> (W, [u8; CHECKSUM]) {
        (self.inner, self.hash.finalize().into())
    }
}

impl<W: io::Write> io::Write for Hashed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.hash.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}
