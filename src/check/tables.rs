//! BSSRDF and f*: both integrate to the ledger's scattered light, and both estimators of f* agree.

use super::gate::{Gate, Law, Where};
use super::{CheckError, Context};
use crate::transport::{Fraction, Ledger};
use crate::yarn::{BssrdfGrid, DirectBatch, DirectTracer, Effort, PatchTracer, SurfaceGrid, YarnResponseGrid};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::iter::zip;

const BSSRDF: Law = Law {
    name: "bssrdf-integral",
    words: "the BSSRDF, with what leaves beyond its last z, integrates to the ledger's scattered light",
};
const FACTOR: Law = Law {
    name: "radiance-factor-integral",
    words: "f* integrates over surface and directions to the ledger's scattered light",
};
const PASSAGES: Law = Law {
    name: "passages",
    words: "what comes in at one place of the section and leaves at another adds up to the ledger's scattered light",
};
pub const ROADS: Law = Law {
    name: "two-estimators",
    words: "f* summed from the BSSRDF over the lit surface sends out the light that a parallel beam does",
};

/// Batches of tables on the study's own axes that are integrated; the BSSRDF has 0.15 GB each.
const TABLES: usize = 2;

/// One direct batch after the other to each of the sinks, so that no more than one table is held.
pub fn direct(
    context: &Context,
    mut sink: impl FnMut(&DirectBatch) -> Result<(), CheckError>,
) -> Result<[Gate; 2], CheckError> {
    let Context { plan, judge, .. } = context;
    let grid = plan.factor_grid;
    let wavelengths = plan.grid.len();
    let paths = context.of_estimator(context.share(8) * context.cloth_batches as u64);
    let effort = Effort::new(plan.study.seed, context.cloth_batches, paths)?;
    let tracer = DirectTracer::new(&plan.yarn, grid, effort, None)?;
    let (mut departures, mut of_passages) = (Vec::new(), Vec::new());
    for batch in 0..context.cloth_batches {
        let batch = tracer.batch(batch);
        if departures.len() < TABLES * batch.ledgers.len() {
            departures.extend(integral_departures(&grid, &batch, wavelengths));
            of_passages.extend(passage_departures(&grid, &batch, wavelengths));
        }
        sink(&batch)?;
    }
    let at = |i: usize| {
        let cell = i % (grid.tilts() * wavelengths);
        Where::new(
            plan.grid.nm()[cell % wavelengths],
            tilt_words(&grid, cell / wavelengths),
        )
    };
    let rounding = plan.study.check.rounding;
    Ok([
        judge.exact(FACTOR, &departures, rounding, at),
        judge.exact(PASSAGES, &of_passages, rounding, at),
    ])
}

/// Passages are fractions of all light of a tilt.
fn passage_departures(grid: &YarnResponseGrid, batch: &DirectBatch, wavelengths: usize) -> Vec<f64> {
    let per_tilt = grid.transfer_cells() / grid.tilts() * wavelengths;
    let tilts = batch
        .response
        .transfer_values()
        .chunks_exact(per_tilt)
        .zip(batch.ledgers.chunks_exact(wavelengths));
    tilts
        .flat_map(|(rows, ledgers)| {
            let mut sums = vec![0.0; wavelengths];
            for row in rows.chunks_exact(wavelengths) {
                zip(&mut sums, row).for_each(|(sum, x)| *sum += x);
            }
            zip(sums, ledgers)
                .map(|(sum, ledger)| sum - ledger[Fraction::Scattered])
                .collect::<Vec<_>>()
        })
        .collect()
}

/// ∮∫ f* cosθ dω R dφ over the yarn is what the beam's 2R cosψ E⊥ scatters: written out from the cells' edges alone.
fn integral_departures(grid: &YarnResponseGrid, batch: &DirectBatch, wavelengths: usize) -> Vec<f64> {
    let exit = grid.surface().exit();
    let (rows, columns) = (exit.theta_cells(), exit.phi_cells());
    let width = TAU / grid.surface().azimuths() as f64;
    let edge = |i: usize| (i as f64 * FRAC_PI_2 / rows as f64).cos();
    // ∫ cosθ dω over a cell of the row.
    let projected: Vec<f64> = (0..rows)
        .map(|i| PI / columns as f64 * (edge(i).powi(2) - edge(i + 1).powi(2)))
        .collect();
    let mut departures = Vec::with_capacity(batch.ledgers.len());
    for tilt in 0..grid.tilts() {
        let [low, high] = grid.tilt_edges(tilt);
        let met = 2.0 * (high.sin() - low.sin()) / (high - low);
        let mut sums = vec![0.0; wavelengths];
        for azimuth in 0..grid.azimuths() {
            for exit in 0..exit.cells() {
                // A cell stands for its mirror image, too.
                let share = 2.0 * width * projected[exit / columns] / met;
                let row = batch.response.row(grid.cell(tilt, azimuth, exit));
                zip(&mut sums, row).for_each(|(sum, f)| *sum += share * f);
            }
        }
        let scattered = &batch.ledgers[tilt * wavelengths..][..wavelengths];
        departures.extend(zip(sums, scattered).map(|(sum, ledger)| sum - ledger[Fraction::Scattered]));
    }
    departures
}

