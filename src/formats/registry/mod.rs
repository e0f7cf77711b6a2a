//! The list of formats: recognising, reading and writing files of any of them.
//!
//! A format is one file of this folder, which provides its descriptor, and is named twice here: as a module and in the
//! list.

mod astm;
mod csv_readings;
mod integra;
mod merl;
mod radiance;
mod rgl;
mod ssdd;
mod utia;
mod wif;
mod zemax;

use super::descriptor::{Beginning, Descriptor, FormatReader, FormatWriter, Input, Mark};
use super::error::FormatError;
use super::options::Encoding;
use super::text::quoted;
use super::write::WriteError;
use crate::goniometric::{Format, Goniometric, Scatter};
use crate::text::{Foreign, foreign};

/// A constant of [`Format`] and a descriptor for each row.
macro_rules! registry {
    ($($name:ident = $descriptor:path,)*) => {
        impl Format {
            $(pub const $name: Self = $descriptor.format;)*
        }
        static ALL: &[Descriptor] = &[$($descriptor,)*];
    };
}

// Of formats that a file may as well have, the first one is taken.
registry! {
    CSV = csv_readings::FORMAT,
    DDR = integra::DIFFUSE,
    SDR = integra::SPECULAR,
    SSDD = ssdd::FORMAT,
    ASTM = astm::FORMAT,
    MERL = merl::FORMAT,
    RGL = rgl::FORMAT,
    ZEMAX = zemax::ZEMAX,
    LIGHT_TOOLS = zemax::LIGHT_TOOLS,
    RADIANCE_XML = radiance::FORMAT,
    UTIA = utia::FORMAT,
    WIF = wif::FORMAT,
}

/// Every format there is.
pub fn all() -> &'static [Descriptor] {
    ALL
}

/// What is known of a format.
///
/// # Panics
/// Never: formats are made by descriptors alone, and all of those are in the list.
pub fn descriptor(format: Format) -> &'static Descriptor {
    let known = ALL.iter().find(|known| known.format == format);
    known.unwrap_or_else(|| unreachable!("{format} is not in the list of formats"))
}

/// How a format is written.
///
/// # Errors
/// A format that can only be read.
pub fn writer(format: Format) -> Result<FormatWriter, WriteError> {
    descriptor(format).write.ok_or_else(|| {
        let written: Vec<&str> = targets().map(|(name, ..)| name).collect();
        let written = any_of(&written);
        WriteError::NotWritten { format, written }
    })
}

/// What can be written: a name on the command line, the format and the encoding.
pub fn targets() -> impl Iterator<Item = (&'static str, Format, Encoding)> {
    let written = ALL.iter().filter_map(|known| Some((known.format, known.write?)));
    written.flat_map(|(format, writer)| {
        let plain = (format.name(), format, Encoding::default());
        let variant = writer.variant.map(|(name, encoding)| (name, format, encoding));
        std::iter::once(plain).chain(variant)
    })
}

/// The extensions of files that can be written, each with its format and what it says of the content.
pub fn extensions() -> impl Iterator<Item = (&'static str, Format, Option<Scatter>)> {
    let written = ALL.iter().filter(|known| known.write.is_some());
    written.flat_map(|known| {
        let of = |&(extension, scatter): &(&'static str, Option<Scatter>)| (extension, known.format, scatter);
        known.extensions.iter().map(of)
    })
}

/// Words as a list: "a, b or c".
pub fn any_of(words: &[&str]) -> String {
    match words {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
    }
}

/// The format of a file of `size` bytes that begins with `head`.
pub(super) fn detect(path: &str, head: &[u8], size: u64) -> Result<&'static Descriptor, FormatError> {
    let expected = || {
        let words: Vec<&str> = ALL
            .iter()
            .filter(|known| known.is_goniometric())
            .map(|known| known.words)
            .collect();
        format!("a goniometric file: {}", any_of(&words))
    };
    if head.is_empty() {
        let remedy = "copy or export it again";
        return Err(FormatError::file(path, expected(), "an empty file", remedy));
    }
    if let Some(Foreign { what, remedy }) = foreign(head) {
        return Err(FormatError::file(path, expected(), what, remedy));
    }
    let beginning = Beginning::new(head, size);
    let marks = ALL
        .iter()
        .filter_map(|known| Some(((known.detect)(&beginning)?, known)));
    let surest = marks.min_by_key(|(mark, _)| *mark);
    match surest {
        Some((Mark::Magic, known)) => return Ok(known),
        Some((Mark::Swapped(remedy), known)) => {
            let found = format!(
                "the header of a file of the format {} with its bytes in big-endian order",
                known.format
            );
            return Err(FormatError::file(path, "little-endian numbers", found, remedy));
        }
        Some((_, known)) => return Ok(known),
        None => {}
    }
    let found = format!("a file that begins with {}", quoted(&beginning.text));
    let remedy = "give the data file of the instrument, archive or renderer; `specval convert --help` lists the \
                  formats, and spectra are read by `specval colour`";
    Err(FormatError::file(path, expected(), found, remedy))
}

/// Reads the values of a file of a format.
pub(super) fn read(known: &Descriptor, input: &Input) -> Result<Goniometric, FormatError> {
    match known.read {
        FormatReader::Goniometric(read) => read(input),
        FormatReader::Elsewhere { found, remedy } => {
            Err(FormatError::file(input.path, "a goniometric file", found, remedy))
        }
    }
}
