//! Spectral validation of physically based cloth models.
//!
//! Data flows one way: spectra → medium → yarn → yarn response f* → cloth → rig → colour → comparison → report.
//! `output` (places files are written to) lies below `artefact` and all of them.
//! A module uses the ones listed before it and never one listed after it.

pub mod artefact;
pub mod check;
pub mod cloth;
pub mod colour;
pub mod compare;
pub mod fault;
pub mod formats;
pub mod geometry;
pub mod number;
pub mod optics;
pub mod output;
pub mod report;
pub mod rig;
pub mod run;
pub mod sample;
pub mod shading;
pub mod spectrum;
pub mod study;
mod text;
pub mod transport;
pub mod validate;
pub mod weave;
pub mod woven;
pub mod yarn;
