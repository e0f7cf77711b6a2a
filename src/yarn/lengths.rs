use super::YarnError;
use super::length_range::LengthRange;
use crate::transport::Estimate;

/// Upper edges of the first bins in radii; further edges double. Most light of a dyed yarn leaves within 4 R, and its
/// path lengths cluster just below 2 R and 4 R (one and two diameters). Equal steps there reduce the re-absorption
/// error to a quarter of that with doubling steps: 0.2 % instead of 0.8 % of f* for κ_0 0.0065 → 0.004 in the dye's
/// band.
const EDGES_IN_RADII: [f64; 7] = [0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 8.0];

/// Bins of path length inside the yarn; the last bin has no upper edge.
#[derive(Clone, Debug, PartialEq)]
pub struct LengthBins {
    edges_mm: Vec<f64>,
}

impl LengthBins {
    /// Number of bins that re-absorption needs at the default study.
    pub const DEFAULT: usize = EDGES_IN_RADII.len() + 1;

    /// Bins for a yarn of a radius in mm.
    ///
    /// # Errors
    /// [`YarnError::Count`] if `bins` is below 2.
    pub fn new(radius_mm: f64, bins: usize) -> Result<Self, YarnError> {
        if bins < 2 {
            return Err(YarnError::Count {
                quantity: "path length bins",
                expected: "2 or more",
                found: bins,
            });
        }
        let last = EDGES_IN_RADII.len() - 1;
        let doubled = (1..).map(|k| EDGES_IN_RADII[last] * 2f64.powi(k));
        let edges = EDGES_IN_RADII.into_iter().chain(doubled).take(bins - 1);
        Ok(Self {
            edges_mm: edges.map(|edge| radius_mm * edge).collect(),
        })
    }

    /// Bins in equal ratios of length from `first_mm`, the upper edge of the first, to `last_mm`, the lower edge of the
    /// open last one.
    ///
    /// # Errors
    /// [`YarnError::Reabsorption`] if the edges are not positive and ascending.
    pub fn logarithmic(first_mm: f64, last_mm: f64, bins: usize) -> Result<Self, YarnError> {
        let steps = bins.saturating_sub(2).max(1) as f64;
        let ratio = last_mm / first_mm;
        let edges = (0..bins.saturating_sub(1)).map(|k| first_mm * ratio.powf(k as f64 / steps));
        Self::from_edges(edges.collect())
    }

    /// Bins from the upper edge of every bin but the last, mm.
    ///
    /// # Errors
    /// [`YarnError::Reabsorption`] if the edges are not positive and ascending.
    pub fn from_edges(edges_mm: Vec<f64>) -> Result<Self, YarnError> {
        if !edges_mm.is_sorted_by(|a, b| a < b) || edges_mm.first().is_none_or(|&first| first.is_nan() || first <= 0.0)
        {
            return Err(YarnError::Reabsorption {
                quantity: "edges of the path length bins in mm",
                expected: "ascending ones above 0".into(),
                found: format!("{edges_mm:?}"),
            });
        }
        Ok(Self { edges_mm })
    }

    /// Upper edge of every bin but the last, mm.
    pub fn edges_mm(&self) -> &[f64] {
        &self.edges_mm
    }

    /// Number of bins, the open one included.
    pub fn bins(&self) -> usize {
        self.edges_mm.len() + 1
    }

    /// Index of the bin of a path length in mm.
    #[inline]
    pub fn bin(&self, length_mm: f64) -> usize {
        self.edges_mm.iter().map(|&edge| usize::from(length_mm >= edge)).sum()
    }

    /// Lengths that a bin holds.
    pub(super) fn range(&self, bin: usize) -> LengthRange {
        let low_mm = if bin == 0 { 0.0 } else { self.edges_mm[bin - 1] };
        LengthRange {
            low_mm,
            width_mm: self.edges_mm.get(bin).map(|edge| edge - low_mm),
        }
    }

    /// Mean of exp(−μ L) over the lengths L of a bin with the mean `mean_mm`, for an absorption of μ in 1/mm.
    pub fn transmittance(&self, bin: usize, mean_mm: f64, mu_per_mm: f64) -> f64 {
        self.range(bin).tilt(mean_mm, mu_per_mm, 1.0).factor
    }
}

/// A table split by path length: for each cell, bin and wavelength (fastest) the amount, and the amount times path
/// length in mm. Single precision: its rounding is far below the noise of a cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LengthTally {
    pub amount: Vec<f32>,
    pub moment_mm: Vec<f32>,
}

/// Sums over batches of tallies by path length, in the order of the batches: Σ x and Σ x² of the amount, and Σ of its
/// moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LengthSums {
    pub batches: u64,
    pub amount: Vec<f32>,
    pub square: Vec<f32>,
    pub moment_mm: Vec<f32>,
}

impl LengthSums {
    /// Empty sums for a number of values.
    pub fn zeros(values: usize) -> Self {
        Self {
            batches: 0,
            amount: vec![0.0; values],
            square: vec![0.0; values],
            moment_mm: vec![0.0; values],
        }
    }

    /// Adds one batch.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn length_lies_between_the_edges_of_its_bin() {
        let bins = LengthBins::new(0.15, LengthBins::DEFAULT + 2).unwrap();
        assert!(bins.edges_mm().is_sorted() && bins.bins() == 10);
        assert_eq!(bins.edges_mm()[8], 32.0 * 0.15);
        for (bin, edge) in bins.edges_mm().iter().enumerate() {
            assert_eq!([bins.bin(0.999 * edge), bins.bin(*edge)], [bin, bin + 1]);
        }
        assert!(LengthBins::new(0.15, 1).is_err());
    }
}
