use super::{Failure, Options, Terminal, study};
use serde::Serialize;
use specval::report::{EnergyRow, check_writable, write_whole};
use specval::run::{self, Plan, YarnSums, energy_rows};
use specval::yarn::{BssrdfGrid, LengthBins};
use std::io::Write;
use std::path::PathBuf;

/// First bytes of an artefact; the number is the format's version.
const MAGIC: &[u8] = b"specval trace 1\n";

/// Traces the yarn and keeps the ledger, the BSSRDF and the radiance factor f*.
///
/// The artefact: the line `specval trace 1`, one line of JSON that names every axis, unit and array with its shape, then
/// the arrays one after the other as little-endian 64-bit floats, last axis fastest.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Study file; without it the built-in study.
    #[arg(value_name = "STUDY")]
    study: Option<PathBuf>,
    /// File for the artefact.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

#[derive(Serialize)]
struct Header<'a> {
    version: &'a str,
    study: &'a specval::study::Study,
    inputs: &'a [specval::report::InputDigest],
    wavelength_nm: &'a [f64],
    tilt_deg: Vec<f64>,
    z_edges_mm: &'a [f64],
    /// Every incident direction, mirrored ones included.
    energy: &'a [EnergyRow],
    arrays: Vec<Array>,
}

#[derive(Serialize)]
struct Array {
    name: &'static str,
    unit: &'static str,
    axes: &'static str,
    shape: Vec<usize>,
}

/// Range of each fraction over wavelengths and directions.
#[derive(Serialize)]
struct Ledger {
    fraction: &'static str,
    lowest: f64,
    mean: f64,
    highest: f64,
}

pub fn run(arguments: &Arguments, options: &Options, terminal: &Terminal) -> Result<(), Failure> {
    let plan = Plan::new(study::load(arguments.study.as_deref(), options)?)?;
    check_writable(&arguments.out)?;
    let tracing = terminal.progress("tracing the yarn");
    let grid = plan.bssrdf_grid()?;
    let lengths = LengthBins::new(plan.yarn.cylinder.radius_mm(), LengthBins::DEFAULT)?;
    let sums = run::trace_yarn(&plan, &grid, &lengths, &|share| tracing.advance(share));
    tracing.finish();
    let sums = sums?;
    let energy = energy_rows(&plan, &sums.ledgers());
    write_whole(&arguments.out, &artefact(&plan, &grid, &sums, &energy)?)?;
    let ledger = ledger(&energy);
    terminal.result(&ledger, |ledger| {
        let mut text = format!("{:<10} {:>12} {:>12} {:>12}\n", "fraction", "lowest", "mean", "highest");
        for row in ledger {
            text += &format!(
                "{:<10} {:>12.4e} {:>12.4e} {:>12.4e}\n",
                row.fraction, row.lowest, row.mean, row.highest
            );
        }
        text
    })
}

/// A fraction's name and where it stands.
type Column = (&'static str, fn(&EnergyRow) -> f64);

fn ledger(energy: &[EnergyRow]) -> Vec<Ledger> {
    let columns: [Column; 6] = [
        ("reflected", |e| e.reflected),
        ("ballistic", |e| e.ballistic),
        ("scattered", |e| e.scattered),
        ("absorbed", |e| e.absorbed),
        ("roulette", |e| e.roulette),
        ("residual", |e| e.residual),
    ];
    columns
        .into_iter()
        .map(|(fraction, of)| Ledger {
            fraction,
            lowest: energy.iter().map(of).fold(f64::INFINITY, f64::min),
            mean: energy.iter().map(of).sum::<f64>() / energy.len() as f64,
            highest: energy.iter().map(of).fold(f64::NEG_INFINITY, f64::max),
        })
        .collect()
}

fn artefact(plan: &Plan, bssrdf: &BssrdfGrid, sums: &YarnSums, energy: &[EnergyRow]) -> Result<Vec<u8>, Failure> {
    let grid = &plan.factor_grid;
    let factor = |name| Array {
        name,
        unit: "1/sr",
        axes: "tilt, azimuth from the light 0..180 deg, exit cell (theta, phi), wavelength; mean and standard error",
        shape: vec![
            grid.tilts(),
            grid.azimuths(),
            grid.surface().exit().cells(),
            plan.grid.len(),
            2,
        ],
    };
    let header = Header {
        version: env!("CARGO_PKG_VERSION"),
        study: &plan.study,
        inputs: &plan.inputs,
        wavelength_nm: plan.grid.nm(),
        tilt_deg: (0..grid.tilts()).map(|k| grid.tilt(k).to_degrees()).collect(),
        z_edges_mm: bssrdf.z_edges_mm(),
        energy,
        arrays: vec![
            factor("radiance_factor_direct"),
            factor("radiance_factor_bssrdf"),
            Array {
                name: "bssrdf_fraction",
                unit: "fraction of the flux incident on the patch",
                axes: "traced direction, exit azimuth, z (overflow first and last), exit cell (theta, phi), wavelength; \
                       mean and standard error",
                shape: bssrdf.shape().into_iter().chain([2]).collect(),
            },
        ],
    };
    let mut bytes = MAGIC.to_vec();
    serde_json::to_writer(&mut bytes, &header)?;
    bytes.push(b'\n');
    for table in [&sums.direct, &sums.summed, &sums.bssrdf] {
        for i in 0..table.sum.len() {
            let estimate = table.estimate(i);
            bytes.write_all(&estimate.value.to_le_bytes())?;
            bytes.write_all(&estimate.se.to_le_bytes())?;
        }
    }
    Ok(bytes)
}
