//! What the reader of goniometric data assumed, left out or found implausible.

use crate::number::count;
use crate::spectrum::{Doubt, TextNotice};
use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};

/// A notice of the reader of a goniometric file. [`Display`] gives its words.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "id", rename_all = "kebab-case")]
pub enum ReadNotice {
    /// Of the encoding or of the grammar of the table.
    Text {
        notice: TextNotice,
    },
    /// Values or angles that look like those of another unit, or readings that repeat.
    Doubt {
        doubt: Doubt,
    },
    /// The same notice several times.
    Several {
        notice: Box<ReadNotice>,
        times: usize,
    },
    /// Largest relative difference between the nodes of a pole.
    Pole {
        difference: f64,
    },
    /// Largest relative difference between azimuths a whole turn apart.
    Seam {
        difference: f64,
    },
    /// What columns of other names were taken for.
    RenamedColumns {
        columns: Vec<String>,
    },
    /// Neither the content nor the name of the file says which.
    ReflectionAssumed {
        file: String,
    },
    RadiansAssumed,
    /// Readings on one side of the plane of incidence alone.
    MirroredPlane,
    /// Nodes at the horizon or below, of all, where f cosθ_o has no f.
    NodesAtHorizon {
        held: usize,
        nodes: usize,
    },
    /// Relative values.
    NoScale,
    /// No `TypeSym` in the header.
    NoSymmetry,
    /// Of a format that states neither RGB primaries nor provenance.
    NoProvenance {
        format: String,
    },
    /// Negative values for no data, at so many of the nodes.
    Holes {
        holes: usize,
        nodes: usize,
    },
    /// Lines before the beginning of an XML document.
    BeforeXml {
        lines: usize,
    },
    /// One of two chromaticity blocks.
    IncompleteColour,
    /// Blocks of infrared or solar quantities; the first few names of these, quoted.
    OtherWavelengths {
        blocks: usize,
        names: Vec<String>,
    },
    /// A version of the format, quoted, that is read as another one.
    ReadAsVersion {
        found: String,
        read_as: String,
    },
    /// Values below 0 that the format is known to have.
    NegativeValues {
        count: usize,
    },
    /// The scale is the user's to give.
    ScaleNotStated,
    /// The file claims a mirror symmetry that its azimuths do not have.
    AzimuthsNotFilled,
    /// Azimuths of light from the back.
    BackAsFront,
    RgbPrimariesNotStated,
    /// Values of an array below 0 sum to more than those above.
    MostlyNegative {
        array: String,
    },
    /// Values of an array below 0; `rgb`: colours, not spectra.
    BelowZero {
        array: String,
        count: usize,
        lowest: f32,
        rgb: bool,
    },
    /// The symmetry that completes the circle of azimuths, in words.
    PartOfAzimuths {
        symmetry: String,
    },
    BytesBehindArrays {
        bytes: usize,
    },
    /// A mask of so many bytes, which is not a bit for each node.
    MaskNotUsed {
        nodes: usize,
        bytes: usize,
    },
    /// Nodes that the mask excludes, of all.
    UnseenNodes {
        unseen: usize,
        nodes: usize,
    },
    /// Values at 90 degrees of incidence, which the mask takes as measured.
    ContinuedToHorizon,
}

impl From<TextNotice> for ReadNotice {
    fn from(notice: TextNotice) -> Self {
        Self::Text { notice }
    }
}

impl From<Doubt> for ReadNotice {
    fn from(doubt: Doubt) -> Self {
        Self::Doubt { doubt }
    }
}

