use super::kind::{ArtefactKind, FORMAT_VERSION};
use crate::output::OutputError;
use std::io;
use std::path::PathBuf;

/// One setting in which two identities differ.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Names from the outside in, such as `trace.batches` or `rig.incidences_deg.2`.
    pub key: String,
    /// Value in the identity that is compared, as JSON, or `absent`.
    pub here: String,
    /// Value of the other.
    pub there: String,
}

/// Why a file was not written or not accepted.
#[derive(Debug, thiserror::Error)]
pub enum ArtefactError {
    #[error("{}: cannot be read; name a file that is there and that you may read", path.display())]
    NotReadable {
        path: PathBuf,
        #[source]
        cause: io::Error,
    },
    /// A file that was there before is untouched.
    #[error("{}: cannot be written; name a place you may write to, or mend its permissions and free space", path.display())]
    NotWritable {
        path: PathBuf,
        #[source]
        cause: io::Error,
    },
    /// The output has no valid place.
    #[error(transparent)]
    Output(OutputError),
    #[error("{}: expected a file, found a folder or a device; name a file", path.display())]
    NotAFile { path: PathBuf },
    /// It does not begin like a file of this program.
    #[error("{}: expected {expected} of specval, found {found}; name a file that specval wrote", path.display())]
    NotOurs {
        path: PathBuf,
        expected: ArtefactKind,
        /// How it begins.
        found: String,
    },
    #[error("{}: expected {expected}, found {found}; name {expected}", path.display())]
    OtherKind {
        path: PathBuf,
        expected: ArtefactKind,
        found: ArtefactKind,
    },
    #[error(
        "{}: expected {kind} of format version {FORMAT_VERSION}, found version {found}; use the specval that wrote it, \
         or {}",
        path.display(), kind.remedy()
    )]
    OtherVersion {
        path: PathBuf,
        kind: ArtefactKind,
        found: u64,
    },
    /// Cut short, or something was added to it.
    #[error(
        "{}: expected {kind} of {expected} bytes, found {found} bytes; take a whole copy, or {}",
        path.display(), kind.remedy()
    )]
    Size {
        path: PathBuf,
        kind: ArtefactKind,
        expected: u64,
        found: u64,
    },
    #[error("{}: expected {kind} as it was written, found {found}; take a sound copy, or {}", path.display(), kind.remedy())]
    Damaged {
        path: PathBuf,
        kind: ArtefactKind,
        found: String,
    },
    /// Of another study, seed or program version.
    #[error("{}", foreign(path, *kind, differences))]
    Foreign {
        path: PathBuf,
        kind: ArtefactKind,
        differences: Vec<Difference>,
    },
    /// The file is intact but holds another array than the one that is read.
    #[error("{}: array `{array}`: expected {expected}, found {found}; {}", path.display(), kind.remedy())]
    Array {
        path: PathBuf,
        kind: ArtefactKind,
        array: String,
        expected: String,
        found: String,
    },
    /// Values to write do not match the declared arrays. A file that was there before is untouched.
    #[error("{}: not written: expected {expected}, found {found}", path.display())]
    Undeclared {
        path: PathBuf,
        expected: String,
        found: String,
    },
    #[error("the identity of a run: expected {expected}, found {found}")]
    Identity { expected: &'static str, found: String },
}

/// Differences that a message names; it counts the others.
const NAMED: usize = 4;

/// Characters of a value in a message.
const SHOWN: usize = 60;

fn foreign(path: &std::path::Path, kind: ArtefactKind, differences: &[Difference]) -> String {
    let short = |value: &str| match value.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &value[..end]),
        None => value.to_owned(),
    };
    let named: Vec<String> = differences
        .iter()
        .take(NAMED)
        .map(|d| format!("`{}`: expected {}, found {}", d.key, short(&d.here), short(&d.there)))
        .collect();
    let more = match differences.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!("; and {more} more"),
    };
    format!(
        "{}: {kind} of another run: {}{more}; use the study, options and specval that made it, or {}",
        path.display(),
        named.join("; "),
        kind.remedy()
    )
}
