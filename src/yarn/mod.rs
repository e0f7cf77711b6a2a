//! Light in one yarn: Monte Carlo from a patch (BSSRDF) and from a parallel beam, and the yarn response f* they give.

mod bssrdf;
mod direct;
mod directions;
mod energy;
mod far_field;
mod interpolation;
mod length_range;
mod lengths;
mod locality;
mod reabsorption;
mod response;
mod response_cells;
mod response_grid;
mod response_weights;
mod sampler;
mod tracer;

pub use bssrdf::{BssrdfBatch, BssrdfGrid, PatchTracer};
pub use direct::{DirectBatch, DirectTracer};
pub use directions::IncidentGrid;
pub use energy::{EnergyBatch, EnergyTracer};
pub use far_field::{FarFieldBatch, FarFieldGrid, FarFieldTracer};
pub use lengths::{LengthBins, LengthSums, LengthTally};
pub use locality::scattered_beyond;
pub use reabsorption::{ByLength, Change, Reabsorption, Reweighted, Support};
pub use response::YarnResponse;
pub use response_grid::YarnResponseGrid;
pub use response_weights::{ResponseWeights, WeightTally};
pub(crate) use sampler::scattered_or_absorbed;
pub use sampler::{Leaving, Meeting, YarnSampler, kept_by_straight_yarn};

use crate::fault::{self, Fault};
use crate::geometry::{HemisphereGrid, Sectors};
use crate::optics::Medium;
use crate::transport::{Coefficients, Cylinder, Interior, Roulette, TransportError, Walk};

/// Invalid input to the tracing of a yarn.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum YarnError {
    #[error(transparent)]
    Transport(#[from] TransportError),
    #[error("{quantity}: expected {expected}, found {found}")]
    Count {
        quantity: &'static str,
        expected: &'static str,
        found: usize,
    },
    #[error("{quantity}: expected {expected} values for the axes of its grid, found {found}")]
    Values {
        quantity: &'static str,
        expected: usize,
        found: usize,
    },
    /// The change of the medium is too large for re-weighting, or the data do not match; trace the new medium.
    #[error("re-absorption: {quantity}: expected {expected}, found {found}; trace the new medium instead")]
    Reabsorption {
        quantity: &'static str,
        expected: String,
        found: String,
    },
}

/// How paths are assigned to wavelengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimator {
    /// One path for all wavelengths, weighted by the balance heuristic.
    Shared,
    /// Separate paths for each wavelength; the ledger closes to rounding.
    Independent,
}

/// A yarn: an infinite circular cylinder filled with the medium.
#[derive(Clone, Debug)]
pub struct Yarn {
    pub cylinder: Cylinder,
    pub medium: Medium,
    pub roulette: Roulette,
    /// Estimator requested; see [`Yarn::estimator_in_use`].
    pub estimator: Estimator,
}

/// Consecutive wavelengths that share paths; `first` is the index of the first one in the medium's grid.
#[derive(Debug)]
pub struct Sharing<'a> {
    pub first: usize,
    pub interior: Interior<'a>,
}

impl Yarn {
    /// The estimator in effect. In a dispersive host refraction separates the wavelengths, so paths are independent
    /// whatever was requested.
    pub fn estimator_in_use(&self) -> Estimator {
        let index = self.medium.host_index();
        if index.iter().all(|n| *n == index[0]) {
            self.estimator
        } else {
            Estimator::Independent
        }
    }

