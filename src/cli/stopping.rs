//! Stop rules of long runs, and their resumption after a kill.

use super::notice::RunNotice;
use super::{Failure, Options, Terminal, in_words};
use specval::report::Notice;
use specval::run::{
    self, Plan, Precision, RunError, Schedule, Simulation, Simulator, Stage, StateFile, StopRule, Watch,
};
use std::ffi::OsString;
use std::path::Path;
use std::time::{Duration, Instant};

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "How long")]
pub struct Stopping {
    /// Go on until each standard error is below this: "rel 1%" or "abs 0.001", of the `curves` or, with that word
    /// behind it, of the `ratios` of Table 1. Makes more batches than the study if need be, or with --paths no more
    /// than those.
    #[arg(long, value_name = "PRECISION", allow_hyphen_values = true)]
    pub until: Option<Precision>,
    #[command(flatten)]
    pub limits: Limits,
}

/// Options of every long run, whichever quantity it watches.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "How long")]
pub struct Limits {
    /// Trace no longer than this, such as 90s, 2min or 1h. Where a batch of the study would take more than an eighth of
    /// that on one core, by an estimate from the study alone, there are more and smaller ones, to the same number of
    /// paths. Two batches are made in any case, and one that has begun is finished; the time of a run that is resumed
    /// does not count. The sweep, with paths in proportion to what was traced, and the graphs come on top.
    #[arg(long, value_name = "TIME", value_parser = time, allow_hyphen_values = true)]
    pub max_time: Option<Duration>,
    /// Least time between two savings of the state that --resume goes on from, more where saving would take over 5 % of
    /// the time; 0s saves after each round of batches.
    #[arg(long, value_name = "TIME", value_parser = time, allow_hyphen_values = true, default_value = "5s")]
    pub checkpoint: Duration,
    /// Go on from the state that a killed run of the same command left. Gives the same bytes as a run without a break.
    #[arg(long)]
    pub resume: bool,
}

impl Limits {
    /// The plan with batches small enough for the time allowed, and the notice of them.
    pub fn split(&self, plan: Plan, stage: Stage) -> Result<(Plan, Option<Notice>), RunError> {
        let Some(limit) = self.max_time else {
            return Ok((plan, None));
        };
        let (plan, parts) = plan.split_for(limit, stage)?;
        let batches = plan.study.trace.batches;
        let notice = (parts > 1).then_some(Notice::SmallerBatches { batches, parts });
        Ok((plan, notice))
    }

    pub fn rule(&self, until: Option<Precision>, study_batches: usize, options: &Options) -> StopRule {
        StopRule::new(until, self.max_time, study_batches, options.paths.is_some())
    }

    /// Notice of the number of batches after which a run is resumed.
    pub fn notice_resumed(&self, state: &Path, batches: Option<usize>, terminal: &Terminal) {
        let state = state.to_owned();
        terminal.notice(match batches {
            Some(batches) => RunNotice::Resumed { state, batches },
            None => RunNotice::NoState { state },
        });
    }
}

impl Stopping {
    pub fn rule(&self, study_batches: usize, options: &Options) -> StopRule {
        self.limits.rule(self.until, study_batches, options)
    }

    /// Traces, shades and measures, and keeps the state in a file, which the caller removes when the results are
    /// written.
    pub fn simulate(
        &self,
        simulator: &Simulator,
        watch: Watch,
        state: &StateFile,
        rule: &StopRule,
        terminal: &Terminal,
    ) -> Result<Simulation, Failure> {
        let start = Instant::now();
        let mut resumed = Vec::new();
        if self.limits.resume {
            let found = state.load(simulator)?;
            if let Some(path) = state.path() {
                self.limits.notice_resumed(path, found.as_ref().map(Vec::len), terminal);
            }
            resumed = found.unwrap_or_default();
        }
        let tracing = terminal.progress("tracing and measuring");
        let schedule = Schedule {
            rule,
            round: Simulator::ROUND,
            checkpoint: state.path().map(|_| self.limits.checkpoint),
            clock: &|| start.elapsed(),
            progress: &|share| tracing.advance(share),
        };
        let simulation = run::simulate(simulator, watch, resumed, state, &schedule);
        tracing.finish();
        Ok(simulation?)
    }
}

/// The command, word by word, without the options that change no result: threads, quiet, force, checkpoints, resuming.
pub fn recorded_command(words: impl IntoIterator<Item = OsString>) -> Vec<String> {
    let mut words = words.into_iter().map(in_words);
    let mut recorded = Vec::new();
    while let Some(word) = words.next() {
        match word.as_str() {
            "--resume" | "--quiet" | "--force" => {}
            "--checkpoint" | "--threads" => {
                words.next();
            }
            _ if word.starts_with("--checkpoint=") || word.starts_with("--threads=") => {}
            // Behind it there are no options.
            "--" => {
                recorded.push(word);
                recorded.extend(&mut words);
            }
            _ => recorded.push(word),
        }
    }
    recorded
}

pub fn time(text: &str) -> Result<Duration, String> {
    humantime::parse_duration(text).map_err(|cause| {
        format!("expected a time such as 90s, 2min or \"1h 30min\", found \"{text}\" ({cause}); write number and unit")
    })
}
