//! Errors, ratios and verdicts: exact cases by hand, standard errors against closed forms, and coverage on synthetic
//! noise of fixed seeds.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use specval::colour::{ColourSystem, Convention};
use specval::compare::{
    Channel, Channels, CompareError, Compared, Comparison, Geometry, Inputs, Propagation, Rmse, RmseRatio, Role,
    Source, Verdict, hue, model_colour_ratios,
};
use specval::sample::{Reading, Sample};
use specval::spectrum::WavelengthGrid;
use statrs::distribution::{ContinuousCDF, Normal};
use std::collections::BTreeSet;

/// Luminance row of linear sRGB, enough digits for synthetic data.
const Y_ROW: [f64; 3] = [0.2126, 0.7152, 0.0722];

fn rgby(r: f64, g: f64, b: f64) -> Channels {
    [r, g, b, Y_ROW[0] * r + Y_ROW[1] * g + Y_ROW[2] * b]
}

/// A reading of RGB data: r, g, b err independently, y follows.
fn reading(rgb: [f64; 3], se: [f64; 3]) -> Reading {
    let mut reading = Reading::independent(rgby(rgb[0], rgb[1], rgb[2]), [se[0], se[1], se[2], 0.0]);
    for i in 0..3 {
        reading.covariance[i][3] = Y_ROW[i] * se[i] * se[i];
        reading.covariance[3][i] = reading.covariance[i][3];
        reading.covariance[3][3] += (Y_ROW[i] * se[i]).powi(2);
    }
    reading
}

fn line(theta_i_deg: f64, views: &[f64]) -> Vec<Geometry> {
    views
        .iter()
        .map(|&theta_v_deg| Geometry {
            theta_i_deg,
            theta_v_deg,
        })
        .collect()
}

fn find(ratios: &[RmseRatio], channel: Channel) -> &RmseRatio {
    ratios.iter().find(|r| r.channel == channel).unwrap()
}

#[test]
fn comparison_without_noise_has_exact_values() {
    let geometries = line(0.0, &[-10.0, 0.0, 10.0, 20.0]);
    // Model: the measurement times 2, but 0.1 too high in red at 10 degrees once halved. Classical: flat.
    let measured = [0.2, 0.4, 0.3, 0.1].map(|r| reading([r, 0.1, 0.1], [0.0; 3]));
    let model: Vec<Channels> = [0.2, 0.4, 0.4, 0.1].map(|r| rgby(2.0 * r, 0.2, 0.2)).to_vec();
    let classical = [rgby(0.4, 0.1, 0.1); 4];
    let options = measured.map(Some);
    let comparison = Comparison::of_one_each(&geometries, &[model.clone(), model], &classical, &options).unwrap();
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-14, "{a} {b}");
    let [model, classical] = comparison.normalisation.as_slice() else {
        panic!("{:?}", comparison.normalisation);
    };
    assert!(model.source == "model" && classical.source == "classical");
    close(model.factor.value, 0.5);
    close(classical.factor.value, 1.0);
    let rmse = |role: Role| {
        comparison
            .rmse
            .iter()
            .find(|m| m.source == role.id() && m.channel == Channel::R)
            .unwrap()
    };
    let (model, flat) = (rmse(Role::Model), rmse(Role::Classical));
    close(model.rmse.value, (0.01f64 / 4.0).sqrt());
    close(model.relative.unwrap().value, (0.01f64 / 4.0).sqrt() / 0.25);
    close(flat.rmse.value, ((0.04 + 0.01 + 0.09) / 4.0f64).sqrt());
    assert_eq!((model.rmse.se, model.views), (0.0, 4));
    let ratio = find(&comparison.rmse_ratios, Channel::R);
    close(ratio.ratio, 14.0f64.sqrt());
    assert_eq!(ratio.verdict, Verdict::Better);
    close(ratio.interval.unwrap()[0], 14.0f64.sqrt());
    // Green is exact in both: no ratio of nothing to nothing.
    let green = find(&comparison.rmse_ratios, Channel::G);
    assert_eq!((green.verdict, green.interval), (Verdict::CannotTell, None));
    let peak = |role: Role| {
        comparison
            .peaks
            .iter()
            .find(|p| p.source == role.id() && p.channel == Channel::R)
            .unwrap()
    };
    // Parabola through (-10, .2), (0, .4), (10, .3): vertex at 10/6; equal heights at 0 and 10: the first counts.
    close(peak(Role::Measured).angle_deg.unwrap().value, 10.0 / 6.0);
    close(peak(Role::Model).angle_deg.unwrap().value, 5.0);
    assert_eq!(peak(Role::Classical).angle_deg, None);
    for row in &comparison.colour_ratios {
        close(row.ratios.blue_over_red.value, 0.25);
        close(row.ratios.green_over_red.value, 0.25);
    }
    assert_eq!(comparison.curves.len(), 3 * 4 * 4);
    let point = comparison
        .curves
        .iter()
        .find(|p| p.source == Role::Model.id() && p.theta_v_deg == 10.0)
        .unwrap();
    close(point.beta, 0.4);
}

