//! Scattering of a plane wave by one homogeneous sphere: the Mie series.
//!
//! Notation and signs of Bohren and Huffman, *Absorption and Scattering of Light by Small Particles* (1983), chapter 4:
//! time factor exp(−iωt), so an absorbing sphere has κ > 0. With A_n = D_n(mx)/m for the electric coefficients and
//! A_n = m D_n(mx) for the magnetic ones (D_n the logarithmic derivative of ψ_n),
//!
//! ```text
//! a_n, b_n = p_n / (p_n − i q_n),   p_n = A_n ψ_n(x) − ψ_n'(x),   q_n = A_n χ_n(x) − χ_n'(x)        (their 4.88)
//! ```
//!
//! Three rearrangements keep the digits those formulas lose in double precision:
//! * D_n(z) = (n+1)/z − z r_n(z) with r_n = 1/(2n+3 − z² r_{n+1}), iterated downwards. The large (n+1)/z of the inside
//!   and the outside then cancel on paper, so spheres down to x = 1e-6 need no separate expansion.
//! * Re a_n − |a_n|² = −Im A_n / |A_n ξ_n − ξ_n'|², by the Wronskian of ψ and χ. Absorption is a sum of terms of one
//!   sign, never a difference of extinction and scattering; it is exactly 0 for a real m.
//! * Beyond n = x, ψ_n follows from r_n, χ_n and the Wronskian, not from its unstable upward recurrence.
//!
//! What remains is the conditioning of the problem: near m = 1 a rounding of m changes everything by 1/|m−1|.

use num_complex::Complex64;

use super::{OpticsError, Property};
use crate::fault::{self, Fault};
use crate::number::shown;

/// Smallest accepted size parameter.
pub const MIN_SIZE_PARAMETER: f64 = 1e-6;
/// Largest accepted size parameter.
pub const MAX_SIZE_PARAMETER: f64 = 1e5;
/// Largest accepted |m| x, which bounds the work of the recurrence inside the sphere.
pub const MAX_INTERNAL_SIZE: f64 = 1e7;

/// Cross sections over the geometric one, πd²/4; dimensionless.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Efficiencies {
    /// Extinction, `q_sca + q_abs`.
    pub q_ext: f64,
    /// Scattering.
    pub q_sca: f64,
    /// Absorption; exactly 0 when m is real.
    pub q_abs: f64,
    /// Radar backscattering, 4|S(180°)|²/x²: 4π dC/dΩ(180°) over the geometric cross section.
    pub q_back: f64,
    /// Mean cosine of the scattering angle, −1..=1; 0 when nothing is scattered (m = 1).
    pub g: f64,
}

/// The solved series of one sphere.
#[derive(Clone, Debug)]
pub struct Mie {
    /// (2n+1)/(n(n+1)) (a_n + b_n), the weights of π_n + τ_n.
    sums: Vec<Complex64>,
    /// (2n+1)/(n(n+1)) (a_n − b_n), the weights of π_n − τ_n.
    differences: Vec<Complex64>,
    efficiencies: Efficiencies,
}

impl Mie {
    /// Sphere of refractive index `m` = n + iκ relative to its non-absorbing host, of size parameter
    /// x = π d n_host / λ (d the diameter, λ the vacuum wavelength).
    ///
    /// # Errors
    /// Outside `MIN_SIZE_PARAMETER..=MAX_SIZE_PARAMETER`, for n ≤ 0, κ < 0 or |m| x above [`MAX_INTERNAL_SIZE`].
    pub fn sphere(m: Complex64, x: f64) -> Result<Self, OpticsError> {
        check_size(x)?;
        if !(m.re.is_finite() && m.re > 0.0) {
            return Err(OpticsError::domain(
                Property::ParticleIndex,
                "real part of the relative index m",
                "a number > 0",
                m.re,
                "give the index of the particle over that of the host",
            ));
        }
        if !(m.im.is_finite() && m.im >= 0.0) {
            return Err(OpticsError::domain(
                Property::ParticleAbsorption,
                "imaginary part of the relative index m",
                "a number >= 0",
                m.im,
                "absorption is n + iκ with κ >= 0 here; flip the sign of an n − iκ convention",
            ));
        }
        let internal = m.norm() * x;
        if internal > MAX_INTERNAL_SIZE {
            return Err(OpticsError::domain(
                Property::ParticleDiameter,
                "|m| x",
                format!("at most {MAX_INTERNAL_SIZE:e}"),
                internal,
                "take a smaller sphere, or a conducting one for so large an index",
            ));
        }
        let m = if fault::active(Fault::KappaSign) { m.conj() } else { m };
        // Roundings would otherwise give a matched sphere a spurious Q of 1e-32 and any g at all.
        let series = if m == Complex64::ONE {
            Vec::new()
        } else {
            dielectric(m, x)
        };
        Ok(Self::from_coefficients(x, series))
    }

