use super::inspect::ChosenComponent;
use super::notice::RunNotice;
use super::{Failure, Options, Replace, Stopping, Terminal, help, in_words, inputs_of, recorded_command, study};
use specval::formats::Scatter;
use specval::output::{EarlierFiles, ReportFolder};
use specval::report::{
    FinishedResult, Notice, Outline, ReportData, file_names, known_names, read_result, render, report_json,
    result_path, summary,
};
use specval::run::{self, FileKind, Request, Simulator, Stage, StateFile, Sweep, Watch};
use specval::sample::Sample;
use specval::shading::DEFAULT_MODELS;
use specval::study::Study;
use std::path::{Path, PathBuf};

/// The preprint's main job: model and classical shading against the measured sample. Writes graphs, table1, curves.csv,
/// energy.csv, report.json and result.json, from which --from draws it again.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Study file; without it the built-in study.
    #[arg(value_name = "STUDY")]
    study: Option<PathBuf>,
    /// Folder for the report; made if need be.
    #[arg(long, value_name = "DIR", default_value = "report")]
    out: PathBuf,
    /// A twentieth of the paths, where --paths does not say how many, and a ninth of the camera rays: seconds instead
    /// of minutes, wider error bands.
    #[arg(long)]
    quick: bool,
    /// Compare the ways to follow light in the cloth, each with the study's effort: approximations.csv and
    /// locality.csv. Minutes.
    #[arg(long)]
    approximations: bool,
    #[arg(long, help = format!("Measured sample instead of the study's: a built-in name ({}), a folder or a file. May \
                                be repeated: further samples are compared at the geometries of the first", help::samples()), value_name = "SAMPLE")]
    measured: Vec<String>,
    /// Draw the report of a finished run again, without tracing: its result.json, or its folder.
    #[arg(long, value_name = "RESULT", conflicts_with_all = ["study", "quick", "approximations", "measured", "scatter", "side", "until", "max_time", "resume"])]
    from: Option<PathBuf>,
    #[command(flatten)]
    chosen: ChosenComponent,
    #[command(flatten)]
    replace: Replace,
    #[command(flatten)]
    stopping: Stopping,
}

#[derive(Debug, thiserror::Error)]
#[error(
    "--out -: expected a folder, as a report is many files, found stdout; name a folder, such as ./-, or print its \
     document with --json"
)]
struct NoFolder;

#[derive(Debug, thiserror::Error)]
#[error("--{option} with --from: a finished result is drawn as it is; leave --{option} out, or run the study again")]
struct Finished {
    option: &'static str,
}

#[derive(Debug, thiserror::Error)]
#[error(
    "--scatter transmission: expected reflection, which is what model and classical shading are of, found \
     transmission; leave --scatter out, or test the transmission by itself with `specval check --sample`"
)]
struct NoTransmission;

