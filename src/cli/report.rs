use super::{Failure, Options, Stopping, Terminal, recorded_command, study};
use serde::Serialize;
use specval::report::{NamedFile, OutputFolder, render, report_json, summary};
use specval::run::{self, Plan, Simulator, StateFile, Watch};
use specval::study::Study;
use std::path::PathBuf;

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
    /// Measured sample instead of the study's: a built-in name, a folder or a CSV file.
    #[arg(long, value_name = "SAMPLE")]
    measured: Option<String>,
    #[command(flatten)]
    stopping: Stopping,
}

/// File in the report's folder that an interrupted run goes on from.
const STATE: &str = "specval.state";

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
    let plan = Plan::new(study)?;
    // Refused before the simulation; the report tells what is only doubtful.
    plan.colour_notices()?;
    let folder = OutputFolder::prepare(&arguments.out)?;
    let geometries = run::report_geometries(&plan);
    let stopping = &arguments.stopping;
    let rule = stopping.rule(plan.direct_effort.batches, options);
    let watch = Watch::new(&plan, &geometries, rule.precision, true)?;
    let simulator = Simulator::new(&plan, geometries)?;
    let state = StateFile::new(folder.path().join(STATE), "report", &plan)?;
    let simulation = stopping.simulate(&simulator, watch, &state, &rule, terminal)?;
    let measuring = terminal.progress("measuring and sweeping");
    let command = recorded_command(std::env::args());
    let data = run::report(&plan, &simulation, command, notices, &|share| measuring.advance(share))?;
    measuring.finish();
    let mut files = render(&data)?;
    if arguments.approximations {
        let comparing = terminal.progress("comparing approximations");
        let rows = run::approximations(&plan, &|share| comparing.advance(share))?;
        comparing.finish();
        files.push(table("approximations.csv", &rows)?);
        files.push(table("locality.csv", &run::locality(&plan)?)?);
    }
    folder.write(&files)?;
    state.remove()?;
    if options.json {
        return terminal.print(&report_json(&data)?);
    }
    terminal.print(&format!(
        "{}\nwritten to {}\n",
        summary(&data).trim_end(),
        folder.path().display()
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
