use super::readings::{FitReadings, rms};
use crate::compare::Verdict;
use crate::transport::{Purpose, Stream};
use ndarray::{Array2, Axis};
use rand::{Rng, RngExt};
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Draws of the bootstrap: its standard error is then steady to about 1 %.
const DRAWS: usize = 4000;

/// Values of a model at the geometries of readings.
#[derive(Clone, Copy, Debug)]
pub struct Modelled<'a> {
    /// β, `[geometry][channel]`.
    pub beta: &'a Array2<f64>,
    /// The same from each Monte Carlo batch alone, whose mean is `beta`; empty for a formula.
    pub batches: &'a [Array2<f64>],
}

/// Misfits of a physical and a classical model, and their ratio.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MisfitRatio {
    /// Rms of (model − measured) / uncertainty.
    pub physical: f64,
    pub classical: f64,
    /// classical / physical, above 1 where the physical model is nearer to the readings.
    pub ratio: f64,
    /// 95 % interval, symmetric in the logarithm.
    pub interval: [f64; 2],
    /// Better or worse if the interval lies on one side of 1; of the physical model.
    pub verdict: Verdict,
}

/// The ratio of the rms misfits with a 95 % interval by a seeded bootstrap over readings and Monte Carlo batches.
///
/// What a model gets wrong it gets wrong over tens of degrees and in all channels, so neighbouring readings are not
/// independent, and there are too few incidences to draw among them. Blocks of √n neighbouring views of one incidence
/// are drawn, n its number of views, with all channels of a view together; blocks go round the ends of the curve
/// so that every view counts the same (circular block bootstrap, D. N. Politis, J. P. Romano, 1992). Each
/// incidence keeps its number of views.
///
/// The interval is ln ratio ± t s. Few blocks make the bootstrap's standard error too small: it is divided by
/// √(1 − l/n), the share of the variance that circular blocks of l views keep, and t is Student's for as many degrees
/// of freedom as there are blocks beyond one an incidence. The fits themselves are held fixed.
pub fn misfit_ratio(readings: &FitReadings, physical: Modelled, classical: Modelled, seed: u64) -> MisfitRatio {
    let curves = curves(readings);
    let both = [physical, classical];
    let misfits = both.map(|model| rms(readings.residuals(model.beta)));
    let squares = both.map(|model| squares(readings, model.beta));
    let logs: Vec<f64> = (0..DRAWS)
        .map(|draw| {
            let mut stream = Stream::open(seed, Purpose::Fit, usize::MAX, draw, 0);
            let mut counts = vec![0.0; readings.geometries.len()];
            curves
                .iter()
                .for_each(|curve| draw_blocks(curve, &mut counts, &mut stream));
            let sums = [0, 1].map(|which| {
                let drawn = redrawn(readings, both[which], &mut stream);
                let squares = drawn.as_ref().unwrap_or(&squares[which]);
                counts
                    .iter()
                    .zip(squares)
                    .map(|(count, square)| count * square)
                    .sum::<f64>()
            });
            0.5 * (sums[1] / sums[0]).ln()
        })
        .collect();
    let mean = logs.iter().sum::<f64>() / DRAWS as f64;
    let variance = logs.iter().map(|log| (log - mean).powi(2)).sum::<f64>() / (DRAWS - 1) as f64;
    let half = widening(&curves) * variance.sqrt();
    let log = (misfits[1] / misfits[0]).ln();
    let interval = [(log - half).exp(), (log + half).exp()];
    MisfitRatio {
        physical: misfits[0],
        classical: misfits[1],
        ratio: misfits[1] / misfits[0],
        interval,
        verdict: match interval {
            [low, _] if low > 1.0 => Verdict::Better,
            [_, high] if high < 1.0 => Verdict::Worse,
            _ => Verdict::CannotTell,
        },
    }
}

