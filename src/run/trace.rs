use super::artefact::YarnLayout;
use super::{Plan, Progress, RunError};
use crate::transport::{BatchSums, Ledger};
use crate::yarn::{
    BssrdfGrid, DirectBatch, DirectTracer, EnergyTracer, LengthBins, LengthSums, LengthTally, PatchTracer,
};

/// Everything one batch of tracing tells about the yarn alone.
#[derive(Clone, Debug, PartialEq)]
pub struct YarnBatch {
    /// Traced incident direction × wavelength, wavelength fastest.
    pub ledgers: Vec<Ledger>,
    /// What left by path length: traced direction × wavelength × bin × (ballistic, scattered, and both times path length).
    pub energy_by_length: Vec<f64>,
    /// f* of the direct simulation, and of the sum over the BSSRDF, 1/sr: cell × wavelength.
    pub direct: Vec<f64>,
    pub summed: Vec<f64>,
    /// BSSRDF as fractions, axes as its grid says. Rounded to single precision, far below the noise of a cell: this is
    /// the largest table by far.
    pub bssrdf: Vec<f32>,
    /// f* of the direct simulation by path length.
    pub by_length: LengthTally,
}

/// Makes batches of the yarn: ledger, BSSRDF, f* by both roads, path lengths.
pub struct YarnTracer<'a> {
    plan: &'a Plan,
    grid: BssrdfGrid,
    lengths: LengthBins,
}

impl<'a> YarnTracer<'a> {
    pub fn new(plan: &'a Plan) -> Result<Self, RunError> {
        Ok(Self {
            plan,
            grid: plan.bssrdf_grid()?,
            lengths: LengthBins::new(plan.yarn.cylinder.radius_mm(), LengthBins::DEFAULT)?,
        })
    }

    /// What the tables hold and along which axes.
    pub fn layout(&self) -> YarnLayout {
        YarnLayout::of(self.plan, &self.grid, &self.lengths)
    }

    /// Batch number `batch`, the same whenever and wherever it is made.
    pub fn batch(&self, batch: usize) -> Result<YarnBatch, RunError> {
        let plan = self.plan;
        let lengths = Some(&self.lengths);
        // The table that takes most memory while it is made comes first, before the others are there.
        let (bssrdf, summed) = {
            let tracer = PatchTracer::new(&plan.yarn, &self.grid, plan.factor_grid, plan.bssrdf_effort)?;
            let patch = tracer.batch(batch);
            let rounded: Vec<f32> = patch.fractions.iter().map(|&fraction| fraction as f32).collect();
            (rounded, patch.radiance_factor)
        };
        let energy = EnergyTracer::new(&plan.yarn, plan.incident, plan.bssrdf_effort, lengths)?.batch(batch);
        let direct = DirectTracer::new(&plan.yarn, plan.factor_grid, plan.direct_effort, lengths)?;
        let DirectBatch {
            radiance_factor,
            lengths,
            ..
        } = direct.batch(batch);
        Ok(YarnBatch {
            ledgers: energy.ledgers,
            energy_by_length: energy.lengths.into_flattened(),
            direct: radiance_factor,
            summed,
            bssrdf,
            by_length: lengths,
        })
    }
}

/// Batches of the yarn added up in their order. Only the ledgers are kept batch by batch; the rest takes the same memory
/// for any number of them.
#[derive(Clone, Debug, PartialEq)]
pub struct YarnSums {
    /// [batch][traced incident direction × wavelength].
    pub ledgers: Vec<Vec<Ledger>>,
    /// See [`YarnBatch`].
    pub energy_by_length: BatchSums,
    pub direct: BatchSums,
    pub summed: BatchSums,
    pub bssrdf: BatchSums,
    pub by_length: LengthSums,
}

impl YarnSums {
    pub fn new(layout: &YarnLayout) -> Self {
        let values = layout.factor_grid.cells() * layout.wavelengths();
        Self {
            ledgers: Vec::new(),
            energy_by_length: BatchSums::zeros(layout.incident.traced() * layout.wavelengths() * layout.bins() * 4),
            direct: BatchSums::zeros(values),
            summed: BatchSums::zeros(values),
            bssrdf: BatchSums::zeros(layout.bssrdf_shape.iter().product()),
            by_length: LengthSums::zeros(values * layout.bins()),
        }
    }

    /// Adds the next batch.
    pub fn add(&mut self, batch: YarnBatch) {
        self.ledgers.push(batch.ledgers);
        self.energy_by_length.add(&batch.energy_by_length);
        self.direct.add(&batch.direct);
        self.summed.add(&batch.summed);
        self.bssrdf.add(&batch.bssrdf);
        self.by_length.add(&batch.by_length);
    }
}

/// Traces all batches of a study.
pub fn trace_yarn(tracer: &YarnTracer, progress: Progress) -> Result<YarnSums, RunError> {
    let layout = tracer.layout();
    let mut sums = YarnSums::new(&layout);
    for batch in 0..layout.batches() {
        sums.add(tracer.batch(batch)?);
        progress(1.0 / layout.batches() as f64);
    }
    Ok(sums)
}
