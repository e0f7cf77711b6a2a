use super::SurfaceGrid;
use crate::geometry::Vec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Axes of a radiance factor table. By the cylinder's symmetry f*(ω_in, ω_out) depends on the light's tilt out of the
/// yarn's normal plane, on the azimuth of the surface point from the light, and on ω_out; both mirrors fold the table
/// to tilts 0..90° and azimuths 0..180°. Tilts are nodes, azimuth and ω_out are cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadianceFactorGrid {
    tilts: usize,
    surface: SurfaceGrid,
}

impl RadianceFactorGrid {
    /// `tilts` is 1 or more.
    pub fn new(tilts: usize, surface: SurfaceGrid) -> Result<Self, super::YarnError> {
        if tilts == 0 {
            return Err(super::YarnError::Count {
                quantity: "tilts",
                expected: "1 or more",
                found: tilts,
            });
        }
        Ok(Self { tilts, surface })
    }

    pub fn tilts(&self) -> usize {
        self.tilts
    }

    pub fn surface(&self) -> &SurfaceGrid {
        &self.surface
    }

    /// Azimuth cells from the light's meridian to the one opposite.
    pub fn azimuths(&self) -> usize {
        self.surface.azimuths / 2
    }

    pub fn cells(&self) -> usize {
        self.tilts * self.azimuths() * self.surface.exit.cells()
    }

    /// Tilt of node k, radians.
    pub fn tilt(&self, k: usize) -> f64 {
        (k as f64 + 0.5) * FRAC_PI_2 / self.tilts as f64
    }

    /// Index of (tilt, azimuth, exit cell).
    pub fn cell(&self, tilt: usize, azimuth: usize, exit: usize) -> usize {
        (tilt * self.azimuths() + azimuth) * self.surface.exit.cells() + exit
    }

    /// f* in a cell per fraction of the beam's flux that leaves through it, 1/sr: radiance of the cell over irradiance
    /// normal to the beam, for flux 2R cos ψ per length of yarn and both mirror images of the cell, 2 RΔφ long.
    pub fn radiance_factor_per_fraction(&self, tilt: usize, exit: usize) -> f64 {
        let width = TAU / self.surface.azimuths as f64;
        self.tilt(tilt).cos() / (width * self.surface.exit.projected_solid_angle(exit))
    }

    /// Multilinear interpolation at local directions (tangent, axis, normal): calls `add(cell, weight)` so that
    /// f* = Σ weight · table. ω_in may be anywhere on the sphere. Between tilts, f*/cos ψ is what is linear.
    #[inline]
    pub fn weights(&self, omega_in: &Vec3, omega_out: &Vec3, mut add: impl FnMut(usize, f64)) {
        let tilt = omega_in.y.abs().min(1.0).asin();
        let axis_reversed = omega_in.y < 0.0;
        // Azimuth of the point as seen from the light.
        let azimuth = -omega_in.x.atan2(omega_in.z);
        let tangent_reversed = azimuth < 0.0;
        let steps = tilt / FRAC_PI_2 * self.tilts as f64 - 0.5;
        let turns = azimuth.abs() / PI * self.azimuths() as f64 - 0.5;
        let (low, wt) = (steps.floor(), steps - steps.floor());
        let (near, wa) = (turns.floor(), turns - turns.floor());
        for (k, weight_k) in [(low, 1.0 - wt), (low + 1.0, wt)] {
            // Below the first node lies its own mirror image.
            let mirror_axis = axis_reversed != (k < 0.0);
            let node = (k.max(0.0) as usize).min(self.tilts - 1);
            let weight_k = weight_k * tilt.cos() / self.tilt(node).cos();
            for (a, weight_a) in [(near, 1.0 - wa), (near + 1.0, wa)] {
                let beyond = a < 0.0 || a >= self.azimuths() as f64;
                let mirror_tangent = tangent_reversed != beyond;
                let cell = (a.max(0.0) as usize).min(self.azimuths() - 1);
                let seen = Vec3::new(
                    if mirror_tangent { -omega_out.x } else { omega_out.x },
                    if mirror_axis { -omega_out.y } else { omega_out.y },
                    omega_out.z,
                );
                for (exit, weight_e) in self.surface.exit.bilinear(&seen) {
                    add(self.cell(node, cell, exit), weight_k * weight_a * weight_e);
                }
            }
        }
    }
}

/// f* per batch, cell and wavelength, 1/sr: radiance per irradiance **normal to the beam**. No cosine is owed when
/// shading with it. The ballistic part is not in it.
#[derive(Clone, Debug, PartialEq)]
pub struct RadianceFactorTable {
    pub(super) grid: RadianceFactorGrid,
    pub(super) wavelengths: usize,
    /// One table a batch, wavelength fastest.
    pub(super) batches: Vec<Vec<f64>>,
}

impl RadianceFactorTable {
    pub(super) fn zeros(grid: RadianceFactorGrid, wavelengths: usize, batches: usize) -> Self {
        Self {
            grid,
            wavelengths,
            batches: vec![vec![0.0; grid.cells() * wavelengths]; batches],
        }
    }

    pub fn grid(&self) -> &RadianceFactorGrid {
        &self.grid
    }

    pub fn batches(&self) -> usize {
        self.batches.len()
    }

    /// Value of one batch.
    pub fn value(&self, batch: usize, cell: usize, wavelength: usize) -> f64 {
        self.batches[batch][cell * self.wavelengths + wavelength]
    }

    /// Mean over batches and its standard error.
    pub fn estimate(&self, cell: usize, wavelength: usize) -> (f64, f64) {
        let n = self.batches.len() as f64;
        let mean = (0..self.batches.len())
            .map(|b| self.value(b, cell, wavelength))
            .sum::<f64>()
            / n;
        let square = (0..self.batches.len())
            .map(|b| (self.value(b, cell, wavelength) - mean).powi(2))
            .sum::<f64>();
        (mean, (square / (n * (n - 1.0))).sqrt())
    }

    /// Σ weight · f* of one batch at every wavelength.
    pub fn contract(&self, batch: usize, weights: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.wavelengths];
        for (&weight, row) in weights.iter().zip(self.batches[batch].chunks_exact(self.wavelengths)) {
            if weight != 0.0 {
                sum.iter_mut().zip(row).for_each(|(s, f)| *s += weight * f);
            }
        }
        sum
    }

    /// Fraction of the beam's flux the table says is scattered, one batch: ∫∫ f* cosθ dω dB over the flux.
    pub fn scattered(&self, batch: usize, tilt: usize, wavelength: usize) -> f64 {
        let exit = self.grid.surface.exit;
        let mut sum = 0.0;
        for azimuth in 0..self.grid.azimuths() {
            for e in 0..exit.cells() {
                sum += self.value(batch, self.grid.cell(tilt, azimuth, e), wavelength)
                    / self.grid.radiance_factor_per_fraction(tilt, e);
            }
        }
        sum
    }
}
