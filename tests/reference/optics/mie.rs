//! The Mie series against 50-digit references, laws, and limits.

use num_complex::Complex64;
use specval::optics::Mie;
use specval::optics::mie::{MAX_INTERNAL_SIZE, MAX_SIZE_PARAMETER, MIN_SIZE_PARAMETER};

use super::reference::{Table, gauss_legendre, relative};

fn sphere(n: f64, kappa: f64, x: f64) -> Mie {
    Mie::sphere(Complex64::new(n, kappa), x).unwrap()
}

/// Documented tolerance of Q and g.
fn tolerance(x: f64) -> f64 {
    if x <= 1e4 { 1e-10 } else { 1e-8 }
}

/// `points` values from low to high, both included, evenly spaced in their logarithm.
fn log_grid(low: f64, high: f64, points: u32) -> impl Iterator<Item = f64> {
    (0..points).map(move |i| (low * (high / low).powf(f64::from(i) / f64::from(points - 1))).clamp(low, high))
}

/// Worst found: 1e-14 in Q_ext, Q_sca and g, 1.2e-11 in Q_back.
#[test]
fn efficiencies_of_the_published_hard_cases() {
    let table = Table::parse(include_str!("../../data/mie/mie_wiscombe.csv"));
    assert_eq!(table.len(), 19);
    for row in table.rows() {
        let x = row.number("x");
        let sphere = match row.text("kind") {
            "pec" => Mie::conducting(x).unwrap(),
            _ => sphere(row.number("m_re"), row.number("m_im"), x),
        };
        let q = sphere.efficiencies();
        for (name, found) in [
            ("Qext_mp", q.q_ext),
            ("Qsca_mp", q.q_sca),
            ("Qback_mp", q.q_back),
            ("g_mp", q.g),
        ] {
            let error = relative(found, row.number(name));
            assert!(
                error <= tolerance(x),
                "{name} of {row:?}: {found:e} is off by {error:e}"
            );
        }
    }
}

#[test]
fn efficiencies_at_the_ends_of_the_domain() {
    let table = Table::parse(include_str!("../../data/mie/mie_extremes.csv"));
    assert_eq!(table.len(), 34);
    for row in table.rows() {
        let x = row.number("x");
        let m = Complex64::new(row.number("m_re"), row.number("m_im"));
        let q = Mie::sphere(m, x).unwrap().efficiencies();
        for (name, found) in [
            ("Qext", q.q_ext),
            ("Qsca", q.q_sca),
            ("Qabs", q.q_abs),
            ("Qback", q.q_back),
            ("g", q.g),
        ] {
            let error = relative(found, row.number(name));
            // A rounding of m moves a nearly matched sphere by 1/|m - 1|: 1e-7 costs seven digits.
            let allowed = if (m - 1.0).norm() < 1e-6 { 1e-8 } else { tolerance(x) };

            assert!(error <= allowed, "{name} of {row:?}: {found:e} is off by {error:e}");
        }
    }
}

#[test]
fn amplitudes_of_the_published_cases() {
    let table = Table::parse(include_str!("../../data/mie/mie_amplitudes.csv"));
    assert_eq!(table.len(), 76);
    for row in table.rows() {
        let sphere = sphere(row.number("m_re"), row.number("m_im"), row.number("x"));
        let scale = sphere.amplitudes(1.0).0.norm();
        let (s1, s2) = sphere.amplitudes(row.number("theta_deg").to_radians().cos());
        let expected =
            |name: &str| Complex64::new(row.number(&format!("{name}_re")), row.number(&format!("{name}_im")));
        let error = (s1 - expected("S1")).norm().max((s2 - expected("S2")).norm()) / scale;
        // Worst found: 7e-15.
        assert!(error <= 1e-13, "{row:?}: {error:e}");
    }
}

/// Worst found: 3e-12 of |S(0)|.
#[test]
fn amplitudes_of_large_spheres() {
    let table = Table::parse(include_str!("../../data/mie/mie_amplitudes_large.csv"));
    assert_eq!(table.len(), 24);
    for row in table.rows() {
        let sphere = sphere(row.number("m_re"), row.number("m_im"), row.number("x"));
        let scale = sphere.amplitudes(1.0).0.norm();
        let (s1, s2) = sphere.amplitudes(row.number("cos_theta"));
        let expected =
            |name: &str| Complex64::new(row.number(&format!("{name}_re")), row.number(&format!("{name}_im")));
        let error = (s1 - expected("S1")).norm().max((s2 - expected("S2")).norm());
        assert!(error <= 1e-11 * scale, "{row:?}: {error:e}");
    }
}

