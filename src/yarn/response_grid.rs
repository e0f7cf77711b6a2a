use super::{SurfaceGrid, YarnError};
use crate::fault::{self, Fault};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Axes of a yarn response. By the cylinder's symmetry f*(ω_in, ω_out) depends on the light's tilt out of the
/// yarn's normal plane, on the azimuth of the surface point from the light, and on ω_out. The two mirror planes reduce
/// the table to tilts 0..90° and azimuths 0..180°. All axes are divided into cells; a table holds means over cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct YarnResponseGrid {
    tilts: usize,
    surface: SurfaceGrid,
}

pub(super) const ENTRIES: usize = 9;

impl YarnResponseGrid {
    /// `tilts` is the number of tilt cells.
    ///
    /// # Errors
    /// [`YarnError::Count`] if `tilts` is 0.
    pub fn new(tilts: usize, surface: SurfaceGrid) -> Result<Self, YarnError> {
        if tilts == 0 {
            return Err(YarnError::Count {
                quantity: "tilts",
                expected: "1 or more",
                found: tilts,
            });
        }
        Ok(Self { tilts, surface })
    }

    /// Number of tilt cells, from 0 to 90°.
    pub fn tilts(&self) -> usize {
        self.tilts
    }

    /// Cells of the surface and of exit directions.
    pub fn surface(&self) -> &SurfaceGrid {
        &self.surface
    }

    /// Azimuth cells from the light's meridian to the one opposite.
    pub fn azimuths(&self) -> usize {
        self.surface.azimuths / 2
    }

    /// Number of cells of f*: tilt × azimuth × exit cell.
    pub fn cells(&self) -> usize {
        self.tilts * self.azimuths() * self.surface.exit.cells()
    }

    /// Number of entry cells on a quarter of the section, from the light's meridian to grazing incidence; light enters
    /// at one of them or at its mirror image. They are 10° wide whatever the grid: narrower cells do not change the
    /// light between yarns.
    pub fn entries(&self) -> usize {
        ENTRIES
    }

    /// Limits of entry cell k, as azimuths from the light's meridian, radians.
    pub fn entry_edges(&self, k: usize) -> [f64; 2] {
        [k, k + 1].map(|edge| edge as f64 * FRAC_PI_2 / self.entries() as f64)
    }

    /// Number of cells of the yarn transfer: (tilt, entry, side, azimuth).
    pub fn transfer_cells(&self) -> usize {
        self.tilts * self.entries() * 2 * self.azimuths()
    }

    /// Index of the transfer cell (tilt, entry, side, azimuth). `opposite`: light leaves on the other side of the
    /// light's meridian than it entered.
    pub fn transfer_cell(&self, tilt: usize, entry: usize, opposite: bool, azimuth: usize) -> usize {
        ((tilt * self.entries() + entry) * 2 + usize::from(opposite)) * self.azimuths() + azimuth
    }

    /// Centre of tilt cell k, radians.
    pub fn tilt(&self, k: usize) -> f64 {
        (k as f64 + 0.5) * FRAC_PI_2 / self.tilts as f64
    }

    /// Limits of tilt cell k, radians.
    pub fn tilt_edges(&self, k: usize) -> [f64; 2] {
        [k, k + 1].map(|edge| edge as f64 * FRAC_PI_2 / self.tilts as f64)
    }

    /// Mean of cos ψ over tilt cell k.
    pub fn mean_cosine(&self, k: usize) -> f64 {
        let [low, high] = self.tilt_edges(k);
        (high.sin() - low.sin()) / (high - low)
    }

    /// Index of (tilt, azimuth, exit cell).
    pub fn cell(&self, tilt: usize, azimuth: usize, exit: usize) -> usize {
        (tilt * self.azimuths() + azimuth) * self.surface.exit.cells() + exit
    }

    /// Factor from the fraction of a tilt cell's flux that leaves through a cell to f* of that cell, 1/sr: radiance
    /// over irradiance normal to the beam, for an incident flux 2R cos ψ per length of yarn and the arc 2 RΔφ of the
    /// cell and its mirror image.
    pub fn response_per_fraction(&self, tilt: usize, exit: usize) -> f64 {
        let width = TAU / self.surface.azimuths as f64;
        let cosine = match fault::active(Fault::FactorOverCosine) {
            true => 1.0,
            false => self.mean_cosine(tilt),
        };
        cosine / (width * self.surface.exit.projected_solid_angle(exit))
    }

    /// Factor from ∫∫ (fraction of the flux on a patch) cos α dω, as in [`Self::response_per_light`], to the fraction
    /// of all light of the tilt cell.
    pub(super) fn fraction_per_light(&self, tilt: usize) -> f64 {
        let tilt_width = FRAC_PI_2 / self.tilts as f64;
        0.25 / (tilt_width * self.mean_cosine(tilt))
    }

    /// Factor from ∫∫ (fraction of the flux on a patch that leaves through a cell) cos α dω to f* of that cell, 1/sr.
    /// This integrates the BSSRDF over the lit surface and averages over the tilts of the cell. α is the light's
    /// azimuth from the patch's normal; ω covers the whole hemisphere of the patch, which contains each tilt twice.
    pub(super) fn response_per_light(&self, exit: usize) -> f64 {
        let width = TAU / self.surface.azimuths as f64;
        let tilt_width = FRAC_PI_2 / self.tilts as f64;
        0.25 / (tilt_width * width * self.surface.exit.projected_solid_angle(exit))
    }
}
