use super::Vec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Cells of the hemisphere about a surface's normal, even in polar angle and azimuth. Directions are given by their
/// (tangent, axis, normal) components; azimuth runs from the tangent towards the axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HemisphereGrid {
    theta_cells: usize,
    phi_cells: usize,
}

impl HemisphereGrid {
    /// At least one polar cell and four azimuths, a multiple of four: mirroring tangent or axis maps cells on cells.
    pub fn new(theta_cells: usize, phi_cells: usize) -> Option<Self> {
        (theta_cells >= 1 && phi_cells >= 4 && phi_cells.is_multiple_of(4)).then_some(Self { theta_cells, phi_cells })
    }

    pub fn theta_cells(&self) -> usize {
        self.theta_cells
    }

    pub fn phi_cells(&self) -> usize {
        self.phi_cells
    }

    pub fn cells(&self) -> usize {
        self.theta_cells * self.phi_cells
    }

    /// Cell of a direction; below the horizon counts as on it.
    #[inline]
    pub fn cell(&self, d: &Vec3) -> usize {
        let theta = d.z.clamp(0.0, 1.0).acos() / FRAC_PI_2 * self.theta_cells as f64;
        let phi = d.y.atan2(d.x) / TAU * self.phi_cells as f64;
        let i = (theta as usize).min(self.theta_cells - 1);
        let j = (phi.floor() as isize).rem_euclid(self.phi_cells as isize) as usize;
        i * self.phi_cells + j
    }

    /// Direction of the middle of a cell.
    pub fn centre(&self, cell: usize) -> Vec3 {
        let theta = ((cell / self.phi_cells) as f64 + 0.5) * FRAC_PI_2 / self.theta_cells as f64;
        let phi = ((cell % self.phi_cells) as f64 + 0.5) * TAU / self.phi_cells as f64;
        Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    }

    /// ∫ cos θ dω over the cell, sr; the cells add to π.
    pub fn projected_solid_angle(&self, cell: usize) -> f64 {
        let edge = |i: usize| (i as f64 * FRAC_PI_2 / self.theta_cells as f64).sin().powi(2);
        let i = cell / self.phi_cells;
        (edge(i + 1) - edge(i)) * PI / self.phi_cells as f64
    }

    /// The cell with tangent and/or axis reversed.
    #[inline]
    pub fn mirrored(&self, cell: usize, tangent: bool, axis: bool) -> usize {
        let (i, mut j) = (cell / self.phi_cells, cell % self.phi_cells);
        if tangent {
            j = (self.phi_cells + self.phi_cells / 2 - 1 - j) % self.phi_cells;
        }
        if axis {
            j = self.phi_cells - 1 - j;
        }
        i * self.phi_cells + j
    }

    /// The four cells between whose centres a direction lies, with bilinear weights that sum to 1. Across the pole the
    /// neighbour is the cell opposite; beyond the outermost centres the value stays what it is there.
    #[inline]
    pub fn bilinear(&self, d: &Vec3) -> [(usize, f64); 4] {
        let theta = d.z.clamp(0.0, 1.0).acos() / FRAC_PI_2 * self.theta_cells as f64 - 0.5;
        let phi = d.y.atan2(d.x) / TAU * self.phi_cells as f64 - 0.5;
        let (i, j) = (theta.floor(), phi.floor());
        let (wi, wj) = (theta - i, phi - j);
        let column = |offset: isize, row_below_pole: bool| {
            let turn = if row_below_pole { self.phi_cells as isize / 2 } else { 0 };
            (j as isize + offset + turn).rem_euclid(self.phi_cells as isize) as usize
        };
        let last = self.theta_cells - 1;
        let below_pole = i < 0.0;
        let low = if below_pole { 0 } else { (i as usize).min(last) };
        let high = ((i + 1.0) as usize).min(last);
        [
            (low * self.phi_cells + column(0, below_pole), (1.0 - wi) * (1.0 - wj)),
            (low * self.phi_cells + column(1, below_pole), (1.0 - wi) * wj),
            (high * self.phi_cells + column(0, false), wi * (1.0 - wj)),
            (high * self.phi_cells + column(1, false), wi * wj),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn projected_solid_angles_add_to_pi() {
        let grid = HemisphereGrid::new(9, 24).unwrap();
        let sum: f64 = (0..grid.cells()).map(|c| grid.projected_solid_angle(c)).sum();
        assert_relative_eq!(sum, PI, epsilon = 1e-14);
        assert!(HemisphereGrid::new(0, 8).is_none() && HemisphereGrid::new(3, 6).is_none());
    }

    #[test]
    fn centres_mirrors_and_weights_agree() {
        let grid = HemisphereGrid::new(7, 12).unwrap();
        for cell in 0..grid.cells() {
            let d = grid.centre(cell);
            assert_eq!(grid.cell(&d), cell);
            assert_eq!(grid.cell(&Vec3::new(-d.x, d.y, d.z)), grid.mirrored(cell, true, false));
            assert_eq!(grid.cell(&Vec3::new(-d.x, -d.y, d.z)), grid.mirrored(cell, true, true));
            let here: f64 = grid
                .bilinear(&d)
                .iter()
                .filter(|(c, _)| *c == cell)
                .map(|(_, w)| w)
                .sum();
            assert_relative_eq!(here, 1.0, epsilon = 1e-12);
        }
        for d in [
            Vec3::new(0.01, 0.0, 1.0),
            Vec3::new(0.3, -0.9, 0.1),
            Vec3::new(-1.0, 0.2, 1e-6),
        ] {
            let sum: f64 = grid.bilinear(&d.normalize()).iter().map(|(_, w)| w).sum();
            assert_relative_eq!(sum, 1.0, epsilon = 1e-14);
        }
    }
}