#[test]
fn jackknife_of_a_mean_is_the_standard_error_of_the_mean() {
    let values = [0.31, 0.29, 0.35, 0.27, 0.33];
    let batches: Vec<Vec<Channels>> = values.iter().map(|v| vec![[*v; 4]]).collect();
    let estimate = Propagation::new(&batches, &[None])
        .unwrap()
        .estimate(|model, _| model[0][2]);
    let mean = values.iter().sum::<f64>() / 5.0;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 4.0;
    assert!((estimate.value - mean).abs() < 1e-16);
    assert!((estimate.se - (variance / 5.0).sqrt()).abs() < 1e-16);
    assert_eq!(estimate.se_measurement, 0.0);
    // Of a ratio: the delta method to first order, here to 1 %.
    let pairs: Vec<Channels> = values.iter().map(|v| [1.0 + v, v * v, 0.5 - v, 0.0]).collect();
    let ratios = model_colour_ratios(&pairs).unwrap();
    let of = |f: fn(f64) -> f64| values.iter().map(|v| f(*v)).sum::<f64>() / 5.0;
    let (red, blue) = (of(|v| 1.0 + v), of(|v| 0.5 - v));
    let residuals = values
        .iter()
        .map(|v| ((0.5 - v) - blue / red * (1.0 + v)).powi(2))
        .sum::<f64>();
    let delta = (residuals / 20.0).sqrt() / red;
    assert!((ratios.blue_over_red.value - blue / red).abs() < 1e-15);
    assert!((ratios.blue_over_red.se / delta - 1.0).abs() < 0.01);
}

#[test]
fn measurement_errors_follow_the_covariance() {
    let (rgb, se) = ([0.28, 0.05, 0.03], [0.014, 0.0025, 0.0015]);
    let flat = vec![vec![[0.2; 4]; 2]; 2];
    let measured = [Some(reading(rgb, se)), None];
    let propagation = Propagation::new(&flat, &measured).unwrap();
    let at = |m: &[Option<Channels>], c: usize| m[0].unwrap()[c];
    // y moves with r, g, b: y less its own luminance has no error at all.
    let nothing =
        propagation.estimate(|_, m| at(m, 3) - Y_ROW[0] * at(m, 0) - Y_ROW[1] * at(m, 1) - Y_ROW[2] * at(m, 2));
    assert!(nothing.se < 1e-9 && nothing.value.abs() < 1e-17);
    let y = propagation.estimate(|_, m| at(m, 3));
    let expected = (Y_ROW[0] * se[0]).hypot(Y_ROW[1] * se[1]).hypot(Y_ROW[2] * se[2]);
    assert!((y.se - expected).abs() < 1e-15);
    // A ratio of two channels with 5 % each: 5 % times root 2, to second order in 5 %.
    let ratio = propagation.estimate(|_, m| at(m, 2) / at(m, 0));
    assert!((ratio.se / ratio.value / (0.05 * 2.0f64.sqrt()) - 1.0).abs() < 0.05f64.powi(2));
    assert_eq!(ratio.se_monte_carlo, 0.0);
}

