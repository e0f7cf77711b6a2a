//! Light and matter at the scale of the wavelength: interfaces, single spheres, phase functions and the medium they
//! make.

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

/// Invalid input to the optics.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum OpticsError {
    #[error("{quantity}: expected {expected}, found {found}; {remedy}")]
    Domain {
        of: Property,
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
         {difference:.1e}, expected 1e-6; take smaller particles (in a study `particle_diameter_nm`), or longer \
         wavelengths"
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

/// Properties that define a medium.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Property {
    HostIndex,
    HostAbsorption,
    ParticleIndex,
    ParticleAbsorption,
    ParticleDiameter,
    VolumeFraction,
}

impl Property {
    /// The key that sets it in a section of a study.
    pub fn key(self) -> &'static str {
        match self {
            Self::HostIndex => "host_index",
            Self::HostAbsorption => "host_mu_a_per_mm",
            Self::ParticleIndex => "particle_index",
            Self::ParticleAbsorption => "kappa_peak",
            Self::ParticleDiameter => "particle_diameter_nm",
            Self::VolumeFraction => "volume_fraction",
        }
    }
}

impl OpticsError {
    /// The key of a study's medium that sets what is wrong. A phase function is that of particles too large or too
    /// small for it.
    pub fn key(&self) -> &'static str {
        match self {
            Self::Domain { of, .. } => of.key(),
            Self::At { source, .. } => source.key(),
            _ => Property::ParticleDiameter.key(),
        }
    }

    fn domain(
        of: Property,
        quantity: impl Into<String>,
        expected: impl Into<String>,
        found: f64,
        remedy: impl Into<String>,
    ) -> Self {
        Self::Domain {
            of,
            quantity: quantity.into(),
            expected: expected.into(),
            found,
            remedy: remedy.into(),
        }
    }
}
