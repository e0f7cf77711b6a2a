use crate::fault::{self, Fault};

/// A mean and its standard error, in the same unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Estimate {
    pub value: f64,
    pub se: f64,
}

impl Estimate {
    /// Mean of equally weighted batches, summed in their order, and the standard error of that mean; 0 for one batch.
    pub fn from_batches(batches: impl ExactSizeIterator<Item = f64> + Clone) -> Self {
        let n = batches.len() as f64;
        // A sum of zeros can be −0; adding 0 makes it +0.
        let value = batches.clone().sum::<f64>() / n + 0.0;
        let square: f64 = batches.map(|x| (x - value) * (x - value)).sum();
        Self {
            value,
            se: if n > 1.0 {
                errors() * (square / (n * (n - 1.0))).sqrt()
            } else {
                0.0
            },
        }
    }

    /// The same as [`Self::from_batches`], from Σ x and Σ x² over a number of batches.
    pub fn from_sums(batches: u64, sum: f64, square: f64) -> Self {
        let n = batches as f64;
        let value = sum / n + 0.0;
        let spread = (square / n - value * value).max(0.0);
        Self {
            value,
            se: if n > 1.0 {
                errors() * (spread / (n - 1.0)).sqrt()
            } else {
                0.0
            },
        }
    }
}

/// Factor on standard errors: 1 unless the fault [`Fault::ErrorsHalved`] is injected.
fn errors() -> f64 {
    if fault::active(Fault::ErrorsHalved) { 0.5 } else { 1.0 }
}

/// Σ x and Σ x² over batches for each of many values; memory does not grow with the number of batches. Add batches in
/// their order, so that the same batches give the same bits.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BatchSums {
    pub batches: u64,
    pub sum: Vec<f64>,
    pub square: Vec<f64>,
}

impl BatchSums {
    /// Empty sums for a number of values.
    pub fn zeros(values: usize) -> Self {
        Self {
            batches: 0,
            sum: vec![0.0; values],
            square: vec![0.0; values],
        }
    }

    /// Adds one batch, which holds one number for each value.
    pub fn add<T: Copy + Into<f64>>(&mut self, batch: &[T]) {
        self.batches += 1;
        for ((sum, square), x) in self.sum.iter_mut().zip(&mut self.square).zip(batch) {
            let x: f64 = (*x).into();
            *sum += x;
            *square += x * x;
        }
    }

    /// Mean of value i and its standard error, 0 for one batch.
    pub fn estimate(&self, i: usize) -> Estimate {
        Estimate::from_sums(self.batches, self.sum[i], self.square[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn estimates_from_batches_and_from_their_sums_agree() {
        let batches = [1.0, 2.0, 6.0];
        let kept = Estimate::from_batches(batches.iter().copied());
        let mut sums = BatchSums::zeros(2);
        batches.iter().for_each(|&x| sums.add(&[x, 5.0]));
        assert_relative_eq!(kept.value, 3.0);
        assert_relative_eq!(kept.se, (14.0f64 / 6.0).sqrt(), epsilon = 1e-15);
        assert_relative_eq!(sums.estimate(0).value, kept.value, epsilon = 1e-15);
        assert_relative_eq!(sums.estimate(0).se, kept.se, epsilon = 1e-14);
        assert_eq!(sums.estimate(1), Estimate { value: 5.0, se: 0.0 });
    }
}