pub fn run(arguments: &Arguments, options: &Options, terminal: &Terminal) -> Result<(), Failure> {
    if arguments.out == Path::new("-") {
        return Err(NoFolder.into());
    }
    if let Some(result) = &arguments.from {
        return again(result, arguments, options, terminal);
    }
    let mut study = study::load(arguments.study.as_deref(), options)?;
    if let Some(sample) = arguments.measured.first() {
        study.measured.sample.clone_from(sample);
        study.origin.give("measured.sample", "--measured");
    }
    let mut notices = Vec::new();
    if arguments.quick {
        quicken(&mut study, options.paths.is_none());
        notices.push(Notice::Quick);
    }
    let more = arguments.measured.get(1..).unwrap_or_default();
    let mut inputs = inputs_of(arguments.study.as_deref(), &study);
    inputs.extend(more.iter().flat_map(|sample| run::sample_files(sample)));
    if arguments.chosen.scatter == Some(Scatter::Transmission) {
        return Err(NoTransmission.into());
    }
    let plan = study::plan_with(study, arguments.chosen.into())?;
    let mut samples = Vec::new();
    for sample in more {
        study::expect_sample(sample)?;
        samples.push(Sample::load_chosen(sample, arguments.chosen.into())?);
    }
    if let Some(notice) = plan.work_notice(Stage::Views)? {
        terminal.notice(&notice);
    }
    let (plan, notice) = arguments.stopping.limits.split(plan, Stage::Views)?;
    notices.extend(notice);
    // Wavelengths without colour are refused before the simulation; doubtful ones become notices of the report.
    plan.colour_notices()?;
    let geometries = run::report_geometries(&plan);
    let names = file_names(&Outline {
        incidences: incidences(geometries.iter().map(|geometry| geometry.theta_i_deg)),
        approximations: arguments.approximations,
    });
    if arguments.approximations {
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
    let batches = simulation.effort.batches;
    let sweep = Sweep::trace(&plan, batches, &|share| measuring.advance(share))?;
    let orders = run::light_orders(&plan, batches)?;
    let request = Request {
        classical: DEFAULT_MODELS,
        samples: &samples,
        command: recorded_command(std::env::args_os()),
        notices,
    };
    let mut data = run::report(&plan, &simulation, &sweep, &orders, request)?;
    measuring.finish();
    if arguments.approximations {
        let comparing = terminal.progress("comparing approximations");
        data.approximations = Some(run::approximations(&plan, &|share| comparing.advance(share))?);
        comparing.finish();
    }
    write(&data, &folder, terminal)?;
    state.remove()?;
    show(&data, &folder, options, terminal)
}

/// Draws the report of a finished run.
fn again(result: &Path, arguments: &Arguments, options: &Options, terminal: &Terminal) -> Result<(), Failure> {
    for (option, given) in [("seed", options.seed.is_some()), ("paths", options.paths.is_some())] {
        if given {
            return Err(Finished { option }.into());
        }
    }
    let FinishedResult { data, is_unchanged } = read_result(result).map_err(|error| {
        // A result that is damaged may look like any document.
        study::or_other_kind(
            error,
            &result_path(result),
            "the result of a report",
            |kind| match kind {
                FileKind::Foreign(of) => of.is_json(),
                kind => kind == FileKind::Result,
            },
        )
    })?;
    let names = file_names(&Outline {
        incidences: incidences(data.curves.iter().map(|point| point.theta_i_deg)),
        approximations: data.approximations.is_some(),
    });
    // A result may be drawn into its own folder, where it replaces itself; one that was changed since is the user's.
    let inputs = match is_unchanged {
        true => Vec::new(),
        false => vec![result_path(result)],
    };
    let folder = ReportFolder::prepare(&arguments.out, &names, &inputs, arguments.replace.force)?;
    write(&data, &folder, terminal)?;
    show(&data, &folder, options, terminal)
}

fn write(data: &ReportData, folder: &ReportFolder, terminal: &Terminal) -> Result<(), Failure> {
    let known = known_names();
    let EarlierFiles { removed, left } = folder.write(&render(data)?, |name| known.contains(name))?;
    for name in removed {
        terminal.notice(RunNotice::Removed {
            path: folder.path().join(name),
        });
    }
    for name in left {
        terminal.notice(RunNotice::Left {
            path: folder.path().join(name),
        });
    }
    Ok(())
}

fn show(data: &ReportData, folder: &ReportFolder, options: &Options, terminal: &Terminal) -> Result<(), Failure> {
    if options.json {
        return terminal.print(&report_json(data)?);
    }
    terminal.print(&format!(
        "{}\nwritten to {}\n",
        summary(data).trim_end(),
        in_words(folder.path())
    ))
}

/// Incidences of which there is a graph, at most.
fn incidences(theta_i_deg: impl Iterator<Item = f64>) -> usize {
    let mut incidences: Vec<f64> = theta_i_deg.collect();
    incidences.sort_by(f64::total_cmp);
    incidences.dedup();
    incidences.len()
}

/// A twentieth of the paths, unless the user gave their number, and a ninth of the camera rays.
pub fn quicken(study: &mut Study, fewer_paths: bool) {
    let batches = u64::from(study.trace.batches);
    let trace = &mut study.trace;
    if fewer_paths {
        for paths in [
            &mut trace.paths_bssrdf,
            &mut trace.paths_direct,
            &mut trace.particles,
            &mut trace.particles_volumetric,
        ] {
            *paths = (*paths / 20).max(batches).min(*paths);
        }
    }
    study.rig.pixels_per_side = (study.rig.pixels_per_side / 3).max(4).min(study.rig.pixels_per_side);
}
