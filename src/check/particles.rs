//! The Mie series and the structure factor done again, as they stand in the textbooks: what they make of the particles
//! is what the medium must be. Bohren and Huffman, *Absorption and Scattering of Light by Small Particles* (1983),
//! chapter 4; Baxter, Australian Journal of Physics 21 (1968), 563.

use super::gate::{Gate, Law, Where};
use super::{CheckError, Context};
use crate::optics::{Medium, gauss_legendre};
use crate::run::medium_spec;
use crate::study::{InterferenceChoice, MediumSection, Study};
use num_complex::Complex64;
use std::f64::consts::PI;
use std::iter::zip;

const COEFFICIENTS: Law = Law {
    name: "particle-coefficients",
    words: "mu_s, mu_a and g are those of N spheres a volume: integrals of their amplitudes, and extinction less \
            scattering",
};
const PHASE: Law = Law {
    name: "particle-phase",
    words: "the phase function is that of unpolarised light, (|S1|² + |S2|²) S(q), at angles all around",
};

/// Of the coefficients, relative.
const COEFFICIENT: f64 = 1e-6;
/// Of the phase function: relative where it is above that of even scattering, of the latter where it is below. A table
/// is refined until its g is good to 1e-6 and is normalised as the polygon that it is, which puts the peak of spheres
/// of 5 µm 4e-4 too low.
const DENSITY: f64 = 2e-3;
/// Panels of q d: narrow where dense spheres have sharp peaks of S, and beyond half of what |S1|² takes to go up and
/// down.
const PEAKS: f64 = 60.0;
const NARROW: f64 = 0.25;
const WIDE: f64 = 4.0;
const PANEL_NODES: usize = 20;
/// Angles θ = 2 asin(k/32), nodes of every table.
const ANGLES: usize = 32;

/// Both gates, for the study's medium and for the same particles with interference on or off, whichever the study has
/// not.
pub fn gates(context: &Context) -> Result<[Gate; 2], CheckError> {
    let Context { plan, judge, .. } = context;
    let study = &plan.study;
    let other = MediumSection {
        interference: match study.medium.interference {
            InterferenceChoice::Independent => InterferenceChoice::PercusYevick,
            InterferenceChoice::PercusYevick => InterferenceChoice::Independent,
        },
        ..study.medium.clone()
    };
    let nm = plan.grid.nm();
    let mut departures = [Vec::new(), Vec::new()];
    let add = |departures: &mut [Vec<f64>; 2], medium: &Medium, section: &MediumSection| -> Result<(), CheckError> {
        let [coefficients, densities] = compare(context, medium, section)?;
        departures[0].extend(coefficients);
        departures[1].extend(densities);
        Ok(())
    };
    add(&mut departures, &plan.yarn.medium, &study.medium)?;
    let of_warp = departures.each_ref().map(Vec::len);
    if plan.weft.is_some() {
        add(
            &mut departures,
            &plan.yarns()[1].medium,
            &study.weft.medium(&study.medium),
        )?;
    }
    let of_yarns = departures.each_ref().map(Vec::len);
    // The study does not need the other medium: where that is refused, as too sharp for a table, there is nothing to
    // test.
    if let Ok(yarn) = plan.yarn_of(&other) {
        add(&mut departures, &yarn.medium, &other)?;
    }
    let whose = |i: usize, gate: usize| match i {
        _ if i < of_warp[gate] => "",
        _ if i < of_yarns[gate] => ", weft",
        _ => ", interference the other way",
    };
    let quantities = ["mu_s", "mu_a", "g"];
    Ok([
        judge.exact(COEFFICIENTS, &departures[0], COEFFICIENT, |i| {
            let at = format!("{}{}", quantities[i % 3], whose(i, 0));
            Where::new(nm[i / 3 % nm.len()], at)
        }),
        judge.exact(PHASE, &departures[1], DENSITY, |i| {
            let degrees = 2.0 * sine(i % (ANGLES + 1)).asin().to_degrees();
            let at = format!("{degrees:.1} deg{}", whose(i, 1));
            Where::new(nm[i / (ANGLES + 1) % nm.len()], at)
        }),
    ])
}

