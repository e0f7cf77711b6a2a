use super::{Failure, Limits, Options, Replace, Scratch, Terminal, claim, inputs_of, study};
use specval::output;
use specval::report::{EnergyRow, effort_line, ledger_notice, ledger_ranges, ledger_table};
use specval::run::{self, Precision, PrecisionError, Schedule, Shard, Stage, Watched, YarnSums, YarnTracer};
use std::path::PathBuf;
use std::time::Instant;

/// Traces the yarn and keeps the ledger, the BSSRDF and the yarn response f*, all of it also by path length.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Study file; without it the built-in study.
    #[arg(value_name = "STUDY")]
    study: Option<PathBuf>,
    /// File for the artefact, or for the shard.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Trace only the batches of shard K of N, for `specval merge`.
    #[arg(long, value_name = "K/N", allow_hyphen_values = true)]
    shard: Option<Shard>,
    /// Go on until the standard error of the ledger's scattered fraction, at every wavelength and incident direction,
    /// is below this: "rel 5%" or "abs 0.001". Makes more batches than the study if need be, or with --paths no more
    /// than those.
    #[arg(long, value_name = "PRECISION", value_parser = scattered, allow_hyphen_values = true, help_heading = "How \
                                                                                                                long")]
    until: Option<Precision>,
    #[command(flatten)]
    replace: Replace,
    #[command(flatten)]
    limits: Limits,
}

/// Options that a shard cannot have.
#[derive(Debug, thiserror::Error)]
#[error(
    "--shard with {option}: expected one of the two, since a shard is always its own part of the study's batches; \
     leave {option} out, or trace without --shard"
)]
struct ShardWith {
    option: &'static str,
}

pub fn run(arguments: &Arguments, options: &Options) -> Result<(), Failure> {
    let study = study::load(arguments.study.as_deref(), options)?;
    let inputs = inputs_of(arguments.study.as_deref(), &study);
    let (_, terminal) = &claim(&[&arguments.out], &inputs, &arguments.replace, options)?;
    let plan = study::plan(study)?;
    for notice in plan.notices_before(Stage::Yarn)? {
        terminal.notice(&notice);
    }
    match arguments.shard {
        Some(shard) => {
            arguments.expect_whole_shard()?;
            let tracer = YarnTracer::new(&plan)?;
            let tracing = terminal.progress("tracing the yarn");
            let energy = run::trace_shard(&tracer, shard, &arguments.out, &|share| tracing.advance(share));
            tracing.finish();
            print_ledger(&energy?, None, terminal)
        }
        None => {
            let (plan, notice) = arguments.limits.split(plan, Stage::Yarn)?;
            if let Some(notice) = notice {
                terminal.notice(&notice);
            }
            let tracer = YarnTracer::new(&plan)?;
            let scratch = Scratch::take(&arguments.out, &inputs, arguments.limits.resume)?;
            arguments.trace(&tracer, scratch, options, terminal)
        }
    }
}

impl Arguments {
    fn trace(
        &self,
        tracer: &YarnTracer,
        scratch: Scratch,
        options: &Options,
        terminal: &Terminal,
    ) -> Result<(), Failure> {
        let start = Instant::now();
        let layout = tracer.layout();
        let limits = &self.limits;
        let mut resumed = None;
        if let Some(state) = scratch.state.as_ref().filter(|_| limits.resume) {
            resumed = YarnSums::load(&layout, state)?;
            limits.notice_resumed(state, resumed.as_ref().map(|sums| sums.ledgers.len()), terminal);
        }
        let tracing = terminal.progress("tracing the yarn");
        let schedule = Schedule {
            rule: &limits.rule(self.until, layout.batches(), options),
            round: YarnTracer::ROUND,
            checkpoint: scratch.state.as_ref().map(|_| limits.checkpoint),
            clock: &|| start.elapsed(),
            progress: &|share| tracing.advance(share),
        };
        let state = scratch.state.as_deref().unwrap_or(&self.out);
        let traced = run::trace_yarn(tracer, resumed, state, &schedule);
        tracing.finish();
        let (artefact, effort) = traced?;
        artefact.write(&self.out)?;
        if let Some(state) = &scratch.state {
            output::remove(state)?;
        }
        let asked = self.until.is_some() || limits.max_time.is_some();
        print_ledger(&artefact.energy, asked.then(|| effort_line(&effort)), terminal)
    }

    fn expect_whole_shard(&self) -> Result<(), ShardWith> {
        let typed = [
            ("--until", self.until.is_some()),
            ("--max-time", self.limits.max_time.is_some()),
            ("--resume", self.limits.resume),
        ];
        match typed.into_iter().find(|(_, typed)| *typed) {
            Some((option, _)) => Err(ShardWith { option }),
            None => Ok(()),
        }
    }
}

/// A precision of the ledger's scattered fractions.
fn scattered(text: &str) -> Result<Precision, PrecisionError> {
    Precision::parse(text, Watched::Scattered, &[])
}

/// The range of each fraction over wavelengths and directions, and behind it, but not in the JSON, a line.
pub fn print_ledger(energy: &[EnergyRow], line: Option<String>, terminal: &Terminal) -> Result<(), Failure> {
    terminal.result(&ledger_ranges(energy), |_| {
        let mut text = ledger_table(energy);
        if let Some(notice) = ledger_notice(energy) {
            text += &format!("notice: {notice}\n");
        }
        if let Some(line) = line {
            text += &line;
            text.push('\n');
        }
        text
    })
}