#[test]
fn scaling_a_source_changes_only_its_coefficient() {
    let study = Study::new(0.1, 0.3);
    let (batches, measured) = study.draw(0.02, 0.03, 7);
    let run = |scale: f64| {
        let scaled: Vec<Vec<Channels>> = batches
            .iter()
            .map(|batch| batch.iter().map(|v| v.map(|x| scale * x)).collect())
            .collect();
        study.compare(&scaled, &measured)
    };
    let (one, other) = (run(1.0), run(2.9));
    let of = |comparison: &Comparison| comparison.normalisation[0].factor.value;
    assert!((of(&one) / of(&other) / 2.9 - 1.0).abs() < 1e-14);
    for (a, b) in one.curves.iter().zip(&other.curves) {
        assert!((a.beta - b.beta).abs() < 1e-14 && (a.se - b.se).abs() < 1e-14);
    }
    for (a, b) in one.rmse_ratios.iter().zip(&other.rmse_ratios) {
        assert!((a.ratio / b.ratio - 1.0).abs() < 1e-12);
    }
}

/// A cloth, a model and a classical shading whose departures from it are known.
struct Study {
    geometries: Vec<Geometry>,
    truth: Vec<Channels>,
    model: Vec<Channels>,
    classical: Vec<Channels>,
}

impl Study {
    /// Relative departures swing between ± the two amplitudes over the views and vanish at the normal.
    fn new(model: f64, classical: f64) -> Self {
        let views: Vec<f64> = (-12..=14).map(|i| 5.0 * f64::from(i)).collect();
        let truth: Vec<Channels> = views
            .iter()
            .map(|v| {
                let lobe = 0.2 + 0.1 * v.to_radians().cos();
                rgby(lobe, 0.15 * lobe, 0.1 * lobe)
            })
            .collect();
        let bent = |amplitude: f64| {
            let factor = |v: &f64| 1.0 + amplitude * (3.0 * v.to_radians()).sin();
            truth
                .iter()
                .zip(&views)
                .map(|(t, v)| t.map(|x| x * factor(v)))
                .collect()
        };
        Self {
            geometries: line(0.0, &views),
            model: bent(model),
            classical: bent(classical),
            truth,
        }
    }

    /// 8 batches and a measurement with independent relative noise of the given standard deviations.
    fn draw(&self, monte_carlo: f64, noise: f64, seed: u64) -> (Vec<Vec<Channels>>, Vec<Option<Reading>>) {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let normal = Normal::standard();
        let mut deviate = || normal.inverse_cdf(rng.random_range(f64::EPSILON..1.0));
        let mut noisy = |v: &Channels, s: f64| [v[0], v[1], v[2]].map(|x| x * (1.0 + s * deviate()));
        let batches = (0..8)
            .map(|_| {
                let batch = self.model.iter().map(|v| noisy(v, monte_carlo));
                batch.map(|v| rgby(v[0], v[1], v[2])).collect()
            })
            .collect();
        let measured = self
            .truth
            .iter()
            .map(|v| Some(reading(noisy(v, noise), [v[0] * noise, v[1] * noise, v[2] * noise])))
            .collect();
        (batches, measured)
    }

    fn compare(&self, batches: &[Vec<Channels>], measured: &[Option<Reading>]) -> Comparison {
        Comparison::of_one_each(&self.geometries, batches, &self.classical, measured).unwrap()
    }
}

/// Share of `trials` in which `event` of the red channel's comparison is true.
fn share(study: &Study, trials: u64, monte_carlo: f64, noise: f64, event: impl Fn(&Comparison) -> bool) -> f64 {
    let hits = (0..trials)
        .filter(|seed| {
            let (batches, measured) = study.draw(monte_carlo, noise, *seed);
            event(&study.compare(&batches, &measured))
        })
        .count();
    hits as f64 / trials as f64
}

const TRIALS: u64 = 400;
/// Three standard deviations of a share that is truly 5 % in so many trials.
const SPREAD: f64 = 3.0 * 0.0109;

#[test]
fn interval_covers_the_true_ratio_in_95_percent() {
    let study = Study::new(0.1, 0.3);
    // Found: 0.955 and 0.9725.
    for (monte_carlo, noise) in [(0.05, 0.01), (0.1, 0.0)] {
        let held = share(&study, TRIALS, monte_carlo, noise, |comparison| {
            let [low, high] = find(&comparison.rmse_ratios, Channel::R).interval.unwrap();
            (low..=high).contains(&3.0)
        });
        println!("batches {monte_carlo}, measurement {noise}: coverage {held}");
        assert!(held >= 0.95 - SPREAD, "{monte_carlo} {noise}: {held}");
    }
}

