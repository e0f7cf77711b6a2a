use super::{SurfaceGrid, YarnError};
use crate::fault::{self, Fault};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Axes of a yarn response. By the cylinder's symmetry f*(ω_in, ω_out) depends on the light's tilt out of the
/// yarn's normal plane, on the azimuth of the surface point from the light, and on ω_out; both mirrors fold the table
/// to tilts 0..90° and azimuths 0..180°. All axes are cells, and a table holds means over them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct YarnResponseGrid {
    tilts: usize,
    surface: SurfaceGrid,
}

pub(super) const ENTRIES: usize = 9;

impl YarnResponseGrid {
    /// `tilts` is 1 or more.
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

    /// Cells of a quarter of the section, from the light's meridian to where the light grazes: light comes in at one of them or
    /// at its mirror image. They are 10° wide whatever the grid: a yarn's light between yarns is the same with narrower ones.
    pub fn entries(&self) -> usize {
        ENTRIES
    }

    /// Azimuths from the light's meridian between which entry cell k lies, radians.
    pub fn entry_edges(&self, k: usize) -> [f64; 2] {
        [k, k + 1].map(|edge| edge as f64 * FRAC_PI_2 / self.entries() as f64)
    }

    /// Cells of a table of where light that came in at one place of the section leaves: (tilt, entry, side, azimuth).
    pub fn transfer_cells(&self) -> usize {
        self.tilts * self.entries() * 2 * self.azimuths()
    }

    /// Number of the transfer cell (tilt, entry, side, azimuth): light that leaves on the `opposite` side of the light's meridian or on its own.
    pub fn transfer_cell(&self, tilt: usize, entry: usize, opposite: bool, azimuth: usize) -> usize {
        ((tilt * self.entries() + entry) * 2 + usize::from(opposite)) * self.azimuths() + azimuth
    }

    /// Middle of tilt cell k, radians.
    pub fn tilt(&self, k: usize) -> f64 {
        (k as f64 + 0.5) * FRAC_PI_2 / self.tilts as f64
    }

    /// Tilts between which cell k lies, radians.
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

    /// f* in a cell per fraction of the flux of all light of the tilt's cell that leaves through it, 1/sr: radiance of the
    /// cell over irradiance normal to the beam, for flux 2R cos ψ per length of yarn and both mirror images of the
    /// cell, 2 RΔφ long.
    pub fn response_per_fraction(&self, tilt: usize, exit: usize) -> f64 {
        let width = TAU / self.surface.azimuths as f64;
        let cosine = match fault::active(Fault::FactorOverCosine) {
            true => 1.0,
            false => self.mean_cosine(tilt),
        };
        cosine / (width * self.surface.exit.projected_solid_angle(exit))
    }

    /// Of all light of the tilt's cell, the fraction per ∫∫ (fraction of the flux on a patch) cos α dω, as in
    /// [`Self::response_per_light`].
    pub(super) fn fraction_per_light(&self, tilt: usize) -> f64 {
        let tilt_width = FRAC_PI_2 / self.tilts as f64;
        0.25 / (tilt_width * self.mean_cosine(tilt))
    }

    /// f* in a cell per ∫∫ (fraction of the flux on a patch that leaves through it) cos α dω, 1/sr: the sum of the BSSRDF
    /// over the lit surface, mean over the tilts of the cell. α is the light's azimuth from the patch's normal, and ω runs over
    /// the whole hemisphere of the patch, which holds each tilt twice.
    pub(super) fn response_per_light(&self, exit: usize) -> f64 {
        let width = TAU / self.surface.azimuths as f64;
        let tilt_width = FRAC_PI_2 / self.tilts as f64;
        0.25 / (tilt_width * width * self.surface.exit.projected_solid_angle(exit))
    }
}
