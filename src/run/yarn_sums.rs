use super::artefact::YarnLayout;
use crate::transport::{BatchSums, Ledger};
use crate::yarn::{LengthSums, LengthTally};

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
