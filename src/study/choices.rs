//! Types of a study's values that are no plain numbers or texts.

use serde::{Deserialize, Serialize};

choices! {
/// How particles scatter beside each other.
pub enum InterferenceChoice {
    Independent = "independent",
    PercusYevick = "percus-yevick",
}

/// Which wavelengths share a path.
pub enum EstimatorChoice {
    /// One path for all wavelengths that share a host index.
    Shared = "shared",
    /// A path for each wavelength.
    Independent = "independent",
}

/// Where the yarn response that shades the cloth is from.
pub enum ShadeWith {
    Direct = "direct",
    Bssrdf = "bssrdf",
}

/// How light in the cloth is simulated.
pub enum MethodChoice {
    /// Yarns scatter by their f*.
    RadianceFactor = "radiance-factor",
    /// Light is traced through the medium of every yarn.
    Volumetric = "volumetric",
}

/// The shape of the yarns' centre lines.
pub enum CentreLineChoice {
    Peirce = "peirce",
    Sinusoid = "sinusoid",
}

/// What shines.
pub enum SurfaceChoice {
    /// The cloth as a whole, about its normal.
    Cloth = "cloth",
    /// The smooth surface of each yarn.
    Yarn = "yarn",
    /// The fibres in the surface of each yarn.
    Fibres = "fibres",
}

/// Distribution of the slopes of facets.
pub enum DistributionChoice {
    Beckmann = "beckmann",
    TrowbridgeReitz = "trowbridge-reitz",
}

/// Absorption of the yarns in a fit.
pub enum DyeChoice {
    /// Fitted at each channel or wavelength.
    Free = "free",
    /// As the study has it.
    Fixed = "fixed",
}

/// Whose geometries a report measures.
pub enum GeometryChoice {
    /// The sample's own, unless the section's angles differ from the built-in ones.
    Auto = "auto",
    /// Those of the section's angles.
    Rig = "rig",
}
}

impl SurfaceChoice {
    /// Whether the yarns shine by themselves.
    pub fn is_of_yarns(self) -> bool {
        self != Self::Cloth
    }
}

/// A quantity that may depend on wavelength.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum NumberOrTable {
    /// The same at every wavelength.
    Number(f64),
    /// Path to a CSV file with the columns `wavelength_nm,value`, values in the unit of the key.
    Table(String),
}

impl From<f64> for NumberOrTable {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl NumberOrTable {
    /// The number, if it is one for all wavelengths.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(*value),
            Self::Table(_) => None,
        }
    }

    /// The path, if it is a table.
    pub fn table(&self) -> Option<&str> {
        match self {
            Self::Number(_) => None,
            Self::Table(path) => Some(path),
        }
    }
}

/// Yarns that light may go on to after the first it met.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum BounceLimit {
    Most(u32),
    Word(BouncesWord),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BouncesWord {
    All,
}

impl BounceLimit {
    /// However many.
    pub const ALL: Self = Self::Word(BouncesWord::All);

    /// The number, with no end for all.
    pub fn most(self) -> usize {
        match self {
            Self::Most(most) => most as usize,
            Self::Word(BouncesWord::All) => usize::MAX,
        }
    }
}
