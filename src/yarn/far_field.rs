use super::tracer::{Beam, Tracer};
use super::{Effort, Yarn, YarnError, add_scaled};
use crate::transport::{Ledger, Purpose};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Axes of the yarn's far field. Tilts of the light and of the light that leaves are the same cells, even in sin ψ and hence
/// in solid angle; the azimuth about the axis, from the light, is in cells of 0..180° on either side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FarFieldGrid {
    tilts: usize,
    azimuths: usize,
}

impl FarFieldGrid {
    pub fn new(tilts: usize, azimuths: usize) -> Result<Self, YarnError> {
        for (quantity, found) in [("tilts", tilts), ("azimuths", azimuths)] {
            if found == 0 {
                return Err(YarnError::Count {
                    quantity,
                    expected: "1 or more",
                    found,
                });
            }
        }
        Ok(Self { tilts, azimuths })
    }

    pub fn tilts(&self) -> usize {
        self.tilts
    }

    pub fn azimuths(&self) -> usize {
        self.azimuths
    }

    /// sin ψ at the edges of a tilt cell.
    pub fn sines(&self, tilt: usize) -> [f64; 2] {
        [tilt, tilt + 1].map(|edge| edge as f64 / self.tilts as f64)
    }

    /// All cells of a batch's scattered light, wavelengths apart.
    pub fn cells(&self) -> usize {
        self.tilts * 2 * self.tilts * 2 * 2 * self.azimuths
    }

    /// Light from tilt cell `from.0` on the side `from.1` of the yarn's normal plane, seen in tilt cell `to.0` on the side
    /// `to.1`, at `side` of the light and so many cells of azimuth from it.
    pub fn cell(&self, from: (usize, bool), to: (usize, bool), side: bool, azimuth: usize) -> usize {
        let place = (from.0 * 2 + usize::from(from.1)) * self.tilts + to.0;
        ((place * 2 + usize::from(to.1)) * 2 + usize::from(side)) * self.azimuths + azimuth
    }
}

/// What a yarn makes of parallel beams as seen from afar, where it is a line: no place on it matters any more.
pub struct FarFieldTracer<'a> {
    tracer: Tracer<'a, Beam>,
    grid: FarFieldGrid,
}

/// Result of one batch.
#[derive(Clone, Debug, PartialEq)]
pub struct FarFieldBatch {
    /// ∫∫ P dω_in dω_out over the cells in units of 2R times the solid angle 2π of the tilt cells' azimuths: P = ∮ f* cosθ_out R dφ,
    /// the radiant intensity per length of yarn and E⊥, symmetric in its two directions. Cell of the grid × wavelength,
    /// wavelength fastest.
    pub scattered: Vec<f64>,
    /// Tilt × wavelength, wavelength fastest; fractions of the light that meets the yarn, mean over beams even in sin ψ.
    pub ledgers: Vec<Ledger>,
}

impl<'a> FarFieldTracer<'a> {
    /// Paths of `effort` are for each tilt.
    pub fn new(yarn: &'a Yarn, grid: FarFieldGrid, effort: Effort) -> Result<Self, YarnError> {
        let beam = Beam {
            purpose: Purpose::Check,
            radius_mm: yarn.cylinder.radius_mm(),
            sines: (0..grid.tilts).map(|tilt| grid.sines(tilt)).collect(),
            both_sides: true,
        };
        Ok(Self {
            tracer: Tracer::new(yarn, beam, effort)?,
            grid,
        })
    }

    pub fn batch(&self, batch: usize) -> FarFieldBatch {
        let tilts: Vec<FarFieldBatch> = (0..self.grid.tilts)
            .into_par_iter()
            .map(|tilt| self.tilt(batch, tilt))
            .collect();
        let mut whole = FarFieldBatch {
            scattered: Vec::with_capacity(self.grid.cells() * self.tracer.wavelengths()),
            ledgers: Vec::new(),
        };
        for tilt in tilts {
            whole.scattered.extend(tilt.scattered);
            whole.ledgers.extend(tilt.ledgers);
        }
        whole
    }

    fn tilt(&self, batch: usize, tilt: usize) -> FarFieldBatch {
        let grid = &self.grid;
        let wavelengths = self.tracer.wavelengths();
        let share = self.tracer.share_of_path();
        let [low, high] = grid.sines(tilt);
        let first_cell = grid.cell((tilt, false), (0, false), false, 0);
        let mut scattered = vec![0.0; grid.cells() / grid.tilts * wavelengths];
        let ledgers = self.tracer.part(batch, tilt, |exit, here| {
            if !exit.scattered {
                return;
            }
            let out = &exit.direction;
            let seen = ((out.y.abs() * grid.tilts as f64) as usize).min(grid.tilts - 1);
            let azimuth = out.x.abs().atan2(out.z) / PI * grid.azimuths as f64;
            let azimuth = (azimuth as usize).min(grid.azimuths - 1);
            let from = (tilt, exit.omega_in.y < 0.0);
            let cell = grid.cell(from, (seen, out.y < 0.0), out.x < 0.0, azimuth) - first_cell;
            // Beams even in sin ψ; of each the yarn meets cos ψ.
            let factor = share * (high - low) * exit.omega_in.z;
            add_scaled(&mut scattered[cell * wavelengths..][here], exit.weights, factor);
        });
        FarFieldBatch { scattered, ledgers }
    }
}
