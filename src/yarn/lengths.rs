use super::YarnError;
use crate::transport::Estimate;

/// Bins of the length of a path inside the yarn. The first reaches to the radius, each next one twice as far, the last has
/// no end.
#[derive(Clone, Debug, PartialEq)]
pub struct LengthBins {
    edges_mm: Vec<f64>,
}

impl LengthBins {
    pub fn new(radius_mm: f64, bins: usize) -> Result<Self, YarnError> {
        if bins < 2 {
            return Err(YarnError::Count {
                quantity: "path length bins",
                expected: "2 or more",
                found: bins,
            });
        }
        Ok(Self {
            edges_mm: (0..bins as i32 - 1).map(|k| radius_mm * 2f64.powi(k)).collect(),
        })
    }

    /// Upper edge of every bin but the last, mm.
    pub fn edges_mm(&self) -> &[f64] {
        &self.edges_mm
    }

    pub fn bins(&self) -> usize {
        self.edges_mm.len() + 1
    }

    #[inline]
    pub fn bin(&self, length_mm: f64) -> usize {
        self.edges_mm.iter().map(|&edge| usize::from(length_mm >= edge)).sum()
    }
}

/// What a table holds, split by path length: for each cell, bin and wavelength (fastest) the amount, and the amount
/// times path length in mm. Single precision: its rounding is far below the noise of a cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LengthTally {
    pub amount: Vec<f32>,
    pub moment_mm: Vec<f32>,
}

/// Tallies by path length added up batch by batch, in their order: Σ x, Σ x² of the amount, Σ of its moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LengthSums {
    pub batches: u64,
    pub amount: Vec<f32>,
    pub square: Vec<f32>,
    pub moment_mm: Vec<f32>,
}

impl LengthSums {
    pub fn zeros(values: usize) -> Self {
        Self {
            batches: 0,
            amount: vec![0.0; values],
            square: vec![0.0; values],
            moment_mm: vec![0.0; values],
        }
    }

    /// Adds one batch, as many values as there are.
    pub fn add(&mut self, batch: &LengthTally) {
        self.batches += 1;
        let moments = self.moment_mm.iter_mut().zip(&batch.moment_mm);
        moments.for_each(|(sum, x)| *sum += x);
        for ((sum, square), x) in self.amount.iter_mut().zip(&mut self.square).zip(&batch.amount) {
            *sum += x;
            *square += x * x;
        }
    }

    /// Mean amount of value i and its standard error, 0 for one batch.
    pub fn estimate(&self, i: usize) -> Estimate {
        Estimate::from_sums(self.batches, self.amount[i].into(), self.square[i].into())
    }
}
