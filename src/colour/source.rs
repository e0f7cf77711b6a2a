//! Observers and illuminants: those of the CIE by name, others from files.

use std::fmt;
use std::path::Path;
use std::sync::Arc;

use super::ColourError;
use crate::spectrum::tables::{self, ObserverTables};
use crate::spectrum::{Spectrum, SpectrumError, UnknownName, bytes_of, parse_observer, parse_spectrum};

/// A table from a file of the user's.
#[derive(Clone, Debug, PartialEq)]
pub struct TableFile<T> {
    /// As it was named.
    pub path: String,
    /// The whole file, for a digest of it.
    pub bytes: Vec<u8>,
    pub table: T,
}

/// An enum of built-in tables, known by one name each, and of a table from a file.
macro_rules! named_or_file {
    ($(#[$doc:meta])* $name:ident, $kind:literal, $table:ty, $parse:expr, $($(#[$value_doc:meta])* $value:ident = $text:literal),+) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq)]
        pub enum $name {
            $($(#[$value_doc])* $value,)+
            File(Arc<TableFile<$table>>),
        }

        impl $name {
            /// Those that are built in.
            pub const ALL: &[Self] = &[$(Self::$value),+];
            /// Their names.
            pub const NAMES: &[&str] = &[$($text),+];

            /// Name of a built-in one, path of a file.
            pub fn name(&self) -> &str {
                match self {
                    $(Self::$value => $text,)+
                    Self::File(file) => &file.path,
                }
            }

            /// A built-in one by its name, upper and lower case being the same, else one from the file of that path.
            ///
            /// # Errors
            /// Neither a name nor a file, or a file that is no such table.
            pub fn load(name_or_path: &str) -> Result<Self, ColourError> {
                let built_in = Self::ALL.iter().find(|known| known.name().eq_ignore_ascii_case(name_or_path));
                if let Some(known) = built_in {
                    return Ok(known.clone());
                }
                let path = Path::new(name_or_path);
                if !path.exists() {
                    return Err(ColourError::NoSuch(UnknownName::new(
                        $kind,
                        name_or_path,
                        Self::ALL.iter().map(|known| known.name()),
                    )));
                }
                let read = || {
                    let bytes = bytes_of(path)?;
                    let table = $parse(name_or_path, &bytes)?;
                    Ok(Self::File(Arc::new(TableFile {
                        path: name_or_path.into(),
                        bytes,
                        table,
                    })))
                };
                read().map_err(|source| ColourError::File { kind: $kind, source })
            }

            /// The file it is from.
            pub fn file(&self) -> Option<&TableFile<$table>> {
                match self {
                    Self::File(file) => Some(file),
                    _ => None,
                }
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.pad(self.name())
            }
        }
    };
}

named_or_file!(
    /// Colour-matching functions: of a CIE standard observer, or from a file with three spectra xbar, ybar and zbar.
    Observer,
    "observer",
    ObserverTables,
    parse_observer,
    /// CIE 1931, 2 degree field.
    Cie1931 = "cie1931-2deg",
    /// CIE 1964, 10 degree field.
    Cie1964 = "cie1964-10deg"
);

named_or_file!(
    /// Relative spectral power of the light: of a CIE illuminant, or from a file with one spectrum, 0 or more.
    Illuminant,
    "illuminant",
    Spectrum,
    |name: &str, bytes: &[u8]| parse_spectrum(name, bytes, 0.0..),
    /// Daylight, 6504 K.
    D65 = "D65",
    /// Daylight, 5003 K.
    D50 = "D50",
    /// Tungsten, 2856 K.
    A = "A",
    /// Historic daylight, white of NTSC 1953.
    C = "C",
    /// Equal energy.
    E = "E"
);

impl Observer {
    pub(super) fn tables(&self) -> Result<&ObserverTables, SpectrumError> {
        match self {
            Self::File(file) => Ok(&file.table),
            built_in => tables::observer(built_in.name()),
        }
    }
}

impl Illuminant {
    pub(super) fn power(&self) -> Result<&Spectrum, SpectrumError> {
        match self {
            Self::File(file) => Ok(&file.table),
            built_in => tables::illuminant(built_in.name()),
        }
    }
}
