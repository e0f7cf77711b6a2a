use super::interpolation::Interpolation;
use super::{YarnResponse, YarnResponseGrid};
use crate::geometry::{Bilinear, Vec3};
use std::iter::zip;

/// Weights of the cells of a yarn response whose weighted sum is a mean of f* over many pairs of directions. They
/// depend on directions only, not on wavelength, medium or f*, so they apply to any response on the same grid.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseWeights {
    /// Indices of the cells, ascending.
    cells: Vec<u32>,
    weights: Vec<f64>,
}

impl ResponseWeights {
    /// Σ weight · f* at every wavelength, 1/sr, in the order of the cells.
    pub fn contract(&self, response: &YarnResponse) -> Vec<f64> {
        let (values, wavelengths) = (response.values(), response.wavelengths());
        let mut sum = vec![0.0; wavelengths];
        for (&cell, weight) in zip(&self.cells, &self.weights) {
            let row = &values[cell as usize * wavelengths..][..wavelengths];
            sum.iter_mut().zip(row).for_each(|(s, f)| *s += weight * f);
        }
        sum
    }
}

/// Accumulates, cell by cell, the interpolation weights of f* at many pairs of directions.
pub struct WeightTally {
    interpolation: Interpolation,
    weights: Vec<f64>,
    /// One bit for each cell: set once the cell has a weight.
    touched: Vec<u64>,
}

impl WeightTally {
    /// An empty tally on a grid.
    pub fn new(grid: YarnResponseGrid) -> Self {
        Self {
            interpolation: Interpolation::new(grid),
            weights: vec![0.0; grid.cells()],
            touched: vec![0; grid.cells().div_ceil(64)],
        }
    }

    /// Adds the weights of a pair of directions: `omega_in` in the local frame of [`YarnResponse::eval`], and the view
    /// direction as `seen` on the exit grid.
    #[inline]
    pub fn add(&mut self, omega_in: &Vec3, seen: &Bilinear) {
        let (weights, touched) = (&mut self.weights, &mut self.touched);
        self.interpolation.spread(omega_in, seen, |cell, weight| {
            weights[cell] += weight;
            touched[cell / 64] |= 1 << (cell % 64);
        });
    }

    /// Returns the sums times `factor` and empties the tally.
    pub fn drain(&mut self, factor: f64) -> ResponseWeights {
        let count = self.touched.iter().map(|bits| bits.count_ones() as usize).sum();
        let mut cells = Vec::with_capacity(count);
        let mut weights = Vec::with_capacity(count);
        for (place, bits) in self.touched.iter_mut().enumerate() {
            while *bits != 0 {
                let cell = place * 64 + bits.trailing_zeros() as usize;
                *bits &= *bits - 1;
                cells.push(cell as u32);
                weights.push(factor * std::mem::take(&mut self.weights[cell]));
            }
        }
        ResponseWeights { cells, weights }
    }
}
