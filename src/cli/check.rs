use super::inspect::ChosenComponent;
use super::{Failure, Options, Replace, Terminal, claim, help, inputs_of, study};
use specval::check::{self, Baseline, CheckEffort, Checked, GateVerdict, annotations, junit, table};
use specval::output::write_whole;
use specval::run::{FileKind, Stage, check_memory, sample_files};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Tests the laws of physics on a study, or a measurement by itself. Exit code 0: all hold; 1: one is broken; 2: it
/// cannot be told, or bad input.
///
/// `--paths` is of the shared ledger, for each traced direction; the other gates trace in proportion.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Study file; without it the built-in study.
    #[arg(value_name = "STUDY")]
    study: Option<PathBuf>,
    /// An eighth of the paths, tolerances of what is random 2.8 times as wide.
    #[arg(long)]
    quick: bool,
    #[arg(long, help = format!("Test a measurement instead of a study: a built-in name ({}), a folder or a file. \
                                Tolerances are the study's", help::samples()), value_name = "SAMPLE", conflicts_with_all = ["quick", "against"])]
    sample: Option<String>,
    #[command(flatten)]
    chosen: ChosenComponent,
    /// Compare with an earlier result as well: the document of `check --json`.
    #[arg(long, value_name = "FILE")]
    against: Option<PathBuf>,
    /// Write the gates as a JUnit XML file, too.
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Print annotations for GitHub Actions on stderr.
    #[arg(long)]
    github: bool,
    #[command(flatten)]
    replace: Replace,
}

const BROKEN: u8 = 1;
const UNDECIDED: u8 = 2;

pub fn run(arguments: &Arguments, options: &Options) -> Result<ExitCode, Failure> {
    let study = study::load(arguments.study.as_deref(), options)?;
    let mut inputs = inputs_of(arguments.study.as_deref(), &study);
    inputs.extend(arguments.against.clone());
    inputs.extend(arguments.sample.iter().flat_map(|sample| sample_files(sample)));
    let outputs: Vec<&Path> = arguments.junit.as_deref().into_iter().collect();
    let (places, terminal) = &claim(&outputs, &inputs, &arguments.replace, options)?;
    for notice in specval::run::study_notices(&study) {
        terminal.notice(&notice);
    }
    let checked = match &arguments.sample {
        Some(sample) => {
            // A gate would call a file of another kind a broken measurement.
            study::expect_sample(sample)?;
            check::sample(sample, arguments.chosen.into(), &study.check)?
        }
        None => {
            arguments.chosen.refuse_for("no --sample")?;
            of_study(arguments, options, terminal, study)?
        }
    };
    for place in places {
        write_whole(place, &junit(&checked)?)?;
    }
    if arguments.github {
        // With stderr closed there is no one left to annotate for.
        let _ = std::io::stderr().write_all(annotations(&checked).as_bytes());
    }
    terminal.result(&checked, table)?;
    Ok(match checked.verdict {
        GateVerdict::Holds => ExitCode::SUCCESS,
        GateVerdict::Broken => ExitCode::from(BROKEN),
        GateVerdict::Undecided => ExitCode::from(UNDECIDED),
    })
}

fn of_study(
    arguments: &Arguments,
    options: &Options,
    terminal: &Terminal,
    study: specval::study::Study,
) -> Result<Checked, Failure> {
    let baseline = arguments
        .against
        .as_deref()
        .map(|path: &Path| {
            Baseline::read(path).map_err(|error| {
                let due = |kind| kind == FileKind::Check;
                study::or_other_kind(error, path, "the document of `specval check --json`", due)
            })
        })
        .transpose()?;
    let effort = match options.paths {
        Some(paths) => CheckEffort::of_paths(paths.get())?,
        None if arguments.quick => CheckEffort::quick(),
        None => CheckEffort::standard(),
    };
    let plan = study::plan(study)?;
    check_memory(&plan.study, Stage::Check)?;
    if let Some(notice) = plan.long_paths() {
        terminal.notice(&notice);
    }
    let checking = terminal.progress("checking");
    let checked = check::study(&plan, effort, &|share| checking.advance(share));
    checking.finish();
    let mut checked = checked?;
    if let Some(baseline) = baseline {
        baseline.compare(&mut checked, plan.study.check.false_alarms)?;
    }
    Ok(checked)
}
