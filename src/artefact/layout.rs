use super::{CHECKSUM, Identity};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::fmt;
use std::io::{self, Write};

/// Bytes of the longest line of JSON that is written or read. A file whose line has lost its end is thus refused
/// without reading all of it into memory.
pub(super) const HEADER_LIMIT: u64 = 1 << 26;

/// Type of an array's elements in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ElementType {
    F64,
    F32,
    U64,
}

impl ElementType {
    /// Bytes of one.
    pub fn bytes(self) -> usize {
        match self {
            ElementType::F64 | ElementType::U64 => 8,
            ElementType::F32 => 4,
        }
    }
}

impl fmt::Display for ElementType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            ElementType::F64 => "f64",
            ElementType::F32 => "f32",
            ElementType::U64 => "u64",
        })
    }
}

/// Element of an array: f64, f32 or u64, each stored bit for bit.
pub trait Element: Copy + Default + sealed::Sealed {
    const TYPE: ElementType;

    #[doc(hidden)]
    fn write_le(self, output: &mut impl Write) -> io::Result<()>;

    /// Fills `values` from as many elements of bytes.
    #[doc(hidden)]
    fn read_le(bytes: &[u8], values: &mut [Self]);
}

mod sealed {
    pub trait Sealed {}
}

macro_rules! element {
    ($($number:ty => $variant:ident),*) => {$(
        impl sealed::Sealed for $number {}

        impl Element for $number {
            const TYPE: ElementType = ElementType::$variant;

            fn write_le(self, output: &mut impl Write) -> io::Result<()> {
                output.write_all(&self.to_le_bytes())
            }

            fn read_le(bytes: &[u8], values: &mut [Self]) {
                for (value, bytes) in values.iter_mut().zip(bytes.as_chunks().0) {
                    *value = <$number>::from_le_bytes(*bytes);
                }
            }
        }
    )*};
}

element!(f64 => F64, f32 => F32, u64 => U64);

/// One array: what it holds and how it is laid out.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ArrayInfo {
    /// Its name in the file, which no other has.
    pub name: String,
    pub unit: String,
    /// What each axis counts, in words, first axis first.
    pub axes: String,
    /// Elements along each axis. The last one runs fastest.
    pub shape: Vec<usize>,
    pub element: ElementType,
}

impl ArrayInfo {
    /// Number of elements; `None` if it overflows.
    pub(super) fn count(&self) -> Option<usize> {
        self.shape.iter().try_fold(1_usize, |n, &side| n.checked_mul(side))
    }

    /// Element type and shape, such as `f64 [3, 4]`.
    pub(super) fn form(element: ElementType, shape: &[usize]) -> String {
        format!("{element} {shape:?}")
    }
}

/// The line of JSON.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Head {
    /// Of the program that wrote the file.
    pub version: String,
    pub identity: Identity,
    pub header: Value,
    pub arrays: Vec<Placed>,
}

impl Head {
    /// Parses the line of JSON. The arrays must follow each other without gaps; the error says what was found instead.
    pub fn parse(json: &[u8]) -> Result<Self, String> {
        if !json.ends_with(b"\n") {
            return Err(format!("no end of its header within {} bytes", json.len()));
        }
        let head: Head =
            serde_json::from_slice(json).map_err(|cause| format!("a header that cannot be read ({cause})"))?;
        let infos: Vec<ArrayInfo> = head.arrays.iter().map(|array| array.info.clone()).collect();
        if place(&infos)? != head.arrays {
            return Err("a header whose arrays do not follow each other".into());
        }
        Ok(head)
    }
}

/// An array and where it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Placed {
    #[serde(flatten)]
    pub info: ArrayInfo,
    /// Bytes from the end of the line of JSON.
    pub offset: u64,
    /// Bytes.
    pub length: u64,
}

/// Places arrays one after the other. The error says why they cannot be placed, such as two of one name.
pub(super) fn place(arrays: &[ArrayInfo]) -> Result<Vec<Placed>, String> {
    let mut offset = 0_u64;
    let mut placed: Vec<Placed> = Vec::with_capacity(arrays.len());
    for info in arrays {
        if placed.iter().any(|other| other.info.name == info.name) {
            return Err(format!("two arrays named `{}`", info.name));
        }
        let length = info
            .count()
            .and_then(|count| u64::try_from(count).ok()?.checked_mul(info.element.bytes() as u64));
        // The checksum follows the last array, and offsets of files are signed.
        let end = length
            .and_then(|length| offset.checked_add(length))
            .filter(|end| *end < i64::MAX as u64 / 2);
        let (Some(length), Some(end)) = (length, end) else {
            return Err(format!(
                "array `{}` of shape {:?}, too large for a file",
                info.name, info.shape
            ));
        };
        placed.push(Placed {
            info: info.clone(),
            offset,
            length,
        });
        offset = end;
    }
    Ok(placed)
}

/// Bytes of a file with these arrays whose two lines take `before` bytes.
pub(super) fn size(before: u64, arrays: &[Placed]) -> u64 {
    before + arrays.last().map_or(0, |last| last.offset + last.length) + CHECKSUM as u64
}
