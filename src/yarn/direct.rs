use super::response_cells::{LightSide, ResponseCells};
use super::tracer::{ParallelBeam, Tracer};
use super::{Effort, LengthBins, LengthTally, Yarn, YarnError, YarnResponse, YarnResponseGrid, add_scaled};
use crate::fault::{self, Fault};
use crate::transport::{Ledger, Purpose};
use rayon::prelude::*;

/// Traces parallel beams over the whole yarn and tallies f* directly, without a BSSRDF.
pub struct DirectTracer<'a> {
    tracer: Tracer<'a, ParallelBeam>,
    grid: YarnResponseGrid,
    cells: ResponseCells,
    lengths: Option<LengthBins>,
}

/// Result of one batch.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectBatch {
    pub response: YarnResponse,
    /// Ledgers, tilt × wavelength (fastest), as fractions of the light that meets the yarn.
    pub ledgers: Vec<Ledger>,
    /// f* by path length; empty if not requested.
    pub lengths: LengthTally,
}

impl<'a> DirectTracer<'a> {
    /// `effort` gives the paths for each tilt.
    pub fn new(
        yarn: &'a Yarn,
        grid: YarnResponseGrid,
        effort: Effort,
        lengths: Option<LengthBins>,
    ) -> Result<Self, YarnError> {
        let beam = ParallelBeam {
            purpose: Purpose::Direct,
            radius_mm: yarn.cylinder.radius_mm(),
            sines: (0..grid.tilts())
                .map(|tilt| grid.tilt_edges(tilt).map(f64::sin))
                .collect(),
            both_sides: false,
        };
        Ok(Self {
            tracer: Tracer::new(yarn, beam, effort)?,
            cells: ResponseCells::new(grid)?,
            grid,
            lengths,
        })
    }

    /// Traces one batch at every tilt.
    pub fn batch(&self, batch: usize) -> DirectBatch {
        let wavelengths = self.tracer.wavelengths();
        let mut response = YarnResponse::zeros(self.grid, wavelengths);
        let [factor, transfer] = response.values_mut();
        let per_tilt = |cells: usize| cells / self.grid.tilts() * wavelengths;
        let tilts: Vec<(Vec<Ledger>, LengthTally)> = factor
            .par_chunks_exact_mut(per_tilt(self.grid.cells()))
            .zip(transfer.par_chunks_exact_mut(per_tilt(self.grid.transfer_cells())))
            .enumerate()
            .map(|(tilt, (factor, transfer))| self.tilt(batch, tilt, factor, transfer))
            .collect();
        let mut ledgers = Vec::with_capacity(self.grid.tilts() * wavelengths);
        let mut lengths = LengthTally::default();
        for (of_tilt, by_length) in tilts {
            ledgers.extend(of_tilt);
            lengths.amount.extend(by_length.amount);
            lengths.moment_mm.extend(by_length.moment_mm);
        }
        DirectBatch {
            response,
            ledgers,
            lengths,
        }
    }

    fn tilt(&self, batch: usize, tilt: usize, values: &mut [f64], transfer: &mut [f64]) -> (Vec<Ledger>, LengthTally) {
        let wavelengths = self.tracer.wavelengths();
        let exits = self.grid.surface().exit().cells();
        let bins = self.lengths.as_ref().map_or(0, LengthBins::bins);
        let per_path = self.tracer.share_of_path();
        let light = LightSide {
            x: 0.0,
            z: 1.0,
            tilt,
            axis_reversed: false,
        };
        let first_cell = self.grid.cell(tilt, 0, 0);
        let first_transfer = self.grid.transfer_cell(tilt, 0, false, 0);
        let mut lengths = LengthTally {
            amount: vec![0.0; values.len() * bins],
            moment_mm: vec![0.0; values.len() * bins],
        };
        let ledgers = self.tracer.part(batch, tilt, |exit, here| {
            if exit.scattered || fault::active(Fault::BallisticBinned) {
                let cell = self.cells.cell(&light, &exit.normal, &exit.direction) - first_cell;
                add_scaled(&mut values[cell * wavelengths..][here.clone()], exit.weights, 1.0);
                let entry = self.cells.entry(&light, &exit.entry);
                let place = self.cells.transfer_cell(&light, entry, &exit.normal) - first_transfer;
                let row = &mut transfer[place * wavelengths..][here.clone()];
                let share = per_path * if fault::active(Fault::PassageLoss) { 0.97 } else { 1.0 };
                add_scaled(row, exit.weights, share);
                if let Some(of) = &self.lengths {
                    let at = (cell * bins + of.bin(exit.length_mm)) * wavelengths;
                    add_single(&mut lengths.amount[at..][here.clone()], exit.weights, 1.0);
                    add_single(&mut lengths.moment_mm[at..][here], exit.weights, exit.length_mm);
                }
            }
        });
        let paths = self.tracer.paths_per_batch() as f64;
        let factor: Vec<f64> = (0..exits)
            .map(|exit| self.grid.response_per_fraction(tilt, exit) / paths)
            .collect();
        for (cell, row) in values.chunks_exact_mut(wavelengths).enumerate() {
            row.iter_mut().for_each(|value| *value *= factor[cell % exits]);
        }
        for part in [&mut lengths.amount, &mut lengths.moment_mm] {
            for (cell, rows) in part.chunks_exact_mut((bins * wavelengths).max(1)).enumerate() {
                rows.iter_mut().for_each(|value| *value *= factor[cell % exits] as f32);
            }
        }
        (ledgers, lengths)
    }
}

#[inline(always)]
fn add_single(sums: &mut [f32], weights: &[f64], factor: f64) {
    sums.iter_mut()
        .zip(weights)
        .for_each(|(sum, weight)| *sum += (factor * weight) as f32);
}
