//! Phase functions: density of the scattered direction over the sphere (1/sr, integral 1), with exact sampling.

use crate::fault::{self, Fault};
use std::f64::consts::PI;

/// Invalid phase function.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PhaseError {
    #[error("the phase function at cos θ = {cos_theta} is {found}; expected a finite value ≥ 0, 1/sr")]
    NotADensity { cos_theta: f64, found: f64 },
    #[error("a phase table needs at least 3 nodes, found {found}")]
    TooFewNodes { found: usize },
    #[error("the asymmetry of a Henyey–Greenstein phase function lies between -1 and 1 (exclusive), found {found}")]
    Asymmetry { found: f64 },
}

/// Density tabulated at nodes uniform in sin(θ/2), where both a forward peak and the rest are well resolved, and linear
/// in cos θ between them: normalisation, asymmetry and inverse CDF of the table are then exact.
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseTable {
    /// p at node k, 1/sr; node 0 is forward.
    density: Vec<f64>,
    /// Probability of scattering into the nodes before k.
    cumulative: Vec<f64>,
    /// First interval that can hold the CDF value j/guide.len().
    guide: Vec<u32>,
    g: f64,
}

/// cos θ of node k of n: 1 − 2 sin²(θ/2).
fn node_cosine(k: usize, nodes: usize) -> f64 {
    let t = k as f64 / (nodes - 1) as f64;
    1.0 - 2.0 * t * t
}

impl PhaseTable {
    /// Tabulates a positive multiple of the density, `f(cos θ)`, at `nodes` points and normalises it.
    pub fn from_density(nodes: usize, f: impl Fn(f64) -> f64) -> Result<Self, PhaseError> {
        if nodes < 3 {
            return Err(PhaseError::TooFewNodes { found: nodes });
        }
        let cosines: Vec<f64> = (0..nodes).map(|k| node_cosine(k, nodes)).collect();
        let mut density: Vec<f64> = cosines.iter().map(|&c| f(c)).collect();
        for (&cos_theta, &found) in cosines.iter().zip(&density) {
            if !found.is_finite() || found < 0.0 {
                return Err(PhaseError::NotADensity { cos_theta, found });
            }
        }
        let interval = |p: &[f64], k: usize| PI * (p[k] + p[k + 1]) * (cosines[k] - cosines[k + 1]);
        let total: f64 = (0..nodes - 1).map(|k| interval(&density, k)).sum();
        if !(total > 0.0 && total.is_finite()) {
            return Err(PhaseError::NotADensity {
                cos_theta: 1.0,
                found: total,
            });
        }
        density.iter_mut().for_each(|p| *p /= total);
        let mut cumulative = Vec::with_capacity(nodes);
        let mut sum = 0.0;
        let mut g = 0.0;
        for k in 0..nodes - 1 {
            cumulative.push(sum);
            sum += interval(&density, k);
            // ∫ p μ dμ of a linear p over the interval, times 2π.
            let (a, b) = (cosines[k + 1], cosines[k]);
            g += PI * (b - a) / 3.0 * (density[k] * (2.0 * b + a) + density[k + 1] * (2.0 * a + b));
        }
        cumulative.push(1.0);
        let mut guide = Vec::with_capacity(nodes);
        let mut k = 0;
        for j in 0..nodes {
            while k + 2 < nodes && cumulative[k + 1] <= j as f64 / nodes as f64 {
                k += 1;
            }
            guide.push(k as u32);
        }
        if fault::active(Fault::PhaseBin) {
            density.rotate_right(1);
        }
        Ok(Self {
            density,
            cumulative,
            guide,
            g,
        })
    }

    /// Density at cos θ, 1/sr.
    #[inline]
    pub fn pdf(&self, cos_theta: f64) -> f64 {
        let nodes = self.density.len();
        let t = (0.5 * (1.0 - cos_theta)).max(0.0).sqrt();
        let k = ((t * (nodes - 1) as f64) as usize).min(nodes - 2);
        let (c0, c1) = (node_cosine(k, nodes), node_cosine(k + 1, nodes));
        let w = (c0 - cos_theta) / (c0 - c1);
        self.density[k] + w * (self.density[k + 1] - self.density[k])
    }

    /// cos θ at the CDF value `u` in 0..1, counted from the forward direction.
    #[inline]
    pub fn sample(&self, u: f64) -> f64 {
        let nodes = self.density.len();
        let mut k = self.guide[((u * nodes as f64) as usize).min(nodes - 1)] as usize;
        while k + 2 < nodes && self.cumulative[k + 1] <= u {
            k += 1;
        }
        let (c0, c1) = (node_cosine(k, nodes), node_cosine(k + 1, nodes));
        let (p0, p1) = (self.density[k], self.density[k + 1]);
        let rest = (u - self.cumulative[k]) / (2.0 * PI);
        let slope = (p1 - p0) / (c0 - c1);
        let root = (p0 * p0 + 2.0 * slope * rest).max(0.0).sqrt();
        let step = if p0 + root > 0.0 { 2.0 * rest / (p0 + root) } else { 0.0 };
        (c0 - step).max(c1)
    }