    /// The medium's wavelengths in order, grouped by shared paths.
    ///
    /// # Errors
    /// [`YarnError`] if the medium cannot be traced.
    pub fn sharing(&self) -> Result<Vec<Sharing<'_>>, YarnError> {
        self.sharing_by(self.estimator_in_use())
    }

    /// The same as [`Self::sharing`] for a given estimator. In a dispersive host, shared paths have wrong directions at
    /// all wavelengths but one.
    pub fn sharing_by(&self, estimator: Estimator) -> Result<Vec<Sharing<'_>>, YarnError> {
        let one_absorption = fault::active(Fault::OneAbsorption) && estimator == Estimator::Independent;
        let middle = |w| one_absorption && w == self.wavelengths() / 2;
        let flights = if fault::active(Fault::FlightsShort) && estimator == Estimator::Shared {
            1.01
        } else {
            1.0
        };
        let coefficients: Vec<Coefficients<'_>> = (0..self.wavelengths())
            .map(|w| Coefficients {
                mu_s: self.medium.mu_s_per_mm()[w] * flights,
                mu_a: self.medium.mu_a_per_mm()[w] * if middle(w) { 1.02 } else { 1.0 },
                phase: self.medium.phase(w),
            })
            .collect();
        let together = match estimator {
            Estimator::Shared => coefficients.len(),
            Estimator::Independent => 1,
        };
        let mut sharing = Vec::new();
        for (k, coefficients) in coefficients.chunks(together).enumerate() {
            let first = k * together;
            let interior = Interior::new(self.medium.host_index()[first], coefficients)?;
            sharing.push(Sharing { first, interior });
        }
        Ok(sharing)
    }

    fn walk<'a>(&'a self, interior: &'a Interior<'a>) -> Walk<'a, Cylinder> {
        Walk {
            shape: &self.cylinder,
            interior,
            roulette: self.roulette,
        }
    }

    fn wavelengths(&self) -> usize {
        self.medium.grid().len()
    }
}

/// Adds the weights of an exit, times a factor, to a row of a table.
#[inline(always)]
fn add_scaled(sums: &mut [f64], weights: &[f64], factor: f64) {
    sums.iter_mut()
        .zip(weights)
        .for_each(|(sum, weight)| *sum += factor * weight);
}

/// Number of paths and batches, and seed of the random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    pub seed: u64,
    /// Number of independent batches; a standard error needs two or more.
    pub batches: usize,
    /// Paths per batch for each direction, and for each wavelength if paths are independent.
    pub paths_per_batch: usize,
}

impl Effort {
    /// Splits `paths` over the batches, rounding up.
    pub fn new(seed: u64, batches: usize, paths: u64) -> Result<Self, YarnError> {
        if batches < 2 {
            return Err(YarnError::Count {
                quantity: "batches",
                expected: "2 or more, for a standard error",
                found: batches,
            });
        }
        if paths == 0 {
            return Err(YarnError::Count {
                quantity: "paths",
                expected: "1 or more",
                found: 0,
            });
        }
        Ok(Self {
            seed,
            batches,
            paths_per_batch: paths.div_ceil(batches as u64) as usize,
        })
    }
}

/// Cells of the yarn's surface (azimuth) and of exit directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceGrid {
    /// Number of azimuth cells around the whole yarn, a multiple of 4.
    azimuths: usize,
    exit: HemisphereGrid,
}

impl SurfaceGrid {
    /// Numbers of azimuth cells around the yarn, and of polar and azimuth cells of exit directions.
    ///
    /// # Errors
    /// [`YarnError::Count`] if a number of azimuth cells is not a multiple of 4, or if there is no polar cell.
    pub fn new(azimuths: usize, theta_cells: usize, phi_cells: usize) -> Result<Self, YarnError> {
        if azimuths < 4 || !azimuths.is_multiple_of(4) {
            return Err(YarnError::Count {
                quantity: "azimuth cells around the yarn",
                expected: "a multiple of 4",
                found: azimuths,
            });
        }
        let exit = HemisphereGrid::new(theta_cells, phi_cells).ok_or(YarnError::Count {
            quantity: "azimuth cells of the exit hemisphere",
            expected: "a multiple of 4, with at least 1 polar cell",
            found: phi_cells,
        })?;
        Ok(Self { azimuths, exit })
    }

    /// Number of azimuth cells around the whole yarn.
    pub fn azimuths(&self) -> usize {
        self.azimuths
    }

    /// Grid of exit directions.
    pub fn exit(&self) -> &HemisphereGrid {
        &self.exit
    }

    fn sectors(&self) -> Result<Sectors, YarnError> {
        Self::sectors_of(self.azimuths)
    }

    fn sectors_of(azimuths: usize) -> Result<Sectors, YarnError> {
        Sectors::new(azimuths).ok_or(YarnError::Count {
            quantity: "azimuth cells around the yarn",
            expected: "a multiple of 4",
            found: azimuths,
        })
    }
}
