use super::{Failure, Options, Terminal, study};
use serde::Serialize;
use specval::report::{check_writable, write_whole};
use specval::run::{self, Plan};
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
    /// CSV file for the curves.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
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
    check_writable(&arguments.out)?;
    let wavelengths = plan.grid.len();
    let tracing = terminal.progress("tracing and measuring");
    let simulation = run::simulate(&plan, plan.geometries(), &|share| tracing.advance(share))?;
    tracing.finish();
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
    let mut csv = csv::Writer::from_writer(Vec::new());
    for row in &rows {
        csv.serialize(row)?;
    }
    write_whole(&arguments.out, &csv.into_inner()?)?;
    terminal.result(&rows, |rows| {
        format!(
            "{} brightness factors written to {}\n",
            rows.len(),
            arguments.out.display()
        )
    })
}