    /// Mean cosine of the table itself.
    pub fn g(&self) -> f64 {
        self.g
    }

    /// Density at the nodes, forward first, 1/sr.
    pub fn density(&self) -> &[f64] {
        &self.density
    }
}

/// Henyey & Greenstein 1941: p = (1 − g²) / (4π (1 + g² − 2 g cos θ)^{3/2}).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HenyeyGreenstein {
    g: f64,
}

impl HenyeyGreenstein {
    pub fn new(g: f64) -> Result<Self, PhaseError> {
        if g > -1.0 && g < 1.0 {
            Ok(Self { g })
        } else {
            Err(PhaseError::Asymmetry { found: g })
        }
    }
}

/// Phase functions supported by the tracer.
#[derive(Clone, Debug, PartialEq)]
pub enum Phase {
    Table(PhaseTable),
    HenyeyGreenstein(HenyeyGreenstein),
}

impl Phase {
    /// Density at cos θ, 1/sr.
    #[inline]
    pub fn pdf(&self, cos_theta: f64) -> f64 {
        match self {
            Self::Table(table) => table.pdf(cos_theta),
            Self::HenyeyGreenstein(HenyeyGreenstein { g }) => {
                (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cos_theta).powf(1.5))
            }
        }
    }

    /// cos θ at the CDF value `u` in 0..1.
    #[inline]
    pub fn sample(&self, u: f64) -> f64 {
        match self {
            Self::Table(table) => table.sample(u),
            Self::HenyeyGreenstein(HenyeyGreenstein { g }) => {
                if g.abs() < 1e-6 {
                    // First order in g of the inverse below, which cancels here.
                    let c = 1.0 - 2.0 * u;
                    return (c + 1.5 * g * (1.0 - c * c)).clamp(-1.0, 1.0);
                }
                // The CDF from the forward direction is the one from backward at 1 − u.
                let f = (1.0 - g * g) / (1.0 + g - 2.0 * g * u);
                ((1.0 + g * g - f * f) / (2.0 * g)).clamp(-1.0, 1.0)
            }
        }
    }

    /// Mean cosine of the scattering angle.
    pub fn g(&self) -> f64 {
        match self {
            Self::Table(table) => table.g(),
            Self::HenyeyGreenstein(hg) => hg.g,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn phases() -> Vec<Phase> {
        let hg = |g| Phase::HenyeyGreenstein(HenyeyGreenstein::new(g).unwrap());
        let table = PhaseTable::from_density(181, |c| 0.2 + (1.0 + c).powi(2)).unwrap();
        vec![Phase::Table(table), hg(0.9), hg(0.0), hg(1e-7), hg(-0.4)]
    }

    /// The inverse of the sampler is the integral of the density: du/dcosθ = −2π p, checked by the midpoint rule.
    #[test]
    fn sampler_inverts_the_cdf_of_the_density() {
        for phase in phases() {
            let n = 200_000;
            let mut u = 0.0;
            let mut worst: f64 = 0.0;
            for i in 0..n {
                let (hi, lo) = (1.0 - 2.0 * i as f64 / n as f64, 1.0 - 2.0 * (i + 1) as f64 / n as f64);
                u += 2.0 * PI * phase.pdf(0.5 * (hi + lo)) * (hi - lo);
                worst = worst.max((phase.sample(u.min(1.0)) - lo).abs());
            }
            assert_relative_eq!(u, 1.0, epsilon = 1e-6);
            assert!(worst < 1e-3 && phase.sample(0.0) > 1.0 - 1e-9, "{phase:?}: {worst}");
        }
    }

    #[test]
    fn mean_cosine_of_the_samples_is_g() {
        for phase in phases() {
            let n = 200_000;
            let mean = (0..n).map(|i| phase.sample((i as f64 + 0.5) / n as f64)).sum::<f64>() / n as f64;
            assert_relative_eq!(mean, phase.g(), epsilon = 1e-8);
        }
    }

    #[test]
    fn refuses_what_is_no_density() {
        assert!(PhaseTable::from_density(181, |c| c).is_err());
        assert!(PhaseTable::from_density(181, |_| 0.0).is_err());
        assert!(PhaseTable::from_density(181, |_| f64::NAN).is_err());
        assert!(PhaseTable::from_density(2, |_| 1.0).is_err());
        assert!(HenyeyGreenstein::new(1.0).is_err());
    }
}
