use super::{Failure, Options, Terminal, study};
use specval::report::{check_writable, ledger_ranges, ledger_table};
use specval::run::{self, Plan, YarnArtefact, YarnTracer};
use std::path::PathBuf;

/// Traces the yarn and keeps the ledger, the BSSRDF and the radiance factor f*.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Study file; without it the built-in study.
    #[arg(value_name = "STUDY")]
    study: Option<PathBuf>,
    /// File for the artefact.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

pub fn run(arguments: &Arguments, options: &Options, terminal: &Terminal) -> Result<(), Failure> {
    let plan = Plan::new(study::load(arguments.study.as_deref(), options)?)?;
    check_writable(&arguments.out)?;
    let tracing = terminal.progress("tracing the yarn");
    let tracer = YarnTracer::new(&plan)?;
    let sums = run::trace_yarn(&tracer, &|share| tracing.advance(share));
    tracing.finish();
    let artefact = YarnArtefact::new(tracer.layout(), sums?);
    artefact.write(&arguments.out)?;
    print_ledger(&artefact, terminal)
}

/// The range of each fraction over wavelengths and directions.
pub fn print_ledger(artefact: &YarnArtefact, terminal: &Terminal) -> Result<(), Failure> {
    terminal.result(&ledger_ranges(&artefact.energy), |_| ledger_table(&artefact.energy))
}
