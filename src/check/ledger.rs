//! Energy ledger of every wavelength and incident direction, and the white furnace.

use super::gate::{Gate, Law, Where};
use super::judge::estimates;
use super::{CheckError, CheckedQuantity, Context};
use crate::study::NumberOrTable;
use crate::transport::{Fraction, FractionList, Ledger, Roulette};
use crate::yarn::{Effort, EnergyTracer, Estimator, Yarn};
use std::iter::zip;

const INDEPENDENT: Law = Law {
    name: "ledger",
    words: "independent paths: reflected + ballistic + scattered + absorbed + roulette is 1",
};
const SHARED: Law = Law {
    name: "ledger-shared",
    words: "shared paths: the same sum and what the balance heuristic took less what it gave are 1",
};
pub const SHARING: Law = Law {
    name: "sharing",
    words: "shared paths: the balance heuristic takes as much as it gives",
};
pub const ROULETTE: Law = Law {
    name: "roulette",
    words: "roulette takes as much as it gives, as the study plays it and played at every step",
};
const FURNACE: Law = Law {
    name: "white-furnace",
    words: "with absorption off nothing is absorbed and all light comes back",
};

/// Russian roulette that applies to nearly every path at nearly every step, with a high survival probability, so that a
/// bias shows.
const FREQUENT_BELOW: f64 = 0.99;
const FREQUENT_SURVIVAL: f64 = 0.8;

/// Batches and paths of ledgers that close to rounding with any number of paths.
const CLOSING: (usize, u64) = (2, 128);

/// Fractions whose means a baseline is compared in; the nets, which are 0 in the mean, have gates of their own.
const COMPARED: [Fraction; 4] = [
    Fraction::Reflected,
    Fraction::Ballistic,
    Fraction::Scattered,
    Fraction::Absorbed,
];

/// The gates, and mean fractions as quantities that a baseline is compared in.
pub fn gates(context: &Context) -> Result<(Vec<Gate>, Vec<CheckedQuantity>), CheckError> {
    let plan = context.plan;
    let check = &plan.study.check;
    let judge = &context.judge;
    let closing = Effort::new(plan.study.seed, CLOSING.0, CLOSING.1)?;
    let independent = Yarn {
        estimator: Estimator::Independent,
        ..plan.yarn.clone()
    };
    let departures =
        |batches: Vec<Vec<Ledger>>, of: fn(&Ledger) -> f64| -> Vec<f64> { batches.iter().flatten().map(of).collect() };
    let closed = departures(traced(context, &independent, closing)?, Ledger::residual);
    let mut gates = vec![judge.exact(INDEPENDENT, &closed, check.rounding, |i| place(context, i))];

    let furnace = Yarn {
        estimator: Estimator::Independent,
        ..white_yarn(context)?
    };
    let lost = departures(traced(context, &furnace, closing)?, |ledger| {
        let residual = ledger.residual();
        if ledger[Fraction::Absorbed].abs() > residual.abs() {
            ledger[Fraction::Absorbed]
        } else {
            residual
        }
    });
    gates.push(judge.exact(FURNACE, &lost, check.rounding, |i| place(context, i)));

    let paths = context.of_estimator(context.judge.paths);
    let effort = Effort::new(plan.study.seed, context.batches, paths)?;
    let batches = traced(context, &plan.yarn, effort)?;
    let wavelengths = plan.grid.len();
    let means = |of: &dyn Fn(&Ledger) -> f64| means_over_directions(context, &batches, of);
    if plan.yarn.estimator_in_use() == Estimator::Shared {
        let of_cells = |of: fn(&Ledger) -> f64| -> Vec<Vec<f64>> {
            batches.iter().map(|batch| batch.iter().map(of).collect()).collect()
        };
        let residuals = of_cells(Ledger::residual);
        let means: Vec<f64> = estimates(&residuals).iter().map(|[mean, _]| *mean).collect();
        gates.push(judge.exact(SHARED, &means, check.rounding, |i| place(context, i)));
        let tolerance = check.sharing * context.widening;
        let taken = of_cells(|ledger| ledger[Fraction::MisNet]);
        gates.push(judge.zero(SHARING, &taken, tolerance, |i| place(context, i)));
    }
    let frequent = Yarn {
        roulette: Roulette::new(FREQUENT_BELOW, FREQUENT_SURVIVAL)?,
        estimator: plan.yarn.estimator,
        ..furnace
    };
    let half = Effort::new(plan.study.seed, context.batches, paths / 2)?;
    let frequent = traced(context, &frequent, half)?;
    let net = |ledger: &Ledger| ledger[Fraction::RouletteNet];
    let mut nets = means(&net);
    for (own, frequent) in zip(&mut nets, means_over_directions(context, &frequent, &net)) {
        own.extend(frequent);
    }
    let tolerance = check.roulette * context.widening;
    gates.push(judge.zero(ROULETTE, &nets, tolerance, |i| {
        let yarn = if i < wavelengths {
            "the study's yarn"
        } else {
            "white yarn, played always"
        };
        Where::new(plan.grid.nm()[i % wavelengths], format!("{yarn}, mean over directions"))
    }));
    let mut quantities = Vec::new();
    for fraction in COMPARED {
        quantities.extend(context.quantities(fraction.name(), &means(&|ledger| ledger[fraction])));
    }
    Ok((gates, quantities))
}

/// The warp's yarn without absorption.
pub fn white_yarn(context: &Context) -> Result<Yarn, CheckError> {
    let mut white = context.plan.study.medium.clone();
    white.kappa_peak = 0.0;
    white.host_mu_a_per_mm = NumberOrTable::Number(0.0);
    Ok(context.plan.yarn_of(&white)?)
}

/// Mean over the traced directions, which mirrored ones repeat: [batch][wavelength].
fn means_over_directions(context: &Context, batches: &[Vec<Ledger>], of: &dyn Fn(&Ledger) -> f64) -> Vec<Vec<f64>> {
    let wavelengths = context.plan.grid.len();
    let share = 1.0 / context.plan.incident.traced() as f64;
    let of_batch = |batch: &Vec<Ledger>| -> Vec<f64> {
        let mut means = vec![0.0; wavelengths];
        for row in batch.chunks_exact(wavelengths) {
            zip(&mut means, row).for_each(|(mean, ledger)| *mean += share * of(ledger));
        }
        means
    };
    batches.iter().map(of_batch).collect()
}

/// [batch][traced direction × wavelength].
fn traced(context: &Context, yarn: &Yarn, effort: Effort) -> Result<Vec<Vec<Ledger>>, CheckError> {
    let tracer = EnergyTracer::new(yarn, context.plan.incident, effort, None)?;
    Ok((0..effort.batches).map(|batch| tracer.batch(batch).ledgers).collect())
}

/// Place of value i of batch × traced direction × wavelength.
fn place(context: &Context, i: usize) -> Where {
    let plan = context.plan;
    let (wavelengths, traced) = (plan.grid.len(), plan.incident.traced());
    let direction = i / wavelengths % traced;
    let all = 0..plan.incident.len();
    let named = all
        .into_iter()
        .find(|&k| plan.incident.representative(k).0 == direction)
        .unwrap_or(direction);
    let [theta, phi] = plan.incident.angles_deg(named);
    Where::new(
        plan.grid.nm()[i % wavelengths],
        format!("theta_in {theta} deg, phi_in {phi} deg"),
    )
}
