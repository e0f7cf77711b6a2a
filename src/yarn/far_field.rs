use super::tracer::{ParallelBeam, Tracer};
use super::{Effort, Yarn, YarnError, add_scaled};
use crate::transport::{Ledger, Purpose};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Axes of the yarn's far field. Incident and exit tilts use the same cells, uniform in sin ψ and hence in solid angle.
/// Azimuth cells about the axis, from the light, cover 0..180° on either side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FarFieldGrid {
    tilts: usize,
    azimuths: usize,
}

impl FarFieldGrid {
    /// Numbers of tilt and azimuth cells.
    ///
    /// # Errors
    /// [`YarnError::Count`] if a number is 0.
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

    /// Number of tilt cells.
    pub fn tilts(&self) -> usize {
        self.tilts
    }

    /// Number of azimuth cells on either side of the light.
    pub fn azimuths(&self) -> usize {
        self.azimuths
    }

    /// sin ψ at the edges of a tilt cell.
    pub fn sines(&self, tilt: usize) -> [f64; 2] {
        [tilt, tilt + 1].map(|edge| edge as f64 / self.tilts as f64)
    }

    /// Number of cells of a batch's scattered light, for one wavelength.
    pub fn cells(&self) -> usize {
        self.tilts * 2 * self.tilts * 2 * 2 * self.azimuths
    }

    /// Index of the cell for light from tilt cell `from.0` on side `from.1` of the yarn's normal plane that leaves in
    /// tilt cell `to.0` on side `to.1`, in azimuth cell `azimuth` on side `side` of the light.
    pub fn cell(&self, from: (usize, bool), to: (usize, bool), side: bool, azimuth: usize) -> usize {
        let place = (from.0 * 2 + usize::from(from.1)) * self.tilts + to.0;
        ((place * 2 + usize::from(to.1)) * 2 + usize::from(side)) * self.azimuths + azimuth
    }
}

/// Traces the far field of a yarn in parallel beams: the scattered radiant intensity, without regard to the exit point.
pub struct FarFieldTracer<'a> {
    tracer: Tracer<'a, ParallelBeam>,
    grid: FarFieldGrid,
}

/// Result of one batch.
#[derive(Clone, Debug, PartialEq)]
pub struct FarFieldBatch {
    /// ∫∫ P dω_in dω_out over the cells, in units of 2R times the azimuth range 2π of the tilt cells. P = ∮ f* cosθ_out
    /// R dφ is the radiant intensity per length of yarn and per E⊥, symmetric in its two directions. Cell of the grid ×
    /// wavelength (fastest).
    pub scattered: Vec<f64>,
    /// Ledgers, tilt × wavelength (fastest), as fractions of the light that meets the yarn; mean over beams uniform in
    /// sin ψ.
    pub ledgers: Vec<Ledger>,
}

impl<'a> FarFieldTracer<'a> {
    /// `effort` gives the paths for each tilt.
    pub fn new(yarn: &'a Yarn, grid: FarFieldGrid, effort: Effort) -> Result<Self, YarnError> {
        let beam = ParallelBeam {
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

    /// Traces one batch at every tilt.
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
            // Beams are uniform in sin ψ; the flux that meets the yarn is proportional to cos ψ.
            let factor = share * (high - low) * exit.omega_in.z;
            add_scaled(&mut scattered[cell * wavelengths..][here], exit.weights, factor);
        });
        FarFieldBatch { scattered, ledgers }
    }
}
