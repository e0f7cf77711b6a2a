//! Classical models fitted to readings, and what they predict.

use ndarray::Array2;
use rand::RngExt;
use specval::colour::Convention;
use specval::fit::{
    Bound, Candidate, Channel, FitError, FitReadings, Predictions, Rival, colour_differences, left_out, rms,
};
use specval::rig::{Geometry, Rig, omega_in, omega_out};
use specval::sample::Sample;
use specval::shading::{Basis, Distribution, Specular, classical_model};
use specval::transport::{Purpose, Stream};

fn gloss() -> Specular {
    Specular::new(Distribution::Beckmann, 0.4, 1.557, 0.7).unwrap()
}

fn rival(id: &str) -> Rival {
    Rival::new(classical_model(id).unwrap(), gloss(), 1)
}

/// Readings of a classical model on the preprint's rig, with 5 % uncertainty and no noise.
fn synthetic(id: &str, shape: &[f64], channels: &[(Channel, f64)]) -> FitReadings {
    let rig = Rig::default();
    let geometries: Vec<Geometry> = rig
        .incidences_deg()
        .iter()
        .flat_map(|&theta_i_deg| {
            rig.views_deg().iter().map(move |&theta_v_deg| Geometry {
                theta_i_deg,
                theta_v_deg,
            })
        })
        .collect();
    let basis = Basis {
        normal: [1.0; 4],
        specular: gloss(),
    };
    let model = classical_model(id).unwrap().shaped(&basis, shape).unwrap();
    let beta = Array2::from_shape_fn((geometries.len(), channels.len()), |(g, c)| {
        let Geometry {
            theta_i_deg,
            theta_v_deg,
        } = geometries[g];
        let lobes = model.lobes(&omega_in(theta_i_deg, 0.0), &omega_out(theta_v_deg, 0.0));
        channels[c].1 * lobes.base + lobes.gloss
    });
    FitReadings {
        sample: "synthetic".into(),
        geometries,
        channels: channels.iter().map(|(channel, _)| *channel).collect(),
        se: 0.05 * &beta,
        beta,
        white: vec![1.0; channels.len()],
        rgby: None,
        transmission: false,
        notices: Vec::new(),
    }
}

const RGB: [(Channel, f64); 3] = [(Channel::Red, 0.5), (Channel::Green, 0.04), (Channel::Blue, 0.0)];

fn with_noise(mut readings: FitReadings, seed: u64) -> FitReadings {
    let mut stream = Stream::open(seed, Purpose::Check, 0, 0, 0);
    for (beta, se) in readings.beta.iter_mut().zip(&readings.se) {
        // Sum of twelve uniform numbers less 6: variance 1.
        let normal: f64 = (0..12).map(|_| stream.random::<f64>()).sum::<f64>() - 6.0;
        *beta += se * normal;
    }
    readings
}

#[test]
fn every_rival_finds_its_own_readings() {
    for (id, shape) in [
        ("oren-nayar", &[31.0][..]),
        ("lambert-cook-torrance", &[0.3, 1.5, 0.6]),
        ("lambert-ggx", &[0.35, 1.5, 0.5]),
        ("lambert-charlie", &[0.4, 0.2]),
    ] {
        let mut readings = synthetic(id, shape, &RGB);
        // Oren–Nayar has no gloss, so a channel without albedo is black.
        readings.se.mapv_inplace(|se| se.max(1e-4));
        let fitted = rival(id).fit(&readings).unwrap();
        assert!(
            fitted.misfit(&readings).unwrap() < 1e-4,
            "{id}: {}",
            fitted.misfit(&readings).unwrap()
        );
        assert!(fitted.converged());
        assert_eq!(fitted.count(), 3 + shape.len());
        let parameters = fitted.parameters();
        let names: Vec<&str> = parameters.iter().map(|parameter| parameter.name.as_str()).collect();
        assert_eq!(names[..3], ["albedo r", "albedo g", "albedo b"]);
        assert!(
            (parameters[0].value - 0.5).abs() < 1e-4 && (parameters[1].value - 0.04).abs() < 1e-4,
            "{parameters:?}"
        );
        assert!(parameters[2].value < 1e-4);
        // What predicts the rig's readings predicts others.
        let elsewhere = Geometry {
            theta_i_deg: 45.0,
            theta_v_deg: 52.5,
        };
        let predicted = fitted.predict(&[elsewhere]).unwrap();
        assert_eq!(predicted.dim(), (1, 3));
        let all = fitted.predict(&readings.geometries).unwrap();
        assert!(rms(readings.residuals(&all)) < 1e-4);
    }
}