/// sin(θ/2) of angle k.
fn sine(k: usize) -> f64 {
    k as f64 / ANGLES as f64
}

/// Departures of coefficients and of the phase function at every wavelength.
fn compare(context: &Context, medium: &Medium, section: &MediumSection) -> Result<[Vec<f64>; 2], CheckError> {
    let plan = context.plan;
    let study = Study {
        medium: section.clone(),
        ..plan.study.clone()
    };
    let spec = medium_spec(&study, &plan.grid)?;
    let [host, particle, kappa, host_mu_a] = [
        &spec.host_index,
        &spec.particle_index,
        &spec.particle_kappa,
        &spec.host_mu_a_per_mm,
    ]
    .map(|spectrum| spectrum.on(&plan.grid));
    let (host, particle, kappa, host_mu_a) = (host?, particle?, kappa?, host_mu_a?);
    let interfering = section.interference == InterferenceChoice::PercusYevick;
    let mut departures = [Vec::new(), Vec::new()];
    for (w, nm) in plan.grid.nm().iter().enumerate() {
        let m = Complex64::new(particle.values()[w], kappa.values()[w]) / host.values()[w];
        let sphere = Sphere::new(m, host.values()[w], *nm, section, interfering);
        let [mu_s, mu_ext, g] = sphere.coefficients();
        let mu_a = sphere.absorption() + host_mu_a.values()[w];
        // Coefficients so small that nothing of them is seen, across the yarn or beside the others, are not compared
        // digit by digit.
        let least = COEFFICIENT * (mu_ext + host_mu_a.values()[w] + 0.5 / plan.yarn.cylinder.radius_mm());
        let relative = |found: f64, expected: f64| (found - expected) / expected.max(least);
        let scatters = mu_s > least;
        departures[0].extend([
            relative(medium.mu_s_per_mm()[w], mu_s),
            relative(medium.mu_a_per_mm()[w], mu_a),
            if scatters { medium.g()[w] - g } else { 0.0 },
        ]);
        departures[1].extend((0..=ANGLES).map(|k| {
            let cos = 1.0 - 2.0 * sine(k).powi(2);
            let expected = 4.0 * PI * sphere.scattering(cos) / mu_s;
            let found = 4.0 * PI * medium.phase(w).pdf(cos);
            if scatters {
                (found - expected) / (1.0 + expected)
            } else {
                0.0
            }
        }));
    }
    Ok(departures)
}

/// One wavelength.
struct Sphere {
    a: Vec<Complex64>,
    b: Vec<Complex64>,
    /// Size parameter in the host.
    x: f64,
    /// N/k², N spheres per mm³ and k the wave number in the host: 1/mm.
    per_mm: f64,
    /// Volume fraction, if neighbours interfere.
    interfering: Option<f64>,
}

impl Sphere {
    fn new(m: Complex64, host: f64, vacuum_nm: f64, of: &MediumSection, interfering: bool) -> Self {
        let wave_number = 2.0 * PI * host / (vacuum_nm * 1e-6);
        let diameter_mm = of.particle_diameter_nm * 1e-6;
        let x = 0.5 * wave_number * diameter_mm;
        let number = 6.0 * of.volume_fraction / (PI * diameter_mm.powi(3));
        let (a, b) = coefficients(m, x);
        Self {
            a,
            b,
            x,
            per_mm: number / (wave_number * wave_number),
            interfering: interfering.then_some(of.volume_fraction),
        }
    }

    /// N (|S1|² + |S2|²) S(q) / (2k²), 1/(mm sr).
    fn scattering(&self, cos: f64) -> f64 {
        let structure = self.interfering.map_or(1.0, |fraction| {
            // q d with q = 2k sin(θ/2).
            baxter(4.0 * self.x * (0.5 * (1.0 - cos)).max(0.0).sqrt(), fraction)
        });
        self.alone(cos) * structure
    }

