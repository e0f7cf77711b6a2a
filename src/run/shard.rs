use std::fmt;
use std::ops::Range;
use std::path::PathBuf;
use std::str::FromStr;

/// One of N parts of a study's batches, for as many machines: number K of N, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Shard {
    pub(super) number: u32,
    pub(super) of: u32,
}

/// Why a shard, or a set of shards, is refused.
#[derive(Debug, thiserror::Error)]
pub enum ShardError {
    #[error("expected K/N, shard K of N with K from 1 to N, such as 3/16; found \"{found}\"")]
    Name { found: String },
    #[error(
        "shard {shard}: expected at most {batches} shards, one for each of the study's batches, found {}; make fewer, \
         or raise `trace.batches` for all of them", shard.of
    )]
    TooMany { shard: Shard, batches: usize },
    #[error("no shards; name the files that `specval trace --shard` wrote")]
    None,
    #[error(
        "{} and {}: expected each batch once, found {} in both (shards {} and {}); leave one of the two out",
        paths[0].display(), paths[1].display(), numbers(batches), shards[0], shards[1]
    )]
    Doubled {
        paths: [PathBuf; 2],
        shards: [Shard; 2],
        batches: Range<usize>,
    },
    #[error("expected shards that hold all {of} batches, missing: {}; make and name them too", missing.join(", "))]
    Missing { missing: Vec<String>, of: usize },
}

impl Shard {
    pub fn new(number: u32, of: u32) -> Result<Self, ShardError> {
        if number == 0 || number > of {
            let found = format!("{number}/{of}");
            return Err(ShardError::Name { found });
        }
        Ok(Self { number, of })
    }

    /// Its batches of the study's B: from ⌊(K−1)B/N⌋ up to ⌊KB/N⌋, exclusive. The N shards hold each batch once.
    pub fn batches(&self, of_study: usize) -> Result<Range<usize>, ShardError> {
        if self.of as usize > of_study {
            return Err(ShardError::TooMany {
                shard: *self,
                batches: of_study,
            });
        }
        // Both factors have 32 bits: the study's batches are a u32 too.
        let edge = |number: u32| (u64::from(number) * of_study as u64 / u64::from(self.of)) as usize;
        Ok(edge(self.number - 1)..edge(self.number))
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Shard {
    type Err = ShardError;

    fn from_str(text: &str) -> Result<Self, ShardError> {
        let name = || ShardError::Name { found: text.to_owned() };
        let (number, of) = text.split_once('/').ok_or_else(name)?;
        Self::new(number.parse().map_err(|_| name())?, of.parse().map_err(|_| name())?).map_err(|_| name())
    }
}

/// "batch 3" or "batches 3 to 5", from 0.
pub(super) fn numbers(batches: &Range<usize>) -> String {
    match batches.len() {
        1 => format!("batch {}", batches.start),
        _ => format!("batches {} to {}", batches.start, batches.end - 1),
    }
}
