//! Optics of one interface, one particle and one medium.

pub mod fresnel;
pub mod phase;