    /// Perfectly conducting sphere of size parameter x: the limit of infinite κ.
    ///
    /// # Errors
    /// Outside `MIN_SIZE_PARAMETER..=MAX_SIZE_PARAMETER`.
    pub fn conducting(x: f64) -> Result<Self, OpticsError> {
        check_size(x)?;
        let outside = Outside::new(x);
        let coefficients = (1..=outside.last())
            .map(|n| {
                let (psi, chi, psi_prime, chi_prime) = outside.at(n);
                SeriesCoefficients {
                    a: Partial::new(psi_prime.into(), chi_prime.into(), 0.0),
                    b: Partial::new(psi.into(), chi.into(), 0.0),
                }
            })
            .collect();
        Ok(Self::from_coefficients(x, coefficients))
    }

    /// Efficiencies and asymmetry parameter of the sphere.
    pub fn efficiencies(&self) -> Efficiencies {
        self.efficiencies
    }

    /// Amplitudes (S1, S2) for light polarised across and along the scattering plane at a scattering angle of the given
    /// cosine, −1..=1 (Bohren and Huffman 4.74). dC_sca/dΩ = |S|²/k² with k = 2π n_host/λ; S1 = S2 at 0°, S1 = −S2 at
    /// 180°.
    pub fn amplitudes(&self, cos_theta: f64) -> (Complex64, Complex64) {
        let (mut even, mut odd) = (Complex64::ZERO, Complex64::ZERO);
        let (mut pi, mut pi_below) = (1.0, 0.0);
        let mut n = 1.0;
        for (sum, difference) in self.sums.iter().zip(&self.differences) {
            // Wiscombe's form of the recurrences (NCAR/TN-140, 1979): exact at 0° and 180°.
            let s = cos_theta * pi;
            let t = s - pi_below;
            let tau = n * t - pi_below;
            even += sum * (pi + tau);
            odd += difference * (pi - tau);
            pi_below = pi;
            pi = s + (n + 1.0) / n * t;
            n += 1.0;
        }
        ((even + odd) * 0.5, (even - odd) * 0.5)
    }

    /// (|S1|² + |S2|²)/2: k² dC_sca/dΩ for unpolarised light. Divided by π x² Q_sca it is the phase function in 1/sr.
    pub fn unpolarised(&self, cos_theta: f64) -> f64 {
        let (s1, s2) = self.amplitudes(cos_theta);
        0.5 * (s1.norm_sqr() + s2.norm_sqr())
    }

    fn from_coefficients(x: f64, mut series: Vec<SeriesCoefficients>) -> Self {
        let size = |n: usize, c: &SeriesCoefficients| (2 * n + 3) as f64 * (c.a.value.norm() + c.b.value.norm());
        let largest = series.iter().enumerate().map(|(n, c)| size(n, c)).fold(0.0, f64::max);
        while series.len() > 3
            && series
                .last()
                .is_some_and(|c| size(series.len() - 1, c) < 1e-17 * largest)
        {
            series.pop();
        }
        let efficiencies = efficiencies(x, &series);
        let weight = |n: usize| (2 * n + 3) as f64 / ((n + 1) * (n + 2)) as f64;
        let combine = |f: fn(&SeriesCoefficients) -> Complex64| -> Vec<Complex64> {
            series.iter().enumerate().map(|(n, c)| f(c) * weight(n)).collect()
        };
        Self {
            sums: combine(|c| c.a.value + c.b.value),
            differences: combine(|c| c.a.value - c.b.value),
            efficiencies,
        }
    }
}

