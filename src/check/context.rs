use super::judge::{Judge, estimates};
use super::{CheckEffort, CheckedQuantity};
use crate::run::Plan;
use crate::yarn::Estimator;

/// What the gates of a study need.
pub struct Context<'a> {
    pub(super) plan: &'a Plan,
    pub(super) judge: Judge,
    pub(super) batches: usize,
    pub(super) cloth_batches: usize,
    /// Factor of the stochastic tolerances.
    pub(super) widening: f64,
}

/// What shared paths carry is good to parts in 10⁶ of the incident flux (`transport::spectral`), what the others carry
/// to rounding.
const SINGLE_PRECISION: f64 = 1e-6;
const DOUBLE_PRECISION: f64 = 1e-12;

impl<'a> Context<'a> {
    /// `in_the_mean` laws have a chance to break: the false alarms of a run are divided between them.
    pub(super) fn new(plan: &'a Plan, effort: CheckEffort, in_the_mean: usize) -> Self {
        Self {
            plan,
            judge: Judge {
                level: plan.study.check.false_alarms / in_the_mean as f64,
                paths: effort.paths,
                precision: match plan.yarn.estimator_in_use() {
                    Estimator::Shared => SINGLE_PRECISION,
                    Estimator::Independent => DOUBLE_PRECISION,
                },
            },
            batches: CheckEffort::BATCHES,
            cloth_batches: CheckEffort::CLOTH_BATCHES,
            widening: effort.widening(),
        }
    }

    /// `shares` times the paths that a batch of the ledger has.
    pub(super) fn share(&self, shares: u64) -> u64 {
        shares * (self.judge.paths / self.batches as u64)
    }

    /// Paths that cost as much as so many shared ones.
    pub(super) fn of_estimator(&self, paths: u64) -> u64 {
        match self.plan.yarn.estimator_in_use() {
            Estimator::Shared => paths,
            Estimator::Independent => (paths / self.plan.grid.len() as u64).max(self.batches as u64),
        }
    }

    /// One quantity at every wavelength, from [batch][wavelength].
    pub(super) fn quantities(&self, name: &str, batches: &[Vec<f64>]) -> Vec<CheckedQuantity> {
        let nm = self.plan.grid.nm();
        let estimates = estimates(batches).into_iter().zip(nm);
        estimates
            .map(|([value, se], &wavelength_nm)| CheckedQuantity {
                name: name.into(),
                wavelength_nm,
                value,
                se,
                batches: batches.len(),
            })
            .collect()
    }
}
