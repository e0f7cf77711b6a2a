/// Range of lengths of a bin, mm; the last bin has no width.
#[derive(Clone, Copy, Debug)]
pub(super) struct LengthRange {
    pub low_mm: f64,
    pub width_mm: Option<f64>,
}

/// A bin after exp(−Δμ L).
pub(super) struct Tilted {
    /// Mean of exp(−Δμ L).
    pub factor: f64,
    /// New mean length.
    pub mean_mm: f64,
    /// Relative part of the factor that is due to the spread of the lengths.
    pub correction: f64,
}

impl LengthRange {
    /// Re-weights lengths with a given mean; the fraction `spreads` of the variance of the assumed distribution is
    /// used.
    pub fn tilt(&self, mean_mm: f64, change_per_mm: f64, spreads: f64) -> Tilted {
        let beyond = (mean_mm - self.low_mm).max(0.0);
        // Logarithm of the mean of exp(−Δμ (L − mean)), and shift of the mean.
        let (spread, shift) = match self.width_mm {
            Some(width) => {
                let rate = rate_of_mean((beyond / width).min(1.0));
                let new = rate + change_per_mm * width;
                let spread = log_integral(new) - log_integral(rate) + change_per_mm * beyond;
                (spread, width * (mean_of_rate(new) - mean_of_rate(rate)))
            }
            None => {
                // Growth is limited below the value at which the exponential diverges; a warning reports the open bin.
                let growth = (change_per_mm * beyond).max(-MOST_OPEN_GROWTH);
                (growth - growth.ln_1p(), -beyond * growth / (1.0 + growth))
            }
        };
        let spread = spreads * spread.max(0.0);
        Tilted {
            factor: (spread - change_per_mm * mean_mm).exp(),
            mean_mm: mean_mm + spreads * shift,
            correction: -(-spread).exp_m1(),
        }
    }
}

/// Upper limit of −Δμ times the mean length beyond the last edge; the exponential diverges at 1.
const MOST_OPEN_GROWTH: f64 = 0.9;

/// ln ∫₀¹ exp(−t x) dx.
fn log_integral(t: f64) -> f64 {
    if t < 0.0 {
        return -t + log_integral(-t);
    }
    if t < 1e-3 {
        return -t / 2.0 + t * t / 24.0;
    }
    (-(-t).exp_m1() / t).ln()
}

/// Mean of x over 0..1 with the density exp(−t x): ½ − ½ L(t/2), L(x) = coth x − 1/x the Langevin function.
fn mean_of_rate(t: f64) -> f64 {
    0.5 - 0.5 * langevin(0.5 * t)
}

/// Inverse of [`mean_of_rate`].
fn rate_of_mean(mean: f64) -> f64 {
    let v = (1.0 - 2.0 * mean).clamp(-STEEPEST, STEEPEST);
    // Start from Cohen's approximation (1991), good to 5 %; each Newton step squares the error.
    let mut x = v * (3.0 - v * v) / (1.0 - v * v);
    for _ in 0..4 {
        let slope = if x.abs() < 1e-2 {
            1.0 / 3.0
        } else {
            1.0 / (x * x) - 1.0 / x.sinh().powi(2)
        };
        x -= (langevin(x) - v) / slope;
    }
    2.0 * x
}

/// Limit of 2 × mean − 1: means nearer to an edge than 5e-4 of the range are moved to that distance.
const STEEPEST: f64 = 0.999;

fn langevin(x: f64) -> f64 {
    if x.abs() < 1e-2 {
        let square = x * x;
        return x / 3.0 * (1.0 - square / 15.0 * (1.0 - square * 2.0 / 21.0));
    }
    1.0 / x.tanh() - 1.0 / x
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::iter::zip;

    #[test]
    fn the_density_of_a_mean_has_that_mean() {
        for k in 1..2000 {
            let mean = k as f64 / 2000.0;
            let found = mean_of_rate(rate_of_mean(mean));
            assert!((found - mean).abs() < 1e-12, "{mean}: {found}");
        }
    }

    /// Reference: the integral by Simpson's rule, and the derivative of its logarithm.
    #[test]
    fn a_tilted_range_has_the_integral_and_mean_of_its_density() {
        let range = LengthRange {
            low_mm: 0.3,
            width_mm: Some(0.15),
        };
        for (u, change) in [(0.1, 12.0), (0.3, -20.0), (0.5, 1e-4), (0.9, 5.0), (0.499, -3.0)] {
            let rate = rate_of_mean(u);
            let steps = 20_000;
            let moments = |change: f64| {
                let mut sums = [0.0; 2];
                for i in 0..=steps {
                    let x = i as f64 / steps as f64;
                    let simpson = if i == 0 || i == steps {
                        1.0
                    } else {
                        2.0 + 2.0 * (i % 2) as f64
                    };
                    let length = 0.3 + 0.15 * x;
                    let density = simpson * (-rate * x - change * length).exp();
                    zip(&mut sums, [1.0, length]).for_each(|(sum, power)| *sum += density * power);
                }
                sums
            };
            let (before, after) = (moments(0.0), moments(change));
            let tilted = range.tilt(before[1] / before[0], change, 1.0);
            let exact = after[0] / before[0];
            assert!(
                (tilted.factor / exact - 1.0).abs() < 1e-9,
                "{u} {change}: {} {exact}",
                tilted.factor
            );
            assert!(
                (tilted.mean_mm / (after[1] / after[0]) - 1.0).abs() < 1e-9,
                "{u} {change}"
            );
            let back = range.tilt(tilted.mean_mm, -change, 1.0);
            assert!((back.factor * tilted.factor - 1.0).abs() < 1e-9, "{u} {change}");
        }
    }

    #[test]
    fn one_path_alone_is_taken_at_its_length() {
        for width_mm in [Some(0.15), None] {
            let tilted = LengthRange { low_mm: 0.3, width_mm }.tilt(0.4, -7.0, 0.0);
            assert_eq!(
                (tilted.factor, tilted.mean_mm, tilted.correction),
                ((7.0f64 * 0.4).exp(), 0.4, 0.0)
            );
        }
    }
}
