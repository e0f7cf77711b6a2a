use super::{Failure, Options, Replace, Stopping, Terminal, help, in_words, inputs_of, recorded_command, study};
use serde::Serialize;
use specval::compare::Geometry;
use specval::output::{NamedFile, ReportFolder};
use specval::report::{file_names, render, report_json, summary};
use specval::run::{self, Simulator, Stage, StateFile, Watch};
use specval::study::Study;
use std::path::{Path, PathBuf};

/// The preprint's main job: model and classical shading against the measured sample. Writes graphs, table1, curves.csv,
/// energy.csv and report.json.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Study file; without it the built-in study.
    #[arg(value_name = "STUDY")]
    study: Option<PathBuf>,
    /// Folder for the report; made if need be.
    #[arg(long, value_name = "DIR", default_value = "report")]
    out: PathBuf,
    /// A twentieth of the paths and a ninth of the camera rays: seconds instead of minutes, wider error bands.
    #[arg(long)]
    quick: bool,
    /// Compare the ways to follow light in the cloth, each with the study's effort: approximations.csv and locality.csv. Minutes.
    #[arg(long)]
    approximations: bool,
    #[arg(long, help = format!("Measured sample instead of the study's: a built-in name ({}), a folder or a file", help::samples()), value_name = "SAMPLE")]
    measured: Option<String>,
    #[command(flatten)]
    replace: Replace,
    #[command(flatten)]
    stopping: Stopping,
}

/// Tables of --approximations.
const APPROXIMATIONS: [&str; 2] = ["approximations.csv", "locality.csv"];

#[derive(Debug, thiserror::Error)]
#[error(
    "--out -: a report is a folder of files and cannot go to stdout; name a folder, such as ./-, or print its document with --json"
)]
struct NoFolder;

pub fn run(arguments: &Arguments, options: &Options, terminal: &Terminal) -> Result<(), Failure> {
    let mut study = study::load(arguments.study.as_deref(), options)?;
    if let Some(sample) = &arguments.measured {
        study.measured.sample.clone_from(sample);
    }
    let mut notices = Vec::new();
    if arguments.quick {
        quicken(&mut study);
        notices.push("--quick: paths and camera rays are reduced; `study` holds the numbers that were used".into());
    }
    if arguments.out == Path::new("-") {
        return Err(NoFolder.into());
    }
    let inputs = inputs_of(arguments.study.as_deref(), &study);
    let plan = study::plan(study)?;
    if let Some(notice) = plan.work_notice(Stage::Views)? {
        terminal.notice(&notice);
    }
    let (plan, notice) = arguments.stopping.limits.split(plan, Stage::Views)?;
    notices.extend(notice);
    // Refused before the simulation; the report tells what is only doubtful.
    plan.colour_notices()?;
    let geometries = run::report_geometries(&plan);
    let mut names = file_names(incidences(&geometries));
    if arguments.approximations {
        names.extend(APPROXIMATIONS.map(str::to_owned));
        run::check_approximations(&plan.study)?;
    }
    let folder = ReportFolder::prepare(&arguments.out, &names, &inputs, arguments.replace.force)?;
    let stopping = &arguments.stopping;
    let rule = stopping.rule(plan.direct_effort.batches, options);
    let watch = Watch::new(&plan, &geometries, rule.precision, true)?;
    let simulator = Simulator::new(&plan, geometries)?;
    let state = StateFile::new(Some(folder.path().join(ReportFolder::STATE)), "report", &plan)?;
    let simulation = stopping.simulate(&simulator, watch, &state, &rule, terminal)?;
    let measuring = terminal.progress("measuring and sweeping");
    let command = recorded_command(std::env::args_os());
    let data = run::report(&plan, &simulation, command, notices, &|share| measuring.advance(share))?;
    measuring.finish();
    let mut files = render(&data)?;
    if arguments.approximations {
        let comparing = terminal.progress("comparing approximations");
        let rows = run::approximations(&plan, &|share| comparing.advance(share))?;
        comparing.finish();
        files.push(table(APPROXIMATIONS[0], &rows)?);
        files.push(table(APPROXIMATIONS[1], &run::locality(&plan)?)?);
    }
    for name in folder.write(&files)? {
        terminal.notice(&format!(
            "{}: of the earlier report in this folder, removed",
            in_words(folder.path().join(name))
        ));
    }
    state.remove()?;
    if options.json {
        return terminal.print(&report_json(&data)?);
    }
    terminal.print(&format!(
        "{}\nwritten to {}\n",
        summary(&data).trim_end(),
        in_words(folder.path())
    ))
}

fn table<T: Serialize>(name: &str, rows: &[T]) -> Result<NamedFile, Failure> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    for row in rows {
        csv.serialize(row)?;
    }
    Ok(NamedFile {
        name: name.to_owned(),
        bytes: csv.into_inner()?,
    })
}

/// Incidences of which there is a graph, at most.
fn incidences(geometries: &[Geometry]) -> usize {
    let mut incidences: Vec<f64> = geometries.iter().map(|geometry| geometry.theta_i_deg).collect();
    incidences.sort_by(f64::total_cmp);
    incidences.dedup();
    incidences.len()
}

fn quicken(study: &mut Study) {
    let batches = u64::from(study.trace.batches);
    let trace = &mut study.trace;
    for paths in [
        &mut trace.paths_bssrdf,
        &mut trace.paths_direct,
        &mut trace.particles,
        &mut trace.particles_volumetric,
    ] {
        *paths = (*paths / 20).max(batches).min(*paths);
    }
    study.rig.pixels_per_side = (study.rig.pixels_per_side / 3).max(4).min(study.rig.pixels_per_side);
}