impl Display for ReadNotice {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Self::Text { notice } => notice.fmt(f),
            Self::Doubt { doubt } => doubt.fmt(f),
            Self::Several { notice, times } => write!(f, "{notice} ({times} times)"),
            Self::Pole { difference } => write!(
                f,
                "values at a pole, which is one direction, differ between azimuths by up to {:.2} %: their mean is \
                 taken",
                100.0 * difference
            ),
            Self::Seam { difference } => write!(
                f,
                "values at azimuths 360 degrees apart, which are one direction, differ by up to {:.1} %: both are \
                 kept, with a jump between them",
                100.0 * difference
            ),
            Self::RenamedColumns { columns } => write!(f, "columns were read as these: {}", columns.join(", ")),
            Self::ReflectionAssumed { file } => write!(
                f,
                "the content does not say whether it is reflection or transmission, nor does the name {file}: taken as \
                 reflection"
            ),
            Self::RadiansAssumed => f.write_str("the file does not state the unit of its angles: taken as radians"),
            Self::MirroredPlane => f.write_str(
                "one side of the plane of incidence alone was measured: the other is taken as its mirror image",
            ),
            Self::NodesAtHorizon { held, nodes } => write!(
                f,
                "{held} of {nodes} nodes are at the horizon or below, where f cos theta_o is 0: f there is that of the \
                 nearest node above"
            ),
            Self::NoScale => f.write_str("the values are relative and nothing states their scale"),
            Self::NoSymmetry => f.write_str("no TypeSym: taken as PlaneSymmetrical, as other readers do"),
            Self::NoProvenance { format } => {
                write!(f, "{format} files state neither their RGB primaries nor any provenance")
            }
            Self::Holes { holes, nodes } => write!(
                f,
                "values are negative, which stands for no data, at {holes} of {nodes} nodes well above the horizon"
            ),
            Self::BeforeXml { lines } => {
                write!(f, "text before the XML is passed over ({})", count(*lines, "line"))
            }
            Self::IncompleteColour => {
                f.write_str("colour is incomplete and left out: one of the two chromaticity blocks is missing")
            }
            Self::OtherWavelengths { blocks, names } => write!(
                f,
                "{blocks} blocks of other wavelengths than the visible are left out: {}",
                names.join(", ")
            ),
            Self::ReadAsVersion { found, read_as } => write!(f, "version {found}: read as version {read_as}"),
            Self::NegativeValues { count } => {
                write!(
                    f,
                    "{count} values are negative, as files of this format have them; they are kept"
                )
            }
            Self::ScaleNotStated => f.write_str(
                "the scale of the values is not stated; give the factor to 1/sr (--scale) to use them as a BRDF",
            ),
            Self::AzimuthsNotFilled => {
                f.write_str("the file calls itself PlaneSymmetrical; azimuths it does not list are not filled in")
            }
            Self::BackAsFront => f.write_str("azimuths on the back are taken to run as on the front"),
            Self::RgbPrimariesNotStated => f.write_str("the RGB primaries are not stated"),
            Self::MostlyNegative { array } => write!(
                f,
                "the values of `{array}` below 0 outweigh those above it: check the sign of the data, or copy the file \
                 again in binary mode"
            ),
            Self::BelowZero {
                array,
                count,
                lowest,
                rgb,
            } => {
                let cause = match rgb {
                    true => "as colours outside the RGB space have them",
                    false => "as dark subtraction leaves them",
                };
                write!(
                    f,
                    "{count} values of `{array}` are below 0, down to {lowest}, {cause}; what is below 0 after \
                     interpolation counts as 0"
                )
            }
            Self::PartOfAzimuths { symmetry } => write!(
                f,
                "azimuths of a part of the circle are stored: the rest is taken as {symmetry}, as Mitsuba does"
            ),
            Self::BytesBehindArrays { bytes } => write!(f, "{bytes} bytes behind the last array are not used"),
            Self::MaskNotUsed { nodes, bytes } => write!(
                f,
                "the mask `valid` is not used: expected {} bytes, a bit for each of {nodes} nodes, found {bytes}",
                nodes.div_ceil(8)
            ),
            Self::UnseenNodes { unseen, nodes } => write!(
                f,
                "the mask `valid` says that the instrument did not see {unseen} of {nodes} nodes, which hold values \
                 that were filled in: they are part of the table, but no readings of a sample"
            ),
            Self::ContinuedToHorizon => f.write_str(
                "values at 90 degrees of incidence, from where no light falls on a sample, are a continuation: part \
                 of the table, but no readings of a sample",
            ),
        }
    }
}
