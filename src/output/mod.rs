//! Where results go. One rule holds for every output of every command:
//!
//! - `-` is stdout. A device, or a pipe with a name, is written to and never replaced; a block device is refused.
//! - A link is followed: the file it leads to is replaced, the link stays.
//! - A file is written whole or not at all, and so is a set of files ([`write_all`]).
//! - An output that is an input of the run is refused before any work, by whatever links, and so are two outputs that
//!   are one file ([`prepare`]).
//! - A file that exists is refused before any work, unless the user says so with `--force`. A report replaces, and
//!   removes, without it what an earlier report wrote there and nobody changed since ([`ReportFolder`]).
//! - Two runs never share a folder or a state ([`Lock`]).

mod error;
mod file;
mod folder;
mod lock;
mod place;
mod record;

pub use error::OutputError;
pub use file::{Output, make_folder, prepare, remove, write_all, write_whole};
pub use folder::{EarlierFiles, NamedFile, ReportFolder};
pub use lock::{Lock, expect_scratch};
pub use place::{Destination, beside};
