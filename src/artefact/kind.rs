use std::fmt;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Version of the format this program writes, and the only one it reads.
pub(super) const FORMAT_VERSION: u64 = 1;

/// Bytes within which the first line must end.
pub(super) const MAGIC_LIMIT: u64 = 64;

/// What a file is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArtefactKind {
    /// The result of a whole run.
    Artefact,
    /// The result of a part of a run, to be merged with the others.
    Shard,
    /// The state of an unfinished run.
    State,
}

impl ArtefactKind {
    pub(super) const ALL: [ArtefactKind; 3] = [ArtefactKind::Artefact, ArtefactKind::Shard, ArtefactKind::State];

    /// Its name in the first line of a file.
    pub(super) fn word(self) -> &'static str {
        match self {
            ArtefactKind::Artefact => "artefact",
            ArtefactKind::Shard => "shard",
            ArtefactKind::State => "state",
        }
    }

    /// What the user does about a file that cannot be used.
    pub(super) fn remedy(self) -> &'static str {
        match self {
            ArtefactKind::Artefact => "make the artefact again",
            ArtefactKind::Shard => "make the shard again",
            ArtefactKind::State => "remove it and start the run from its beginning",
        }
    }

    /// The first line of a file, but for its end.
    pub(super) fn magic(self) -> String {
        format!("specval-{} {FORMAT_VERSION}", self.word())
    }
}

impl fmt::Display for ArtefactKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            ArtefactKind::Artefact => "an artefact",
            ArtefactKind::Shard => "a shard",
            ArtefactKind::State => "the state of a run",
        })
    }
}

impl ArtefactKind {
    /// Kind named in a file's first line; `None` for a file that this program did not write.
    pub fn of(path: &Path) -> Option<Self> {
        let mut head = Vec::new();
        let file = File::open(path).ok()?;
        file.take(MAGIC_LIMIT).read_to_end(&mut head).ok()?;
        let begins = |kind: &ArtefactKind| head.starts_with(format!("specval-{} ", kind.word()).as_bytes());
        Self::ALL.into_iter().find(begins)
    }
}