#[test]
fn cotton_yarn_efficiencies() {
    let table = Table::parse(include_str!("../../data/mie/mie_cotton.csv"));
    assert_eq!(table.len(), 70);
    for row in table.rows() {
        let x = 2.0 * std::f64::consts::PI * 1.557 * row.number("radius_nm") / row.number("lambda_nm");
        let q = sphere(1.61 / 1.557, row.number("kappa") / 1.557, x).efficiencies();
        for (name, found) in [("Qext", q.q_ext), ("Qsca", q.q_sca), ("Qabs", q.q_abs), ("g", q.g)] {
            let error = relative(found, row.number(name));
            assert!(error <= 1e-12, "{name} of {row:?}: {found:e} is off by {error:e}");
        }
    }
}

#[test]
fn cotton_yarn_phase_functions() {
    let table = Table::parse(include_str!("../../data/mie/mie_phase_cotton.csv"));
    assert_eq!(table.len(), 181);
    for (size, radius_nm) in [("d150", 75.0), ("r150", 150.0)] {
        for (label, kappa) in [("k0", 0.0), ("k1e-2", 1e-2)] {
            for lambda_nm in [400.0, 550.0, 700.0] {
                let x = 2.0 * std::f64::consts::PI * 1.557 * radius_nm / lambda_nm;
                let sphere = sphere(1.61 / 1.557, kappa / 1.557, x);
                let norm = std::f64::consts::PI * x * x * sphere.efficiencies().q_sca;
                let column = format!("p_{size}_{label}_{lambda_nm}");
                for row in table.rows() {
                    let found = sphere.unpolarised(row.number("theta_deg").to_radians().cos()) / norm;
                    let error = relative(found, row.number(&column));
                    assert!(error <= 1e-11, "{column} at {row:?}: {found:e} is off by {error:e}");
                }
            }
        }
    }
}

#[test]
fn lossless_spheres_scatter_all_they_remove() {
    for x in log_grid(MIN_SIZE_PARAMETER, MAX_SIZE_PARAMETER, 45) {
        for n in [0.75, 1.0340398201669878, 1.5, 4.0] {
            let sphere = sphere(n, 0.0, x);
            let q = sphere.efficiencies();
            assert_eq!((q.q_ext, q.q_abs), (q.q_sca, 0.0), "n = {n}, x = {x}");
            let forward = 4.0 / (x * x) * sphere.amplitudes(1.0).0.re;
            assert!(relative(forward, q.q_ext) <= 1e-12, "optical theorem, n = {n}, x = {x}");
        }
    }
}

#[test]
fn the_optical_theorem_holds_and_absorption_is_positive() {
    for x in log_grid(MIN_SIZE_PARAMETER, MAX_SIZE_PARAMETER, 23) {
        for (n, kappa) in [(1.5, 1e-15), (1.034, 1e-6), (1.33, 0.1), (0.2, 3.4), (50.0, 60.0)] {
            let sphere = sphere(n, kappa, x);
            let q = sphere.efficiencies();
            let (s1, s2) = sphere.amplitudes(1.0);
            assert_eq!(s1, s2);
            assert!(
                relative(4.0 / (x * x) * s1.re, q.q_ext) <= 1e-12,
                "m = {n}+{kappa}i, x = {x}"
            );
            assert!(
                q.q_abs > 0.0 && q.q_sca > 0.0 && q.q_ext.is_finite() && q.g.abs() <= 1.0,
                "{q:?}"
            );
        }
    }
}

/// The efficiencies come from the coefficients, the amplitudes from the angular recurrences: two ways to one number.
#[test]
fn amplitudes_integrate_to_scattering_and_asymmetry() {
    for (n, kappa, x) in [
        (1.5, 0.0, 1e-6),
        (1.034, 0.0, 1.3),
        (1.5, 1.0, 1.0),
        (1.33, 0.01, 30.0),
        (0.75, 0.0, 200.0),
    ] {
        let sphere = sphere(n, kappa, x);
        let q = sphere.efficiencies();
        let (mut total, mut mean) = (0.0, 0.0);
        for (cos, weight) in gauss_legendre(2 * x as usize + 60) {
            let value = weight * sphere.unpolarised(cos) * 2.0 / (x * x);
            total += value;
            mean += value * cos;
        }
        assert!(relative(total, q.q_sca) < 1e-11, "{total:e} {q:?}");
        assert!((mean / total - q.g).abs() < 1e-11, "{mean:e} {q:?}");
    }
}

