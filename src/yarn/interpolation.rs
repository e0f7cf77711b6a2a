use super::YarnResponseGrid;
use crate::fault::{self, Fault};
use crate::geometry::{Bilinear, Vec3};
use std::f64::consts::{FRAC_PI_2, PI};
use std::iter::zip;

/// Multilinear interpolation of f* between the nodes of its grid.
pub(super) struct Interpolation {
    grid: YarnResponseGrid,
    /// 1/cos ψ of the grid's tilts.
    tilt_secants: Vec<f64>,
}

impl Interpolation {
    pub fn new(grid: YarnResponseGrid) -> Self {
        Self {
            tilt_secants: (0..grid.tilts()).map(|k| 1.0 / grid.mean_cosine(k)).collect(),
            grid,
        }
    }

    /// Passes cells and weights to `add` such that f* = Σ weight · table. `omega_in` is the local direction (tangent,
    /// axis, normal) towards the light, anywhere on the sphere; `seen` is the view direction on the exit grid. Between
    /// tilts, f*/cos ψ is interpolated linearly.
    #[inline(always)]
    pub fn spread(&self, omega_in: &Vec3, seen: &Bilinear, mut add: impl FnMut(usize, f64)) {
        let sin_tilt = omega_in.y.abs().min(1.0);
        let axis_reversed = omega_in.y < 0.0 && !fault::active(Fault::AxisMirror);
        // Azimuth of the point from the light.
        let sign = if fault::active(Fault::AzimuthSign) { 1.0 } else { -1.0 };
        let azimuth = sign * omega_in.x.atan2(omega_in.z);
        let tangent_reversed = azimuth < 0.0;
        // Positions between nodes, counted from one node before the first.
        let (tilts, azimuths) = (self.grid.tilts(), self.grid.azimuths());
        let steps =
            sin_tilt.asin() / FRAC_PI_2 * tilts as f64 + if fault::active(Fault::TiltHalfCell) { 1.0 } else { 0.5 };
        let from_first = azimuth.abs() / PI * azimuths as f64 + 0.5;
        let cos_tilt = (1.0 - sin_tilt * sin_tilt).sqrt();
        let (low, near) = (steps as usize, from_first as usize);
        let (wt, wa) = (steps - low as f64, from_first - near as f64);
        for (k, weight_k) in [(low, 1.0 - wt), (low + 1, wt)] {
            // The node before the first is the mirror image of the first.
            let mirror_axis = axis_reversed != (k == 0);
            let node = k.clamp(1, tilts) - 1;
            let weight_k = weight_k * cos_tilt * self.tilt_secants[node];
            for (a, weight_a) in [(near, 1.0 - wa), (near + 1, wa)] {
                let beyond = a == 0 || a > azimuths;
                let mirror_tangent = tangent_reversed != beyond;
                let row = self.grid.cell(node, a.clamp(1, azimuths) - 1, 0);
                let weight = weight_k * weight_a;
                for (exit, weight_e) in zip(seen.cells(mirror_tangent, mirror_axis), seen.weights()) {
                    add(row + exit, weight * weight_e);
                }
            }
        }
    }
}
