//! Spectral validation of physically based cloth models.
//!
//! Data flows one way: spectra → medium → yarn → yarn response f* → cloth → rig → colour → comparison → report.
//! The rooms from the ground up; each uses rooms above it in this list and none below it (`tests/laws/structure.rs`).
//!
//! - `fault`: deliberate faults of the physics, for tests alone
//! - `number`: numbers as people write them
//! - `geometry`: vectors, frames, cells on the sphere, interpolation
//! - `input`: files in, up to a size
//! - `text`: bounded reading and the grammars of tables
//! - `output`: places that files are written to, whole or not at all
//! - `artefact`: files of large arrays with their identity
//! - `spectrum`: wavelength grids, spectra, built-in tables
//! - `colour`: observers, illuminants, RGB spaces, the one conversion
//! - `optics`: Fresnel, Mie, phase functions, medium
//! - `shading`: shading about a normal: Cook–Torrance, classical models by id, fibres
//! - `transport`: the Monte Carlo kernel, its ledger and its statistics
//! - `validate`: reference problems of optics and transport
//! - `yarn`: light in one yarn: BSSRDF and yarn response f*
//! - `cloth`: weaves, the shape of a cloth, and light between its yarns
//! - `goniometric`: measured scattering in memory: tables, evaluation, hemispherical values
//! - `formats`: files of goniometric measurements and drafts
//! - `weave`: drafts by name or from files
//! - `rig`: directions, camera rays and brightness factors
//! - `sample`: a measurement to compare with
//! - `compare`: sources, errors, ratios, verdicts, Table 1
//! - `fit`: least squares, fitted models and what they predict
//! - `study`: the keys of a study
//! - `report`: the result: written, read back, drawn
//! - `run`: a whole study from its values to its result
//! - `check`: laws of physics as gates

pub mod artefact;
pub mod check;
pub mod cloth;
pub mod colour;
pub mod compare;
pub mod fault;
pub mod fit;
pub mod formats;
pub mod geometry;
pub mod goniometric;
pub mod input;
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
pub mod yarn;