/// Places of the geometries of each incidence, by ascending view.
fn curves(readings: &FitReadings) -> Vec<Vec<usize>> {
    let of = |theta_i_deg: f64| {
        let all = 0..readings.geometries.len();
        let mut views: Vec<usize> = all
            .filter(|&g| readings.geometries[g].theta_i_deg == theta_i_deg)
            .collect();
        views.sort_by(|&a, &b| {
            readings.geometries[a]
                .theta_v_deg
                .total_cmp(&readings.geometries[b].theta_v_deg)
        });
        views
    };
    readings.incidences_deg().into_iter().map(of).collect()
}

/// Squared residuals of each geometry, summed over its channels.
fn squares(readings: &FitReadings, beta: &Array2<f64>) -> Vec<f64> {
    let residuals = readings.residuals(beta);
    (&residuals * &residuals).sum_axis(Axis(1)).to_vec()
}

/// Views of a block.
fn block_of(curve: &[usize]) -> usize {
    (curve.len() as f64).sqrt().ceil() as usize
}

/// Half of the interval in standard errors of the bootstrap; not finite where there is but one block an incidence.
fn widening(curves: &[Vec<usize>]) -> f64 {
    let (mut views, mut kept, mut blocks) = (0.0, 0.0, 0.0);
    for curve in curves {
        let (n, block) = (curve.len() as f64, block_of(curve) as f64);
        views += n;
        kept += n - block;
        blocks += n / block;
    }
    match StudentsT::new(0.0, 1.0, blocks - curves.len() as f64) {
        Ok(t) => t.inverse_cdf(0.975) / (kept / views).sqrt(),
        Err(_) => f64::INFINITY,
    }
}

/// Adds to `counts` how often each view of a curve is drawn; in all as often as the curve has views.
fn draw_blocks(curve: &[usize], counts: &mut [f64], stream: &mut impl Rng) {
    let block = block_of(curve);
    let mut drawn = 0;
    while drawn < curve.len() {
        let first = stream.random_range(0..curve.len());
        for view in 0..block.min(curve.len() - drawn) {
            counts[curve[(first + view) % curve.len()]] += 1.0;
            drawn += 1;
        }
    }
}

/// Squared residuals of the mean of as many batches as there are, drawn with replacement; none for a formula.
fn redrawn(readings: &FitReadings, model: Modelled, stream: &mut impl Rng) -> Option<Vec<f64>> {
    let batches = model.batches;
    if batches.is_empty() {
        return None;
    }
    let mut sum = Array2::zeros(model.beta.dim());
    for _ in batches {
        sum += &batches[stream.random_range(0..batches.len())];
    }
    Some(squares(readings, &(sum / batches.len() as f64)))
}

/// A physical against a classical model, on the readings both were fitted to and on those they were not.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FitVerdict {
    pub fitted: MisfitRatio,
    /// Of predictions of incidences left out; none with one incidence.
    pub left_out: Option<MisfitRatio>,
    pub verdict: Verdict,
}

impl FitVerdict {
    /// The verdict is that on incidences left out: more parameters always bring a model nearer to what it was
    /// fitted to. With one incidence nothing is unseen, and it cannot tell.
    pub fn new(fitted: MisfitRatio, left_out: Option<MisfitRatio>) -> Self {
        Self {
            fitted,
            left_out,
            verdict: left_out.map_or(Verdict::CannotTell, |ratio| ratio.verdict),
        }
    }

    /// The verdict in words.
    pub fn words(&self) -> &'static str {
        match self.verdict {
            Verdict::Better => "physical better",
            Verdict::Worse => "classical better",
            Verdict::CannotTell => "cannot tell",
        }
    }

    /// 0 physical better, 1 classical better, 2 cannot tell.
    pub fn exit_code(&self) -> u8 {
        match self.verdict {
            Verdict::Better => 0,
            Verdict::Worse => 1,
            Verdict::CannotTell => 2,
        }
    }
}
