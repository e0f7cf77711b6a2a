use super::trace::print_ledger;
use super::{Failure, Terminal};
use specval::report::check_writable;
use specval::run;
use std::fs;
use std::path::{Path, PathBuf};

/// Adds the shards of one study: the same file, bit for bit, as one run of all of it writes. Only reads the shards.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Files of `trace --shard`, in any order; together they hold every batch once.
    #[arg(value_name = "SHARD", required = true)]
    shards: Vec<PathBuf>,
    /// File for the artefact.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

#[derive(Debug, thiserror::Error)]
#[error("--out {}: expected a place for the artefact, found one of the shards, {}; name another place", out.display(), shard.display())]
struct OutIsShard {
    out: PathBuf,
    shard: PathBuf,
}

pub fn run(arguments: &Arguments, terminal: &Terminal) -> Result<(), Failure> {
    let Arguments { shards, out } = arguments;
    if let Some(shard) = shards.iter().find(|shard| is_same(shard, out)) {
        return Err(Box::new(OutIsShard {
            out: out.clone(),
            shard: shard.clone(),
        }));
    }
    check_writable(out)?;
    let merging = terminal.progress("adding the shards");
    let artefact = run::merge_shards(shards, &|share| merging.advance(share));
    merging.finish();
    let artefact = artefact?;
    artefact.write(out)?;
    print_ledger(&artefact.energy, None, terminal)
}

/// Whether both lead to one file, by whatever links.
fn is_same(a: &Path, b: &Path) -> bool {
    match (fs::canonicalize(a), fs::canonicalize(b)) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}
