use super::{Effort, Sharing, Yarn, YarnError, add_scaled};
use crate::geometry::Vec3;
use crate::transport::{Entry, Ledger, Purpose, Stream};
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
    yarn: &'a Yarn,
    sharing: Vec<Sharing<'a>>,
    grid: FarFieldGrid,
    effort: Effort,
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
        Ok(Self {
            yarn,
            sharing: yarn.sharing()?,
            grid,
            effort,
        })
    }

    pub fn batch(&self, batch: usize) -> FarFieldBatch {
        let tilts: Vec<FarFieldBatch> = (0..self.grid.tilts)
            .into_par_iter()
            .map(|tilt| self.tilt(batch, tilt))
            .collect();
        let mut whole = FarFieldBatch {
            scattered: Vec::with_capacity(self.grid.cells() * self.yarn.wavelengths()),
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
        let wavelengths = self.yarn.wavelengths();
        let paths = self.effort.paths_per_batch;
        let scale = 1.0 / paths as f64;
        let [low, high] = grid.sines(tilt);
        let first_cell = grid.cell((tilt, false), (0, false), false, 0);
        let mut scattered = vec![0.0; grid.cells() / grid.tilts * wavelengths];
        let mut ledgers = Vec::with_capacity(wavelengths);
        for sharing in &self.sharing {
            let here = sharing.first..sharing.first + sharing.interior.wavelengths();
            let stream = Stream::open(self.effort.seed, Purpose::Check, tilt, batch, sharing.first);
            let traced = self.yarn.walk(&sharing.interior).trace(
                stream,
                paths,
                |[across, along, side, _]| {
                    let h = 2.0 * across - 1.0;
                    let normal = Vec3::new(h, 0.0, (1.0 - h * h).max(0.0).sqrt());
                    let sine = low + (high - low) * along;
                    let cosine = (1.0 - sine * sine).sqrt();
                    Entry {
                        position: normal * self.yarn.cylinder.radius_mm(),
                        normal,
                        omega_in: Vec3::new(0.0, if *side < 0.5 { sine } else { -sine }, cosine),
                    }
                },
                |exit| {
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
                    let factor = scale * (high - low) * exit.omega_in.z;
                    add_scaled(&mut scattered[cell * wavelengths..][here.clone()], exit.weights, factor);
                },
            );
            ledgers.extend(traced.ledgers.iter().map(|sum| sum.scaled(scale)));
        }
        FarFieldBatch { scattered, ledgers }
    }
}
