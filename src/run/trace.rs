use super::artefact::{
    BatchTables, MediumValues, ShardWriter, YarnArtefact, YarnBatch, YarnLayout, YarnSettings, YarnSums,
};
use super::effort::{effort_note, paths_per_batch};
use super::{
    Gather, Plan, Precision, Progress, RunError, Schedule, Shard, Stage, Tolerance, Watched, check_memory, energy_rows,
    gather,
};
use crate::report::{EffortNote, EnergyRow, PathsPerBatch};
use crate::transport::{BatchSums, Fraction, Ledger};
use crate::yarn::{DirectBatch, DirectTracer, EnergyTracer, LengthBins, PatchTracer};
use std::path::Path;

/// Traces batches of the yarn: ledger, BSSRDF, f* of a beam and from the BSSRDF, path lengths.
pub struct YarnTracer<'a> {
    layout: YarnLayout,
    paths_per_batch: PathsPerBatch,
    energy: EnergyTracer<'a>,
    direct: DirectTracer<'a>,
    patch: PatchTracer<'a>,
}

impl<'a> YarnTracer<'a> {
    /// Batches to trace at once. Each takes hundreds of megabytes and keeps all threads busy by itself.
    pub const ROUND: usize = 1;

    /// # Errors
    /// A study whose tables do not fit into the memory that is free.
    pub fn new(plan: &'a Plan) -> Result<Self, RunError> {
        check_memory(&plan.study, Stage::Yarn)?;
        let (yarn, factors) = (&plan.yarn, plan.factor_grid);
        let lengths = LengthBins::new(yarn.cylinder.radius_mm(), LengthBins::DEFAULT)?;
        let bssrdf = plan.bssrdf_grid(yarn)?;
        let settings = YarnSettings {
            study: plan.study.clone(),
            inputs: plan.inputs.clone(),
            medium: MediumValues::from(&yarn.medium),
            reabsorbed: Vec::new(),
        };
        Ok(Self {
            layout: YarnLayout::new(settings, plan.incident, factors, &bssrdf, &lengths),
            paths_per_batch: paths_per_batch(plan),
            energy: EnergyTracer::new(yarn, plan.incident, plan.bssrdf_effort, Some(lengths.clone()))?,
            direct: DirectTracer::new(yarn, factors, plan.direct_effort, Some(lengths))?,
            patch: PatchTracer::new(yarn, bssrdf, factors, plan.bssrdf_effort)?,
        })
    }

    /// What the tables hold and along which axes.
    pub fn layout(&self) -> YarnLayout {
        self.layout.clone()
    }

    /// Batch number `batch`, the same bits whenever and wherever it is traced.
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
            tables: BatchTables {
                energy_by_length: energy.lengths.into_flattened(),
                direct: response.into_values(),
                summed,
                bssrdf,
                by_length: lengths,
            },
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
    /// Batches after which the run ends in any case.
    most: usize,
    state: &'a Path,
}

impl Tracing<'_> {
    /// Adds one batch's scattered fractions to the sums that the stop rule watches.
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
            // The trace file is written next, and is no larger.
            return Ok(());
        }
        self.sums.save(&self.layout, self.state)
    }
}

/// Largest standard error of the ledger's scattered fractions over wavelengths and directions, absolute or relative as
/// the tolerance is; none for fewer than two batches.
fn largest_error(scattered: &BatchSums, tolerance: Tolerance) -> Option<f64> {
    if scattered.batches < 2 {
        return None;
    }
    let estimates = (0..scattered.sum.len()).map(|i| scattered.estimate(i));
    tolerance.largest_error(scattered.batches as usize, estimates.map(|e| (e.value, e.se)))
}

/// Traces the batches of one shard into its file. Holds one batch at a time. Returns the ledger of these batches.
pub fn trace_shard(
    tracer: &YarnTracer,
    shard: Shard,
    path: &Path,
    progress: Progress,
) -> Result<Vec<EnergyRow>, RunError> {
    let layout = &tracer.layout;
    let batches = shard.batches(layout.batches())?;
    let mut file = ShardWriter::create(path, layout, shard)?;
    let mut ledgers = Vec::with_capacity(batches.len());
    for number in batches.clone() {
        let batch = tracer.batch(number);
        file.append(number, &batch)?;
        ledgers.push(batch.ledgers);
        progress(1.0 / batches.len() as f64);
    }
    file.finish()?;
    Ok(energy_rows(&layout.axes.wavelength_nm, &layout.incident, &ledgers))
}

/// Traces until the schedule's stop rule ends the run; its precision is that of the ledger's scattered fractions.
/// Continues from `resumed`, if there is one, and keeps the state in the file `state`.
///
/// # Errors
/// A state of more batches than a run under this rule would have traced.
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
    // Without a precision nothing is watched and there is no largest error.
    let watched = rule.precision.unwrap_or(Precision {
        tolerance: Tolerance::Absolute(0.0),
        of: Watched::Scattered,
    });
    let effort = effort_note(tracer.paths_per_batch, rule, &outcome, watched);
    Ok((YarnArtefact::new(tracing.layout, tracing.sums), effort))
}
