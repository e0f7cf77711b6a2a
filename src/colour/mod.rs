//! From a spectral brightness factor to XYZ, linear RGB and Lab: one conversion for model, classical shading and
//! measurement.

mod convention;
mod difference;
mod interpolation;
mod rgb_space;
mod source;
mod stated;
mod system;

pub use convention::{Adaptation, Convention, RgbSpace};
pub use difference::{delta_e_2000, delta_e_cmc};
pub use source::{Illuminant, Observer, TableFile};
pub use stated::Stated;
pub use system::ColourSystem;

use serde::Serialize;

use crate::spectrum::{SpectrumError, UnknownName};

/// CIE tristimulus values, dimensionless; the perfect diffuser has Y = 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Xyz {
    #[serde(rename = "X")]
    pub x: f64,
    #[serde(rename = "Y")]
    pub y: f64,
    #[serde(rename = "Z")]
    pub z: f64,
}

/// Red, green, blue of a linear (not gamma-encoded) RGB space, dimensionless, never clipped: saturated colours have
/// negative components.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LinearRgb(pub [f64; 3]);

/// CIE 1976 L*, a*, b* against the white of the [`ColourSystem`]; the perfect diffuser is (100, 0, 0).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Lab(pub [f64; 3]);

/// One spectrum seen under one convention.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Colour {
    #[serde(flatten)]
    pub xyz: Xyz,
    pub linear_rgb: LinearRgb,
    pub lab: Lab,
    pub in_gamut: bool,
}

impl LinearRgb {
    /// Whether the RGB space holds this chromaticity: no component is negative. Components above 1 (gloss brighter
    /// than the perfect diffuser) are a matter of exposure, not of gamut.
    pub fn in_gamut(self) -> bool {
        self.0.iter().all(|&component| component >= 0.0)
    }
}

/// Why there is no colour conversion.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ColourError {
    /// A table of the user's own does not cover the grid.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    #[error("{0}; nor is there a file of that name: take one of these names, or the path of a table")]
    NoSuch(UnknownName),
    /// A file named as an observer or an illuminant.
    #[error("{kind}: {source}")]
    File { kind: &'static str, source: SpectrumError },
    #[error(
        "on {low}..{high} nm under {convention} the perfect diffuser has X, Y, Z = {x}, {y}, {z}; all must be positive \
         to speak of colour: check the illuminant's and the observer's tables"
    )]
    Blind {
        low: f64,
        high: f64,
        convention: String,
        x: f64,
        y: f64,
        z: f64,
    },
    #[error(
        "these data have no colour: {why}; 390..730 nm in steps of 10 nm, or 400..700 nm in steps of 20 nm at most, \
         have one"
    )]
    NoColour { why: String },
}
