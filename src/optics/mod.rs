//! Light and matter at the scale of the wavelength: interfaces, single spheres, phase functions and the medium they make.

pub mod fresnel;
mod medium;
pub mod mie;
mod phase;
mod quadrature;
mod structure_factor;

pub use medium::{Interference, Medium, MediumSpec};
pub use mie::{Efficiencies, Mie};
pub use phase::{HenyeyGreenstein, Phase, PhaseError, PhaseTable};
pub(crate) use quadrature::gauss_legendre;
pub use structure_factor::percus_yevick;

use crate::spectrum::SpectrumError;

/// What is wrong with an input of the optics.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum OpticsError {
    #[error("{quantity}: expected {expected}, found {found}; {remedy}")]
    Domain {
        quantity: String,
        expected: String,
        found: f64,
        remedy: String,
    },
    #[error("at {wavelength_nm} nm: {source}")]
    At {
        wavelength_nm: f64,
        source: Box<OpticsError>,
    },
    #[error("{quantity}: expected {expected} values, one a wavelength, found {found}")]
    Length {
        quantity: &'static str,
        expected: usize,
        found: usize,
    },
    #[error(
        "phase function of particles of {diameter_nm} nm at {wavelength_nm} nm: with {nodes} nodes g is still off by \
         {difference:.1e}, expected 1e-6; take smaller particles (in a study `particle_diameter_nm`), or longer wavelengths"
    )]
    PhaseUnresolved {
        wavelength_nm: f64,
        nodes: usize,
        difference: f64,
        diameter_nm: f64,
    },
    #[error(transparent)]
    Phase(#[from] PhaseError),
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
}

impl OpticsError {
    fn domain(quantity: impl Into<String>, expected: impl Into<String>, found: f64, remedy: impl Into<String>) -> Self {
        Self::Domain {
            quantity: quantity.into(),
            expected: expected.into(),
            found,
            remedy: remedy.into(),
        }
    }
}