#[test]
fn equal_sources_give_at_most_5_percent_false_alarms() {
    let study = Study::new(0.2, -0.2);
    // Found: 0.0575 and 0.0375.
    for (monte_carlo, noise) in [(0.05, 0.05), (0.2, 0.01)] {
        let alarms = share(&study, TRIALS, monte_carlo, noise, |comparison| {
            find(&comparison.rmse_ratios, Channel::R).verdict != Verdict::CannotTell
        });
        println!("batches {monte_carlo}, measurement {noise}: false alarms {alarms}");
        assert!(alarms <= 0.05 + SPREAD, "{monte_carlo} {noise}: {alarms}");
    }
}

#[test]
fn clear_difference_gives_a_verdict() {
    let seen = |study: &Study, verdict| {
        share(study, 100, 0.05, 0.05, |comparison| {
            find(&comparison.rmse_ratios, Channel::R).verdict == verdict
        })
    };
    let (better, worse) = (
        seen(&Study::new(0.1, 0.3), Verdict::Better),
        seen(&Study::new(0.3, 0.1), Verdict::Worse),
    );
    println!("power: better {better}, worse {worse}");
    assert!(better > 0.95 && worse > 0.95);
}

#[test]
fn coefficient_standard_error_matches_its_scatter() {
    let study = Study::new(0.1, 0.3);
    let runs: Vec<_> = (0..TRIALS)
        .map(|seed| {
            let (batches, measured) = study.draw(0.05, 0.03, seed);
            study.compare(&batches, &measured).normalisation[0].factor
        })
        .collect();
    let count = runs.len() as f64;
    let mean = runs.iter().map(|e| e.value).sum::<f64>() / count;
    let scatter = (runs.iter().map(|e| (e.value - mean).powi(2)).sum::<f64>() / (count - 1.0)).sqrt();
    let stated = (runs.iter().map(|e| e.se * e.se).sum::<f64>() / count).sqrt();
    println!("stated {stated}, scatter {scatter}");
    // Three standard deviations of a standard deviation from 400 values: 3/sqrt(800).
    assert!((stated / scatter - 1.0).abs() < 0.106, "{stated} {scatter}");
}

#[test]
fn incidences_are_kept_apart_and_views_without_measurement_left_out() {
    let mut geometries = line(30.0, &[20.0, -20.0, 0.0]);
    geometries.extend(line(0.0, &[0.0, 20.0]));
    let values: Vec<Channels> = (1..=5).map(|i| rgby(0.1 * f64::from(i), 0.02, 0.01)).collect();
    let mut measured: Vec<_> = values
        .iter()
        .map(|v| Some(Reading::independent(*v, [0.01; 4])))
        .collect();
    measured[2] = None;
    let comparison =
        Comparison::of_one_each(&geometries, &[values.clone(), values.clone()], &values, &measured).unwrap();
    let views: Vec<(f64, usize)> = comparison
        .rmse
        .iter()
        .filter(|m| m.channel == Channel::Y && m.source == Role::Model.id())
        .map(|m| (m.theta_i_deg, m.views))
        .collect();
    assert_eq!(views, [(0.0, 2), (30.0, 2)]);
    assert_eq!(comparison.curves.len(), 4 * (5 + 5 + 4));
    // Highest of the two measured views at 30 degrees, (-20, .2) and (20, .1), is the first, an edge.
    let peak = comparison
        .peaks
        .iter()
        .find(|p| p.theta_i_deg == 30.0 && p.source == Role::Measured.id())
        .unwrap();
    assert_eq!((peak.angle_deg.unwrap().value, peak.at_edge), (-20.0, true));
    let json = serde_json::to_value(&comparison).unwrap();
    assert_eq!(json["rmse"][0]["source"], "model");
    assert!(json["rmse"][0]["se"].is_number() && json["rmse_ratios"][0]["verdict"] == "cannot tell");
}