    fn alone(&self, cos: f64) -> f64 {
        let (s1, s2) = self.amplitudes(cos);
        0.5 * self.per_mm * (s1.norm_sqr() + s2.norm_sqr())
    }

    /// S1 and S2 by the upward recurrences of π_n and τ_n (Bohren and Huffman 4.47, 4.74).
    fn amplitudes(&self, cos: f64) -> (Complex64, Complex64) {
        let (mut s1, mut s2) = (Complex64::ZERO, Complex64::ZERO);
        let (mut pi, mut below) = (1.0, 0.0);
        for (k, (a, b)) in zip(&self.a, &self.b).enumerate() {
            let n = (k + 1) as f64;
            let tau = n * cos * pi - (n + 1.0) * below;
            let weight = (2.0 * n + 1.0) / (n * (n + 1.0));
            s1 += weight * (a * pi + b * tau);
            s2 += weight * (a * tau + b * pi);
            (pi, below) = (((2.0 * n + 1.0) * cos * pi - (n + 1.0) * below) / n, pi);
        }
        (s1, s2)
    }

    /// μ_s, extinction and g: ∫ dC/dΩ and ∫ dC/dΩ cosθ over the sphere by Gauss's rule in panels of q d = 4x sin(θ/2).
    fn coefficients(&self) -> [f64; 3] {
        let rule = gauss_legendre(PANEL_NODES);
        let most = 4.0 * self.x;
        let (mut mu_s, mut forward, mut low) = (0.0, 0.0, 0.0);
        while low < most {
            let step = if low < PEAKS { NARROW } else { WIDE };
            let high: f64 = if low + step < most { low + step } else { most };
            for (node, weight) in &rule {
                let sine = (0.5 * (low + high) + 0.5 * (high - low) * node) / most;
                let cos = 1.0 - 2.0 * sine * sine;
                // dω = 8π t dt with t = sin(θ/2).
                let share = 8.0 * PI * sine * 0.5 * (high - low) / most * weight * self.scattering(cos);
                mu_s += share;
                forward += share * cos;
            }
            low = high;
        }
        let mu_ext = mu_s + self.absorption();
        [mu_s, mu_ext, if mu_s > 0.0 { forward / mu_s } else { 0.0 }]
    }

    /// Of spheres that do not interfere, extinction by the optical theorem, 4π N Re S(0)/k², less scattering, term by
    /// term: (2π N/k²) Σ (2n + 1) (Re a_n − |a_n|² + Re b_n − |b_n|²).
    fn absorption(&self) -> f64 {
        let terms = zip(&self.a, &self.b).enumerate().map(|(k, (a, b))| {
            let n = (k + 1) as f64;
            (2.0 * n + 1.0) * (a.re - a.norm_sqr() + b.re - b.norm_sqr())
        });
        2.0 * PI * self.per_mm * terms.sum::<f64>()
    }
}

/// a_n and b_n by Bohren and Huffman 4.88 with the logarithmic derivative from 4.89.
fn coefficients(m: Complex64, x: f64) -> (Vec<Complex64>, Vec<Complex64>) {
    let last = (x + 6.0 * x.cbrt() + 6.0).ceil() as usize;
    let inside = m * x;
    let mut derivatives = vec![Complex64::ZERO; last + 1];
    let mut derivative = Complex64::ZERO;
    let start = last.max(inside.norm().ceil() as usize) + 32;
    for n in (1..=start).rev() {
        let ratio = n as f64 / inside;
        derivative = ratio - (derivative + ratio).inv();
        if n <= last + 1 {
            derivatives[n - 1] = derivative;
        }
    }
    let psi = regular(x, last);
    // χ_n = −x y_n, upwards.
    let mut chi = vec![x.cos(), x.cos() / x + x.sin()];
    for n in 2..=last {
        chi.push((2 * n - 1) as f64 / x * chi[n - 1] - chi[n - 2]);
    }
    let xi = |n: usize| Complex64::new(psi[n], -chi[n]);
    let quotient = |n: usize, factor: Complex64| {
        let factor = factor + n as f64 / x;
        (factor * psi[n] - psi[n - 1]) / (factor * xi(n) - xi(n - 1))
    };
    let orders = 1..=last;
    (
        orders.clone().map(|n| quotient(n, derivatives[n] / m)).collect(),
        orders.map(|n| quotient(n, derivatives[n] * m)).collect(),
    )
}

