//! Laws and formulas of the classical models of the registry.

use nalgebra::Vector3;
use specval::shading::{Basis, Distribution, Lobes, ShadingModel, Specular, classical_model, classical_models};
use std::f64::consts::PI;

type Vec3 = Vector3<f64>;

fn direction(theta: f64, phi: f64) -> Vec3 {
    Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

fn basis() -> Basis {
    Basis {
        normal: [1.0; 4],
        specular: Specular::new(Distribution::Beckmann, 0.4, 1.557, 0.7).unwrap(),
    }
}

fn shaped(id: &str, shape: &[f64]) -> Box<dyn ShadingModel> {
    classical_model(id).unwrap().shaped(&basis(), shape).unwrap()
}

/// Points of every range, the ends included, that no lobe is too narrow for.
fn shapes(id: &str) -> Vec<Vec<f64>> {
    match id {
        "oren-nayar" => [0.0, 10.0, 17.0, 40.0, 90.0].map(|slope| vec![slope]).to_vec(),
        "lambert-charlie" => [0.05, 0.1, 0.3, 0.6, 1.0]
            .map(|roughness| vec![roughness, 1.0])
            .to_vec(),
        "lambert-cook-torrance" | "lambert-ggx" => [0.15, 0.4, 1.0].map(|roughness| vec![roughness, 1e6, 1.0]).to_vec(),
        other => panic!("{other} has no shapes here"),
    }
}

#[test]
fn classical_models_are_reciprocal_isotropic_and_never_negative() {
    for model in classical_models() {
        for shape in shapes(model.id) {
            let shaded = shaped(model.id, &shape);
            for (a, b, phi) in [
                (0.0, 0.4, 0.0),
                (0.1, 1.2, 1.0),
                (0.9, 1.5, 2.5),
                (1.5, 1.55, PI),
                (0.7, 0.7, 0.0),
            ] {
                let (one, other) = (direction(a, 0.3), direction(b, 0.3 + phi));
                let (found, exchanged) = (shaded.lobes(&one, &other), shaded.lobes(&other, &one));
                let turned = shaded.lobes(&direction(a, 1.9), &direction(b, 1.9 + phi));
                for (x, y) in [(found, exchanged), (found, turned)] {
                    let scale = 1.0 + found.base + found.gloss;
                    assert!((x.base - y.base).abs() < 1e-10 * scale && (x.gloss - y.gloss).abs() < 1e-10 * scale);
                }
                assert!(
                    found.base > 0.0 && found.gloss >= 0.0 && found.gloss.is_finite(),
                    "{} {found:?}",
                    model.id
                );
            }
            for (l, v) in [(-Vec3::z(), Vec3::z()), (Vec3::z(), -Vec3::z()), (Vec3::x(), Vec3::z())] {
                assert_eq!(shaded.lobes(&l, &v), Lobes::default());
            }
        }
    }
}

/// Directional-hemispherical reflectance of base and gloss by the midpoint rule in θ_v and φ.
fn reflectance(shaded: &dyn ShadingModel, theta: f64) -> [f64; 2] {
    let (rings, sectors) = (800, 360);
    let omega_in = direction(theta, 0.0);
    let (mut sums, mut whole) = ([0.0; 2], 0.0);
    for k in 0..rings {
        let theta_v = 0.5 * PI * (f64::from(k) + 0.5) / f64::from(rings);
        let weight = theta_v.sin() * theta_v.cos();
        for s in 0..sectors {
            let phi = 2.0 * PI * (f64::from(s) + 0.5) / f64::from(sectors);
            let lobes = shaded.lobes(&omega_in, &direction(theta_v, phi));
            sums[0] += weight * lobes.base;
            sums[1] += weight * lobes.gloss;
            whole += weight;
        }
    }
    sums.map(|sum| sum / whole)
}

#[test]
fn no_part_of_a_classical_model_gains_energy() {
    for model in classical_models() {
        for shape in shapes(model.id) {
            let shaded = shaped(model.id, &shape);
            for theta_deg in [0.0, 30.0, 60.0, 80.0, 88.0f64] {
                let [base, gloss] = reflectance(&*shaded, theta_deg.to_radians());
                // Oren and Nayar's approximation gains 1.5 % at grazing incidence; 1e-3 is of the midpoint rule.
                let most = if model.id == "oren-nayar" { 1.016 } else { 1.0 + 1e-9 };
                assert!(base <= most, "{} {shape:?} {theta_deg}: {base}", model.id);
                assert!(gloss <= 1.0 + 1e-3, "{} {shape:?} {theta_deg}: {gloss}", model.id);
            }
        }
    }
}

#[test]
fn oren_nayar_is_its_formula_and_has_its_albedos() {
    for slope_deg in [0.0, 12.0, 35.0, 90.0f64] {
        let model = shaped("oren-nayar", &[slope_deg]);
        let sigma2 = slope_deg.to_radians().powi(2);
        let a = 1.0 - 0.5 * sigma2 / (sigma2 + 0.33);
        let b = 0.45 * sigma2 / (sigma2 + 0.09);
        for (theta_i, theta_r, phi) in [(0.3, 1.1, 0.4), (1.2, 0.5, 1.3), (0.8, 0.7, 2.8), (0.0, 0.9, 0.0)] {
            let (alpha, beta) = (f64::max(theta_i, theta_r), f64::min(theta_i, theta_r));
            let expected = a + b * f64::max(0.0, f64::cos(phi)) * alpha.sin() * beta.tan();
            let found = model.lobes(&direction(theta_i, 0.2), &direction(theta_r, 0.2 + phi));
            assert!((found.base - expected).abs() < 1e-12, "{found:?} {expected}");
            assert_eq!(found.gloss, 0.0);
        }
        // ∫ max(0, cosφ) tanθ cosθ dω / π is 1/2; at the normal the second term vanishes.
        let [normal, _] = reflectance(&*model, 0.0);
        let [grazing, _] = reflectance(&*model, 89.9999f64.to_radians());
        // Sums of 288000 terms: rounding.
        assert!((normal - a).abs() < 1e-11, "{normal} {a}");
        assert!((grazing - a - b / 2.0).abs() < 1e-5, "{} {grazing}", a + b / 2.0);
    }
}

#[test]
fn ggx_is_the_formula_of_walter_and_others() {
    for (alpha, n, weight) in [(0.1, 1.5, 1.0), (0.45, 1.8, 0.6), (1.0, 1.3, 0.2f64)] {
        let model = shaped("lambert-ggx", &[alpha, n, weight]);
        for (theta_i, theta_o, phi) in [(0.0, 0.0, 0.0), (0.4, 0.9, PI), (1.2, 0.3, 2.0), (1.4, 1.5, 0.7f64)] {
            let (i, o) = (direction(theta_i, 0.0), direction(theta_o, phi));
            let h = (i + o).normalize();
            let theta_m = h.z.min(1.0).acos();
            let d = alpha.powi(2) / (PI * theta_m.cos().powi(4) * (alpha.powi(2) + theta_m.tan().powi(2)).powi(2));
            let g1 = |theta: f64| 2.0 / (1.0 + (1.0 + alpha.powi(2) * theta.tan().powi(2)).sqrt());
            // Their equation 22.
            let c = i.dot(&h);
            let g = (n * n - 1.0 + c * c).sqrt();
            let f = 0.5 * ((g - c) / (g + c)).powi(2) * (1.0 + ((c * (g + c) - 1.0) / (c * (g - c) + 1.0)).powi(2));
            let expected = PI * weight * f * g1(theta_i) * g1(theta_o) * d / (4.0 * theta_i.cos() * theta_o.cos());
            let found = model.lobes(&i, &o);
            assert!((found.gloss / expected - 1.0).abs() < 1e-10, "{found:?} {expected}");
            assert_eq!(found.base, 1.0);
        }
    }
}

/// The sheen's formula in θ, with the paper's coefficients (their Table 1) for the ends of the roughness.
#[test]
fn charlie_is_the_formula_of_estevez_and_kulla() {
    let l = |x: f64, r: f64| {
        let p = |zero: f64, one: f64| (1.0 - r).powi(2) * zero + (1.0 - (1.0 - r).powi(2)) * one;
        let (a, b, c) = (p(25.3245, 21.5473), p(3.32435, 3.82987), p(0.16801, 0.19823));
        a / (1.0 + b * x.powf(c)) + p(-1.27393, -1.97760) * x + p(-4.85967, -4.32054)
    };
    let lambda = |theta: f64, r: f64| match theta.cos() < 0.5 {
        true => l(theta.cos(), r).exp(),
        false => (2.0 * l(0.5, r) - l(1.0 - theta.cos(), r)).exp(),
    };
    for r in [0.05, 0.2, 0.5, 1.0] {
        let model = shaped("lambert-charlie", &[r, 0.3]);
        for (theta_i, theta_o, phi) in [(0.2, 0.5, PI), (1.0, 0.3, 2.0), (1.2, 1.5, 0.0), (1.3, 1.1, 1.0f64)] {
            let (i, o) = (direction(theta_i, 0.4), direction(theta_o, 0.4 + phi));
            let theta_h = (i + o).normalize().z.acos();
            let d = (2.0 + 1.0 / r) * theta_h.sin().powf(1.0 / r) / (2.0 * PI);
            let g = 1.0 / (1.0 + lambda(theta_i, r) + lambda(theta_o, r));
            let expected = PI * 0.3 * d * g / (4.0 * theta_i.cos() * theta_o.cos());
            let found = model.lobes(&i, &o);
            assert!(
                (found.gloss - expected).abs() < 1e-10 * expected.max(1.0),
                "{r}: {found:?} {expected}"
            );
            assert_eq!(found.base, 1.0);
        }
    }
}

#[test]
fn every_classical_model_starts_with_the_albedo() {
    for model in classical_models() {
        assert_eq!(model.parameters[0].name, "diffuse");
        assert_eq!(model.shape(), &model.parameters[1..]);
        let start = (model.start)(&basis());
        let albedo = |diffuse: f64| {
            model
                .with(&basis(), &[&[diffuse], &start[1..]].concat())
                .unwrap()
                .albedo()
        };
        assert_eq!((albedo(1.0), albedo(0.25)), ([1.0; 4], [0.25; 4]));
    }
    for (id, bad) in [
        ("oren-nayar", vec![-1.0]),
        ("oren-nayar", vec![f64::NAN]),
        ("lambert-charlie", vec![0.01, 0.5]),
        ("lambert-charlie", vec![0.5, 1.5]),
        ("lambert-ggx", vec![0.5, 0.9, 0.5]),
    ] {
        assert!(
            classical_model(id).unwrap().shaped(&basis(), &bad).is_err(),
            "{id} {bad:?}"
        );
    }
}
