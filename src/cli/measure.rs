use super::stopping::beside;
use super::{Failure, Options, Stopping, Terminal, full, state_beside, study};
use serde::Serialize;
use specval::report::{check_writable, effort_line, write_whole};
use specval::run::{Plan, Simulator, StateFile, Watch};
use specval::study::MethodChoice;
use specval::transport::Estimate;
use specval::woven::ClothLedger;
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
    /// How light in the cloth is simulated, instead of the study's `[cloth] method`; with --full volumetric unless said here.
    #[arg(long, value_enum, value_name = "METHOD")]
    method: Option<Method>,
    #[command(flatten)]
    full: full::Arguments,
    #[command(flatten)]
    stopping: Stopping,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Method {
    /// Yarns scatter by their f*; `[cloth] bounces` says how often light goes on.
    RadianceFactor,
    /// Traced through the medium of every yarn that light meets.
    Volumetric,
}

/// Where the light of one incidence and wavelength went.
#[derive(Serialize)]
struct EnergyRow {
    theta_i_deg: f64,
    wavelength_nm: f64,
    reflected: f64,
    reflected_se: f64,
    through_yarns: f64,
    through_yarns_se: f64,
    through_gaps: f64,
    through_gaps_se: f64,
    absorbed: f64,
    absorbed_se: f64,
    reflection_dropped: f64,
    reflection_dropped_se: f64,
    bounces_cut: f64,
    bounces_cut_se: f64,
    games: f64,
    games_se: f64,
    residual: f64,
    residual_se: f64,
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
    let mut study = study::load(arguments.study.as_deref(), options)?;
    match arguments.method {
        Some(Method::RadianceFactor) => study.cloth.method = MethodChoice::RadianceFactor,
        Some(Method::Volumetric) => study.cloth.method = MethodChoice::Volumetric,
        None => {}
    }
    let plan = Plan::new(study)?;
    if arguments.full.full {
        // The study's method is that of curves; a full BSDF is the ground truth unless asked otherwise.
        let method = match arguments.method {
            Some(Method::RadianceFactor) => MethodChoice::RadianceFactor,
            Some(Method::Volumetric) | None => MethodChoice::Volumetric,
        };
        return full::run(&plan, method, &arguments.out, &arguments.full, options, terminal);
    }
    check_writable(&arguments.out)?;
    let energy_file = beside(&arguments.out, ".energy.csv");
    check_writable(&energy_file)?;
    let wavelengths = plan.grid.len();
    let stopping = &arguments.stopping;
    let rule = stopping.rule(plan.direct_effort.batches, options);
    let watch = Watch::new(&plan, &plan.geometries(), rule.precision, false)?;
    let simulator = Simulator::new(&plan, plan.geometries())?;
    let state = StateFile::new(state_beside(&arguments.out), "measure", &plan)?;
    let simulation = stopping.simulate(&simulator, watch, &state, &rule, terminal)?;
    let effort = effort_line(&simulation.effort);
    let energy = energy_rows(&plan, &simulator.incidences_deg(), &simulation.cloth);
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
    let mut also = String::new();
    if !energy.is_empty() {
        let mut csv = csv::Writer::from_writer(Vec::new());
        for row in &energy {
            csv.serialize(row)?;
        }
        write_whole(&energy_file, &csv.into_inner()?)?;
        also = format!(", where the light went to {}", energy_file.display());
    }
    state.remove()?;
    terminal.result(&rows, |rows| {
        format!(
            "{} brightness factors written to {}{also}\n{effort}\n",
            rows.len(),
            arguments.out.display()
        )
    })
}

/// `cloth` is [batch][incidence × wavelength]; empty where light was not followed from yarn to yarn.
fn energy_rows(plan: &Plan, incidences_deg: &[f64], cloth: &[Vec<ClothLedger>]) -> Vec<EnergyRow> {
    let nm = plan.grid.nm();
    let cells = cloth.first().map_or(0, Vec::len);
    let row = |i: usize| {
        let estimate = |of: fn(&ClothLedger) -> f64| Estimate::from_batches(cloth.iter().map(|batch| of(&batch[i])));
        let [
            reflected,
            through_yarns,
            through_gaps,
            absorbed,
            dropped,
            cut,
            games,
            residual,
        ] = [
            estimate(|ledger| ledger.reflected),
            estimate(|ledger| ledger.through_yarns),
            estimate(|ledger| ledger.through_gaps),
            estimate(|ledger| ledger.absorbed),
            estimate(|ledger| ledger.reflection_dropped),
            estimate(|ledger| ledger.bounces_cut),
            estimate(|ledger| ledger.games),
            estimate(ClothLedger::residual),
        ];
        EnergyRow {
            theta_i_deg: incidences_deg[i / nm.len()],
            wavelength_nm: nm[i % nm.len()],
            reflected: reflected.value,
            reflected_se: reflected.se,
            through_yarns: through_yarns.value,
            through_yarns_se: through_yarns.se,
            through_gaps: through_gaps.value,
            through_gaps_se: through_gaps.se,
            absorbed: absorbed.value,
            absorbed_se: absorbed.se,
            reflection_dropped: dropped.value,
            reflection_dropped_se: dropped.se,
            bounces_cut: cut.value,
            bounces_cut_se: cut.se,
            games: games.value,
            games_se: games.se,
            residual: residual.value,
            residual_se: residual.se,
        }
    };
    (0..cells).map(row).collect()
}
