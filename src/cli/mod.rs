//! What was typed: one file per subcommand, and what all of them share.
//!
//! Exit codes: 0 done, 2 bad input, with the reason on stderr; of `check` 1 for a broken law, 2 also for one it cannot
//! tell; of `compare` 1 where a classical model is better, 2 also where it cannot tell. A reader that closes stdout early is no error.

pub mod bsdf;
pub mod check;
pub mod colour;
pub mod compare;
pub mod convert;
pub mod fit;
mod help;
pub mod init;
pub mod inspect;
pub mod measure;
pub mod medium;
pub mod merge;
mod method;
pub mod mie;
mod notice;
mod numbers;
mod outputs;
pub mod reabsorb;
pub mod report;
mod stopping;
mod study;
pub mod sweep;
mod terminal;
pub mod trace;
pub mod validate;
pub mod weave;

pub use outputs::{Replace, Scratch, claim, in_words, inputs_of};
pub use stopping::{Limits, Stopping, recorded_command};
pub use terminal::{Failure, Terminal, exit};

use clap::{Args, Parser, Subcommand};
use std::ffi::OsString;
use std::num::{NonZeroU64, NonZeroUsize};

/// Tells builds apart: `build.rs`. Files record the version alone.
const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), " (", env!("SPECVAL_BUILD"), ")");

/// Decides whether a physical model of cloth scatters light as a measured sample does.
#[derive(Debug, Parser)]
#[command(name = "specval", version = VERSION)]
pub struct TypedCommand {
    #[command(subcommand)]
    pub command: Command,
    #[command(flatten)]
    pub options: Options,
}

impl TypedCommand {
    /// The command line, and the notice of an old spelling in it: `measure --full` is `bsdf`.
    pub fn typed() -> (Self, Option<notice::RunNotice>) {
        let mut arguments: Vec<OsString> = std::env::args_os().collect();
        let place = |arguments: &[OsString], word: &str| arguments.iter().position(|argument| argument == word);
        let old = place(&arguments, "measure").zip(place(&arguments, "--full"));
        if let Some((command, option)) = old.filter(|(command, option)| command < option) {
            arguments[command] = "bsdf".into();
            arguments.remove(option);
        }
        let notice = old.map(|_| notice::RunNotice::OldCommand);
        (Self::parse_from(arguments), notice)
    }
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Model and classical shading against a measured sample: graphs, Table 1, energy table.
    #[command(long_about = help::of::<report::Arguments>(), after_long_help = help::REPORT)]
    Report(report::Arguments),
    /// Fit a study to a measured sample: parameters with intervals.
    #[command(long_about = help::of::<fit::Arguments>(), after_long_help = help::FIT)]
    Fit(fit::Arguments),
    /// Physical against classical models on measured samples: verdicts in one table. Exit 0 physical, 1 classical, 2 cannot tell.
    #[command(long_about = help::of::<compare::Arguments>(), after_long_help = help::COMPARE)]
    Compare(compare::Arguments),
    /// Write study.toml with every default and what it means.
    #[command(long_about = help::of::<init::Arguments>(), after_long_help = help::init())]
    Init(init::Arguments),
    /// Mie scattering of one sphere: efficiencies and amplitudes.
    #[command(long_about = help::of::<mie::Arguments>(), after_long_help = help::MIE)]
    Mie(mie::Arguments),
    /// Scattering and absorption of the yarn's medium at each wavelength.
    #[command(long_about = help::of::<medium::Arguments>(), after_long_help = help::MEDIUM)]
    Medium(medium::Arguments),
    /// Monte Carlo of the yarn: energy ledger, BSSRDF, yarn response f*.
    #[command(long_about = help::of::<trace::Arguments>(), after_long_help = help::TRACE)]
    Trace(trace::Arguments),
    /// Another dye, kappa or host absorption for a finished trace, without tracing.
    #[command(long_about = help::of::<reabsorb::Arguments>(), after_long_help = help::REABSORB)]
    Reabsorb(reabsorb::Arguments),
    /// Add the shards of a trace: the same file as one run.
    #[command(long_about = help::of::<merge::Arguments>(), after_long_help = help::MERGE)]
    Merge(merge::Arguments),
    /// Brightness factors of the woven model on the virtual rig.
    #[command(long_about = help::of::<measure::Arguments>(), after_long_help = help::MEASURE)]
    Measure(measure::Arguments),
    /// The model over ranges of the study's keys: ratios, normalisation and misfit at each point.
    #[command(long_about = help::of::<sweep::Arguments>(), after_long_help = help::SWEEP)]
    Sweep(sweep::Arguments),
    /// Full BSDF of the woven model, reflection and transmission, as a file for lighting simulation.
    #[command(long_about = help::of::<bsdf::Arguments>(), after_long_help = help::BSDF)]
    Bsdf(bsdf::Arguments),
    /// Laws of physics as gates, on a study or a measurement: exit 0 holds, 1 broken, 2 cannot tell.
    #[command(long_about = help::of::<check::Arguments>(), after_long_help = help::CHECK)]
    Check(check::Arguments),
    /// Reference problems (slabs, cylinders, spheres, yarns): value, reference, z-score.
    #[command(long_about = help::of::<validate::Arguments>(), after_long_help = help::VALIDATE)]
    Validate(validate::Arguments),
    /// Colours of spectra: XYZ, linear RGB and Lab.
    #[command(long_about = help::of::<colour::Arguments>(), after_long_help = help::COLOUR)]
    Colour(colour::Arguments),
    /// What a goniometric file holds.
    #[command(long_about = help::of::<inspect::Arguments>(), after_long_help = help::INSPECT)]
    Inspect(inspect::Arguments),
    /// A goniometric file in another format.
    #[command(long_about = help::of::<convert::Arguments>(), after_long_help = help::CONVERT)]
    Convert(convert::Arguments),
    /// The drawdown of a built-in weave or of a draft.
    #[command(long_about = help::of::<weave::Arguments>(), after_long_help = help::WEAVE)]
    Weave(weave::Arguments),
}

/// Options of every subcommand.
#[derive(Debug, Args)]
#[command(next_help_heading = "Everywhere")]
pub struct Options {
    /// Print one JSON document on stdout instead of text.
    #[arg(long, global = true)]
    pub json: bool,
    /// Seed of the random streams, instead of the study's. The same seed gives the same bits.
    #[arg(long, global = true, value_name = "N", value_parser = numbers::seed, allow_negative_numbers = true)]
    pub seed: Option<u64>,
    /// Threads to work with [default: one a core]. Results do not depend on it.
    #[arg(long, global = true, value_name = "N", value_parser = numbers::threads, allow_negative_numbers = true)]
    pub threads: Option<NonZeroUsize>,
    /// Paths for each incident direction, instead of the study's. With --until they are the most that are traced.
    #[arg(long, global = true, value_name = "N", value_parser = numbers::paths, allow_negative_numbers = true)]
    pub paths: Option<NonZeroU64>,
    /// No progress and no notes on stderr.
    #[arg(long, global = true)]
    pub quiet: bool,
}
