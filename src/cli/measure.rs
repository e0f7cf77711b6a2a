use super::method::Method;
use super::{Failure, Options, Replace, Scratch, Stopping, claim, in_words, inputs_of, study};
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};
use specval::cloth::light::{ClothFraction, ClothLedger};
use specval::output::{self, Destination, beside, write_all};
use specval::report::{GrazingGain, effort_line};
use specval::run::{RunError, Simulator, Stage, StateFile, Watch, check_memory, grazing_gains, grazing_notice};
use specval::transport::{Estimate, FractionList};
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
    /// How light in the cloth is simulated, instead of the study's `[cloth] method`.
    #[arg(long, value_enum, value_name = "METHOD")]
    method: Option<Method>,
    #[command(flatten)]
    replace: Replace,
    #[command(flatten)]
    stopping: Stopping,
}

/// Where the light of one incidence and wavelength went: every fraction, then the residual.
struct EnergyRow {
    theta_i_deg: f64,
    wavelength_nm: f64,
    mean: ClothLedger,
    se: ClothLedger,
    residual: Estimate,
}

impl Serialize for EnergyRow {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut row = serializer.serialize_struct("EnergyRow", 4 + 2 * ClothFraction::COUNT)?;
        row.serialize_field("theta_i_deg", &self.theta_i_deg)?;
        row.serialize_field("wavelength_nm", &self.wavelength_nm)?;
        for &fraction in ClothFraction::ALL {
            row.serialize_field(fraction.name(), &self.mean[fraction])?;
            row.serialize_field(fraction.se_name(), &self.se[fraction])?;
        }
        row.serialize_field("residual", &self.residual.value)?;
        row.serialize_field("residual_se", &self.residual.se)?;
        row.end()
    }
}

#[derive(Serialize)]
struct Row {
    theta_i_deg: f64,
    theta_v_deg: f64,
    wavelength_nm: f64,
    beta: f64,
    beta_se: f64,
}

/// The result as JSON.
#[derive(Serialize)]
struct Measured {
    brightness_factors: Vec<Row>,
    /// Incidences at which shading with f* gains energy.
    grazing_gains: Vec<GrazingGain>,
    notices: Vec<String>,
}

pub fn run(arguments: &Arguments, options: &Options) -> Result<(), Failure> {
    let study = Method::study(arguments.method, arguments.study.as_deref(), options)?;
    let inputs = inputs_of(arguments.study.as_deref(), &study);
    let out = arguments.out.as_path();
    let is_file = Destination::find(out)?.is_file();
    let energy_file = beside(out, ".energy.csv");
    let mut outputs = vec![out];
    if is_file {
        outputs.push(&energy_file);
    }
    let (places, terminal) = &claim(&outputs, &inputs, &arguments.replace, options)?;
    let (plan, split) = arguments.stopping.limits.split(study::plan(study)?, Stage::Views)?;
    let mut notices = plan.notices_before(Stage::Views)?;
    notices.extend(split);
    // The search for gains itself holds a table of f* on each thread.
    check_memory(&plan.study, Stage::Views)?;
    let grazing_gains = grazing_gains(&plan).map_err(RunError::from)?;
    notices.extend(grazing_notice(&grazing_gains));
    for notice in &notices {
        terminal.notice(notice);
    }
    let scratch = Scratch::take(out, &inputs, arguments.stopping.limits.resume)?;
    let wavelengths = plan.grid.len();
    let stopping = &arguments.stopping;
    let rule = stopping.rule(plan.direct_effort.batches, options);
    let watch = Watch::new(&plan, &plan.geometries(), rule.precision, false)?;
    let simulator = Simulator::new(&plan, plan.geometries())?;
    let state = StateFile::new(scratch.state.clone(), "measure", &plan)?;
    let simulation = stopping.simulate(&simulator, watch, &state, &rule, terminal)?;
    let effort = effort_line(&simulation.effort);
    let energy = energy_rows(plan.grid.nm(), &simulator.incidences_deg(), &simulation.cloth);
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
    for notice in &notices {
        text.extend(format!("# {notice}\n").into_bytes());
    }
    let mut csv = csv::Writer::from_writer(text);
    for row in &rows {
        csv.serialize(row)?;
    }
    let curves_csv = csv.into_inner()?;
    let mut csv = csv::Writer::from_writer(Vec::new());
    for row in &energy {
        csv.serialize(row)?;
    }
    let energy_csv = csv.into_inner()?;
    let mut set = vec![(&places[0], curves_csv.as_slice())];
    let mut also = String::new();
    match places.get(1) {
        Some(place) if !energy.is_empty() => {
            set.push((place, &energy_csv));
            also = format!(", where the light went to {}", in_words(&energy_file));
        }
        _ => {}
    }
    write_all(&set)?;
    if places.len() > set.len() {
        // That of an earlier run, of which --force said that it may go.
        output::remove(&energy_file)?;
    }
    state.remove()?;
    let measured = Measured {
        brightness_factors: rows,
        grazing_gains,
        notices: notices.iter().map(ToString::to_string).collect(),
    };
    terminal.result(&measured, |measured| {
        format!(
            "{} brightness factors written to {}{also}\n{effort}\n",
            measured.brightness_factors.len(),
            in_words(out)
        )
    })
}

/// `cloth` is [batch][incidence × wavelength]; empty where light was not followed from yarn to yarn.
fn energy_rows(nm: &[f64], incidences_deg: &[f64], cloth: &[Vec<ClothLedger>]) -> Vec<EnergyRow> {
    let cells = cloth.first().map_or(0, Vec::len);
    let row = |i: usize| {
        let batches: Vec<ClothLedger> = cloth.iter().map(|batch| batch[i]).collect();
        let [mean, se] = ClothLedger::mean_and_se(&batches);
        EnergyRow {
            theta_i_deg: incidences_deg[i / nm.len()],
            wavelength_nm: nm[i % nm.len()],
            mean,
            se,
            residual: Estimate::from_batches(batches.iter().map(ClothLedger::residual)),
        }
    };
    (0..cells).map(row).collect()
}
