//! Monte Carlo transport of light through one homogeneous body of scattering medium with a smooth dielectric surface.

mod angles;
mod entrance;
mod flights;
mod groups;
mod interior;
mod lane_math;
mod ledger;
mod path;
mod plain;
mod roulette;
mod shape;
mod spectral;
mod statistics;
mod stream;
mod walk;
mod weights;

pub use interior::{Coefficients, Interior};
pub(crate) use ledger::fractions;
pub use ledger::{Column, Fraction, FractionList, Ledger, LedgerOf};
pub use path::{Collision, ENTRY_COORDINATES, Entry, Exit};
pub use roulette::Roulette;
pub use shape::{Cylinder, Shape, Slab};
pub use statistics::{BatchSums, Estimate};
pub use stream::{Purpose, Stream};
pub use walk::{Traced, Walk};

/// Invalid input to the transport.
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