#[test]
fn built_in_sample_can_be_compared() {
    let sample = Sample::load("merl-red-fabric").unwrap();
    let geometries: Vec<Geometry> = sample
        .geometries()
        .map(|(theta_i_deg, theta_v_deg)| Geometry {
            theta_i_deg,
            theta_v_deg,
        })
        .collect();
    let measured: Vec<Option<Reading>> = geometries
        .iter()
        .map(|g| {
            sample
                .reading(g.theta_i_deg, g.theta_v_deg, &Default::default())
                .unwrap()
        })
        .collect();
    let lambert = vec![measured[12].unwrap().beta; 81];
    let comparison =
        Comparison::of_one_each(&geometries, &[lambert.clone(), lambert.clone()], &lambert, &measured).unwrap();
    assert_eq!(comparison.rmse_ratios.len(), 12);
    // The same curve twice: exactly 1, and nobody can tell.
    assert!(
        comparison
            .rmse_ratios
            .iter()
            .all(|r| r.ratio == 1.0 && r.verdict == Verdict::CannotTell)
    );
    let ratios = comparison
        .colour_ratios
        .iter()
        .find(|r| r.source == Role::Measured.id())
        .unwrap()
        .ratios;
    assert!((ratios.green_over_red.value - 0.047679 / 0.280098).abs() < 1e-15);
}

#[test]
fn inputs_that_cannot_be_compared_are_rejected() {
    let geometries = line(0.0, &[0.0, 10.0]);
    let good = vec![rgby(0.2, 0.1, 0.1); 2];
    let measured = vec![Some(Reading::independent(good[0], [0.0; 4])); 2];
    let run =
        |geometries: &[Geometry], batches: &[Vec<Channels>], classical: &[Channels], measured: &[Option<Reading>]| {
            Comparison::of_one_each(geometries, batches, classical, measured).unwrap_err()
        };
    let two = [good.clone(), good.clone()];
    assert_eq!(
        run(&geometries, &two[..1], &good, &measured),
        CompareError::TooFewBatches { found: 1 }
    );
    let short = [good.clone(), good[..1].to_vec()];
    assert!(matches!(
        run(&geometries, &short, &good, &measured),
        CompareError::Length { .. }
    ));
    assert!(matches!(
        run(&geometries, &two, &good[..1], &measured),
        CompareError::Length { .. }
    ));
    assert!(matches!(
        run(&geometries[..1], &two, &good[..1], &measured),
        CompareError::Length { .. }
    ));
    let nan = [good.clone(), vec![[f64::NAN; 4]; 2]];
    assert!(matches!(
        run(&geometries, &nan, &good, &measured),
        CompareError::NotFinite { .. }
    ));
    assert_eq!(run(&geometries, &two, &good, &[None, None]), CompareError::NoReading);
    let mut odd = measured.clone();
    odd[1].as_mut().unwrap().covariance[0][0] = f64::INFINITY;
    assert!(matches!(
        run(&geometries, &two, &good, &odd),
        CompareError::NotFinite { .. }
    ));
}

#[test]
fn nearest_reading_normalises_without_one_at_the_normal() {
    let mut geometries = line(45.0, &[-10.0, 0.0, 10.0]);
    geometries.extend(line(0.0, &[0.0]));
    let values = [0.2, 0.4, 0.3, 0.5].map(|r| rgby(r, 0.1, 0.1));
    let measured: Vec<_> = [Some(0), Some(1), Some(2), None]
        .map(|place: Option<usize>| place.map(|j| Reading::independent(values[j], [0.01; 4])))
        .to_vec();
    let doubled = values.map(|v| v.map(|x| 2.0 * x)).to_vec();
    let run = |model: &Vec<Channels>| {
        Comparison::of_one_each(&geometries, &[model.clone(), model.clone()], &values, &measured).unwrap()
    };
    let comparison = run(&doubled);
    assert_eq!(comparison.references, [geometries[1]]);
    assert_eq!(comparison.normalisation[0].factor.value, 0.5);
    assert_eq!(comparison.normalisation[0].at, geometries[1]);
    assert!(
        comparison
            .rmse
            .iter()
            .all(|rmse| rmse.theta_i_deg == 45.0 && rmse.views == 3)
    );
    // A model without light is compared as it is.
    let dark = run(&vec![[0.0; 4]; 4]);
    assert_eq!(dark.normalisation, []);
    let red = dark
        .rmse
        .iter()
        .find(|m| m.channel == Channel::R && m.source == Role::Model.id())
        .unwrap();
    assert!((red.rmse.value - (0.29f64 / 3.0).sqrt()).abs() < 1e-15);
}

