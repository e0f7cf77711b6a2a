//! The optics against outside references and laws.

mod medium;
mod mie;
mod reference;
mod structure_factor;
