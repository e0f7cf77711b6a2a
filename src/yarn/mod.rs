//! Light in one yarn: Monte Carlo from a patch (BSSRDF) and from a parallel beam, and the radiance factor f* they give.

mod bssrdf;
mod direct;
mod directions;
mod radiance_factor;

pub use bssrdf::{Bssrdf, BssrdfRun, trace_bssrdf};
pub use direct::{DirectRun, trace_direct};
pub use directions::IncidentGrid;
pub use radiance_factor::{FactorWeights, RadianceFactorGrid, RadianceFactorTable, WeightTally};

use crate::geometry::HemisphereGrid;
use crate::optics::Medium;
use crate::transport::{Cylinder, Interior, Roulette, TransportError};

/// What is wrong with an input of the yarn's tracing.
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
}

/// A yarn: a cylinder full of medium.
#[derive(Clone, Debug)]
pub struct Yarn {
    pub cylinder: Cylinder,
    pub medium: Medium,
    pub roulette: Roulette,
}

impl Yarn {
    fn interior(&self, wavelength: usize) -> Interior<'_> {
        Interior {
            index: self.medium.host_index()[wavelength],
            mu_s: self.medium.mu_s_per_mm()[wavelength],
            mu_a: self.medium.mu_a_per_mm()[wavelength],
            phase: self.medium.phase(wavelength),
        }
    }

    fn wavelengths(&self) -> usize {
        self.medium.grid().len()
    }
}

/// How much to trace and with what random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    pub seed: u64,
    /// Independent batches, two or more for a standard error.
    pub batches: usize,
    /// Paths of one batch for each direction and wavelength.
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

/// Cells on the yarn's surface and in direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceGrid {
    /// Azimuth cells around the whole yarn; even.
    azimuths: usize,
    exit: HemisphereGrid,
}

impl SurfaceGrid {
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

    pub fn azimuths(&self) -> usize {
        self.azimuths
    }

    pub fn exit(&self) -> &HemisphereGrid {
        &self.exit
    }
}
