//! What the registry holds of a format. Each format's file provides its own descriptor.

use std::ops::RangeInclusive;

use super::error::FormatError;
use super::options::{Encoding, ReadOptions};
use super::text::{Text, decode};
use super::write::{WriteError, WriteNotice};
use crate::goniometric::{Component, FileProvenance, Format, Goniometric, ReadNotice, Scatter};
use crate::text::encoding::beginning;

pub(super) const MIB: u64 = 1 << 20;
/// Sizes of most files.
pub(super) const USUAL_SIZES: RangeInclusive<u64> = 1..=256 * MIB;

/// A file format: how to tell, read and write it.
pub struct Descriptor {
    pub format: Format,
    /// Name of its files for users, in the list of formats.
    pub words: &'static str,
    /// Extensions of its files, with what they say of the content.
    pub extensions: &'static [(&'static str, Option<Scatter>)],
    /// Sizes in bytes that its files can have.
    pub sizes: RangeInclusive<u64>,
    /// How the format's own words for the sides and directions are meant, where they are not those of this program.
    pub convention: Option<&'static str>,
    pub(super) detect: fn(&Beginning) -> Option<Mark>,
    pub(super) read: FormatReader,
    /// `None` for formats that can only be read.
    pub write: Option<FormatWriter>,
}

impl Descriptor {
    /// Size of the largest file that is read, bytes.
    pub fn most_bytes(&self) -> u64 {
        *self.sizes.end()
    }

    /// Whether its files hold goniometric data.
    pub(super) fn is_goniometric(&self) -> bool {
        matches!(self.read, FormatReader::Goniometric(_))
    }
}

pub(super) enum FormatReader {
    Goniometric(fn(&Input) -> Result<Goniometric, FormatError>),
    /// A file that is recognised here and read by another module: what it is, and how to use it.
    Elsewhere {
        found: &'static str,
        remedy: &'static str,
    },
}

/// A file to be read.
pub(super) struct Input<'a> {
    /// What errors call it; some formats tell reflection from transmission by it.
    pub(super) path: &'a str,
    pub(super) bytes: &'a [u8],
    pub(super) options: &'a ReadOptions,
}

impl Input<'_> {
    /// Reads text, with a warning of what its encoding left open.
    pub(super) fn text(
        &self,
        read: impl FnOnce(Text) -> Result<Goniometric, FormatError>,
    ) -> Result<Goniometric, FormatError> {
        let decoded = decode(self.path, self.bytes)?;
        let mut data = read(Text::new(self.path, &decoded.text))?;
        data.warnings.extend(decoded.notice.map(ReadNotice::from));
        Ok(data)
    }
}

/// How a format is written.
#[derive(Clone, Copy)]
pub struct FormatWriter {
    pub holds: Holds,
    /// Whether it holds standard errors of the values.
    pub errors: bool,
    /// A variant in another encoding, with its name on the command line.
    pub variant: Option<(&'static str, Encoding)>,
    pub(super) write: fn(&Content, &mut Vec<WriteNotice>) -> Result<Vec<u8>, WriteError>,
}

/// What a file of a format can hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holds {
    /// One component of scattering.
    Scattering,
    /// One component of reflection.
    Reflection,
    /// Specular fractions.
    Fractions,
    /// Reflection and transmission, scattering and specular fractions, of light from one side.
    Kinds,
    /// Reflection and transmission of light from both sides, with specular fractions beside scattering.
    Sides,
}

impl Holds {
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::Fractions => "specular fractions",
            Self::Reflection => "reflection",
            Self::Kinds => "scattering and specular fractions",
            Self::Scattering | Self::Sides => "scattering over directions",
        }
    }

    /// Whether a file holds more than one component.
    pub(super) fn several(self) -> bool {
        matches!(self, Self::Kinds | Self::Sides)
    }
}

/// What is written into a file.
pub(super) struct Content<'a> {
    pub(super) format: Format,
    /// The first of those below.
    pub(super) component: &'a Component,
    /// One alone of formats that hold one.
    pub(super) components: &'a [&'a Component],
    pub(super) provenance: &'a FileProvenance,
    pub(super) encoding: Encoding,
}

/// How surely a file is of a format, the surest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Mark {
    /// It begins with bytes that this format alone begins with.
    Magic,
    /// It begins so, but with the bytes of its numbers in big-endian order; with the remedy.
    Swapped(&'static str),
    /// Text with binary data behind it, or binary data of a size that this format alone has.
    Binary,
    /// A key word of this format alone, at this line, from 1, and word of it. The first one in the file decides.
    Word { line: usize, word: usize },
    /// A line begins with a key word that other formats may have too.
    LineWord,
    /// Words that other formats may have too, or nothing that contradicts.
    Likely,
}

/// The beginning of a file, by which its format is known.
pub(super) struct Beginning<'a> {
    pub(super) head: &'a [u8],
    pub(super) text: String,
    /// Bytes of the whole file.
    pub(super) size: u64,
}

impl<'a> Beginning<'a> {
    pub(super) fn new(head: &'a [u8], size: u64) -> Self {
        let text = beginning(head).to_string();
        Self { head, text, size }
    }

    /// Lines that are neither blank nor comments, with their number from 1.
    pub(super) fn lines(&self) -> impl Iterator<Item = (usize, &str)> {
        // Spreadsheets put comments in quotes.
        let is_comment = |line: &str| line.trim_start_matches('"').starts_with(['#', ';']);
        let lines = self.text.split(['\n', '\r']).map(str::trim_start);
        (1..).zip(lines.filter(move |line| !line.is_empty() && !is_comment(line)))
    }

    /// Words of those lines in small letters, each with its mark, up to a comment that `;;` begins.
    pub(super) fn words(&self) -> impl Iterator<Item = (Mark, String)> {
        self.lines().flat_map(|(line, text)| {
            let words = text.split_whitespace().map(str::to_ascii_lowercase);
            let words = words.take_while(|word| word != ";;");
            (1..)
                .zip(words)
                .map(move |(word, text)| (Mark::Word { line, word }, text))
        })
    }

    /// The first line that begins with a key word.
    pub(super) fn line_of(&self, keyword: &str) -> Option<Mark> {
        self.first_line(|line| line.split_whitespace().next() == Some(keyword))
    }

    pub(super) fn first_line(&self, is: impl Fn(&str) -> bool) -> Option<Mark> {
        let mut lines = self.lines().filter(|(_, text)| is(text));
        lines.next().map(|(line, _)| Mark::Word { line, word: 0 })
    }

    /// The first place of a word, in any case.
    pub(super) fn word(&self, keyword: &str) -> Option<Mark> {
        self.words().find(|(_, word)| word == keyword).map(|(mark, _)| mark)
    }
}
