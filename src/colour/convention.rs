use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Illuminant, Observer};
use crate::spectrum::UnknownName;

/// An enum whose values are known by one name each, in files, flags and messages alike.
macro_rules! named {
    ($(#[$doc:meta])* $name:ident, $kind:literal, $($(#[$value_doc:meta])* $value:ident = $text:literal),+) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $name {
            $($(#[$value_doc])* $value),+
        }

        impl $name {
            pub const ALL: &[Self] = &[$(Self::$value),+];
            /// Their names.
            pub const NAMES: &[&str] = &[$($text),+];

            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$value => $text),+
                }
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.pad(self.name())
            }
        }

        impl FromStr for $name {
            type Err = UnknownName;

            /// Upper and lower case are the same.
            fn from_str(text: &str) -> Result<Self, UnknownName> {
                Self::ALL
                    .iter()
                    .copied()
                    .find(|value| value.name().eq_ignore_ascii_case(text))
                    .ok_or_else(|| UnknownName::new($kind, text, Self::ALL.iter().map(|value| value.name())))
            }
        }

        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(self.name())
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
            }
        }
    };
}

named!(
    /// Linear RGB space: primaries and white.
    RgbSpace,
    "RGB space",
    /// IEC 61966-2-1, primaries of ITU-R BT.709, white D65.
    Srgb = "srgb",
    /// CIE 1931 RGB, primaries 700, 546.1 and 435.8 nm, equal-energy white.
    CieRgb = "cie-rgb",
    /// FCC 1953, white C.
    Ntsc = "ntsc"
);

named!(
    /// What becomes of the illuminant's white on its way into the RGB space.
    Adaptation,
    "adaptation",
    /// XYZ as they are: under another white than the space's the perfect diffuser is not (1, 1, 1).
    None = "none",
    /// Linear Bradford transform from the illuminant's own sum on the grid to the white of the space.
    Bradford = "bradford"
);

/// All that turns a spectrum into numbers of colour. A ratio such as G/R of a saturated red means nothing without it.
#[derive(Clone, Debug, PartialEq)]
pub struct Convention {
    pub observer: Observer,
    pub illuminant: Illuminant,
    pub rgb: RgbSpace,
    pub adaptation: Adaptation,
}

impl Default for Convention {
    /// 2 degree observer, D65, linear sRGB, no adaptation.
    fn default() -> Self {
        Self {
            observer: Observer::Cie1931,
            illuminant: Illuminant::D65,
            rgb: RgbSpace::Srgb,
            adaptation: Adaptation::None,
        }
    }
}

impl Convention {
    /// Every combination of what is built in, 60 of them, for tables of a ratio under each.
    pub fn all() -> impl Iterator<Item = Self> {
        Observer::ALL.iter().flat_map(|observer| {
            Illuminant::ALL.iter().flat_map(move |illuminant| {
                RgbSpace::ALL.iter().flat_map(move |&rgb| {
                    Adaptation::ALL.iter().map(move |&adaptation| Self {
                        observer: observer.clone(),
                        illuminant: illuminant.clone(),
                        rgb,
                        adaptation,
                    })
                })
            })
        })
    }
}

impl fmt::Display for Convention {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(
            f,
            "{}, {}, {}, adaptation {}",
            self.observer, self.illuminant, self.rgb, self.adaptation
        )
    }
}
