//! What some formats leave open, stated by the user.

use crate::goniometric::{Scatter, Side};

/// What some formats leave open, stated by the user.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Of Integra and ASTM files, which differ by name alone.
    pub scatter: Option<Scatter>,
    /// Of ASTM files; radians if not stated.
    pub angle_unit: Option<AngleUnit>,
    /// Factor from a UTIA file's numbers to f in 1/sr.
    pub scale: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AngleUnit {
    Radians,
    Degrees,
}

/// What some formats leave to the writer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// What is written; without it all that the format holds, of formats that hold one component the reflection if
    /// there is one.
    pub scatter: Option<Scatter>,
    /// Where the light comes from; without it the front, of formats that state the side both.
    pub side: Option<Side>,
    /// Of the values of SSDD files.
    pub encoding: Encoding,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    /// All digits.
    #[default]
    Text,
    /// 32-bit floating point, little-endian.
    Binary,
}