#[test]
fn small_spheres_follow_rayleigh() {
    for (n, kappa) in [(1.5, 0.0), (1.034, 0.0), (1.33, 0.3)] {
        let m = Complex64::new(n, kappa);
        let lorentz = (m * m - 1.0) / (m * m + 2.0);
        let x = 1e-4_f64;
        let sphere = sphere(n, kappa, x);
        let q = sphere.efficiencies();
        assert!(relative(q.q_sca, 8.0 / 3.0 * x.powi(4) * lorentz.norm_sqr()) < 1e-7);
        assert!((q.q_abs - 4.0 * x * lorentz.im).abs() <= 1e-7 * q.q_abs);
        let (s1, s2) = sphere.amplitudes(0.3);
        assert!((s2 / s1 - 0.3).norm() < 1e-7, "S2/S1 = cos θ");
    }
}

/// Twice the geometric cross section, half of it diffracted forwards, half reflected evenly: Q = 2, g = 1/2, Q_back =
/// 1.
#[test]
fn large_conducting_spheres_follow_geometrical_optics() {
    let q = Mie::conducting(MAX_SIZE_PARAMETER).unwrap().efficiencies();
    // Q − 2 falls as x^(-2/3): 6e-5 here.
    assert!(
        (q.q_sca - 2.0).abs() < 1e-4 && (q.g - 0.5).abs() < 1e-4 && (q.q_back - 1.0).abs() < 1e-6,
        "{q:?}"
    );
    assert_eq!((q.q_ext, q.q_abs), (q.q_sca, 0.0));
}

#[test]
fn conducting_is_the_limit_of_a_large_index() {
    let limit = Mie::conducting(3.0).unwrap().efficiencies();
    let metal = sphere(1e5, 1e5, 3.0).efficiencies();
    assert!((metal.q_sca - limit.q_sca).abs() < 1e-4 && (metal.g - limit.g).abs() < 1e-4);
}

#[test]
fn forward_and_backward_amplitudes_are_tied() {
    for x in [1e-3, 1.7, 40.0, 1e4] {
        let sphere = sphere(1.4, 0.02, x);
        let (s1, s2) = sphere.amplitudes(1.0);
        assert_eq!(s1, s2);
        let (s1, s2) = sphere.amplitudes(-1.0);
        assert!((s1 + s2).norm() <= 1e-12 * s1.norm());
        let q_back = 4.0 * s1.norm_sqr() / (x * x);
        assert!(relative(q_back, sphere.efficiencies().q_back) < 1e-6, "x = {x}");
    }
}

#[test]
fn a_matched_sphere_is_invisible() {
    let sphere = sphere(1.0, 0.0, 5.0);
    let q = sphere.efficiencies();
    assert_eq!((q.q_ext, q.q_sca, q.q_abs, q.q_back, q.g), (0.0, 0.0, 0.0, 0.0, 0.0));
    assert_eq!(sphere.unpolarised(0.2), 0.0);
}

#[test]
fn the_domain_is_declared_and_kept() {
    assert_eq!((MIN_SIZE_PARAMETER, MAX_SIZE_PARAMETER), (1e-6, 1e5));
    for x in [0.99e-6, 1.01e5, 0.0, -1.0, f64::NAN, f64::INFINITY] {
        for error in [
            Mie::sphere(Complex64::new(1.5, 0.0), x).unwrap_err(),
            Mie::conducting(x).unwrap_err(),
        ] {
            let text = error.to_string();
            assert!(text.contains("from 1e-6 to 100000"), "{text}");
        }
    }
    for m in [
        (0.0, 0.0),
        (-1.5, 0.0),
        (1.5, -1e-9),
        (f64::NAN, 0.0),
        (1.5, f64::NAN),
        (f64::INFINITY, 0.0),
    ] {
        assert!(Mie::sphere(Complex64::new(m.0, m.1), 1.0).is_err(), "{m:?}");
    }
    let too_large = Mie::sphere(Complex64::new(2.0 * MAX_INTERNAL_SIZE, 0.0), 1.0).unwrap_err();
    assert!(too_large.to_string().contains("1e7"), "{too_large}");
}
