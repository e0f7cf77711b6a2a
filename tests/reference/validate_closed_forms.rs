//! The closed forms of a cylinder that does not scatter, written literally and integrated over the beam, against the
//! table the kernel is compared with. Nothing is shared with the crate: this guards the table and the formulas.

use std::f64::consts::{FRAC_PI_2, PI};

/// Tanh–sinh rule on a..b: doubly exponential, so that a pole close to an end of the interval does no harm.
fn integral(a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
    let step = 1.0 / 64.0;
    let half = 0.5 * (b - a);
    let sum: f64 = (-256..=256)
        .map(|k| {
            let t = f64::from(k) * step;
            let u = FRAC_PI_2 * t.sinh();
            // Distance from the nearer end, which does not cancel.
            let distance = half * (-u.abs()).exp() / u.cosh();
            let x = if t < 0.0 { a + distance } else { b - distance };
            let weight = FRAC_PI_2 * t.cosh() / (u.cosh() * u.cosh());
            if distance > 0.0 { weight * f(x) } else { 0.0 }
        })
        .sum();
    half * step * sum
}

/// Mean over the projected width, h = sin φ, of a function of cos φ.
fn over_beam(f: impl Fn(f64) -> f64) -> f64 {
    integral(0.0, FRAC_PI_2, |phi| phi.cos() * f(phi.cos()))
}

/// What one ray meets: internal path between two reflections as exp(−μ_a L), and the reflectances s, p.
struct Ray {
    a: f64,
    s: f64,
    p: f64,
}

fn ray(n: f64, tilt: f64, mu_a_r: f64, cos_phi: f64) -> Ray {
    let cos_i = tilt.cos() * cos_phi;
    let sin2_i = 1.0 - cos_i * cos_i;
    let cos_t = (1.0 - sin2_i / (n * n)).sqrt();
    let chord = 2.0 * cos_t / (1.0 - (tilt.sin() / n).powi(2));
    Ray {
        a: (-mu_a_r * chord).exp(),
        s: ((cos_i - n * cos_t) / (cos_i + n * cos_t)).powi(2),
        p: ((n * cos_i - cos_t) / (n * cos_i + cos_t)).powi(2),
    }
}

impl Ray {
    /// f(r, a) of unpolarised light at each interface, or the mean of both polarisations followed apart.
    fn mean(&self, polarised: bool, f: impl Fn(f64, f64) -> f64) -> f64 {
        if polarised {
            0.5 * (f(self.s, self.a) + f(self.p, self.a))
        } else {
            f(0.5 * (self.s + self.p), self.a)
        }
    }
}

fn transmitted(r: f64, a: f64) -> f64 {
    // Nothing enters at r = 1, where the quotient is 0/0 without absorption.
    if r == 1.0 {
        0.0
    } else {
        (1.0 - r).powi(2) * a / (1.0 - r * a)
    }
}

fn absorbed(r: f64, a: f64) -> f64 {
    if r == 1.0 {
        0.0
    } else {
        (1.0 - r) * (1.0 - a) / (1.0 - r * a)
    }
}

/// Worst difference found: 5e-13, the rounding of the table.
#[test]
fn quadratures_agree_with_every_row() {
    let text = include_str!("../data/transport/cylinder_analytic.csv");
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let mut compared = 0;
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let cell = |name: &str| cells[header.iter().position(|h| *h == name).unwrap()];
        let number = |name: &str| cell(name).parse::<f64>();
        let mut agree = |name: &str, found: f64| {
            let expected = number(name).unwrap();
            let error = (found - expected).abs();
            assert!(
                error <= 1e-10 * expected.abs().max(1e-3),
                "{name} of {line}: {found:e}, off by {error:e}"
            );
            compared += 1;
        };
        let case = cell("case");
        let n = number("n").unwrap();
        let tilt = number("tilt_deg").unwrap_or(0.0).to_radians();
        let mu_a_r = number("mu_a_R").unwrap_or(0.0);
        let polarised = case.contains("polarised");
        let beam = |f: fn(f64, f64) -> f64| over_beam(|cos| ray(n, tilt, mu_a_r, cos).mean(polarised, f));
        match case {
            "A_absorb_matched" => {
                agree("T_or_value", beam(|_, a| a));
                agree("absorbed", beam(|_, a| 1.0 - a));
            }
            "B_fresnel_scalar" | "B_fresnel_polarised" => {
                agree("R_frac", beam(|r, _| r));
                agree("T_frac", beam(transmitted));
                agree("A_frac", beam(absorbed));
            }
            "C_external_reflectance_s" => agree("R_frac", over_beam(|cos| ray(n, tilt, 0.0, cos).s)),
            "C_external_reflectance_p" => agree("R_frac", over_beam(|cos| ray(n, tilt, 0.0, cos).p)),
            "C_external_reflectance_unpol" => agree("R_frac", beam(|r, _| r)),
            "E_mean_chord_parallel_over_R" => agree("T_or_value", over_beam(|cos| 2.0 * cos)),
            // Even light from a hemisphere: polar angle to the axis, azimuth from the normal; cosine sin α cos φ, chord
            // 2 cos φ/sin α.
            "E_mean_chord_isotropic_over_R" => agree(
                "T_or_value",
                integral(0.0, PI, |alpha| {
                    let ring = integral(-FRAC_PI_2, FRAC_PI_2, |phi| {
                        let cosine = alpha.sin() * phi.cos();
                        cosine * 2.0 * phi.cos() / alpha.sin()
                    });
                    alpha.sin() * ring / PI
                }),
            ),
            order => {
                let order: i32 = order.rsplit_once("_p").unwrap().1.parse().unwrap();
                let power = |r: f64, a: f64| match order {
                    0 => r,
                    _ => (1.0 - r).powi(2) * r.powi(order - 1) * a.powi(order),
                };
                agree(
                    "power",
                    over_beam(|cos| ray(n, tilt, mu_a_r, cos).mean(polarised, power)),
                );
            }
        }
    }
    assert_eq!(compared, 166);
}