fn tilt_words(grid: &YarnResponseGrid, tilt: usize) -> String {
    let [low, high] = grid.tilt_edges(tilt).map(f64::to_degrees);
    format!("tilt {low:.0} to {high:.0} deg")
}

pub fn bssrdf(context: &Context) -> Result<Gate, CheckError> {
    let Context { plan, judge, .. } = context;
    let grid = plan.bssrdf_grid(&plan.yarn)?;
    let wavelengths = plan.grid.len();
    let effort = Effort::new(plan.study.seed, TABLES, context.of_estimator(2 * context.share(1)))?;
    let summed = YarnResponseGrid::new(1, SurfaceGrid::new(4, 1, 4)?)?;
    let tracer = PatchTracer::new(&plan.yarn, grid.clone(), summed, effort)?;
    let per_direction: usize = grid.shape()[1..].iter().product();
    let mut departures = Vec::new();
    for batch in 0..TABLES {
        let batch = tracer.batch(batch);
        for (direction, fractions) in batch.fractions.chunks_exact(per_direction).enumerate() {
            let mut sums = vec![0.0; wavelengths];
            for row in fractions.chunks_exact(wavelengths) {
                zip(&mut sums, row).for_each(|(sum, fraction)| *sum += fraction);
            }
            let ledgers: &[Ledger] = &batch.ledgers[direction * wavelengths..][..wavelengths];
            departures.extend(zip(sums, ledgers).map(|(sum, ledger)| sum - ledger[Fraction::Scattered]));
        }
    }
    Ok(judge.exact(BSSRDF, &departures, plan.study.check.rounding, |i| {
        let direction = i / wavelengths % plan.incident.traced();
        Where::new(plan.grid.nm()[i % wavelengths], format!("traced direction {direction}"))
    }))
}

/// Tilts, and azimuths around the yarn (lit side, rim, far side), in which the two estimators of f* are compared.
const ROAD_TILTS: usize = 4;
const ROAD_AZIMUTHS: usize = 12;
const ROAD_SIDES: usize = 3;

pub fn two_estimators(context: &Context) -> Result<Gate, CheckError> {
    let Context { plan, judge, .. } = context;
    let wavelengths = plan.grid.len();
    let surface = SurfaceGrid::new(ROAD_AZIMUTHS, 1, 4)?;
    let grid = YarnResponseGrid::new(ROAD_TILTS, surface)?;
    let batches = context.batches;
    let effort = |share| {
        Effort::new(
            plan.study.seed,
            batches,
            context.of_estimator(context.share(share) * batches as u64),
        )
    };
    let axes = BssrdfGrid::new(&plan.yarn, plan.incident, SurfaceGrid::new(4, 1, 4)?, 2)?;
    let patch = PatchTracer::new(&plan.yarn, axes, grid, effort(1)?)?;
    let direct = DirectTracer::new(&plan.yarn, grid, effort(8)?, None)?;
    let per_side = grid.azimuths() / ROAD_SIDES;
    let differences: Vec<Vec<f64>> = (0..batches)
        .map(|batch| {
            let (patch, direct) = (patch.batch(batch), direct.batch(batch));
            let mut cells = vec![0.0; ROAD_TILTS * ROAD_SIDES * wavelengths];
            for tilt in 0..ROAD_TILTS {
                for azimuth in 0..grid.azimuths() {
                    for exit in 0..surface.exit().cells() {
                        let share = 1.0 / grid.response_per_fraction(tilt, exit);
                        let [summed, beam] =
                            [&patch.response, &direct.response].map(|of| of.row(grid.cell(tilt, azimuth, exit)));
                        let to = (tilt * ROAD_SIDES + azimuth / per_side) * wavelengths;
                        for w in 0..wavelengths {
                            let difference = summed[w] - beam[w];
                            cells[to + w] += share * difference;
                        }
                    }
                }
            }
            cells
        })
        .collect();
    let tolerance = plan.study.check.two_estimators * context.widening;
    Ok(judge.zero(ROADS, &differences, tolerance, |i| {
        let cell = i / wavelengths;
        let side = ["lit side", "rim", "far side"][cell % ROAD_SIDES];
        let tilt = tilt_words(&grid, cell / ROAD_SIDES);
        Where::new(plan.grid.nm()[i % wavelengths], format!("{tilt}, {side}"))
    }))
}
