//! Monte Carlo transport of light through one homogeneous body of scattering medium with a smooth dielectric surface.

mod ledger;
mod shape;
mod stream;
mod walk;

pub use ledger::{Ledger, LedgerEntry};
pub use shape::{Boundary, Cylinder, Shape, Slab};
pub use stream::{Purpose, Stream};
pub use walk::{Exit, Interior, Roulette, Walk};

/// What is wrong with an input of the transport.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TransportError {
    #[error("{quantity}: expected {expected}, found {found}; {remedy}")]
    Domain {
        quantity: &'static str,
        expected: &'static str,
        found: f64,
        remedy: &'static str,
    },
}
