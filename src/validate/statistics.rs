use super::Check;
use crate::transport::Estimate;

/// Rounding of the printed references, which are fractions of 1.
const ROUNDING: f64 = 1e-11;

/// One estimate for each element of the batches' vectors.
pub(super) fn estimates(batches: &[Vec<f64>]) -> Vec<Estimate> {
    let places = batches.first().map_or(0, Vec::len);
    (0..places)
        .map(|i| Estimate::from_batches(batches.iter().map(|b| b[i])))
        .collect()
}

/// Difference from a reference in standard errors of both.
fn deviation(estimate: Estimate, reference: Estimate) -> f64 {
    (estimate.value - reference.value) / (estimate.se.powi(2) + reference.se.powi(2) + ROUNDING * ROUNDING).sqrt()
}

pub(super) fn check(estimate: Estimate, problem: String, quantity: &str, reference: Estimate) -> Check {
    Check {
        problem,
        quantity: quantity.to_owned(),
        value: estimate.value,
        se: estimate.se,
        reference: reference.value,
        reference_se: reference.se,
        z: deviation(estimate, reference),
    }
}

/// Joint test of all bins of a histogram: χ² of their deviations, compared with the number of bins.
pub(super) fn joint(problem: String, quantity: &str, values: &[Estimate], references: &[Estimate]) -> Check {
    let chi2: f64 = values
        .iter()
        .zip(references)
        .map(|(&value, &reference)| deviation(value, reference).powi(2))
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

    /// χ² of 36 bins exceeds 67.985 with probability 1e-3, which corresponds to a normal deviate of 3.0902.
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