#[test]
fn spectral_readings_have_an_albedo_a_wavelength() {
    let channels: Vec<(Channel, f64)> = (0..35)
        .map(|k| (Channel::Wavelength(390.0 + 10.0 * f64::from(k)), 0.02 * f64::from(k)))
        .collect();
    let mut readings = synthetic("oren-nayar", &[25.0], &channels);
    readings.se.mapv_inplace(|se| se.max(1e-4));
    let fitted = rival("oren-nayar").fit(&readings).unwrap();
    assert_eq!(fitted.count(), 36);
    assert_eq!(fitted.parameters()[34].name, "albedo 730 nm");
    for (k, parameter) in fitted.parameters()[..35].iter().enumerate() {
        assert!((parameter.value - 0.02 * k as f64).abs() < 1e-6);
    }
    assert!((fitted.parameters()[35].value - 25.0).abs() < 1e-4);
    assert_eq!(fitted.parameters()[0].at_bound, Some(Bound::Lower));
}

#[test]
fn albedo_is_never_negative() {
    // A channel darker than its own gloss.
    let mut readings = synthetic("lambert-cook-torrance", &[0.3, 1.5, 0.6], &RGB);
    readings.beta.column_mut(2).fill(1e-3);
    readings.se.column_mut(2).fill(0.5);
    let fitted = rival("lambert-cook-torrance").fit(&readings).unwrap();
    let blue = &fitted.parameters()[2];
    assert_eq!((blue.value, blue.at_bound, blue.se), (0.0, Some(Bound::Lower), None));
    assert!(
        fitted
            .predict(&readings.geometries)
            .unwrap()
            .iter()
            .all(|beta| *beta >= 0.0)
    );
}

#[test]
fn standard_errors_are_those_of_repeated_measurements() {
    let channels = [(Channel::Red, 0.5), (Channel::Green, 0.1)];
    let clean = synthetic("oren-nayar", &[30.0], &channels);
    let truth = [0.5, 0.1, 30.0];
    let (repeats, mut inside, mut chi2) = (200, [0; 3], 0.0);
    for seed in 0..repeats {
        let readings = with_noise(clean.clone(), seed);
        let fitted = rival("oren-nayar").fit(&readings).unwrap();
        for (count, (parameter, truth)) in inside.iter_mut().zip(fitted.parameters().iter().zip(truth)) {
            *count += i32::from((parameter.value - truth).abs() < 1.96 * parameter.se.unwrap());
        }
        chi2 += fitted.misfit(&readings).unwrap().powi(2) / repeats as f64;
    }
    // 95 % of 200 are 190 ± 3.1.
    assert!(inside.iter().all(|count| (179..=200).contains(count)), "{inside:?}");
    // The mean of χ² over n readings is 1 − 3/n, with a standard error of √(2/n/200).
    let n = clean.len() as f64;
    let off = (chi2 - (1.0 - 3.0 / n)) / (2.0 / n / repeats as f64).sqrt();
    assert!(off.abs() < 4.0, "{off}");
}

/// The fit of the preprint's shading to both built-in samples is at least as near as the best of a grid over the shape,
/// and hardly nearer.
#[test]
fn fit_to_built_in_samples_is_the_best_of_a_grid() {
    for name in ["merl-red-fabric", "merl-red-fabric2"] {
        let readings = FitReadings::new(&Sample::load(name).unwrap(), &Convention::default()).unwrap();
        let fitted = rival("lambert-cook-torrance").fit(&readings).unwrap();
        let misfit = fitted.misfit(&readings).unwrap();
        let mut best = f64::INFINITY;
        for roughness in (1..=40).map(|k| 0.025 * f64::from(k)) {
            // Of F w only the height at the mirror counts here: an index with weight 1, or 1.557 with a weight.
            for strength in (0..=40).map(|k| 0.025 * f64::from(k)) {
                for specular in [(1.557, strength), (1.0 + 2.0 * strength, 1.0)] {
                    let specular = Specular::new(Distribution::Beckmann, roughness, specular.0, specular.1).unwrap();
                    let mut squares = 0.0;
                    for c in 0..3 {
                        let (mut product, mut square, mut rest) = (0.0, 0.0, 0.0);
                        for (g, geometry) in readings.geometries.iter().enumerate() {
                            let (l, v) = (
                                omega_in(geometry.theta_i_deg, 0.0),
                                omega_out(geometry.theta_v_deg, 0.0),
                            );
                            let weight = readings.se[(g, c)].powi(-2);
                            let base = readings.beta[(g, c)] - specular.brdf(&l, &v).brightness_factor().0;
                            product += weight * base;
                            square += weight;
                            rest += weight * base * base;
                        }
                        let albedo = f64::max(0.0, product / square);
                        squares += rest - 2.0 * albedo * product + albedo * albedo * square;
                    }
                    best = best.min((squares / readings.len() as f64).sqrt());
                }
            }
        }
        println!("{name}: fit {misfit:.4}, grid {best:.4}");
        assert!(
            misfit <= best + 1e-9 && misfit > 0.9 * best,
            "{name}: fit {misfit}, grid {best}"
        );
    }
}

