use crate::transport::BatchSums;
use crate::yarn::LengthSums;

/// Means over the batches and their standard errors.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TraceTable {
    pub mean: Vec<f64>,
    /// Single precision, as no more is known of an error.
    pub se: Vec<f32>,
}

impl From<BatchSums> for TraceTable {
    fn from(sums: BatchSums) -> Self {
        let se = (0..sums.sum.len()).map(|i| sums.estimate(i).se as f32).collect();
        let n = sums.batches as f64;
        let mut mean = sums.sum;
        mean.iter_mut().for_each(|sum| *sum /= n);
        Self { mean, se }
    }
}

/// f* split by path length: cell × bin × wavelength. Single precision: its rounding is far below the noise of a cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LengthTable {
    /// f* of the paths of the bin, 1/sr; the bins add to f*.
    pub mean: Vec<f32>,
    pub se: Vec<f32>,
    /// Mean of f* times path length, mm/sr.
    pub moment_mm: Vec<f32>,
}

impl From<LengthSums> for LengthTable {
    fn from(sums: LengthSums) -> Self {
        let se = (0..sums.amount.len()).map(|i| sums.estimate(i).se as f32).collect();
        let mean = |mut sums: Vec<f32>, n: u64| {
            sums.iter_mut()
                .for_each(|sum| *sum = (f64::from(*sum) / n as f64) as f32);
            sums
        };
        Self {
            mean: mean(sums.amount, sums.batches),
            se,
            moment_mm: mean(sums.moment_mm, sums.batches),
        }
    }
}
