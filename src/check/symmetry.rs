//! Reciprocity and mirror symmetry of the yarn's scattering.

use super::gate::{Gate, Law, Where};
use super::{CheckError, Context};
use crate::yarn::{Effort, FarFieldBatch, FarFieldGrid, FarFieldTracer};

pub const RECIPROCITY: Law = Law {
    name: "reciprocity",
    words: "f* cosθ_out, integrated around the yarn, is the same with light and viewer exchanged",
};
pub const MIRROR: Law = Law {
    name: "mirror",
    words: "the yarn scatters alike in its two mirror planes",
};
const TILTS: usize = 4;
const AZIMUTHS: usize = 4;

/// The cells that a law compares: the sum of the first less the sum of the second is 0.
struct Pair {
    one: Vec<usize>,
    other: Vec<usize>,
    words: String,
}

pub fn gates(context: &Context) -> Result<Vec<Gate>, CheckError> {
    let Context { plan, judge, .. } = context;
    let grid = FarFieldGrid::new(TILTS, AZIMUTHS)?;
    let paths = context.of_estimator(context.share(1) * 4 * context.batches as u64);
    let effort = Effort::new(plan.study.seed, context.batches, paths)?;
    let tracer = FarFieldTracer::new(&plan.yarn, grid, effort)?;
    let wavelengths = plan.grid.len();
    let (reciprocal, mirrored) = (reciprocal(&grid), mirrored(&grid));
    let mut differences = [Vec::new(), Vec::new()];
    for batch in 0..context.batches {
        let batch = tracer.batch(batch);
        for (differences, pairs) in differences.iter_mut().zip([&reciprocal, &mirrored]) {
            differences.push(
                pairs
                    .iter()
                    .flat_map(|pair| pair.differences(&batch, wavelengths))
                    .collect(),
            );
        }
    }
    let tolerance = plan.study.check.reciprocity * context.widening;
    let judged = [(RECIPROCITY, &reciprocal), (MIRROR, &mirrored)]
        .into_iter()
        .zip(&differences);
    Ok(judged
        .map(|((law, pairs), differences)| {
            judge.zero(law, differences, tolerance, |i| {
                Where::new(plan.grid.nm()[i % wavelengths], pairs[i / wavelengths].words.clone())
            })
        })
        .collect())
}

impl Pair {
    fn differences(&self, batch: &FarFieldBatch, wavelengths: usize) -> Vec<f64> {
        let mut sums = vec![0.0; wavelengths];
        for (cells, sign) in [(&self.one, 1.0), (&self.other, -1.0)] {
            for cell in cells {
                let row = &batch.scattered[cell * wavelengths..][..wavelengths];
                sums.iter_mut().zip(row).for_each(|(sum, x)| *sum += sign * x);
            }
        }
        sums
    }
}

fn degrees(grid: &FarFieldGrid, tilt: usize) -> String {
    let [low, high] = grid.sines(tilt).map(|sine| sine.asin().to_degrees());
    format!("{low:.0}..{high:.0}")
}

/// P(ω_a, ω_b) = P(ω_b, ω_a), both directions away from the yarn. Its mirror images are taken together.
fn reciprocal(grid: &FarFieldGrid) -> Vec<Pair> {
    let all = |from: usize, to: usize, same_side: bool, azimuth: usize| -> Vec<usize> {
        let mut cells = Vec::new();
        for light in [false, true] {
            for side in [false, true] {
                cells.push(grid.cell((from, light), (to, light == same_side), side, azimuth));
            }
        }
        cells
    };
    let mut pairs = Vec::new();
    for low in 0..grid.tilts() {
        for high in low + 1..grid.tilts() {
            for same_side in [true, false] {
                for azimuth in 0..grid.azimuths() {
                    let words = format!(
                        "tilts {} and {} deg, on {}, azimuth cell {azimuth}",
                        degrees(grid, low),
                        degrees(grid, high),
                        if same_side { "one side" } else { "opposite sides" }
                    );
                    pairs.push(Pair {
                        one: all(low, high, same_side, azimuth),
                        other: all(high, low, same_side, azimuth),
                        words,
                    });
                }
            }
        }
    }
    pairs
}

/// Tangent reversed, and axis reversed.
fn mirrored(grid: &FarFieldGrid) -> Vec<Pair> {
    let mut pairs = Vec::new();
    for from in 0..grid.tilts() {
        for to in 0..grid.tilts() {
            for azimuth in 0..grid.azimuths() {
                let cell = |light, out, side| grid.cell((from, light), (to, out), side, azimuth);
                let tilts = format!(
                    "from {} to {} deg, azimuth cell {azimuth}",
                    degrees(grid, from),
                    degrees(grid, to)
                );
                for same in [true, false] {
                    let sides = |side| vec![cell(false, !same, side), cell(true, same, side)];
                    pairs.push(Pair {
                        one: sides(false),
                        other: sides(true),
                        words: format!("{tilts}, left and right"),
                    });
                    let ends = |light: bool| [false, true].map(|side| cell(light, light == same, side)).to_vec();
                    pairs.push(Pair {
                        one: ends(false),
                        other: ends(true),
                        words: format!("{tilts}, both ends of the axis"),
                    });
                }
            }
        }
    }
    pairs
}
