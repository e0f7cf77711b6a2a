use super::{Failure, Options, Stopping, Terminal, full, state_beside, study};
use serde::Serialize;
use specval::report::{check_writable, effort_line, write_whole};
use specval::run::{Plan, Simulator, StateFile, Watch};
use specval::transport::Estimate;
use std::path::PathBuf;

/// Measures the woven model with the virtual rig: spectral brightness factors, gloss included, not normalised.
///
/// The CSV has the layout of a measured spectral sample, so `report --measured FILE` reads it.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Study file; without it the built-in study.
    #[arg(value_name = "STUDY")]
    study: Option<PathBuf>,
    /// CSV file for the curves; with --full a file of any format that is written.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    full: full::Arguments,
    #[command(flatten)]
    stopping: Stopping,
}

#[derive(Serialize)]
struct Row {
    theta_i_deg: f64,
    theta_v_deg: f64,
    wavelength_nm: f64,
    beta: f64,
    beta_se: f64,
}

pub fn run(arguments: &Arguments, options: &Options, terminal: &Terminal) -> Result<(), Failure> {
    let plan = Plan::new(study::load(arguments.study.as_deref(), options)?)?;
    if arguments.full.full {
        return full::run(&plan, &arguments.out, &arguments.full, options, terminal);
    }
    check_writable(&arguments.out)?;
    let wavelengths = plan.grid.len();
    let stopping = &arguments.stopping;
    let rule = stopping.rule(plan.direct_effort.batches, options);
    let watch = Watch::new(&plan, &plan.geometries(), rule.precision, false)?;
    let simulator = Simulator::new(&plan, plan.geometries())?;
    let state = StateFile::new(state_beside(&arguments.out), "measure", &plan)?;
    let simulation = stopping.simulate(&simulator, watch, &state, &rule, terminal)?;
    let effort = effort_line(&simulation.effort);
    let curves = simulation.curves;
    let mut rows = Vec::with_capacity(curves.geometries.len() * wavelengths);
    for (g, geometry) in curves.geometries.iter().enumerate() {
        for (w, &wavelength_nm) in plan.grid.nm().iter().enumerate() {
            let Estimate { value, se } = curves.estimate(g, w);
            rows.push(Row {
                theta_i_deg: geometry.theta_i_deg,
                theta_v_deg: geometry.theta_v_deg,
                wavelength_nm,
                beta: value,
                beta_se: se,
            });
        }
    }
    let mut text = Vec::new();
    if rule.precision.is_some() || rule.max_time.is_some() {
        // Only what the study does not say by itself; a comment to the reader of samples.
        text.extend(format!("# {effort}\n").into_bytes());
    }
    let mut csv = csv::Writer::from_writer(text);
    for row in &rows {
        csv.serialize(row)?;
    }
    write_whole(&arguments.out, &csv.into_inner()?)?;
    state.remove()?;
    terminal.result(&rows, |rows| {
        format!(
            "{} brightness factors written to {}\n{effort}\n",
            rows.len(),
            arguments.out.display()
        )
    })
}
