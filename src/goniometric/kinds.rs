//! Metadata of goniometric values: source, quantity, channels and interpolation.

use std::fmt;

use serde::Serialize;

use crate::spectrum::WavelengthGrid;

/// A file format by its name on the command line. `formats::registry` lists those there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Format(&'static str);

impl Format {
    pub(crate) const fn new(name: &'static str) -> Self {
        Self(name)
    }

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        self.0
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A file's statement of the source of its values.
#[derive(Clone, Debug, PartialEq, Default, Serialize)]
pub struct FileProvenance {
    /// `Measured`, `Generated`, `Edited`, …, as the file has it.
    pub source: Option<String>,
    /// Other statements, by the file's own key words.
    pub statements: Vec<(String, String)>,
    pub comments: Vec<String>,
}

/// Reflection or transmission.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Scatter {
    Reflection,
    Transmission,
}

/// Side of the surface the light comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// The half space of +z.
    Front,
    Back,
}

/// Quantity of a table. f is the BRDF or, in transmission, the BTDF: radiance per irradiance on the surface, 1/sr.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// f, 1/sr.
    Bsdf,
    /// f cos θ_out, 1/sr.
    BsdfCosine,
    /// Brightness factor β = π f, 1 for the perfect diffuser.
    BrightnessFactor,
    /// Specularly reflected or regularly transmitted fraction of the flux; has no density over solid angle.
    Fraction,
    /// Unknown scale: the file does not state it.
    Unscaled,
}

impl Quantity {
    /// f in 1/sr of a value; `None` where the quantity has no f.
    pub fn to_bsdf(self, value: f64, cos_out: f64) -> Option<f64> {
        match self {
            Self::Bsdf => Some(value),
            Self::BsdfCosine => Some(value / cos_out),
            Self::BrightnessFactor => Some(value / std::f64::consts::PI),
            Self::Fraction | Self::Unscaled => None,
        }
    }

    /// The value that represents f in 1/sr; `None` if the quantity has no f.
    pub fn of_bsdf(self, bsdf: f64, cos_out: f64) -> Option<f64> {
        match self {
            Self::Bsdf => Some(bsdf),
            Self::BsdfCosine => Some(bsdf * cos_out),
            Self::BrightnessFactor => Some(bsdf * std::f64::consts::PI),
            Self::Fraction | Self::Unscaled => None,
        }
    }
}

/// Meaning of the values of one geometry.
#[derive(Clone, Debug, PartialEq)]
pub enum ChannelSet {
    /// One value of no stated colour; in Radiance files photometric.
    Monochrome,
    /// Linear, of primaries that hardly any format states.
    Rgb,
    Xyz,
    Wavelengths(WavelengthGrid),
}

impl ChannelSet {
    /// Number of values of a geometry.
    pub fn count(&self) -> usize {
        match self {
            Self::Monochrome => 1,
            Self::Rgb | Self::Xyz => 3,
            Self::Wavelengths(grid) => grid.len(),
        }
    }

    /// A name for each, wavelengths with their unit.
    pub fn names(&self) -> Vec<String> {
        let named = |names: &[&str]| names.iter().map(|&n| n.to_owned()).collect();
        match self {
            Self::Monochrome => named(&["value"]),
            Self::Rgb => named(&["R", "G", "B"]),
            Self::Xyz => named(&["X", "Y", "Z"]),
            Self::Wavelengths(grid) => grid.nm().iter().map(|nm| format!("{nm}nm")).collect(),
        }
    }
}

/// How an evaluated value was obtained.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Placement {
    /// A node of the file.
    OnNode,
    /// Linear between nodes, in the file's own parameters.
    Interpolated,
    /// The mean over a patch or cell, as stored in the file.
    InCell,
    /// Made, wholly or in part, of nodes that the instrument did not see and the maker of the file filled in.
    FilledIn,
}
