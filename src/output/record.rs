use super::OutputError;
use super::error::not_writable;
use sha2::{Digest, Sha256};
use std::fs;
use std::path::Path;

/// Which files of a folder a report wrote, and their digests: known again by both, a file is this program's own.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct WrittenRecord(Vec<RecordEntry>);

#[derive(Clone, Debug, PartialEq, Eq)]
struct RecordEntry {
    /// SHA-256, lower-case hexadecimal.
    sha256: String,
    name: String,
}

/// Its first line; `sha256sum --check` passes over it.
const HEAD: &str =
    "# files of a specval report; a later report into this folder replaces or removes those that are unchanged";

impl WrittenRecord {
    pub(super) const NAME: &str = "report.sha256";

    /// The record of a folder, empty where there is none. A file of that name with another first line is no record.
    pub(super) fn read(folder: &Path) -> Self {
        let Ok(text) = fs::read_to_string(folder.join(Self::NAME)) else {
            return Self::default();
        };
        let mut lines = text.lines();
        if lines.next() != Some(HEAD) {
            return Self::default();
        }
        let entry = |line: &str| {
            let (sha256, name) = line.split_once("  ")?;
            // A name, and no path to somewhere else.
            let plain = Path::new(name).file_name().is_some_and(|own| own == name);
            plain.then(|| RecordEntry {
                sha256: sha256.to_owned(),
                name: name.to_owned(),
            })
        };
        Self(lines.filter_map(entry).collect())
    }

    pub(super) fn of<'a>(files: impl IntoIterator<Item = (&'a str, &'a [u8])>) -> Self {
        let entry = |(name, bytes): (&str, &[u8])| RecordEntry {
            sha256: digest(bytes),
            name: name.to_owned(),
        };
        Self(files.into_iter().map(entry).collect())
    }

    /// What either holds: what is known while files are replaced one by one.
    pub(super) fn and(&self, other: &Self) -> Self {
        Self(self.0.iter().chain(&other.0).cloned().collect())
    }

    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|entry| entry.name.as_str())
    }

    /// Whether the file of this name is in the folder as it was written, and no link.
    pub(super) fn owns(&self, folder: &Path, name: &str) -> bool {
        let path = folder.join(name);
        if name == Self::NAME {
            return !self.0.is_empty() && !path.is_symlink();
        }
        let mut entries = self.0.iter().filter(|entry| entry.name == name).peekable();
        if entries.peek().is_none() || !path.symlink_metadata().is_ok_and(|there| there.is_file()) {
            return false;
        }
        let found = fs::read(&path).map(|bytes| digest(&bytes));
        found.is_ok_and(|found| entries.any(|entry| entry.sha256 == found))
    }

    pub(super) fn bytes(&self) -> Vec<u8> {
        let mut text = format!("{HEAD}\n");
        for RecordEntry { sha256, name } in &self.0 {
            text += &format!("{sha256}  {name}\n");
        }
        text.into_bytes()
    }

    /// Removes the files of an earlier record that are unchanged and of which this one says nothing; returns their
    /// names.
    pub(super) fn remove_others(&self, earlier: &Self, folder: &Path) -> Result<Vec<String>, OutputError> {
        let mut removed = Vec::new();
        for name in earlier.names() {
            if !self.names().any(|kept| kept == name) && earlier.owns(folder, name) {
                let path = folder.join(name);
                fs::remove_file(&path).map_err(not_writable(&path))?;
                removed.push(name.to_owned());
            }
        }
        Ok(removed)
    }
}

fn digest(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