fn check_size(x: f64) -> Result<(), OpticsError> {
    if (MIN_SIZE_PARAMETER..=MAX_SIZE_PARAMETER).contains(&x) {
        return Ok(());
    }
    let expected = format!("from {} to {}", shown(MIN_SIZE_PARAMETER), shown(MAX_SIZE_PARAMETER));
    Err(OpticsError::domain(
        Property::ParticleDiameter,
        "size parameter x = π d n_host / λ",
        expected,
        x,
        "change the particle's diameter or the wavelength; beyond this range accuracy was not verified",
    ))
}

/// One coefficient, with what it scatters and absorbs.
#[derive(Clone, Copy)]
struct Partial {
    value: Complex64,
    /// |value|²
    scattered: f64,
    /// Re value − |value|²
    absorbed: f64,
}

impl Partial {
    /// p/(p − iq), with `minus_im_a` = −Im A_n.
    fn new(p: Complex64, q: Complex64, minus_im_a: f64) -> Self {
        let denominator = Complex64::new(p.re + q.im, p.im - q.re).norm_sqr();
        let scattered = p.norm_sqr() / denominator;
        let absorbed = minus_im_a / denominator;
        let im = (p.re * q.re + p.im * q.im) / denominator;
        Self {
            value: Complex64::new(scattered + absorbed, im),
            scattered,
            absorbed,
        }
    }
}

struct SeriesCoefficients {
    a: Partial,
    b: Partial,
}

fn dielectric(m: Complex64, x: f64) -> Vec<SeriesCoefficients> {
    let outside = Outside::new(x);
    let inside = ratios(m * x, outside.last());
    let m2 = m * m;
    let (one_minus_m2, inverse_m2) = ((1.0 - m) * (1.0 + m), m2.inv());
    (1..=outside.last())
        .map(|n| {
            let (psi, chi, psi_prime, chi_prime) = outside.at(n);
            let (inner, lead) = (inside[n], (n + 1) as f64 / x);
            let electric = inverse_m2 * lead - inner * x;
            let magnetic = lead - m2 * inner * x;
            let (p_a, p_b) = match outside.ratio(n) {
                Some(r) => (
                    (one_minus_m2 * inverse_m2 * lead + (r - inner) * x) * psi,
                    (r - m2 * inner) * (x * psi),
                ),
                None => (electric * psi - psi_prime, magnetic * psi - psi_prime),
            };
            SeriesCoefficients {
                a: Partial::new(p_a, electric * chi - chi_prime, -electric.im),
                b: Partial::new(p_b, magnetic * chi - chi_prime, -magnetic.im),
            }
        })
        .collect()
}

/// Sums of Bohren and Huffman 4.61, 4.62, 4.82 and the asymmetry parameter of their section 4.5.
fn efficiencies(x: f64, series: &[SeriesCoefficients]) -> Efficiencies {
    let (mut scattered, mut absorbed, mut asymmetry) = (0.0, 0.0, 0.0);
    let mut back = Complex64::ZERO;
    let mut lost = Complex64::ZERO;
    for (i, c) in series.iter().enumerate() {
        let n = (i + 1) as f64;
        let weight = 2.0 * n + 1.0;
        scattered += weight * (c.a.scattered + c.b.scattered);
        absorbed += weight * (c.a.absorbed + c.b.absorbed);
        let (a, b) = (c.a.value, c.b.value);
        asymmetry += weight / (n * (n + 1.0)) * real_product(a, b);
        if let Some(next) = series.get(i + 1) {
            asymmetry += n * (n + 2.0) / (n + 1.0) * (real_product(a, next.a.value) + real_product(b, next.b.value));
        }
        // A compensated sum: the terms alternate and reach x² while the result is of order x.
        let term = (a - b) * if i % 2 == 0 { -weight } else { weight } - lost;
        let sum = back + term;
        lost = (sum - back) - term;
        back = sum;
    }
    let q_sca = 2.0 / (x * x) * scattered;
    let q_abs = 2.0 / (x * x) * absorbed;
    Efficiencies {
        q_ext: q_sca + q_abs,
        q_sca,
        q_abs,
        q_back: back.norm_sqr() / (x * x),
        g: if scattered > 0.0 {
            2.0 * asymmetry / scattered
        } else {
            0.0
        },
    }
}

