use super::trace::print_ledger;
use super::{Failure, Options, Replace, claim};
use specval::artefact;
use specval::run::{self, FileKind, OtherKind};
use std::path::PathBuf;

/// Adds the shards of one study: the same file, bit for bit, as one run of all of it writes. Only reads the shards.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Files of `trace --shard`, in any order; together they hold every batch once.
    #[arg(value_name = "SHARD", required = true)]
    shards: Vec<PathBuf>,
    /// File for the artefact.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    replace: Replace,
}

pub fn run(arguments: &Arguments, options: &Options) -> Result<(), Failure> {
    let Arguments { shards, out, replace } = arguments;
    let (_, terminal) = &claim(&[out], shards, replace, options)?;
    let merging = terminal.progress("adding the shards");
    let artefact = run::merge_shards(shards, &|share| merging.advance(share));
    merging.finish();
    let artefact = artefact.map_err(|error| {
        // Unsound shards, and shards that do not fit each other, keep their own message.
        let due = |kind| kind == FileKind::Artefact(artefact::ArtefactKind::Shard);
        let other = shards
            .iter()
            .find_map(|path| OtherKind::find(path, "a shard of a trace", due));
        other.map_or_else(|| Failure::from(error), Failure::from)
    })?;
    artefact.write(out)?;
    print_ledger(&artefact.energy, None, terminal)
}