/// ψ_n = x j_n: upwards as far as that is stable, n ≤ x, and beyond by the ratios ψ_n/ψ_{n−1} of the recurrence
/// downwards.
fn regular(x: f64, last: usize) -> Vec<f64> {
    let mut ratios = vec![0.0; last + 1];
    let mut ratio = 0.0;
    for n in (1..=last + 32).rev() {
        ratio = 1.0 / ((2 * n + 1) as f64 / x - ratio);
        if n <= last {
            ratios[n] = ratio;
        }
    }
    let mut psi = vec![x.sin()];
    for n in 1..=last {
        psi.push(match n as f64 <= x {
            true if n == 1 => x.sin() / x - x.cos(),
            true => (2 * n - 1) as f64 / x * psi[n - 1] - psi[n - 2],
            false => ratios[n] * psi[n - 1],
        });
    }
    psi
}

/// S(q) of hard spheres by Baxter's factor: S = 1/|Q|², Q = 1 − 12η ∫₀¹ e^(iys) (a (s² − 1)/2 + b (s − 1)) ds with y =
/// q d, a = (1 + 2η)/(1 − η)² and b = −3η/(2 (1 − η)²).
fn baxter(y: f64, fraction: f64) -> f64 {
    let square = (1.0 - fraction).powi(2);
    let (a, b) = ((1.0 + 2.0 * fraction) / square, -1.5 * fraction / square);
    let integral = if y < 1.0 {
        // The closed form cancels here.
        let nodes = gauss_legendre(12)
            .into_iter()
            .map(|(x, weight)| (0.5 * (1.0 + x), 0.5 * weight));
        nodes
            .map(|(s, weight)| Complex64::cis(y * s) * (weight * (0.5 * a * (s * s - 1.0) + b * (s - 1.0))))
            .sum()
    } else {
        let (iy, end) = (Complex64::new(0.0, y), Complex64::cis(y));
        let linear = iy.inv() + (end - 1.0) / (y * y);
        let quadratic = iy.inv() + 2.0 * end / (y * y) - 2.0 * (end - 1.0) / (iy * (y * y));
        0.5 * a * quadratic + b * linear
    };
    1.0 / (1.0 - 12.0 * fraction * integral).norm_sqr()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{Mie, percus_yevick};

    #[test]
    fn both_series_agree_from_tiny_to_large_spheres() {
        for m in [
            Complex64::new(1.034, 0.0),
            Complex64::new(1.5, 0.01),
            Complex64::new(1.1, 2.0),
        ] {
            for x in [1e-3, 0.1, 1.0, PI, 2.0 * PI, 9.3, 120.0] {
                let (a, b) = coefficients(m, x);
                let sums = zip(&a, &b)
                    .enumerate()
                    .map(|(k, (a, b))| (2 * k + 3) as f64 * (a.re + b.re));
                let q_ext = 2.0 / (x * x) * sums.sum::<f64>();
                let expected = Mie::sphere(m, x).unwrap().efficiencies().q_ext;
                assert!((q_ext / expected - 1.0).abs() < 1e-8, "{m} {x}: {q_ext:e} {expected:e}");
            }
        }
    }

    #[test]
    fn baxters_factor_is_percus_yevick() {
        for fraction in [0.0, 0.01, 0.14, 0.45, 0.7] {
            for y in [0.0, 0.3, 0.999, 1.001, 4.0, 7.3, 40.0] {
                let (found, expected) = (baxter(y, fraction), percus_yevick(y, fraction));
                assert!(
                    (found / expected - 1.0).abs() < 1e-10,
                    "{fraction} {y}: {found} {expected}"
                );
            }
        }
    }
}
