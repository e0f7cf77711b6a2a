use super::Check;

/// Rounding of the printed references, of fractions of 1.
const ROUNDING: f64 = 1e-11;

/// Mean of batches and its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Estimate {
    pub value: f64,
    pub se: f64,
}

impl Estimate {
    /// One estimate for each place of the batches' vectors, which are summed in their order.
    pub fn from_batches(batches: &[Vec<f64>]) -> Vec<Self> {
        let n = batches.len() as f64;
        let places = batches.first().map_or(0, Vec::len);
        (0..places)
            .map(|i| {
                let value = batches.iter().map(|b| b[i]).sum::<f64>() / n;
                let squares: f64 = batches.iter().map(|b| (b[i] - value).powi(2)).sum();
                Self {
                    value,
                    se: (squares / (n * (n - 1.0))).sqrt(),
                }
            })
            .collect()
    }

    /// Difference from a reference in standard errors of both.
    pub fn deviation(&self, reference: Self) -> f64 {
        (self.value - reference.value) / (self.se.powi(2) + reference.se.powi(2) + ROUNDING * ROUNDING).sqrt()
    }

    pub fn check(&self, problem: String, quantity: &str, reference: Self) -> Check {
        Check {
            problem,
            quantity: quantity.to_owned(),
            value: self.value,
            se: self.se,
            reference: reference.value,
            reference_se: reference.se,
            z: self.deviation(reference),
        }
    }
}

/// All bins of a histogram together: χ² of their deviations against the number of bins.
pub(super) fn joint(problem: String, quantity: &str, values: &[Estimate], references: &[Estimate]) -> Check {
    let chi2: f64 = values
        .iter()
        .zip(references)
        .map(|(value, &reference)| value.deviation(reference).powi(2))
        .sum();
    let bins = references.len() as f64;
    let spread = 2.0 / (9.0 * bins);
    Check {
        problem,
        quantity: quantity.to_owned(),
        value: chi2,
        se: (2.0 * bins).sqrt(),
        reference: bins,
        reference_se: 0.0,
        z: ((chi2 / bins).cbrt() - (1.0 - spread)) / spread.sqrt(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn mean_and_standard_error_of_batches() {
        let found = Estimate::from_batches(&[vec![1.0, 5.0], vec![2.0, 5.0], vec![6.0, 5.0]]);
        assert_relative_eq!(found[0].value, 3.0);
        assert_relative_eq!(found[0].se, (14.0f64 / 6.0).sqrt(), epsilon = 1e-15);
        assert_eq!(found[1], Estimate { value: 5.0, se: 0.0 });
    }

    /// 67.985 is the point χ² of 36 bins exceeds with probability 1e-3, where the normal deviate is 3.0902.
    #[test]
    fn joint_deviate_has_the_tail_of_chi_squared() {
        let zero = Estimate { value: 0.0, se: 1.0 };
        let off = Estimate {
            value: (67.985f64 / 36.0).sqrt(),
            se: 0.0,
        };
        let check = joint(String::new(), "", &[off; 36], &[zero; 36]);
        assert_relative_eq!(check.value, 67.985, epsilon = 1e-9);
        assert_relative_eq!(check.z, 3.0902, epsilon = 0.01);
    }
}
