//! Laws of the flat shading models.

use nalgebra::Vector3;
use specval::shading::{
    Basis, Brdf, Distribution, LambertCookTorrance, ShadingError, ShadingModel, Specular, classical_model,
    classical_models,
};
use std::f64::consts::PI;

type Vec3 = Vector3<f64>;

const DISTRIBUTIONS: [Distribution; 2] = [Distribution::Beckmann, Distribution::TrowbridgeReitz];

fn direction(theta: f64, phi: f64) -> Vec3 {
    Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

#[test]
fn facet_distribution_is_normalised() {
    for (distribution, m) in DISTRIBUTIONS
        .into_iter()
        .flat_map(|d| [0.02, 0.1, 0.3, 0.7, 1.0].map(|m| (d, m)))
    {
        // 2π ∫ D cosα sinα dα with tanα = m q/(1−q), which spreads the lobe evenly; midpoint rule.
        let n = 200_000;
        let sum: f64 = (0..n)
            .map(|k| {
                let q = (f64::from(k) + 0.5) / f64::from(n);
                let tan = m * q / (1.0 - q);
                let cos = 1.0 / 1f64.hypot(tan);
                let dtan = m / ((1.0 - q) * (1.0 - q)) / f64::from(n);
                // sinα dα = tanα cos³α d(tanα)
                2.0 * PI * distribution.density(cos, m) * cos * tan * cos.powi(3) * dtan
            })
            .sum();
        assert!((sum - 1.0).abs() < 1e-8, "{distribution:?} {m}: {sum}");
        assert_eq!(distribution.density(-0.5, m), 0.0);
    }
}

#[test]
fn specular_brdf_is_reciprocal_and_isotropic() {
    for distribution in DISTRIBUTIONS {
        let specular = Specular::new(distribution, 0.35, 1.557, 0.8).unwrap();
        for a in [0.0, 0.4, 1.2, 1.55] {
            for b in [0.1, 0.9, 1.5] {
                for phi in [0.0, 1.0, 2.5, PI] {
                    let (one, other) = (direction(a, 0.3), direction(b, 0.3 + phi));
                    let (f, g) = (specular.brdf(&one, &other).0, specular.brdf(&other, &one).0);
                    assert_eq!(f, g);
                    let turned = specular.brdf(&direction(a, 1.9), &direction(b, 1.9 + phi)).0;
                    assert!((f - turned).abs() <= 1e-11 * f, "{f} {turned}");
                    assert!(f.is_finite() && f >= 0.0);
                }
            }
        }
    }
}

/// Directional albedo ∫ f cosθ_v dω_v, integrated over facet normals, where the lobe is narrow in no direction: the
/// mirrored direction sweeps 4 (v·h) steradians a steradian of normals.
fn albedo(specular: &Specular, m: f64, omega_in: &Vec3) -> f64 {
    let (rings, sectors) = (800, 180);
    let mut sum = 0.0;
    for k in 0..rings {
        let q = (f64::from(k) + 0.5) / f64::from(rings);
        let tan = m * q / (1.0 - q);
        let cos = 1.0 / 1f64.hypot(tan);
        let solid_angle =
            tan * cos.powi(3) * m / ((1.0 - q) * (1.0 - q)) / f64::from(rings) * 2.0 * PI / f64::from(sectors);
        for s in 0..sectors {
            let h = direction(tan.atan(), 2.0 * PI * (f64::from(s) + 0.5) / f64::from(sectors));
            let l_h = omega_in.dot(&h);
            let omega_out = h * (2.0 * l_h) - omega_in;
            if l_h > 0.0 && omega_out.z > 0.0 {
                sum += specular.brdf(omega_in, &omega_out).0 * omega_out.z * 4.0 * l_h * solid_angle;
            }
        }
    }
    sum
}

#[test]
fn white_furnace_never_gains_energy() {
    // An index of 1e6 makes all but perfect mirrors of the facets.
    for (distribution, m) in DISTRIBUTIONS
        .into_iter()
        .flat_map(|d| [0.02, 0.1, 0.3, 0.6, 1.0].map(|m| (d, m)))
    {
        let mirror = Specular::new(distribution, m, 1e6, 1.0).unwrap();
        for theta_deg in [0.0, 30.0, 60.0, 80.0, 89.0f64] {
            let found = albedo(&mirror, m, &direction(theta_deg.to_radians(), 0.0));
            assert!(found <= 1.0 + 1e-4, "{distribution:?} {m} {theta_deg}: {found}");
            // Facets of small slope, far from grazing, lose nothing: the 4 of the formula is right, not π.
            if m == 0.02 && theta_deg <= 60.0 {
                let lost = if distribution == Distribution::Beckmann {
                    1e-3
                } else {
                    2e-2
                };
                assert!(found > 1.0 - lost, "{distribution:?} {theta_deg}: {found}");
            }
        }
    }
}

#[test]
fn gloss_has_the_fresnel_limits() {
    // At normal incidence and view f = w ((n − 1)/(n + 1))² / (4 π m²).
    for distribution in DISTRIBUTIONS {
        let specular = Specular::new(distribution, 0.25, 1.557, 0.5).unwrap();
        let expected = 0.5 * (0.557f64 / 2.557).powi(2) / (4.0 * PI * 0.0625);
        let found = specular.brdf(&Vec3::z(), &Vec3::z());
        assert!((found.0 - expected).abs() < 1e-14 * expected.max(1.0));
        assert!((found.brightness_factor().0 - PI * expected).abs() < 1e-14);
        // Mirror configuration: h on the normal, D = 1/(π m²), G = 1 and F → 1 at grazing.
        let theta = 89.999f64.to_radians();
        let f = specular.brdf(&direction(theta, 0.0), &direction(theta, PI)).0;
        let fresnel = f * 4.0 * theta.cos().powi(2) * PI * 0.0625 / 0.5;
        assert!(fresnel < 1.0 && fresnel > 0.9998, "{fresnel}");
        // At Brewster's angle only the perpendicular polarisation is left: F = ((n² − 1)/(n² + 1))² / 2.
        let brewster = 1.557f64.atan();
        let f = specular.brdf(&direction(brewster, 0.0), &direction(brewster, PI)).0;
        let fresnel = f * 4.0 * brewster.cos().powi(2) * PI * 0.0625 / 0.5;
        let n2 = 1.557f64.powi(2);
        assert!((fresnel - 0.5 * ((n2 - 1.0) / (n2 + 1.0)).powi(2)).abs() < 1e-14);
        // Without a step of index there is no gloss, and none from below or in the plane.
        let none = Specular::new(distribution, 0.25, 1.0, 1.0).unwrap();
        assert!(none.brdf(&direction(0.5, 0.0), &direction(0.7, PI)).0 < 1e-30);
        assert_eq!(specular.brdf(&Vec3::x(), &Vec3::z()), Brdf(0.0));
        assert_eq!(specular.brdf(&Vec3::z(), &-Vec3::z()), Brdf(0.0));
    }
}

#[test]
fn attenuation_follows_blinn() {
    // θ_l = 80°, θ_v = 70° on one side: h at 75°, v·h = cos 5°; G = 2 cos75° cos80° / cos5°.
    let m = 0.9;
    let (l, v) = (direction(80f64.to_radians(), 0.0), direction(70f64.to_radians(), 0.0));
    let (c80, c75, c70, c5) = (
        80f64.to_radians().cos(),
        75f64.to_radians().cos(),
        70f64.to_radians().cos(),
        5f64.to_radians().cos(),
    );
    let g = 2.0 * c75 * c80 / c5;
    let mirror = Specular::new(Distribution::Beckmann, m, 1e9, 1.0).unwrap();
    let d = (-(1.0 / (c75 * c75) - 1.0) / (m * m)).exp() / (PI * m * m * c75.powi(4));
    let expected = d * g / (4.0 * c80 * c70);
    assert!((mirror.brdf(&l, &v).0 / expected - 1.0).abs() < 1e-7);
}

#[test]
fn parameters_out_of_range_are_rejected() {
    let new = |m, n, w| Specular::new(Distribution::Beckmann, m, n, w).map(|_| ());
    assert_eq!(new(0.0, 1.5, 1.0), Err(ShadingError::Roughness { found: 0.0 }));
    assert_eq!(new(0.3, 0.9, 1.0), Err(ShadingError::Index { found: 0.9 }));
    assert_eq!(new(0.3, 1.5, 1.1), Err(ShadingError::Weight { found: 1.1 }));
    for bad in [
        new(f64::NAN, 1.5, 1.0),
        new(0.3, f64::NAN, 1.0),
        new(0.3, f64::INFINITY, 1.0),
        new(0.3, 1.5, f64::NAN),
    ] {
        assert!(bad.is_err());
    }
    let specular = Specular::new(Distribution::Beckmann, 0.4, 1.557, 0.7).unwrap();
    for bad in [f64::NAN, f64::INFINITY] {
        for channel in 0..4 {
            let mut normal = [0.4, 0.1, 0.05, 0.2];
            normal[channel] = bad;
            let error = LambertCookTorrance::new(normal, specular).unwrap_err();
            assert!(error.to_string().contains("normal/normal"), "{error}");
        }
    }
}

#[test]
fn classical_model_adds_white_gloss_to_the_normal_reading() {
    // Green below 0: a saturated red outside the gamut. The white of an illuminant that is not the RGB space's own.
    let (normal, white) = ([0.6, -0.02, 0.05, 0.13], [1.1, 0.98, 0.9, 1.0]);
    let specular = Specular::new(Distribution::Beckmann, 0.4, 1.557, 0.7).unwrap();
    let classical = LambertCookTorrance::new(normal, specular).unwrap();
    for (theta_l, theta_v) in [(0.0, 0.0), (0.5, 1.1), (1.0, 0.2)] {
        let (l, v) = (direction(theta_l, PI), direction(theta_v, 0.0));
        let gloss = PI * specular.brdf(&l, &v).0;
        assert!(gloss > 0.0);
        let found = classical.eval(&l, &v, &white);
        for channel in 0..4 {
            assert!((found[channel] - normal[channel] - gloss * white[channel]).abs() < 1e-15);
        }
    }
}

#[test]
fn classical_model_without_gloss_is_lambert() {
    let none = Specular::new(Distribution::Beckmann, 0.4, 1.557, 0.0).unwrap();
    let normal = [0.37, 0.1, -0.01, 1.2];
    let classical = LambertCookTorrance::new(normal, none).unwrap();
    for theta in [0.0, 0.7, 1.5] {
        let found = classical.eval(&direction(0.3, 1.0), &direction(theta, 2.0), &[1.0; 4]);
        assert_eq!(found, normal);
    }
    for (l, v) in [(-Vec3::z(), Vec3::z()), (Vec3::z(), -Vec3::z()), (Vec3::x(), Vec3::z())] {
        assert_eq!(classical.eval(&l, &v, &[1.0; 4]), [0.0; 4]);
    }
}

/// For every model of the registry, the start values lie within the ranges, build the default model, and are accepted
/// as parameters.
#[test]
fn registered_classical_models_start_from_a_sample() {
    let basis = Basis {
        normal: [0.6, 0.1, 0.05, 0.2],
        specular: Specular::new(Distribution::TrowbridgeReitz, 0.4, 1.557, 0.7).unwrap(),
    };
    let (l, v, white) = (direction(0.5, PI), direction(0.8, 0.0), [1.0; 4]);
    for model in classical_models() {
        let start = (model.start)(&basis);
        assert_eq!(start.len(), model.parameters.len(), "{}", model.id);
        let shaded = model.of(&basis).unwrap().eval(&l, &v, &white);
        assert!(
            shaded.iter().all(|beta| beta.is_finite() && *beta > 0.0),
            "{}",
            model.id
        );
        assert_eq!(model.with(&basis, &start).unwrap().eval(&l, &v, &white), shaded);
        for (place, parameter) in model.parameters.iter().enumerate() {
            let [low, high] = parameter.range;
            assert!((low..=high).contains(&start[place]), "{}", parameter.name);
            let mut moved = start.clone();
            moved[place] = 0.5 * (start[place] + low);
            let other = model.with(&basis, &moved).unwrap().eval(&l, &v, &white);
            assert_ne!(other, shaded, "{} does not depend on {}", model.id, parameter.name);
        }
        assert!(model.with(&basis, &start[1..]).is_err());
        assert_eq!(classical_model(model.id).unwrap().id, model.id);
    }
    let preprint = classical_model("lambert-cook-torrance").unwrap().of(&basis).unwrap();
    let direct = LambertCookTorrance::new(basis.normal, basis.specular).unwrap();
    assert_eq!(preprint.eval(&l, &v, &white), direct.eval(&l, &v, &white));
    let unknown = classical_model("lambert-cook-torance").err().unwrap().to_string();
    assert!(unknown.contains("lambert-cook-torrance"), "{unknown}");
}