#[test]
fn too_few_paths_withhold_the_verdict() {
    let study = Study::new(0.1, 0.3);
    // The mean of 8 batches has an error of scatter/sqrt(8): 0.18 and 0.53 of the value.
    for (scatter, withheld) in [(0.5, false), (1.5, true)] {
        let (batches, measured) = study.draw(scatter, 0.01, 3);
        for ratio in study.compare(&batches, &measured).rmse_ratios {
            assert_eq!(ratio.too_few_paths, withheld, "{scatter}");
            assert!(!withheld || (ratio.verdict == Verdict::CannotTell && ratio.interval.is_none()));
        }
    }
}

#[test]
fn red_near_zero_has_no_ratio() {
    let ratios = |red: [f64; 2]| model_colour_ratios(&red.map(|r| rgby(r, 0.1, 0.6))).unwrap();
    assert!(!ratios([0.1, 0.11]).red_is_zero);
    // Well known, but a 120th of blue; and 0.03 with the error 0.02.
    assert!(ratios([-0.005, -0.005]).red_is_zero && ratios([0.01, 0.05]).red_is_zero);
}

#[test]
fn different_hues_are_flagged() {
    let colour = ColourSystem::new(&WavelengthGrid::preprint(), Convention::default()).unwrap();
    let compared = |model: Channels, sample: Channels| {
        let measured = [Some(Reading::independent(sample, [0.001; 4]))];
        hue(
            &Propagation::new(&[vec![model], vec![model]], &measured).unwrap(),
            0,
            &colour,
        )
        .unwrap()
    };
    let (red, blue, grey) = (rgby(0.3, 0.01, 0.02), rgby(0.02, 0.1, 0.6), rgby(0.2, 0.2, 0.2));
    let other = compared(red, blue);
    assert!(
        other.plainly_different && other.difference_deg.value.abs() > 60.0,
        "{other:?}"
    );
    assert!(compared(red, grey).plainly_different);
    let alike = compared(red, rgby(0.6, 0.03, 0.05));
    assert!(
        !alike.plainly_different && alike.difference_deg.value.abs() < 10.0,
        "{alike:?}"
    );
    // Two greys have no hue to differ in.
    assert!(!compared(grey, rgby(0.2, 0.2, 0.21)).plainly_different);
}

