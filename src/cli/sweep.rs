use super::inspect::ChosenComponent;
use super::notice::RunNotice;
use super::report::quicken;
use super::{Failure, Options, Replace, Terminal, help, in_words, inputs_of, recorded_command, stopping, study};
use serde::Serialize;
use specval::fit::{Axis, Design};
use specval::output::{NamedFile, ReportFolder};
use specval::report::{SweepTable, sweep_charts};
use specval::run::{Stage, SweepPlan};
use specval::study::Study;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The model at many points of its parameters: ratios of Table 1, normalisation, misfit against the sample. Writes
/// sweep.csv, a row as soon as its point is done, sweep.json, and graphs over each parameter.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Study file; without it the built-in study.
    #[arg(value_name = "STUDY")]
    study: Option<PathBuf>,
    /// A key of the study and its values: KEY=FROM:TO:COUNT, with :log behind it for equal ratios, KEY=FROM:TO of lhs
    /// and sobol, or KEY=V1,V2,... May be repeated.
    #[arg(long, value_name = "KEY=VALUES", required = true)]
    vary: Vec<Axis>,
    /// How points are chosen: grid (every combination), lhs (Latin hypercube, by the study's seed) or sobol.
    #[arg(long, value_name = "DESIGN", default_value = "grid")]
    design: String,
    /// Number of points of lhs and sobol.
    #[arg(long, value_name = "N")]
    points: Option<usize>,
    /// Folder for the sweep; made if need be.
    #[arg(long, value_name = "DIR", default_value = "sweep")]
    out: PathBuf,
    #[arg(long, help = format!("Measured sample instead of the study's: a built-in name ({}), a folder or a file", help::samples()), value_name = "SAMPLE")]
    measured: Option<String>,
    /// As in `report`: fewer paths and camera rays.
    #[arg(long)]
    quick: bool,
    /// Begin no point after this time, such as 90s, 2min or 1h; one is made in any case.
    #[arg(long, value_name = "TIME", value_parser = stopping::time, allow_hyphen_values = true)]
    max_time: Option<Duration>,
    /// Go on from the rows of sweep.csv of the same sweep. Gives the same bytes as a sweep without a break.
    #[arg(long)]
    resume: bool,
    #[command(flatten)]
    chosen: ChosenComponent,
    #[command(flatten)]
    replace: Replace,
}

#[derive(Debug, thiserror::Error)]
#[error(
    "--out -: expected a folder, as a sweep is several files, found stdout; name a folder, or print the points with --json"
)]
struct NoFolder;

#[derive(Debug, thiserror::Error)]
#[error(
    "{path}: expected the rows of this sweep, found those of another study, sample, seed or design; leave --resume out to begin \
     anew, or name another --out"
)]
struct OtherSweep {
    path: String,
}

/// sweep.json and the result of --json.
#[derive(Serialize)]
struct Document<'a> {
    command: Vec<String>,
    design: &'a str,
    /// Points of the whole design.
    of: usize,
    #[serde(flatten)]
    table: &'a SweepTable,
    study: &'a Study,
}

const CSV: &str = "sweep.csv";

pub fn run(arguments: &Arguments, options: &Options, terminal: &Terminal) -> Result<(), Failure> {
    let start = Instant::now();
    if arguments.out == Path::new("-") {
        return Err(NoFolder.into());
    }
    let mut study = study::load(arguments.study.as_deref(), options)?;
    if let Some(sample) = &arguments.measured {
        study.measured.sample.clone_from(sample);
        study.origin.give("measured.sample", "--measured");
    }
    if arguments.quick {
        quicken(&mut study, options.paths.is_none());
    }
    study::expect_sample(&study.measured.sample)?;
    let design = Design::named(&arguments.design, arguments.points)?;
    let inputs = inputs_of(arguments.study.as_deref(), &study);
    let plan = SweepPlan::new(study, arguments.chosen.into(), arguments.vary.clone(), design)?;
    plan.base().require_colour()?;
    for notice in plan.base().notices() {
        terminal.notice(&notice);
    }
    let mut table = plan.outline().clone();
    let path = arguments.out.join(CSV);
    let mut own = false;
    if arguments.resume {
        match std::fs::read_to_string(&path) {
            Err(_) => terminal.notice(RunNotice::NoState { state: path.clone() }),
            Ok(text) => {
                let points = table.points_of(&text).filter(|points| points.len() <= plan.len());
                table.points = points.ok_or_else(|| OtherSweep { path: in_words(&path) })?;
                own = true;
                terminal.notice(RunNotice::ResumedSweep {
                    path: path.clone(),
                    points: table.points.len(),
                });
            }
        }
    }
    specval::run::check_memory(&plan.base().study, Stage::Views)?;
    let names = SweepTable::file_names(table.keys.len());
    let folder = ReportFolder::prepare(&arguments.out, &names, &inputs, arguments.replace.force || own)?;
    let is_own = |name: &str| names.iter().any(|own| own == name);
    let sweeping = terminal.progress("sweeping");
    sweeping.advance(table.points.len() as f64 / plan.len() as f64);
    let mut rays = None;
    let resumed = table.points.len();
    for number in resumed..plan.len() {
        if number > resumed && arguments.max_time.is_some_and(|most| start.elapsed() >= most) {
            break;
        }
        table.points.push(plan.point(number, &mut rays)?);
        let row = NamedFile {
            name: CSV.into(),
            bytes: table.csv()?,
        };
        folder.write(&[row], is_own)?;
        sweeping.advance(1.0 / plan.len() as f64);
    }
    sweeping.finish();
    let document = Document {
        command: recorded_command(std::env::args_os()),
        design: &arguments.design,
        of: plan.len(),
        table: &table,
        study: &plan.base().study,
    };
    let json = serde_json::to_string_pretty(&document)? + "\n";
    let mut files = vec![
        NamedFile {
            name: CSV.into(),
            bytes: table.csv()?,
        },
        NamedFile {
            name: "sweep.json".into(),
            bytes: json.into_bytes(),
        },
    ];
    files.extend(sweep_charts(&table)?);
    folder.write(&files, is_own)?;
    if table.points.len() < plan.len() {
        terminal.notice(RunNotice::UnfinishedSweep {
            points: table.points.len(),
            of: plan.len(),
        });
    }
    terminal.result(&document, |_| summary(&table, folder.path()))
}

/// The point of the least misfit, absolute and normalised.
fn summary(table: &SweepTable, folder: &Path) -> String {
    let mut text = format!("points       {}\n", table.points.len());
    for (name, misfit) in [
        (
            "absolute",
            (|point| point.misfit_absolute) as fn(&specval::report::SweepPoint) -> f64,
        ),
        ("normalised", |point| point.misfit_normalised),
    ] {
        let finite = table.points.iter().filter(|point| misfit(point).is_finite());
        if let Some(best) = finite.min_by(|a, b| misfit(a).total_cmp(&misfit(b))) {
            let at = std::iter::zip(&table.keys, &best.parameters).map(|(key, value)| format!("{key} = {value}"));
            text += &format!(
                "least misfit {:.3} times the uncertainty, {name}, at {}\n",
                misfit(best),
                at.collect::<Vec<_>>().join(", ")
            );
        }
    }
    let largest = table.points.iter().map(|point| point.relative_se).fold(0.0, f64::max);
    text += &format!(
        "luminance    standard errors up to {:.1} % at any point and geometry\n",
        100.0 * largest
    );
    text + &format!("written to {}\n", in_words(folder))
}
