use super::{Failure, Options, Terminal, study};
use specval::report::{EnergyRow, check_writable, ledger_ranges, ledger_table};
use specval::run::{self, Plan, Shard, YarnArtefact, YarnTracer};
use std::path::PathBuf;

/// Traces the yarn and keeps the ledger, the BSSRDF and the radiance factor f*, all of it also by path length.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Study file; without it the built-in study.
    #[arg(value_name = "STUDY")]
    study: Option<PathBuf>,
    /// File for the artefact, or for the shard.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Trace only the batches of shard K of N, for `specval merge`.
    #[arg(long, value_name = "K/N")]
    shard: Option<Shard>,
}

pub fn run(arguments: &Arguments, options: &Options, terminal: &Terminal) -> Result<(), Failure> {
    let plan = Plan::new(study::load(arguments.study.as_deref(), options)?)?;
    check_writable(&arguments.out)?;
    let tracer = YarnTracer::new(&plan)?;
    let tracing = terminal.progress("tracing the yarn");
    let energy = match arguments.shard {
        Some(shard) => run::trace_shard(&tracer, shard, &arguments.out, &|share| tracing.advance(share))?,
        None => {
            let sums = run::trace_yarn(&tracer, &|share| tracing.advance(share))?;
            let artefact = YarnArtefact::new(tracer.layout(), sums);
            artefact.write(&arguments.out)?;
            artefact.energy
        }
    };
    tracing.finish();
    print_ledger(&energy, terminal)
}

/// The range of each fraction over wavelengths and directions.
pub fn print_ledger(energy: &[EnergyRow], terminal: &Terminal) -> Result<(), Failure> {
    terminal.result(&ledger_ranges(energy), |_| ledger_table(energy))
}
