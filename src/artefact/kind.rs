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
pub enum Kind {
    /// The result of a whole run.
    Artefact,
    /// The result of a part of a run, to be merged with the others.
    Shard,
    /// The state of an unfinished run.
    State,
}

impl Kind {
    pub(super) const ALL: [Kind; 3] = [Kind::Artefact, Kind::Shard, Kind::State];

    /// Its name in the first line of a file.
    pub(super) fn word(self) -> &'static str {
        match self {
            Kind::Artefact => "artefact",
            Kind::Shard => "shard",
            Kind::State => "state",
        }
    }

    /// What the user does about a file that cannot be used.
    pub(super) fn remedy(self) -> &'static str {
        match self {
            Kind::Artefact => "make the artefact again",
            Kind::Shard => "make the shard again",
            Kind::State => "remove it and start the run from its beginning",
        }
    }

    /// The first line of a file, but for its end.
    pub(super) fn magic(self) -> String {
        format!("specval-{} {FORMAT_VERSION}", self.word())
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Kind::Artefact => "an artefact",
            Kind::Shard => "a shard",
            Kind::State => "the state of a run",
        })
    }
}

impl Kind {
    /// Kind named in a file's first line; `None` for a file that this program did not write.
    pub fn of(path: &Path) -> Option<Self> {
        let mut head = Vec::new();
        let file = File::open(path).ok()?;
        file.take(MAGIC_LIMIT).read_to_end(&mut head).ok()?;
        let begins = |kind: &Kind| head.starts_with(format!("specval-{} ", kind.word()).as_bytes());
        Self::ALL.into_iter().find(begins)
    }
}
