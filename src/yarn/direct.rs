use super::radiance_factor::{FactorCells, LightSide};
use super::{Effort, LengthBins, LengthTally, RadianceFactorGrid, Sharing, Yarn, YarnError, add_scaled};
use crate::fault::{self, Fault};
use crate::geometry::Vec3;
use crate::transport::{Entry, Ledger, Purpose, Stream};
use rayon::prelude::*;

/// Parallel beams over the whole yarn, tallied to f* without a BSSRDF between.
pub struct DirectTracer<'a> {
    yarn: &'a Yarn,
    sharing: Vec<Sharing<'a>>,
    grid: RadianceFactorGrid,
    cells: FactorCells,
    effort: Effort,
    lengths: Option<LengthBins>,
}

/// Result of one batch.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectBatch {
    /// f*, 1/sr: cell of the grid × wavelength, wavelength fastest.
    pub radiance_factor: Vec<f64>,
    /// Of all light of a tilt, the fraction that comes in at one place of the section or its mirror image, scatters, and leaves at
    /// another: passage of the grid × wavelength, wavelength fastest.
    pub passages: Vec<f64>,
    /// Tilt × wavelength, wavelength fastest; fractions of the light that meets the yarn.
    pub ledgers: Vec<Ledger>,
    /// f* by path length; empty where it was not asked for.
    pub lengths: LengthTally,
}

impl<'a> DirectTracer<'a> {
    pub fn new(
        yarn: &'a Yarn,
        grid: RadianceFactorGrid,
        effort: Effort,
        lengths: Option<LengthBins>,
    ) -> Result<Self, YarnError> {
        Ok(Self {
            yarn,
            sharing: yarn.sharing()?,
            grid,
            cells: FactorCells::new(grid)?,
            effort,
            lengths,
        })
    }

    /// Traces one batch at every tilt.
    pub fn batch(&self, batch: usize) -> DirectBatch {
        let tilts: Vec<DirectBatch> = (0..self.grid.tilts())
            .into_par_iter()
            .map(|tilt| self.tilt(batch, tilt))
            .collect();
        let mut whole = DirectBatch {
            radiance_factor: Vec::with_capacity(self.grid.cells() * self.yarn.wavelengths()),
            passages: Vec::with_capacity(self.grid.passages() * self.yarn.wavelengths()),
            ledgers: Vec::new(),
            lengths: LengthTally::default(),
        };
        for tilt in tilts {
            whole.radiance_factor.extend(tilt.radiance_factor);
            whole.passages.extend(tilt.passages);
            whole.ledgers.extend(tilt.ledgers);
            whole.lengths.amount.extend(tilt.lengths.amount);
            whole.lengths.moment_mm.extend(tilt.lengths.moment_mm);
        }
        whole
    }

    /// Beams evenly spread over the cell of the tilt, in the sine of it: the same radiance from all of that band of sky.
    fn tilt(&self, batch: usize, tilt: usize) -> DirectBatch {
        let wavelengths = self.yarn.wavelengths();
        let exits = self.grid.surface().exit().cells();
        let cells = self.grid.azimuths() * exits;
        let bins = self.lengths.as_ref().map_or(0, LengthBins::bins);
        let paths = self.effort.paths_per_batch;
        let per_path = 1.0 / paths as f64;
        let [low, high] = self.grid.tilt_edges(tilt).map(f64::sin);
        let light = LightSide {
            x: 0.0,
            z: 1.0,
            tilt,
            axis_reversed: false,
        };
        let first_cell = self.grid.cell(tilt, 0, 0);
        let first_passage = self.grid.passage(tilt, 0, false, 0);
        let mut passages = vec![0.0; self.grid.passages() / self.grid.tilts() * wavelengths];
        let mut values = vec![0.0; cells * wavelengths];
        let mut lengths = LengthTally {
            amount: vec![0.0; cells * bins * wavelengths],
            moment_mm: vec![0.0; cells * bins * wavelengths],
        };
        let mut ledgers = Vec::with_capacity(wavelengths);
        for sharing in &self.sharing {
            let here = sharing.first..sharing.first + sharing.interior.wavelengths();
            let stream = Stream::open(self.effort.seed, Purpose::Direct, tilt, batch, sharing.first);
            let traced = self.yarn.walk(&sharing.interior).trace(
                stream,
                paths,
                |[across, along, ..]| {
                    let h = 2.0 * across - 1.0;
                    let normal = Vec3::new(h, 0.0, (1.0 - h * h).max(0.0).sqrt());
                    let sine = low + (high - low) * along;
                    Entry {
                        position: normal * self.yarn.cylinder.radius_mm(),
                        normal,
                        omega_in: Vec3::new(0.0, sine, (1.0 - sine * sine).sqrt()),
                    }
                },
                |exit| {
                    if exit.scattered || fault::active(Fault::BallisticBinned) {
                        let cell = self.cells.cell(&light, &exit.normal, &exit.direction) - first_cell;
                        add_scaled(&mut values[cell * wavelengths..][here.clone()], exit.weights, 1.0);
                        let entry = self.cells.entry(&light, &exit.entry);
                        let passage = self.cells.passage(&light, entry, &exit.normal) - first_passage;
                        add_scaled(
                            &mut passages[passage * wavelengths..][here.clone()],
                            exit.weights,
                            per_path * if fault::active(Fault::PassageLoss) { 0.97 } else { 1.0 },
                        );
                        if let Some(of) = &self.lengths {
                            let at = (cell * bins + of.bin(exit.length_mm)) * wavelengths;
                            add_single(&mut lengths.amount[at..][here.clone()], exit.weights, 1.0);
                            add_single(&mut lengths.moment_mm[at..][here.clone()], exit.weights, exit.length_mm);
                        }
                    }
                },
            );
            ledgers.extend(traced.ledgers.iter().map(|sum| sum.scaled(per_path)));
        }
        let factor: Vec<f64> = (0..exits)
            .map(|exit| self.grid.radiance_factor_per_fraction(tilt, exit) / paths as f64)
            .collect();
        for (cell, row) in values.chunks_exact_mut(wavelengths).enumerate() {
            row.iter_mut().for_each(|value| *value *= factor[cell % exits]);
        }
        for part in [&mut lengths.amount, &mut lengths.moment_mm] {
            for (cell, rows) in part.chunks_exact_mut((bins * wavelengths).max(1)).enumerate() {
                rows.iter_mut().for_each(|value| *value *= factor[cell % exits] as f32);
            }
        }
        DirectBatch {
            radiance_factor: values,
            passages,
            ledgers,
            lengths,
        }
    }
}

#[inline(always)]
fn add_single(sums: &mut [f32], weights: &[f64], factor: f64) {
    sums.iter_mut()
        .zip(weights)
        .for_each(|(sum, weight)| *sum += (factor * weight) as f32);
}
