use super::arrays::ArrayEntry;
use super::catalogue::{BatchTables, Part};
use super::layout::{damaged, parse};
use super::state::{ledgers_entry, read_ledgers};
use super::{YarnArtefact, YarnBatch, YarnLayout, YarnSums};
use crate::artefact::{ArrayInfo, ArtefactKind, Reader, Writer};
use crate::run::shard::numbers;
use crate::run::{Progress, RunError, Shard, ShardError};
use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Writes the file of one shard: its batches each by itself, so that a merge can add them as a single run does. Holds
/// one batch at a time.
pub(in crate::run) struct ShardWriter<'a> {
    layout: &'a YarnLayout,
    file: Writer,
}

impl<'a> ShardWriter<'a> {
    pub fn create(path: &Path, layout: &'a YarnLayout, shard: Shard) -> Result<Self, RunError> {
        let batches = shard.batches(layout.batches())?;
        let empty = YarnBatch {
            ledgers: Vec::new(),
            tables: BatchTables::default(),
        };
        let arrays: Vec<ArrayInfo> = batches
            .flat_map(|batch| entries(layout, batch, &empty))
            .map(|entry| entry.info)
            .collect();
        let header = serde_json::json!({ "shard": shard.to_string(), "axes": layout.axes });
        let file = Writer::create(path, ArtefactKind::Shard, &layout.identity()?, &header, &arrays)?;
        Ok(Self { layout, file })
    }

    /// Writes the next batch, of this number.
    pub fn append(&mut self, number: usize, batch: &YarnBatch) -> Result<(), RunError> {
        for entry in entries(self.layout, number, batch) {
            entry.append(&mut self.file)?;
        }
        Ok(())
    }

    pub fn finish(self) -> Result<(), RunError> {
        Ok(self.file.finish()?)
    }
}

/// The arrays of one batch.
fn entries<'a>(layout: &YarnLayout, number: usize, batch: &'a YarnBatch) -> Vec<ArrayEntry<'a>> {
    let mut entries = vec![ledgers_entry(layout, number, &batch.ledgers)];
    entries.extend(batch.tables.entries(layout, Part::Batch(number)));
    entries
}

fn read_batch(file: &mut Reader, layout: &YarnLayout, number: usize) -> Result<YarnBatch, RunError> {
    Ok(YarnBatch {
        ledgers: read_ledgers(file, layout, number)?,
        tables: BatchTables::read(file, layout, Part::Batch(number), true)?,
    })
}

/// A shard's file, verified.
struct ShardFile {
    path: PathBuf,
    shard: Shard,
    batches: Range<usize>,
    file: Reader,
}

/// Merges shards, in any order, to the bits that a single run would have written. Verifies each file first and then
/// reads its batches one by one; never writes to them.
pub fn merge_shards(paths: &[PathBuf], progress: Progress) -> Result<YarnArtefact, RunError> {
    let mut layout: Option<YarnLayout> = None;
    let mut shards = Vec::with_capacity(paths.len());
    let step = 0.5 / paths.len() as f64;
    for path in paths {
        let file = Reader::open(path, ArtefactKind::Shard)?;
        let read = match &layout {
            Some(layout) => {
                file.expect(&layout.identity()?)?;
                YarnLayout::read(path, ArtefactKind::Shard, &file)?
            }
            None => layout
                .insert(YarnLayout::read(path, ArtefactKind::Shard, &file)?)
                .clone(),
        };
        if Some(&read) != layout.as_ref() {
            return Err(damaged(
                path,
                ArtefactKind::Shard,
                "other axes than its study has".into(),
            ));
        }
        let name: String = parse(path, ArtefactKind::Shard, "header.shard", &file.header()["shard"])?;
        let shard: Shard = name
            .parse()
            .map_err(|e: ShardError| damaged(path, ArtefactKind::Shard, e.to_string()))?;
        shards.push(ShardFile {
            path: path.clone(),
            batches: shard.batches(read.batches())?,
            shard,
            file,
        });
        progress(step);
    }
    let layout = layout.ok_or(ShardError::None)?;
    shards.sort_by_key(|shard| (shard.batches.start, shard.batches.end));
    check_set(&shards, layout.batches())?;
    let mut sums = YarnSums::new(&layout);
    for shard in &mut shards {
        for batch in shard.batches.clone() {
            sums.add(read_batch(&mut shard.file, &layout, batch)?);
        }
        progress(step);
    }
    Ok(YarnArtefact::new(layout, sums))
}

