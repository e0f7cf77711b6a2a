use super::{Plan, Progress, RunError};
use crate::transport::{BatchSums, Ledger};
use crate::yarn::{
    BssrdfBatch, BssrdfGrid, DirectBatch, DirectTracer, EnergyBatch, EnergyTracer, LengthBins, LengthSums, PatchTracer,
};

/// Everything one batch of tracing tells about the yarn alone.
#[derive(Clone, Debug, PartialEq)]
pub struct YarnBatch {
    pub energy: EnergyBatch,
    pub direct: DirectBatch,
    pub patch: BssrdfBatch,
}

/// Makes batches of the yarn: ledger, BSSRDF, f* by both roads, path lengths.
pub struct YarnTracer<'a> {
    plan: &'a Plan,
    grid: &'a BssrdfGrid,
    lengths: &'a LengthBins,
}

impl<'a> YarnTracer<'a> {
    pub fn new(plan: &'a Plan, grid: &'a BssrdfGrid, lengths: &'a LengthBins) -> Self {
        Self { plan, grid, lengths }
    }

    /// Batch number `batch`, the same whenever and wherever it is made.
    pub fn batch(&self, batch: usize) -> Result<YarnBatch, RunError> {
        let plan = self.plan;
        let lengths = Some(self.lengths);
        let energy = EnergyTracer::new(&plan.yarn, plan.incident, plan.bssrdf_effort, lengths)?;
        let direct = DirectTracer::new(&plan.yarn, plan.factor_grid, plan.direct_effort, lengths)?;
        let patch = PatchTracer::new(&plan.yarn, self.grid, plan.factor_grid, plan.bssrdf_effort)?;
        Ok(YarnBatch {
            energy: energy.batch(batch),
            direct: direct.batch(batch),
            patch: patch.batch(batch),
        })
    }
}

/// Batches of the yarn added up in their order. Only the energy is kept batch by batch; the rest takes the same memory
/// for any number of them.
#[derive(Clone, Debug, PartialEq)]
pub struct YarnSums {
    pub energy: Vec<EnergyBatch>,
    /// f* of the direct simulation, and of the sum over the BSSRDF: cell × wavelength.
    pub direct: BatchSums,
    pub summed: BatchSums,
    /// Fractions, axes as the BSSRDF's grid says.
    pub bssrdf: BatchSums,
    /// f* of the direct simulation by path length.
    pub lengths: LengthSums,
}

impl YarnSums {
    pub fn new(plan: &Plan, grid: &BssrdfGrid, lengths: &LengthBins) -> Self {
        let values = plan.factor_grid.cells() * plan.grid.len();
        Self {
            energy: Vec::new(),
            direct: BatchSums::zeros(values),
            summed: BatchSums::zeros(values),
            bssrdf: BatchSums::zeros(grid.shape().iter().product()),
            lengths: LengthSums::zeros(values * lengths.bins()),
        }
    }

    pub fn add(&mut self, batch: YarnBatch) {
        self.direct.add(&batch.direct.radiance_factor);
        self.summed.add(&batch.patch.radiance_factor);
        self.bssrdf.add(&batch.patch.fractions);
        self.lengths.add(&batch.direct.lengths);
        self.energy.push(batch.energy);
    }

    /// [batch][traced incident direction × wavelength].
    pub fn ledgers(&self) -> Vec<Vec<Ledger>> {
        self.energy.iter().map(|batch| batch.ledgers.clone()).collect()
    }
}

/// Traces all batches of a study.
pub fn trace_yarn(
    plan: &Plan,
    grid: &BssrdfGrid,
    lengths: &LengthBins,
    progress: Progress,
) -> Result<YarnSums, RunError> {
    let tracer = YarnTracer::new(plan, grid, lengths);
    let mut sums = YarnSums::new(plan, grid, lengths);
    let batches = plan.direct_effort.batches;
    for batch in 0..batches {
        sums.add(tracer.batch(batch)?);
        progress(1.0 / batches as f64);
    }
    Ok(sums)
}
