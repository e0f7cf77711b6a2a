//! Standard errors and normalisation, against numbers of which both are known.

use super::gate::{Gate, Law, Where};
use super::judge::estimates;
use super::{CheckError, Context};
use crate::compare::{Comparison, Geometry, Propagation};
use crate::run::{RunError, SpectralCurves};
use crate::sample::Reading;
use crate::transport::{BatchSums, Estimate, Ledger};
use crate::yarn::{LengthSums, LengthTally};

const ERRORS: Law = Law {
    name: "standard-errors",
    words: "batches of 1, 2, …, 11 have the mean 6 and the standard error 1, by every way to them",
};
const NORMALISATION: Law = Law {
    name: "normalisation",
    words: "normalised, model and classical shading have the measured luminance at normal incidence and view",
};

/// The variance of 1, 2, …, n about their mean is n (n + 1)/12, so that the standard error of the mean is √((n +
/// 1)/12): 1 for 11.
const BATCHES: usize = 11;
const MEAN: f64 = 6.0;

pub fn standard_errors(context: &Context) -> Result<Gate, CheckError> {
    let numbers = (1..=BATCHES).map(|k| k as f64);
    let mut ways: Vec<(&str, [f64; 2])> = Vec::new();
    let pair = |estimate: Estimate| [estimate.value, estimate.se];
    let kept: Vec<f64> = numbers.clone().collect();
    ways.push(("kept batches", pair(Estimate::from_batches(kept.iter().copied()))));
    let mut sums = BatchSums::zeros(1);
    numbers.clone().for_each(|x| sums.add(&[x]));
    ways.push(("summed batches", pair(sums.estimate(0))));
    let mut lengths = LengthSums::zeros(1);
    numbers.clone().for_each(|x| {
        lengths.add(&LengthTally {
            amount: vec![x as f32],
            moment_mm: vec![0.0],
        })
    });
    ways.push(("batches by path length", pair(lengths.estimate(0))));
    let ledgers: Vec<Ledger> = numbers.clone().map(|x| Ledger::new(|_| x)).collect();
    let [mean, se] = Ledger::mean_and_se(&ledgers);
    for (mean, se) in mean.amounts().into_iter().zip(se.amounts()) {
        ways.push(("ledger", [mean, se]));
    }
    let channels: Vec<Vec<[f64; 4]>> = numbers.clone().map(|x| vec![[x; 4]]).collect();
    let propagation = Propagation::new(&channels, &[None]).map_err(RunError::from)?;
    let jackknife = propagation.estimate(|model, _| model[0][0]);
    ways.push(("jackknife", [jackknife.value, jackknife.se]));
    let curves = SpectralCurves {
        geometries: vec![Geometry::NORMAL],
        diffuse: numbers.clone().map(|x| vec![vec![x]]).collect(),
        gloss: vec![0.0],
    };
    ways.push(("curves", pair(curves.estimate(0, 0))));
    let gates: Vec<Vec<f64>> = numbers.map(|x| vec![x]).collect();
    ways.extend(estimates(&gates).into_iter().map(|estimate| ("gates", estimate)));
    let departures: Vec<f64> = ways
        .iter()
        .flat_map(|(_, [mean, se])| [mean / MEAN - 1.0, se - 1.0])
        .collect();
    Ok(context
        .judge
        .exact(ERRORS, &departures, context.plan.study.check.rounding, |i| {
            Where::named(format!("{}, {}", ways[i / 2].0, ["mean", "standard error"][i % 2]))
        }))
}

/// Three colours that differ in every channel, so that no other one takes the place of luminance unseen.
pub fn normalisation(context: &Context) -> Result<Gate, CheckError> {
    const LUMINANCE: usize = 3;
    let (model, classical, measured) = ([0.9, 0.2, 0.1, 0.4], [0.5, 0.7, 0.3, 0.6], [0.3, 0.25, 0.2, 0.26]);
    let comparison = Comparison::of_one_each(
        &[Geometry::NORMAL],
        &[vec![model], vec![model]],
        &[classical],
        &[Some(Reading::independent(measured, [0.01; 4]))],
    )
    .map_err(RunError::from)?;
    // No coefficient at all breaks the law as a wrong one does.
    let found: Vec<f64> = comparison.normalisation.iter().map(|of| of.factor.value).collect();
    let coefficients = if found.is_empty() { vec![f64::NAN; 2] } else { found };
    let departures: Vec<f64> = std::iter::zip(coefficients, [model, classical])
        .map(|(coefficient, source)| coefficient * source[LUMINANCE] / measured[LUMINANCE] - 1.0)
        .collect();
    Ok(context
        .judge
        .exact(NORMALISATION, &departures, context.plan.study.check.rounding, |i| {
            Where::named(["model", "classical shading"][i])
        }))
}