/// Two models, two classical shadings and two samples: each pair has its own errors, each sample its own normalisation.
#[test]
fn every_model_and_shading_is_compared_with_every_sample() {
    let geometries = line(0.0, &[-20.0, 0.0, 20.0]);
    let source = |role, place| Source::numbered(role, place, format!("{role:?} {place}"));
    let [models, shadings, samples] =
        [Role::Model, Role::Classical, Role::Measured].map(|role| [source(role, 0), source(role, 1)]);
    let grey = |values: [f64; 3]| values.map(|v| [v; 4]).to_vec();
    let batches = [[0.2, 0.4, 0.3], [0.4, 0.4, 0.4]].map(|values| vec![grey(values); 2]);
    let formulas = [[0.3, 0.3, 0.3], [0.1, 0.2, 0.1]].map(grey);
    let readings =
        [[0.4, 0.8, 0.4], [0.1, 0.2, 0.3]].map(|values| values.map(|v| Some(Reading::independent([v; 4], [0.0; 4]))));
    let inputs = |models: &[Compared<Vec<Channels>>], shadings: &[Compared<Channels>]| {
        Comparison::new(&Inputs {
            geometries: &geometries,
            models,
            classical: shadings,
            measured: &[
                Compared::new(&samples[0], &readings[0]),
                Compared::new(&samples[1], &readings[1]),
            ],
        })
    };
    let both_models = [
        Compared::new(&models[0], &batches[0]),
        Compared::new(&models[1], &batches[1]),
    ];
    let both_shadings = [
        Compared::new(&shadings[0], &formulas[0]),
        Compared::new(&shadings[1], &formulas[1]),
    ];
    let found = inputs(&both_models, &both_shadings).unwrap();
    let ids: Vec<&str> = found.sources.iter().map(|source| source.id.as_str()).collect();
    assert_eq!(
        ids,
        ["model", "model-2", "classical", "classical-2", "measured", "measured-2"]
    );
    // Curves are normalised to the first sample, whose luminance at the normal is 0.8.
    let curve = |id: &str| -> Vec<f64> {
        let points = found
            .curves
            .iter()
            .filter(|p| p.source == id && p.channel == Channel::Y);
        points.map(|p| p.beta).collect()
    };
    let close = |a: &[f64], b: &[f64]| {
        assert!(
            a.len() == b.len() && std::iter::zip(a, b).all(|(a, b)| (a - b).abs() < 1e-14),
            "{a:?} {b:?}"
        );
    };
    close(&curve("model"), &[0.4, 0.8, 0.6]);
    close(&curve("model-2"), &[0.8, 0.8, 0.8]);
    close(&curve("classical"), &[0.8, 0.8, 0.8]);
    close(&curve("classical-2"), &[0.4, 0.8, 0.4]);
    close(&curve("measured"), &[0.4, 0.8, 0.4]);
    close(&curve("measured-2"), &[0.1, 0.2, 0.3]);
    // Beside the second sample, 0.2 at the normal, a source is a quarter of that.
    let rmse = |id: &str, sample: &str| {
        let of = |m: &&Rmse| m.source == id && m.sample == sample && m.channel == Channel::Y;
        let metrics: Vec<f64> = found.rmse.iter().filter(of).map(|m| m.rmse.value).collect();
        assert_eq!(metrics.len(), 1, "{id} {sample}");
        metrics[0]
    };
    close(
        &[
            rmse("model", "measured"),
            rmse("model-2", "measured"),
            rmse("classical-2", "measured"),
            rmse("model", "measured-2"),
            rmse("model-2", "measured-2"),
            rmse("classical-2", "measured-2"),
        ],
        &[
            (0.04f64 / 3.0).sqrt(),
            (0.32f64 / 3.0).sqrt(),
            0.0,
            (0.0225f64 / 3.0).sqrt(),
            (0.02f64 / 3.0).sqrt(),
            (0.04f64 / 3.0).sqrt(),
        ],
    );
    // Every model has a verdict beside every shading and sample, and no two of them are the same.
    let luminance = || found.rmse_ratios.iter().filter(|r| r.channel == Channel::Y);
    let pairs: BTreeSet<_> = luminance().map(|r| (&r.model, &r.classical, &r.sample)).collect();
    assert_eq!((pairs.len(), luminance().count()), (8, 8));
    let factors: Vec<f64> = found.normalisation.iter().map(|of| of.factor.value).collect();
    close(&factors, &[2.0, 2.0, 0.8 / 0.3, 4.0, 0.5, 0.5, 0.2 / 0.3, 1.0]);
    assert_eq!(found.references.len(), 2);

    let again = [
        Compared::new(&models[0], &batches[0]),
        Compared::new(&models[0], &batches[1]),
    ];
    let twice = inputs(&again, &both_shadings).unwrap_err();
    assert!(
        matches!(&twice, CompareError::SameId { id } if *id == "model"),
        "{twice}"
    );
    // A formula alone has its errors from the samples.
    let formulas_alone = inputs(&[], &both_shadings).unwrap();
    assert_eq!(formulas_alone.rmse.len(), 2 * 2 * 4);
    assert_eq!(formulas_alone.rmse_ratios, []);
    assert!(formulas_alone.rmse.iter().all(|m| m.rmse.se == 0.0));
    // Without a sample curves are absolute.
    let absolute = Comparison::new(&Inputs {
        geometries: &geometries,
        models: &both_models,
        classical: &both_shadings,
        measured: &[],
    });
    let first: Vec<f64> = absolute.unwrap().curves[..3].iter().map(|p| p.beta).collect();
    close(&first, &[0.2, 0.4, 0.3]);
}
