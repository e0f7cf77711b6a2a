//! What the reader of a sample assumed, left out or found implausible.

use crate::goniometric::ReadNotice;
use crate::number::{shown, significant};
use crate::spectrum::{Doubt, TextNotice};
use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};

/// A notice of a sample's reader. [`Display`] gives its words.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "id", rename_all = "kebab-case")]
pub enum SampleNotice {
    /// Of the file, in words: read back from results that were written before these notices were typed.
    File { words: String },
    /// Of the text or the table of the file, such as its encoding or its decimal sign.
    Text { notice: TextNotice },
    /// Of the reader of a goniometric file.
    Format { notice: ReadNotice },
    /// Values or angles that look like those of another unit, or readings that repeat.
    Doubt { doubt: Doubt },
    /// Columns that were read by another name. `unsigned`: no view is below 0.
    RenamedColumns { columns: Vec<String>, unsigned: bool },
    /// Angles that were read anew at each wavelength, and their largest difference.
    AnglesOfWavelengths { largest_deg: f64 },
    /// Values below 0 within noise.
    NegativeValues { count: usize, lowest: f64 },
    /// Values at wavelengths without colour-matching functions.
    OutsideColour { count: usize },
    /// Components of the file beside the one that is the sample.
    OtherComponents {
        path: String,
        component: String,
        others: Vec<String>,
    },
    /// Geometries, of so many, whose values the instrument did not read.
    NotSeen { count: usize, of: usize },
    /// Values that are means over so many patches of the incident hemisphere and of the other.
    PatchMeans { patches: [usize; 2] },
    /// One channel that stands for r, g and b too.
    LuminanceAlone,
}

impl SampleNotice {
    /// Those of the reader of the file.
    pub(super) fn of_file<N: Clone + Into<Self>>(notices: &[N]) -> impl Iterator<Item = Self> {
        notices.iter().cloned().map(Into::into)
    }
}

impl From<TextNotice> for SampleNotice {
    fn from(notice: TextNotice) -> Self {
        Self::Text { notice }
    }
}

impl From<ReadNotice> for SampleNotice {
    fn from(notice: ReadNotice) -> Self {
        Self::Format { notice }
    }
}

impl From<Doubt> for SampleNotice {
    fn from(doubt: Doubt) -> Self {
        Self::Doubt { doubt }
    }
}

impl Display for SampleNotice {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Self::File { words } => f.write_str(words),
            Self::Text { notice } => notice.fmt(f),
            Self::Format { notice } => notice.fmt(f),
            Self::Doubt { doubt } => doubt.fmt(f),
            Self::RenamedColumns { columns, unsigned } => {
                let sign = match unsigned {
                    true => "no view is below 0, so all are on the mirror side of the normal",
                    false => "views below 0 are on the light's side of the normal",
                };
                write!(
                    f,
                    "columns of the sample were read as these: {}; {sign}",
                    columns.join(", ")
                )
            }
            Self::AnglesOfWavelengths { largest_deg } => write!(
                f,
                "angles of the sample differ between the wavelengths of a geometry, by up to {} degrees: their means \
                 are taken",
                significant(*largest_deg, 2)
            ),
            Self::NegativeValues { count, lowest } => write!(
                f,
                "{count} values of the sample are below 0, the lowest {}: taken as they are, as noise about 0",
                shown(*lowest)
            ),
            Self::OutsideColour { count } => write!(
                f,
                "{count} values of the sample are outside 360..780 nm, where the CIE tables are: left out"
            ),
            Self::OtherComponents {
                path,
                component,
                others,
            } => write!(
                f,
                "{path}: the sample is the {component}; the file also has, and --scatter and --side choose: {}",
                others.join(", ")
            ),
            Self::NotSeen { count, of } => write!(
                f,
                "{count} of {of} geometries of the sample, at its own incidences with views every 5 degrees, need values that \
                 the instrument did not read but the file's maker filled in: left out"
            ),
            Self::PatchMeans { patches: [light, view] } => write!(
                f,
                "values of the sample are means over {light} patches of directions of light by {view} of views: a geometry has \
                 the mean of its patches, which smooths peaks narrower than they are"
            ),
            Self::LuminanceAlone => f.write_str(
                "the sample has luminance alone: its channels r, g and b repeat it, as those of a grey cloth would, and only y \
                 compares like with like",
            ),
        }
    }
}
