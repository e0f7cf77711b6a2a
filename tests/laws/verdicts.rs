//! The ratio of misfits of two fitted models, its interval, and the verdict.

use ndarray::Array2;
use rand::RngExt;
use specval::compare::Verdict;
use specval::fit::{Channel, FitReadings, FitVerdict, MisfitRatio, Modelled, misfit_ratio};
use specval::rig::Geometry;
use specval::transport::{Purpose, Stream};

/// Three incidences of 27 views, 0 everywhere, with an uncertainty of 1: models are their own residuals.
fn readings() -> FitReadings {
    let geometries: Vec<Geometry> = [0.0, 30.0, 60.0]
        .into_iter()
        .flat_map(|theta_i_deg| {
            (-12..=14).map(move |k| Geometry {
                theta_i_deg,
                theta_v_deg: 5.0 * f64::from(k),
            })
        })
        .collect();
    FitReadings {
        sample: "nothing".into(),
        beta: Array2::zeros((geometries.len(), 3)),
        se: Array2::ones((geometries.len(), 3)),
        geometries,
        channels: vec![Channel::Red, Channel::Green, Channel::Blue],
        white: vec![1.0; 3],
        rgby: None,
        transmission: false,
        notices: Vec::new(),
    }
}

/// Errors that neighbouring views share, correlation `rho` from view to view, and channels for the larger part.
fn errors(size: f64, rho: f64, seed: u64) -> Array2<f64> {
    let mut stream = Stream::open(seed, Purpose::Check, 1, 0, 0);
    let mut normal = move || (0..12).map(|_| stream.random::<f64>()).sum::<f64>() - 6.0;
    let mut all = Array2::zeros((81, 3));
    let mut state = 0.0;
    for g in 0..81 {
        let new = normal();
        state = if g % 27 == 0 {
            new
        } else {
            rho * state + (1.0 - rho * rho).sqrt() * new
        };
        for c in 0..3 {
            all[(g, c)] = size * (0.9f64.sqrt() * state + 0.1f64.sqrt() * normal());
        }
    }
    all
}

fn ratio(physical: &Array2<f64>, classical: &Array2<f64>) -> MisfitRatio {
    let of = |beta| Modelled { beta, batches: &[] };
    misfit_ratio(&readings(), of(physical), of(classical), 1)
}

#[test]
fn better_model_is_told_from_worse_and_from_an_equal_one() {
    let (small, large) = (errors(0.8, 0.6, 1), errors(2.4, 0.6, 2));
    let better = ratio(&small, &large);
    assert_eq!(better.verdict, Verdict::Better);
    assert!(
        better.interval[0] < better.ratio && better.ratio < better.interval[1],
        "{better:?}"
    );
    let worse = ratio(&large, &small);
    assert_eq!(worse.verdict, Verdict::Worse);
    assert!((worse.ratio * better.ratio - 1.0).abs() < 1e-12);
    assert_eq!((better.physical, better.classical), (worse.classical, worse.physical));
    let equal = ratio(&errors(1.0, 0.6, 3), &errors(1.0, 0.6, 4));
    assert_eq!(equal.verdict, Verdict::CannotTell);
    // The same errors twice as large are so in every draw.
    let twice = ratio(&small, &(2.0 * &small));
    assert!(
        [twice.ratio, twice.interval[0], twice.interval[1]]
            .iter()
            .all(|end| (end - 2.0).abs() < 1e-12)
    );
    assert_eq!(better, ratio(&small, &large));
}

/// Of two models with equally large errors the interval of 95 % holds the ratio 1 nearly as often as it says.
#[test]
fn interval_covers_the_true_ratio() {
    for (rho, least) in [(0.0, 85), (0.6, 82), (0.8, 78)] {
        let covered = (0..100)
            .filter(|&k| {
                let found = ratio(&errors(1.0, rho, 1000 + 2 * k), &errors(1.0, rho, 1001 + 2 * k));
                (found.interval[0]..=found.interval[1]).contains(&1.0)
            })
            .count();
        println!("correlation {rho}: {covered} of 100");
        assert!(covered >= least && covered < 100, "correlation {rho}: {covered} of 100");
    }
}

#[test]
fn monte_carlo_batches_widen_the_interval() {
    let (physical, classical) = (errors(1.0, 0.6, 5), errors(1.2, 0.6, 6));
    let noise: Vec<Array2<f64>> = (0..8).map(|k| errors(2.0, 0.0, 50 + k)).collect();
    let sum = noise
        .iter()
        .fold(Array2::<f64>::zeros((81, 3)), |sum, batch| sum + batch);
    let mean = sum / 8.0;
    let batches: Vec<Array2<f64>> = noise.iter().map(|batch| &physical + batch - &mean).collect();
    let of = |beta, batches| Modelled { beta, batches };
    let known = misfit_ratio(&readings(), of(&physical, &[]), of(&classical, &[]), 1);
    let noisy = misfit_ratio(&readings(), of(&physical, &batches), of(&classical, &[]), 1);
    assert_eq!((known.physical, known.ratio), (noisy.physical, noisy.ratio));
    assert!(noisy.interval[1] - noisy.interval[0] > 0.9 * (known.interval[1] - known.interval[0]));
    assert_ne!(noisy.interval, known.interval);
}

#[test]
fn verdict_is_that_of_readings_that_were_left_out() {
    let better = ratio(&errors(0.8, 0.6, 1), &errors(2.4, 0.6, 2));
    let worse = ratio(&errors(2.4, 0.6, 2), &errors(0.8, 0.6, 1));
    for (left_out, words, code) in [
        (Some(better), "physical better", 0),
        (Some(worse), "classical better", 1),
        (None, "cannot tell", 2),
    ] {
        let verdict = FitVerdict::new(better, left_out);
        assert_eq!((verdict.words(), verdict.exit_code()), (words, code));
    }
}
