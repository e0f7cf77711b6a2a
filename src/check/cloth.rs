//! Energy of the cloth: what it reflects, transmits and absorbs of a parallel beam, integrated over all directions.

use super::gate::{Gate, Law, Where};
use super::{CheckError, CheckedQuantity, Context};
use crate::rig::{omega_in, view_cell};
use crate::run::{Plan, hemisphere};
use crate::transport::{Fraction, Purpose, Stream};
use crate::yarn::{DirectBatch, ResponseWeights};
use rayon::prelude::*;

pub const ENERGY: Law = Law {
    name: "cloth-energy",
    words: "the cloth reflects, transmits and absorbs no more light than falls on it",
};
pub const ALBEDO: Law = Law {
    name: "cloth-albedo",
    words: "what the cloth reflects and transmits is between 0 and 1 at every wavelength",
};

/// Strata of the cell, a side, and how often the beam's rays go through them.
const PIXELS: usize = 6;
const ROUNDS: usize = 72;
/// In place of a view, apart from the other streams of the check.
const STREAM: usize = 1 << 21;

/// The cloth in one batch: what falls on it at each incidence of the rig.
pub struct ClothEnergy<'a> {
    context: &'a Context<'a>,
    /// [batch][incidence × wavelength].
    reflected: Vec<Vec<f64>>,
    transmitted: Vec<Vec<f64>>,
    absorbed: Vec<Vec<f64>>,
}

impl<'a> ClothEnergy<'a> {
    pub fn new(context: &'a Context<'a>) -> Self {
        Self {
            context,
            reflected: Vec::new(),
            transmitted: Vec::new(),
            absorbed: Vec::new(),
        }
    }

    /// Shades with one batch of the yarn.
    pub fn add(&mut self, yarn: &DirectBatch) -> Result<(), CheckError> {
        let plan = self.context.plan;
        let batch = self.reflected.len();
        let wavelengths = plan.grid.len();
        let samples = crate::rig::PixelSamples::new(PIXELS, PIXELS).map_err(crate::run::RunError::from)?;
        let incidences = plan.rig.incidences_deg();
        let sides: Vec<[ResponseWeights; 2]> = incidences
            .par_iter()
            .enumerate()
            .map(|(k, &theta_i_deg)| {
                [1.0, -1.0].map(|side| {
                    let stream = STREAM + 2 * k + usize::from(side > 0.0);
                    let mut rng = Stream::open(plan.study.seed, Purpose::Check, stream, batch, 0);
                    hemisphere(plan, &samples, &mut rng, theta_i_deg, side)
                })
            })
            .collect();
        let contract = |side: usize| -> Vec<f64> {
            let of = |weights: &[ResponseWeights; 2]| weights[side].contract(&yarn.response);
            sides.iter().flat_map(of).collect()
        };
        self.reflected.push(contract(0));
        self.transmitted.push(contract(1));
        let mut absorbed = Vec::with_capacity(incidences.len() * wavelengths);
        for (k, &theta_i_deg) in incidences.iter().enumerate() {
            absorbed.extend(absorbed_of(plan, &samples, [k, batch], theta_i_deg, yarn));
        }
        self.absorbed.push(absorbed);
        Ok(())
    }

    pub fn gates(&self) -> (Vec<Gate>, Vec<CheckedQuantity>) {
        let Self { context, .. } = self;
        let (plan, judge) = (context.plan, &context.judge);
        let (wavelengths, nm) = (plan.grid.len(), plan.grid.nm());
        let at = |i: usize| {
            let theta = plan.rig.incidences_deg()[i / wavelengths];
            Where::new(nm[i % wavelengths], format!("theta_i {theta} deg"))
        };
        let sum = |parts: &[&Vec<Vec<f64>>]| -> Vec<Vec<f64>> {
            let batches = 0..self.reflected.len();
            let cells = |batch: usize| {
                (0..self.reflected[batch].len()).map(move |i| parts.iter().map(|part| part[batch][i]).sum::<f64>())
            };
            batches
                .map(|batch| cells(batch).map(|all| all - 1.0).collect())
                .collect()
        };
        let tolerance = plan.study.check.cloth * context.widening;
        let all = sum(&[&self.reflected, &self.transmitted, &self.absorbed]);
        // f* is a sum of weights that are never negative, so of the two bounds one is exact.
        let least = self.reflected.iter().chain(&self.transmitted).flatten();
        let least = least.fold(0.0, |low: f64, x| if *x >= low { low } else { *x });
        let albedo = judge.at_most_zero(ALBEDO, &sum(&[&self.reflected, &self.transmitted]), tolerance, at);
        let albedo = match least < 0.0 {
            true => Gate {
                verdict: super::GateVerdict::Broken,
                ..albedo
            }
            .with_note(format!("negative light: {least:e}")),
            false => albedo,
        };
        let mut quantities = Vec::new();
        for (name, of) in [
            ("cloth-reflected", &self.reflected),
            ("cloth-transmitted", &self.transmitted),
        ] {
            for (k, theta) in plan.rig.incidences_deg().iter().enumerate() {
                let here = k * wavelengths..(k + 1) * wavelengths;
                let batches: Vec<Vec<f64>> = of.iter().map(|batch| batch[here.clone()].to_vec()).collect();
                quantities.extend(context.quantities(&format!("{name} {theta} deg"), &batches));
            }
        }
        (
            vec![judge.at_most_zero(ENERGY, &all, tolerance, at), albedo],
            quantities,
        )
    }
}

/// Absorbed by the yarns that the beam meets first: of rays even across the beam, the ledger of the tilt each has on
/// its yarn.
fn absorbed_of(
    plan: &Plan,
    samples: &crate::rig::PixelSamples,
    [incidence, batch]: [usize; 2],
    theta_i_deg: f64,
    yarn: &DirectBatch,
) -> Vec<f64> {
    let wavelengths = plan.grid.len();
    let light = omega_in(theta_i_deg, plan.study.cloth.azimuth_deg);
    let mut rng = Stream::open(plan.study.seed, Purpose::Check, 2 * STREAM + incidence, batch, 0);
    let tilts = plan.factor_grid.tilts();
    let mut rays = vec![0.0; tilts];
    for _ in 0..ROUNDS {
        view_cell(&plan.cloth, &light, samples, &mut rng, |interaction| {
            if let Some(point) = interaction {
                let tilt = point.hit.frame.to_local(&light).y.abs().min(1.0).asin().to_degrees() / 90.0;
                rays[((tilt * tilts as f64) as usize).min(tilts - 1)] += 1.0;
            }
        });
    }
    let share = 1.0 / (ROUNDS * samples.count()) as f64;
    let mut absorbed = vec![0.0; wavelengths];
    for (rays, ledgers) in rays.iter().zip(yarn.ledgers.chunks_exact(wavelengths)) {
        for (sum, ledger) in absorbed.iter_mut().zip(ledgers) {
            *sum += share * rays * ledger[Fraction::Absorbed];
        }
    }
    absorbed
}
