use super::{Effort, RadianceFactorGrid, RadianceFactorTable, Yarn};
use crate::geometry::Vec3;
use crate::transport::{Ledger, Purpose, Stream, Walk};
use rand::RngExt;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Parallel beams over the whole yarn.
#[derive(Clone, Debug)]
pub struct DirectRun {
    pub table: RadianceFactorTable,
    /// Ledger of [tilt][wavelength][batch].
    pub ledgers: Vec<Vec<Vec<Ledger>>>,
}

/// Lights the whole yarn by a parallel beam at every tilt of the grid and tallies f* without an intermediate BSSRDF.
/// `done` is told the paths of each finished piece of work.
pub fn trace_direct(yarn: &Yarn, grid: RadianceFactorGrid, effort: Effort, done: &(dyn Fn(u64) + Sync)) -> DirectRun {
    let wavelengths = yarn.wavelengths();
    let cells_per_tilt = grid.cells() / grid.tilts();
    let pieces: Vec<(Vec<Vec<f64>>, Vec<Ledger>)> = (0..grid.tilts() * wavelengths)
        .into_par_iter()
        .map(|piece| {
            let (tilt, wavelength) = (piece / wavelengths, piece % wavelengths);
            let result = (0..effort.batches)
                .map(|batch| trace_batch(yarn, &grid, effort, tilt, wavelength, batch))
                .unzip();
            done((effort.batches * effort.paths_per_batch) as u64);
            result
        })
        .collect();
    let exits = grid.surface().exit().cells();
    let per_fraction: Vec<f64> = (0..grid.tilts() * exits)
        .map(|i| grid.radiance_factor_per_fraction(i / exits, i % exits))
        .collect();
    let mut table = RadianceFactorTable::zeros(grid, wavelengths, effort.batches);
    table.batches.par_iter_mut().enumerate().for_each(|(batch, values)| {
        for (cell, row) in values.chunks_exact_mut(wavelengths).enumerate() {
            let (tilt, c) = (cell / cells_per_tilt, cell % cells_per_tilt);
            let factor = per_fraction[tilt * exits + c % exits];
            for (wavelength, value) in row.iter_mut().enumerate() {
                *value = factor * pieces[tilt * wavelengths + wavelength].0[batch][c];
            }
        }
    });
    let mut ledgers = vec![vec![Vec::new(); wavelengths]; grid.tilts()];
    for (piece, (_, ledger)) in pieces.into_iter().enumerate() {
        ledgers[piece / wavelengths][piece % wavelengths] = ledger;
    }
    DirectRun { table, ledgers }
}

/// Fractions of the beam's flux per (azimuth, exit) cell of one tilt, and the ledger.
fn trace_batch(
    yarn: &Yarn,
    grid: &RadianceFactorGrid,
    effort: Effort,
    tilt: usize,
    wavelength: usize,
    batch: usize,
) -> (Vec<f64>, Ledger) {
    let mut rng = Stream::open(effort.seed, Purpose::Direct, tilt, batch, wavelength);
    let walk = Walk {
        shape: &yarn.cylinder,
        interior: yarn.interior(wavelength),
        roulette: yarn.roulette,
    };
    let psi = grid.tilt(tilt);
    let omega_in = Vec3::new(0.0, psi.sin(), psi.cos());
    let exit_grid = grid.surface().exit();
    let mut fractions = vec![0.0; grid.azimuths() * exit_grid.cells()];
    let mut ledger = Ledger::default();
    let n = effort.paths_per_batch;
    for path in 0..n {
        // Impact parameter, stratified over the beam.
        let h = -1.0 + 2.0 * (path as f64 + rng.random::<f64>()) / n as f64;
        let normal = Vec3::new(h, 0.0, (1.0 - h * h).max(0.0).sqrt());
        let position = normal * yarn.cylinder.radius_mm();
        ledger.add(&walk.run(&mut rng, &position, &normal, &omega_in, |exit| {
            if exit.scattered {
                let azimuth = exit.normal.x.atan2(exit.normal.z);
                let mut local = yarn.cylinder.frame(&exit.position).to_local(&exit.direction);
                if azimuth < 0.0 {
                    local.x = -local.x;
                }
                let a = ((azimuth.abs() / PI * grid.azimuths() as f64) as usize).min(grid.azimuths() - 1);
                fractions[a * exit_grid.cells() + exit_grid.cell(&local)] += exit.weight;
            }
        }));
    }
    let scale = 1.0 / n as f64;
    fractions.iter_mut().for_each(|f| *f *= scale);
    (fractions, ledger.scaled(scale))
}