/// Checks that shards, sorted by their first batch, hold each of the study's batches once.
fn check_set(shards: &[ShardFile], batches: usize) -> Result<(), ShardError> {
    for pair in shards.windows(2) {
        let [a, b] = pair else { continue };
        if b.batches.start < a.batches.end {
            return Err(ShardError::Doubled {
                paths: [a.path.clone(), b.path.clone()],
                shards: [a.shard, b.shard],
                batches: b.batches.start..a.batches.end.min(b.batches.end),
            });
        }
    }
    let starts = shards.iter().map(|shard| shard.batches.start).chain([batches]);
    let ends = [0].into_iter().chain(shards.iter().map(|shard| shard.batches.end));
    let gaps: Vec<Range<usize>> = std::iter::zip(ends, starts)
        .filter(|(end, start)| end < start)
        .map(|(end, start)| end..start)
        .collect();
    if gaps.is_empty() {
        return Ok(());
    }
    let counts: BTreeSet<u32> = shards.iter().map(|shard| shard.shard.of).collect();
    let missing = gaps
        .iter()
        .map(|gap| {
            let shards = counts.iter().find_map(|&of| shards_of(gap, of, batches));
            match shards {
                Some(shards) => format!("{shards} ({})", numbers(gap)),
                None => numbers(gap),
            }
        })
        .collect();
    Err(ShardError::Missing { missing, of: batches })
}

/// The shards of N that hold exactly these batches, in words; `None` where no whole shards do.
fn shards_of(gap: &Range<usize>, of: u32, batches: usize) -> Option<String> {
    let within: Vec<(Shard, Range<usize>)> = (1..=of)
        .filter_map(|number| {
            let shard = Shard { number, of };
            let here = shard.batches(batches).ok()?;
            (here.start >= gap.start && here.end <= gap.end).then_some((shard, here))
        })
        .collect();
    let (first, last) = (within.first()?, within.last()?);
    if first.1.start != gap.start || last.1.end != gap.end {
        return None;
    }
    Some(match within.len() {
        1 => format!("shard {}", first.0),
        _ => format!("shards {} to {}", first.0, last.0),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_hold_each_batch_once() {
        for batches in [1, 2, 7, 16, 100_000] {
            for of in [1, 2, 3, 7, 16].into_iter().filter(|&of| of as usize <= batches) {
                let mut end = 0;
                for number in 1..=of {
                    let here = Shard::new(number, of).unwrap().batches(batches).unwrap();
                    assert!(
                        here.start == end && !here.is_empty(),
                        "{number}/{of} of {batches}: {here:?}"
                    );
                    end = here.end;
                }
                assert_eq!(end, batches);
            }
        }
        assert_eq!("2/3".parse::<Shard>().unwrap().batches(16).unwrap(), 5..10);
        assert!("4/17".parse::<Shard>().unwrap().batches(16).is_err());
    }

    #[test]
    fn malformed_shard_names_are_refused() {
        for wrong in [
            "",
            "3",
            "0/3",
            "4/3",
            "1/0",
            "-1/3",
            "1/3/5",
            "a/b",
            "1.5/3",
            "1/99999999999",
        ] {
            let error = wrong.parse::<Shard>().unwrap_err().to_string();
            assert!(
                error.contains(&format!("{wrong:?}")) && error.contains("K/N"),
                "{error}"
            );
        }
    }

    #[test]
    fn gaps_that_are_whole_shards_are_named_as_shards() {
        assert_eq!(shards_of(&(5..10), 3, 16).unwrap(), "shard 2/3");
        assert_eq!(shards_of(&(0..10), 3, 16).unwrap(), "shards 1/3 to 2/3");
        assert_eq!(shards_of(&(5..11), 3, 16), None);
    }
}
