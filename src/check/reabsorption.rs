//! Re-absorption against light that was traced with the other absorption.

use super::gate::{Gate, Law, Where};
use super::medium::few_wavelengths;
use super::{CheckError, Context};
use crate::transport::{BatchSums, Roulette};
use crate::yarn::{
    ByLength, DirectBatch, DirectTracer, Effort, Estimator, LengthBins, LengthSums, Reabsorption, SurfaceGrid, Yarn,
    YarnResponse, YarnResponseGrid,
};
use std::iter::zip;

const LAW: Law = Law {
    name: "reabsorption",
    words: "light of known path lengths, given another absorption, is what tracing with that absorption finds",
};

/// Absorption added and taken away again, times the mean length of scattered light.
const CHANGE: f64 = 0.1;
/// Relative to the scattered light. Both sides have the same paths and no roulette, so only the width of the bins
/// remains.
const TOLERANCE: f64 = 5e-3;
/// Fraction of the incident flux below which scattered light is too little for a mean path length.
const LEAST: f64 = 1e-9;
/// At most one path a vector lane: all paths of a batch then start together, and the random numbers of each do not
/// depend on the others.
const PATHS_OF_A_BATCH: u64 = 8;
const BATCHES: usize = 64;

/// The study's yarn at three of its wavelengths, and the same with more absorption: each changed into the other.
pub fn gate(context: &Context) -> Result<Gate, CheckError> {
    let Context { plan, judge, .. } = context;
    let bins = LengthBins::new(plan.yarn.cylinder.radius_mm(), LengthBins::DEFAULT)?;
    let yarn = |added: &[f64]| -> Result<Yarn, CheckError> {
        Ok(Yarn {
            // Independent paths are then the same whatever they lose on the way, down to weights that do not count.
            roulette: Roulette::new(1e-6, 0.5)?,
            estimator: Estimator::Independent,
            ..few_wavelengths(&plan.yarn, |k, [mu_s, mu_a]| {
                [mu_s, mu_a + added.get(k).unwrap_or(&0.0)]
            })?
        })
    };
    let axes = YarnResponseGrid::new(1, SurfaceGrid::new(4, 1, 4)?)?;
    let own = yarn(&[])?;
    let nm = own.medium.grid().nm();
    let of_own = trace(plan.study.seed, &own, axes, &bins)?;
    let lengths = mean_lengths(&of_own.1, nm.len());
    let darker = yarn(
        &lengths
            .map(|length| if length > 0.0 { CHANGE / length } else { 0.0 })
            .collect::<Vec<_>>(),
    )?;
    let of_darker = trace(plan.study.seed, &darker, axes, &bins)?;
    let mut departures = Vec::new();
    for ([from, to], [traced, wanted]) in [
        ([&own, &darker], [&of_own, &of_darker]),
        ([&darker, &own], [&of_darker, &of_own]),
    ] {
        let change = Reabsorption::new(bins.clone(), &from.medium, &to.medium)?;
        let (mean, stated) = changed(traced, &change)?;
        let [found, stated, expected] = [mean, stated, means(&wanted.0)].map(|table| scattered(axes, table, nm.len()));
        let (found, stated, expected) = (found?, stated?, expected?);
        let values = zip(zip(found, stated), expected);
        departures.extend(values.map(|((found, stated), expected)| match expected > LEAST {
            // What is beyond the systematic error that re-absorption states of its bins.
            true => {
                let departure = found / expected - 1.0;
                departure - departure.clamp(-stated / expected, stated / expected)
            }
            false => 0.0,
        }));
    }
    Ok(judge.exact(LAW, &departures, TOLERANCE, |i| {
        let way = if i < nm.len() { "more" } else { "less" };
        Where::new(nm[i % nm.len()], format!("{way} absorption, scattered light"))
    }))
}

fn trace(
    seed: u64,
    yarn: &Yarn,
    axes: YarnResponseGrid,
    bins: &LengthBins,
) -> Result<(BatchSums, LengthSums), CheckError> {
    let effort = Effort::new(seed, BATCHES, BATCHES as u64 * PATHS_OF_A_BATCH)?;
    let tracer = DirectTracer::new(yarn, axes, effort, Some(bins.clone()))?;
    let mut batches = (0..BATCHES).map(|batch| tracer.batch(batch)).peekable();
    let [values, by_length] = batches.peek().map_or([0; 2], |batch: &DirectBatch| {
        [batch.response.values().len(), batch.lengths.amount.len()]
    });
    let mut sums = (BatchSums::zeros(values), LengthSums::zeros(by_length));
    for batch in batches {
        sums.0.add(batch.response.values());
        sums.1.add(&batch.lengths);
    }
    Ok(sums)
}

/// Of scattered light at each wavelength, mm; 0 where there is none.
fn mean_lengths(lengths: &LengthSums, wavelengths: usize) -> impl Iterator<Item = f64> {
    (0..wavelengths).map(move |w| {
        let of = |sums: &[f32]| {
            sums.iter()
                .skip(w)
                .step_by(wavelengths)
                .map(|x| f64::from(*x))
                .sum::<f64>()
        };
        let (light, moment) = (of(&lengths.amount), of(&lengths.moment_mm));
        if light > 0.0 { moment / light } else { 0.0 }
    })
}

fn means(sums: &BatchSums) -> Vec<f64> {
    (0..sums.sum.len()).map(|i| sums.estimate(i).value).collect()
}

/// f* with another absorption, and the systematic error that is stated of it, 1/sr.
fn changed(
    (table, lengths): &(BatchSums, LengthSums),
    change: &Reabsorption,
) -> Result<(Vec<f64>, Vec<f64>), CheckError> {
    let mut mean = means(table);
    let mut se: Vec<f32> = (0..mean.len()).map(|i| table.estimate(i).se as f32).collect();
    let mut systematic = vec![0.0; mean.len()];
    let of = |i: usize| lengths.estimate(i);
    let places = 0..lengths.amount.len();
    let share = 1.0 / lengths.batches as f32;
    let mut by_mean: Vec<f32> = places.clone().map(|i| of(i).value as f32).collect();
    let mut by_se: Vec<f32> = places.map(|i| of(i).se as f32).collect();
    let mut moment: Vec<f32> = lengths.moment_mm.iter().map(|sum| sum * share).collect();
    let by_length = ByLength {
        mean: &mut by_mean,
        se: &mut by_se,
        moment_mm: &mut moment,
    };
    change.table(&mut mean, &mut se, by_length, &mut systematic)?;
    Ok((mean, systematic.into_iter().map(f64::from).collect()))
}

/// Scattered light of all cells, of the incident flux, at each wavelength.
fn scattered(axes: YarnResponseGrid, table: Vec<f64>, wavelengths: usize) -> Result<Vec<f64>, CheckError> {
    let transfer = vec![0.0; axes.transfer_cells() * wavelengths];
    Ok(YarnResponse::new(axes, wavelengths, table, transfer)?.albedo(0))
}
