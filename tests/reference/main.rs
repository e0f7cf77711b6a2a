//! Independent numbers: closed forms, other programs, published tables.

#[path = "../support/golden.rs"]
mod golden;

mod colour;
mod compare_study;
mod formats_hemispherical;
mod least_squares;
mod optics;
mod transport_references;
mod validate_closed_forms;
