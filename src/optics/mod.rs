//! Light and matter at the scale of the wavelength: interfaces, single spheres, phase functions and the medium they make.

pub mod mie;
mod structure_factor;

pub use mie::{Efficiencies, Mie};
pub use structure_factor::percus_yevick;

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
