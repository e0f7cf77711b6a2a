use super::{Sectors, Vec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Cells of the hemisphere about a surface's normal, uniform in polar angle and azimuth. Directions are given by their
/// (tangent, axis, normal) components; azimuth runs from the tangent towards the axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HemisphereGrid {
    theta_cells: usize,
    phi_cells: usize,
}

impl HemisphereGrid {
    /// `None` unless there is at least one polar cell and the number of azimuth cells is a positive multiple of 4, so
    /// that reversing tangent or axis maps cells to cells.
    pub fn new(theta_cells: usize, phi_cells: usize) -> Option<Self> {
        (theta_cells >= 1 && phi_cells >= 4 && phi_cells.is_multiple_of(4)).then_some(Self { theta_cells, phi_cells })
    }

    /// Number of polar cells.
    pub fn theta_cells(&self) -> usize {
        self.theta_cells
    }

    /// Number of azimuth cells.
    pub fn phi_cells(&self) -> usize {
        self.phi_cells
    }

    /// Number of all cells.
    pub fn cells(&self) -> usize {
        self.theta_cells * self.phi_cells
    }

    /// A finder for the cells of many directions.
    pub fn finder(&self) -> CellFinder {
        CellFinder {
            edges: (1..self.theta_cells)
                .map(|i| (i as f64 * FRAC_PI_2 / self.theta_cells as f64).cos())
                .collect(),
            sectors: Sectors::of_quadrants(self.phi_cells / 4),
        }
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
    /// neighbour is the opposite cell; beyond the outermost centres the value is constant.
    #[inline]
    pub fn bilinear(&self, d: &Vec3) -> Bilinear {
        let theta = d.z.clamp(0.0, 1.0).acos() / FRAC_PI_2 * self.theta_cells as f64 - 0.5;
        let phi = d.y.atan2(d.x) / TAU * self.phi_cells as f64 - 0.5;
        let (i, j) = (theta.floor(), phi.floor());
        let (wi, wj) = (theta - i, phi - j);
        let n = self.phi_cells;
        let wrap = |column: usize| if column >= n { column - n } else { column };
        // The azimuth is within ±180°.
        let first = wrap((j as isize + n as isize) as usize);
        let last = self.theta_cells - 1;
        let below_pole = i < 0.0;
        let low = if below_pole { 0 } else { (i as usize).min(last) };
        let high = ((i + 1.0) as usize).min(last);
        let turn = if below_pole { n / 2 } else { 0 };
        let places = [
            (low, wrap(first + turn)),
            (low, wrap(wrap(first + 1) + turn)),
            (high, first),
            (high, wrap(first + 1)),
        ];
        let in_tangent = |j: usize| wrap(n + n / 2 - 1 - j);
        let in_axis = |j: usize| n - 1 - j;
        Bilinear {
            cells: [
                places.map(|(i, j)| i * n + j),
                places.map(|(i, j)| i * n + in_tangent(j)),
                places.map(|(i, j)| i * n + in_axis(j)),
                places.map(|(i, j)| i * n + in_axis(in_tangent(j))),
            ],
            weights: [(1.0 - wi) * (1.0 - wj), (1.0 - wi) * wj, wi * (1.0 - wj), wi * wj],
        }
    }
}

/// Bilinear interpolation at a direction and, with the same weights, at its mirror images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bilinear {
    cells: [[usize; 4]; 4],
    weights: [f64; 4],
}

impl Bilinear {
    /// Cells around the direction with tangent and/or axis reversed, in the order of [`Self::weights`].
    #[inline]
    pub fn cells(&self, tangent: bool, axis: bool) -> &[usize; 4] {
        &self.cells[usize::from(tangent) + 2 * usize::from(axis)]
    }

    /// Weights of the four cells; they sum to 1.
    #[inline]
    pub fn weights(&self) -> &[f64; 4] {
        &self.weights
    }
}

/// Finds the cell of a direction by comparisons with the cosines and tangents of the edges.
#[derive(Clone, Debug, PartialEq)]
pub struct CellFinder {
    /// Cosines of the polar edges between the pole and the horizon.
    edges: Vec<f64>,
    sectors: Sectors,
}

impl CellFinder {
    /// Cell of a direction; below the horizon counts as on it.
    #[inline(always)]
    pub fn cell(&self, d: &Vec3) -> usize {
        let row: usize = self.edges.iter().map(|edge| usize::from(d.z < *edge)).sum();
        row * self.sectors.count() + self.sectors.sector(d.x, d.y)
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
        let finder = grid.finder();
        for cell in 0..grid.cells() {
            let d = grid.centre(cell);
            assert_eq!(finder.cell(&d), cell);
            assert_eq!(
                finder.cell(&Vec3::new(-d.x, d.y, d.z)),
                grid.mirrored(cell, true, false)
            );
            assert_eq!(
                finder.cell(&Vec3::new(-d.x, -d.y, d.z)),
                grid.mirrored(cell, true, true)
            );
            for (tangent, axis) in [(false, false), (true, false), (false, true), (true, true)] {
                let corners = grid.bilinear(&d);
                let mirrored = grid.mirrored(cell, tangent, axis);
                let here: f64 = std::iter::zip(corners.cells(tangent, axis), corners.weights())
                    .filter(|(c, _)| **c == mirrored)
                    .map(|(_, w)| w)
                    .sum();
                assert_relative_eq!(here, 1.0, epsilon = 1e-12);
            }
        }
        for d in [
            Vec3::new(0.01, 0.0, 1.0),
            Vec3::new(0.3, -0.9, 0.1),
            Vec3::new(-1.0, 0.2, 1e-6),
        ] {
            let sum: f64 = grid.bilinear(&d.normalize()).weights().iter().sum();
            assert_relative_eq!(sum, 1.0, epsilon = 1e-14);
        }
    }
}