#[test]
fn left_out_incidences_are_predicted_from_the_others() {
    let readings = with_noise(synthetic("lambert-ggx", &[0.35, 1.5, 0.5], &RGB), 5);
    let right = left_out(&rival("lambert-ggx"), &readings).unwrap();
    let wrong = left_out(&rival("oren-nayar"), &readings).unwrap();
    assert_eq!(
        right.iter().map(|part| part.theta_i_deg).collect::<Vec<_>>(),
        [0.0, 30.0, 60.0]
    );
    for (right, wrong) in right.iter().zip(&wrong) {
        assert!(right.misfit < wrong.misfit, "{} {}", right.misfit, wrong.misfit);
    }
    // Not a reading of the incidence was used: the prediction stays as it is whatever they are.
    let mut other = readings.clone();
    for (geometry, mut row) in readings.geometries.iter().zip(other.beta.outer_iter_mut()) {
        if geometry.theta_i_deg == 30.0 {
            row.fill(7.0);
        }
    }
    let again = left_out(&rival("lambert-ggx"), &other).unwrap();
    assert_eq!(again[1].prediction, right[1].prediction);
    assert_ne!(again[0].prediction, right[0].prediction);
    // Together they are in the order of the readings, whatever that is.
    let joined = Predictions::of(&right, &readings).unwrap();
    let square = |part: &specval::fit::LeftOut| part.misfit.powi(2) * part.prediction.len() as f64;
    let mean = right.iter().map(square).sum::<f64>() / readings.len() as f64;
    assert!((rms(readings.residuals(&joined.beta)) - mean.sqrt()).abs() < 1e-12);
    assert!(joined.batches.is_empty());
    assert!(Predictions::of(&right[1..], &readings).is_none());
    let one = readings.subset(|geometry| geometry.theta_i_deg == 30.0);
    assert!(left_out(&rival("lambert-ggx"), &one).unwrap().is_empty());
}

#[test]
fn impossible_rivals_are_refused() {
    let readings = synthetic("oren-nayar", &[30.0], &RGB);
    let first = readings.geometries[0];
    let few = readings.subset(|geometry| *geometry == first);
    let refused = rival("lambert-ggx").fit(&few).err().unwrap().to_string();
    assert!(
        refused.contains("6 free parameters (albedo r, albedo g, albedo b, roughness, index, weight) and 3 readings"),
        "{refused}"
    );
    let through = FitReadings {
        transmission: true,
        ..readings
    };
    let refused = rival("oren-nayar").fit(&through).err().unwrap();
    assert!(matches!(refused, FitError::Transmission { .. }), "{refused}");
}

#[test]
fn colour_differences_vanish_for_the_sample_itself() {
    let convention = Convention::default();
    let readings = FitReadings::new(&Sample::load("merl-red-fabric").unwrap(), &convention).unwrap();
    let none = colour_differences(&readings, &readings.beta, &convention)
        .unwrap()
        .unwrap();
    assert_eq!(none.len(), readings.geometries.len());
    assert!(none.iter().all(|d| d.delta_e_2000 == 0.0 && d.delta_e_cmc == 0.0));
    let darker = colour_differences(&readings, &(0.8 * &readings.beta), &convention)
        .unwrap()
        .unwrap();
    assert!(darker.iter().all(|d| d.delta_e_2000 > 0.5 && d.delta_e_cmc > 0.5));
    assert_eq!(darker[7].theta_v_deg, readings.geometries[7].theta_v_deg);
}
