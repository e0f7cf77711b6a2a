//! What a written file does not hold as its source did.

use crate::goniometric::Format;
use crate::number::{count, shown};
use std::fmt::{self, Display, Formatter};

/// A hemispherical value before and after writing, at an incidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HemisphericalChange {
    pub theta_i_deg: f64,
    pub source: f64,
    pub table: f64,
    /// Of both integrals together, estimated.
    pub error: f64,
}

impl HemisphericalChange {
    /// Relative to the table's value.
    pub(super) fn size(&self) -> f64 {
        (self.source / self.table - 1.0).abs()
    }
}

/// A notice on a written file. [`Display`] gives its words.
#[derive(Clone, Debug, PartialEq)]
pub enum WriteNotice {
    /// The same notice several times.
    Several {
        notice: Box<WriteNotice>,
        times: usize,
    },
    /// Components of the source that the file does not have.
    ComponentsLeftOut {
        components: Vec<String>,
    },
    /// Light from the back in a format without sides.
    SideNotStated {
        format: Format,
    },
    ErrorsLeftOut {
        format: Format,
    },
    /// More bytes than are read in the format.
    TooLargeToRead {
        format: Format,
        bytes: usize,
        most: u64,
    },
    /// Transmission in ASTM files.
    TransmissionNotStated {
        format: Format,
    },
    Resampled,
    /// Values beyond what the source measured, of all that were asked for.
    Filled {
        filled: usize,
        asked: usize,
    },
    /// Hemispherical values that scaling kept; the largest change of the table.
    BalanceKept(HemisphericalChange),
    /// Hemispherical values that change; the largest change.
    BalanceChanged(HemisphericalChange),
    /// Directions of incidence whose hemisphere the source does not cover.
    NotCovered {
        directions: usize,
    },
    /// One channel as three.
    Grey,
    XyzAsRgb,
    /// Spectra as linear sRGB.
    SpectraAsRgb,
    /// RGB without stated primaries as linear sRGB.
    RgbAsSrgb,
    SpectraAsXyz,
    /// Why the colours of the source's wavelengths are doubtful, in the words of the colour system.
    DoubtfulColours {
        words: String,
    },
    /// Negative components of colours outside the RGB space, and how many where they are counted.
    Clipped {
        components: Option<usize>,
    },
    /// Means over azimuths of incidence.
    Isotropic {
        format: Format,
        azimuths: usize,
    },
    /// Means over exchanged light and viewer: share of the mean that f changes by at most, polar angles there in
    /// degrees, and the two values, 1/sr.
    Reciprocal {
        format: Format,
        share: f64,
        theta_deg: [f64; 2],
        values: [f64; 2],
    },
    /// Fractions of an incidence, of several azimuths.
    FirstAzimuth,
    PatchMeans,
    /// Specular fractions without scattering of their kind.
    SpecularLeftOut,
    /// Specular fractions, where incident and exiting patches differ.
    SpecularWithoutDiagonal,
    SpecularOnDiagonal,
    /// Specular fractions at incidences that the source does not have.
    SpecularBeyond,
    RoundedTo32Bits,
}

impl Display for WriteNotice {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Self::Several { notice, times } => write!(f, "{notice} ({times} times)"),
            Self::ComponentsLeftOut { components } => {
                write!(f, "not in the file, but in the source: {}", components.join("; "))
            }
            Self::SideNotStated { format } => write!(
                f,
                "{format} does not state the side: the light comes from the back, and azimuths run as on the front"
            ),
            Self::ErrorsLeftOut { format } => {
                write!(f, "{format} holds no standard errors: those of the source are left out")
            }
            Self::TooLargeToRead { format, bytes, most } => write!(
                f,
                "the file has {bytes} bytes, and those that specval reads in the format {format} have at most {most}"
            ),
            Self::TransmissionNotStated { format } => {
                write!(f, "{format} does not state that the values are of transmission")
            }
            Self::Resampled => f.write_str("values are interpolated in the source's own parameters"),
            Self::Filled { filled, asked } => write!(
                f,
                "{filled} of {asked} values lie beyond what the source measured and hold the nearest value towards the \
                 normal or of the nearest incidence"
            ),
            Self::BalanceKept(change) => write!(
                f,
                "hemispherical values are kept: values are scaled at each incidence and channel, by {:+.2} % at most, \
                 at incidence {} degrees, where the table alone has {:.5} for {:.5}, {}",
                100.0 * (change.source / change.table - 1.0),
                shown(change.theta_i_deg),
                change.table,
                change.source,
                integrated(change)
            ),
            Self::BalanceChanged(change) => write!(
                f,
                "hemispherical values change by up to {:+.2} %: {:.5} becomes {:.5} at incidence {} degrees, {}",
                100.0 * (change.table / change.source - 1.0),
                change.source,
                change.table,
                shown(change.theta_i_deg),
                integrated(change)
            ),
            Self::NotCovered { directions } => write!(
                f,
                "at {} of incidence the source does not cover the hemisphere: its hemispherical value is not kept \
                 there",
                count(*directions, "direction")
            ),
            Self::Grey => f.write_str("the one channel is written as red, green and blue alike"),
            Self::XyzAsRgb => f.write_str("XYZ is written as linear sRGB"),
            Self::SpectraAsRgb => f.write_str("spectra are written as linear sRGB under D65, CIE 1931 2° observer"),
            Self::RgbAsSrgb => f.write_str("RGB of no stated primaries is taken as linear sRGB"),
            Self::SpectraAsXyz => f.write_str("spectra are written as XYZ under D65, CIE 1931 2° observer"),
            Self::DoubtfulColours { words } => f.write_str(words),
            Self::Clipped { components } => {
                if let Some(number) = components {
                    write!(f, "{number} ")?;
                }
                f.write_str("components of colours outside the RGB space are written as 0")
            }
            Self::Isotropic { format, azimuths } => write!(
                f,
                "{format} holds isotropic data: values are the mean over {azimuths} turns about the normal"
            ),
            Self::Reciprocal {
                format,
                share,
                theta_deg: [theta_i, theta_o],
                values: [there, back],
            } => write!(
                f,
                "{format} holds reciprocal data: values are means with light and viewer exchanged; that changes f by \
                 up to {:.1} %, at incidence {theta_i:.1} degrees towards {theta_o:.1} degrees, where it is {there:.4} \
                 one way and {back:.4} the other, 1/sr",
                100.0 * share
            ),
            Self::FirstAzimuth => f.write_str("fractions are those of the first incident azimuth"),
            Self::PatchMeans => f.write_str("values are means over the patches of Klems' full basis"),
            Self::SpecularLeftOut => f.write_str("specular fractions without scattering of their kind are left out"),
            Self::SpecularWithoutDiagonal => {
                f.write_str("specular fractions are left out: incident and exiting patches differ")
            }
            Self::SpecularOnDiagonal => {
                f.write_str("specular fractions are on the diagonal, over the projected solid angle of the patch")
            }
            Self::SpecularBeyond => {
                f.write_str("specular fractions beyond the first and last incidence are those there")
            }
            Self::RoundedTo32Bits => f.write_str("values are rounded to 32-bit floating point"),
        }
    }
}

/// The error of the integrals in words, two digits of it.
fn integrated(change: &HemisphericalChange) -> String {
    let rounded = format!("{:.1e}", change.error).parse().unwrap_or(change.error);
    format!("integrated to within {}", shown(rounded))
}
