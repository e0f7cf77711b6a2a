use super::artefact::{YarnArtefact, YarnLayout};
use super::effort::effort_note;
use super::yarn_sums::{YarnBatch, YarnSums};
use super::{Gather, Plan, Precision, RunError, Schedule, Stage, Tolerance, Watched, check_memory, gather};
use crate::report::EffortNote;
use crate::transport::{BatchSums, Fraction, Ledger};
use crate::yarn::{DirectBatch, DirectTracer, EnergyTracer, LengthBins, PatchTracer};
use std::path::Path;

/// Makes batches of the yarn: ledger, BSSRDF, f* by both roads, path lengths.
pub struct YarnTracer<'a> {
    plan: &'a Plan,
    lengths: LengthBins,
    energy: EnergyTracer<'a>,
    direct: DirectTracer<'a>,
    patch: PatchTracer<'a>,
}

impl<'a> YarnTracer<'a> {
    /// Batches to have under way at once. Each takes hundreds of megabytes, and keeps all threads busy by itself.
    pub const ROUND: usize = 1;

    /// # Errors
    /// A study whose tables do not fit into the memory that is free.
    pub fn new(plan: &'a Plan) -> Result<Self, RunError> {
        check_memory(&plan.study, Stage::Yarn)?;
        let (yarn, factors) = (&plan.yarn, plan.factor_grid);
        let lengths = LengthBins::new(yarn.cylinder.radius_mm(), LengthBins::DEFAULT)?;
        Ok(Self {
            plan,
            energy: EnergyTracer::new(yarn, plan.incident, plan.bssrdf_effort, Some(lengths.clone()))?,
            direct: DirectTracer::new(yarn, factors, plan.direct_effort, Some(lengths.clone()))?,
            patch: PatchTracer::new(yarn, plan.bssrdf_grid(yarn)?, factors, plan.bssrdf_effort)?,
            lengths,
        })
    }

    /// What the tables hold and along which axes.
    pub fn layout(&self) -> YarnLayout {
        YarnLayout::of(self.plan, self.patch.grid(), &self.lengths)
    }

    /// Batch number `batch`, the same whenever and wherever it is made.
    pub fn batch(&self, batch: usize) -> YarnBatch {
        // The table that takes most memory while it is made comes first, before the others are there.
        let (bssrdf, summed) = {
            let patch = self.patch.batch(batch);
            let rounded: Vec<f32> = patch.fractions.iter().map(|&fraction| fraction as f32).collect();
            (rounded, patch.response.into_values())
        };
        let energy = self.energy.batch(batch);
        let DirectBatch { response, lengths, .. } = self.direct.batch(batch);
        YarnBatch {
            ledgers: energy.ledgers,
            energy_by_length: energy.lengths.into_flattened(),
            direct: response.into_values(),
            summed,
            bssrdf,
            by_length: lengths,
        }
    }
}

/// Batches of a trace so far.
struct Tracing<'a> {
    tracer: &'a YarnTracer<'a>,
    layout: YarnLayout,
    sums: YarnSums,
    scattered: BatchSums,
    tolerance: Option<Tolerance>,
    /// Batches with which the run ends in any case.
    most: usize,
    state: &'a Path,
}

impl Tracing<'_> {
    /// Takes one batch's scattered fractions into what the stop rule watches.
    fn watch(scattered: &mut BatchSums, ledgers: &[Ledger]) {
        let fractions: Vec<f64> = ledgers.iter().map(|ledger| ledger[Fraction::Scattered]).collect();
        scattered.add(&fractions);
    }
}

impl Gather for Tracing<'_> {
    type Batch = YarnBatch;
    type Error = RunError;

    fn batches(&self) -> usize {
        self.sums.ledgers.len()
    }

    fn make(&self, batch: usize) -> Result<YarnBatch, RunError> {
        Ok(self.tracer.batch(batch))
    }

    fn accept(&mut self, batch: YarnBatch) {
        Self::watch(&mut self.scattered, &batch.ledgers);
        self.sums.add(batch);
    }

    fn largest_error(&self) -> Option<f64> {
        largest_error(&self.scattered, self.tolerance?)
    }

    fn save(&self) -> Result<(), RunError> {
        if self.batches() >= self.most {
            // The artefact comes next, and is no larger.
            return Ok(());
        }
        self.sums.save(&self.layout, self.state)
    }
}

/// Largest standard error of the ledger's scattered fractions over wavelengths and directions, as the tolerance counts
/// it; none for fewer than two batches.
fn largest_error(scattered: &BatchSums, tolerance: Tolerance) -> Option<f64> {
    if scattered.batches < 2 {
        return None;
    }
    let estimates = (0..scattered.sum.len()).map(|i| scattered.estimate(i));
    tolerance.largest_error(scattered.batches as usize, estimates.map(|e| (e.value, e.se)))
}

/// Traces until the schedule's rule says stop; its precision is that of the ledger's scattered fractions. Goes on from
/// `resumed`, if there is one, and keeps the state in the file `state`.
///
/// # Errors
/// A state of more batches than this rule would have let a run make.
pub fn trace_yarn(
    tracer: &YarnTracer,
    resumed: Option<YarnSums>,
    state: &Path,
    schedule: &Schedule,
) -> Result<(YarnArtefact, EffortNote), RunError> {
    let layout = tracer.layout();
    let rule = schedule.rule;
    let tolerance = rule.precision.map(|precision| precision.tolerance);
    let mut scattered = BatchSums::zeros(layout.incident.traced() * layout.wavelengths());
    let sums = resumed.unwrap_or_else(|| YarnSums::new(&layout));
    for (batches, ledgers) in sums.ledgers.iter().enumerate() {
        let error = || largest_error(&scattered, tolerance?);
        if rule.reached(batches, error).is_some() {
            return Err(RunError::StateTooFar {
                path: state.to_owned(),
                found: sums.ledgers.len(),
                most: batches,
            });
        }
        Tracing::watch(&mut scattered, ledgers);
    }
    let mut tracing = Tracing {
        tracer,
        layout,
        sums,
        scattered,
        tolerance,
        most: rule.batches,
        state,
    };
    let outcome = gather(&mut tracing, schedule)?;
    // Without a precision nothing is watched, and its largest error is none.
    let watched = rule.precision.unwrap_or(Precision {
        tolerance: Tolerance::Absolute(0.0),
        of: Watched::Scattered,
    });
    let effort = effort_note(tracer.plan, rule, &outcome, watched);
    Ok((YarnArtefact::new(tracing.layout, tracing.sums), effort))
}
