//! Locality: distance along the yarn between the entry and the exit of scattered light.

use super::tracer::{ParallelBeam, Tracer};
use super::{Effort, Yarn, YarnError};
use crate::transport::{Estimate, Purpose};

const BATCHES: usize = 16;
const PATHS_PER_BATCH: usize = 4000;

/// Fractions of the scattered light that leave farther along the yarn from their entry than each of the given
/// distances, mm, for a beam normal to a straight yarn: `[wavelength][distance]`.
pub fn scattered_beyond<const N: usize>(
    yarn: &Yarn,
    distances_mm: [f64; N],
    seed: u64,
) -> Result<Vec<[Estimate; N]>, YarnError> {
    let beam = ParallelBeam {
        purpose: Purpose::Locality,
        radius_mm: yarn.cylinder.radius_mm(),
        sines: vec![[0.0; 2]],
        both_sides: false,
    };
    let effort = Effort {
        seed,
        batches: BATCHES,
        paths_per_batch: PATHS_PER_BATCH,
    };
    let tracer = Tracer::new(yarn, beam, effort)?;
    let batches: Vec<Vec<[f64; N]>> = (0..BATCHES).map(|batch| shares(&tracer, distances_mm, batch)).collect();
    let estimate = |w: usize, k: usize| Estimate::from_batches(batches.iter().map(|shares| shares[w][k]));
    Ok((0..tracer.wavelengths())
        .map(|w| std::array::from_fn(|k| estimate(w, k)))
        .collect())
}

/// One batch: `[wavelength][distance]`.
fn shares<const N: usize>(tracer: &Tracer<ParallelBeam>, distances_mm: [f64; N], batch: usize) -> Vec<[f64; N]> {
    let mut beyond = vec![[0.0; N]; tracer.wavelengths()];
    let mut scattered = vec![0.0; tracer.wavelengths()];
    tracer.part(batch, 0, |exit, here| {
        if !exit.scattered {
            return;
        }
        let along_mm = (exit.position.y - exit.entry.y).abs();
        for (w, weight) in here.zip(exit.weights) {
            scattered[w] += weight;
            for (sum, distance) in beyond[w].iter_mut().zip(distances_mm) {
                if along_mm > distance {
                    *sum += weight;
                }
            }
        }
    });
    for (sums, scattered) in beyond.iter_mut().zip(scattered) {
        sums.iter_mut().for_each(|sum| *sum /= scattered);
    }
    beyond
}
