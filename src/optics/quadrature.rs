use std::f64::consts::PI;

/// Nodes and weights of the n-point Gauss–Legendre rule on −1..=1, exact for polynomials of degree 2n − 1; n ≥ 1.
/// Newton's method on the three-term recurrence of the Legendre polynomials, from Tricomi's guess.
pub(crate) fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    let legendre = |x: f64| {
        let (mut p, mut below) = (x, 1.0);
        for k in 2..=n {
            let k = k as f64;
            (p, below) = (((2.0 * k - 1.0) * x * p - (k - 1.0) * below) / k, p);
        }
        (p, n as f64 * (x * p - below) / (x * x - 1.0))
    };
    (0..n)
        .map(|i| {
            let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            for _ in 0..4 {
                let (p, slope) = legendre(x);
                x -= p / slope;
            }
            let (_, slope) = legendre(x);
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_for_the_highest_even_power() {
        for n in [1, 2, 5, 64, 301] {
            let power = 2 * n as i32 - 2;
            let sum: f64 = gauss_legendre(n).iter().map(|(x, w)| w * x.powi(power)).sum();
            let exact = 2.0 / f64::from(power + 1);
            assert!((sum / exact - 1.0).abs() < 1e-11, "n = {n}: {sum} for {exact}");
        }
    }
}