/// Re(u v*)
fn real_product(u: Complex64, v: Complex64) -> f64 {
    u.re * v.re + u.im * v.im
}

/// Riccati–Bessel functions of the host: ψ_n = x j_n, χ_n = −x y_n.
struct Outside {
    x: f64,
    psi: Vec<f64>,
    chi: Vec<f64>,
    /// First order at which `ratio` is used, n ≥ x: past the oscillations, where r_n has no poles.
    turn: usize,
    /// r_n(x) for n ≥ turn, at index n − turn.
    ratios: Vec<f64>,
}

impl Outside {
    fn new(x: f64) -> Self {
        // Orders up to where ψ_n/χ_n is below 1e-16 (Airy asymptotics of the transition region; Wiscombe's 4.05 reaches
        // 1e-7).
        let last = (x + 7.0 * x.cbrt() + 5.0).ceil() as usize;
        let turn = (x.ceil() as usize).max(1);
        let (sin, cos) = x.sin_cos();
        let mut chi = Vec::with_capacity(last + 2);
        chi.extend([cos, cos / x + sin]);
        for n in 1..=last {
            chi.push((2 * n + 1) as f64 / x * chi[n] - chi[n - 1]);
        }
        let mut ratios = vec![0.0; last + 1 - turn];
        let mut r = 0.0;
        for n in (turn..=recurrence_start(x, last)).rev() {
            r = 1.0 / ((2 * n + 3) as f64 - x * x * r);
            if n <= last {
                ratios[n - turn] = r;
            }
        }
        let mut psi = Vec::with_capacity(last + 1);
        psi.push(sin);
        if turn > 1 {
            psi.push(sin / x - cos);
        }
        for n in 2..turn {
            psi.push((2 * n - 1) as f64 / x * psi[n - 1] - psi[n - 2]);
        }
        for n in turn..=last {
            // ψ_n χ_{n+1} − ψ_{n+1} χ_n = 1 with ψ_{n+1} = x r_n ψ_n.
            psi.push(1.0 / (chi[n + 1] - x * ratios[n - turn] * chi[n]));
        }
        Self {
            x,
            psi,
            chi,
            turn,
            ratios,
        }
    }

    fn last(&self) -> usize {
        self.psi.len() - 1
    }

    fn ratio(&self, n: usize) -> Option<f64> {
        n.checked_sub(self.turn).map(|i| self.ratios[i])
    }

    /// ψ_n, χ_n, ψ_n', χ_n' for n ≥ 1.
    fn at(&self, n: usize) -> (f64, f64, f64, f64) {
        let (psi, chi, order) = (self.psi[n], self.chi[n], n as f64);
        let psi_prime = match self.ratio(n) {
            Some(r) => psi * ((order + 1.0) / self.x - self.x * r),
            None => self.psi[n - 1] - order / self.x * psi,
        };
        (psi, chi, psi_prime, self.chi[n - 1] - order / self.x * chi)
    }
}

/// r_n(z) = ψ_{n+1}(z)/(z ψ_n(z)) for n = 0..=last, by downward recurrence (stable for every z).
fn ratios(z: Complex64, last: usize) -> Vec<Complex64> {
    let z2 = z * z;
    let mut out = vec![Complex64::ZERO; last + 1];
    let mut r = Complex64::ZERO;
    for n in (1..=recurrence_start(z.norm(), last)).rev() {
        let mut denominator = (2 * n + 3) as f64 - z2 * r;
        if denominator == Complex64::ZERO {
            // ψ_n(z) = 0 to the last bit: any tiny value stands for it (Lentz).
            denominator = Complex64::new(1e-60, 0.0);
        }
        r = denominator.inv();
        if n <= last {
            out[n] = r;
        }
    }
    out
}

/// Order from which the downward recurrence forgets its starting value before it reaches orders near |z| or `last`.
fn recurrence_start(z: f64, last: usize) -> usize {
    last.max((z + 8.0 * z.cbrt()).ceil() as usize) + 16
}
