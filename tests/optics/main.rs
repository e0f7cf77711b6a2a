//! The optics against outside references and laws.

mod mie;
mod reference;
mod structure_factor;
