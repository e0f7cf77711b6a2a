use std::fmt;
use std::ops::RangeInclusive;

use super::FormatError;
use super::text::quoted;
use super::{merl, utia};
use crate::text::encoding::beginning;
use crate::text::{Heading, heading};

/// A file format. It is told by what a file holds, never by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Readings as comma-separated text, of this program.
    Csv,
    /// Integra diffuse distribution, `.ddr` (reflection) and `.ddt` (transmission).
    Ddr,
    /// Integra specular distribution, `.sdr` and `.sdt`.
    Sdr,
    /// Surface Scattering Distribution Data.
    Ssdd,
    /// Columns of the ASTM E1392 style.
    Astm,
    /// MERL isotropic table.
    Merl,
    /// Tensor file of the Realistic Graphics Lab.
    Rgl,
    /// Zemax (Radiant) tabular BSDF.
    Zemax,
    /// LightTools tabular BSDF.
    LightTools,
    /// Radiance and WINDOW: Klems matrix or tensor tree in XML.
    RadianceXml,
    /// UTIA anisotropic table.
    Utia,
    /// Weave draft; not goniometric.
    Wif,
}

impl Format {
    pub const ALL: [Self; 12] = [
        Self::Csv,
        Self::Ddr,
        Self::Sdr,
        Self::Ssdd,
        Self::Astm,
        Self::Merl,
        Self::Rgl,
        Self::Zemax,
        Self::LightTools,
        Self::RadianceXml,
        Self::Utia,
        Self::Wif,
    ];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Ddr => "ddr",
            Self::Sdr => "sdr",
            Self::Ssdd => "ssdd",
            Self::Astm => "astm",
            Self::Merl => "merl",
            Self::Rgl => "rgl",
            Self::Zemax => "zemax",
            Self::LightTools => "lighttools",
            Self::RadianceXml => "klems",
            Self::Utia => "utia",
            Self::Wif => "wif",
        }
    }

    /// Bytes of the largest file that is read.
    pub fn most_bytes(self) -> u64 {
        *self.sizes().end()
    }

    /// Sizes in bytes a file of this format can have.
    pub(super) fn sizes(self) -> RangeInclusive<u64> {
        const MIB: u64 = 1 << 20;
        match self {
            Self::Merl => merl::SIZE..=merl::SIZE,
            Self::Utia => utia::SIZE..=utia::SIZE,
            // The largest of the public database, anisotropic and spectral, have a few hundred megabytes.
            Self::Rgl => 1..=1024 * MIB,
            Self::Wif => 1..=4 * MIB,
            _ => 1..=256 * MIB,
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The format of a file of `size` bytes that begins with `head`.
pub(super) fn detect(path: &str, head: &[u8], size: u64) -> Result<Format, FormatError> {
    let expected = "a goniometric file: csv, ddr, ddt, sdr, sdt, ssdd, astm, merl, rgl, zemax, lighttools, radiance xml \
                    or utia";
    if head.is_empty() {
        let remedy = "copy or export it again";
        return Err(FormatError::file(path, expected, "an empty file", remedy));
    }
    if head.starts_with(b"tensor_file\0") {
        return Ok(Format::Rgl);
    }
    if merl::begins(head) {
        return Ok(Format::Merl);
    }
    if merl::begins_swapped(head) {
        let found = "the header of a MERL file with its bytes in big-endian order";
        let remedy = "reverse the bytes of each count (4 bytes) and of each value (8 bytes), or copy the original file";
        return Err(FormatError::file(path, "little-endian numbers", found, remedy));
    }
    let text = beginning(head);
    if is_web_page(&text) {
        let remedy = "download the file itself: the page usually has a link named Raw or Download";
        return Err(FormatError::file(path, expected, "a web page (HTML)", remedy));
    }
    let of_text = of_text(&text);
    // Numbers without a header may begin with any byte.
    if size == utia::SIZE && (of_text.is_none() || head.contains(&0)) && of_text != Some(Format::Ssdd) {
        return Ok(Format::Utia);
    }
    if let Some(format) = of_text {
        return Ok(format);
    }
    let found = format!("a file that begins with {}", quoted(&text));
    let remedy = match other_kind(head) {
        Some(kind) => format!("this is {kind}"),
        None => "give the data file of the instrument, archive or renderer; `specval convert --help` lists the formats, and \
                 spectra are read by `specval colour`"
            .into(),
    };
    Err(FormatError::file(path, expected, found, remedy))
}

/// Whether a page of HTML begins, be it a reader's error page or the view of a file.
fn is_web_page(text: &str) -> bool {
    let lower = text.to_ascii_lowercase();
    let page = ["<!doctype html", "<html", "<head>"]
        .iter()
        .filter_map(|tag| lower.find(tag))
        .min();
    page.is_some_and(|at| {
        lower.trim_start().starts_with('<') && lower.find("<windowelement").is_none_or(|bsdf| at < bsdf)
    })
}

/// Kinds of files that are often taken for others, by their first bytes, with what to do.
fn other_kind(head: &[u8]) -> Option<&'static str> {
    let kinds: [(&[u8], &str); 8] = [
        (
            b"PK\x03\x04",
            "a ZIP archive or a spreadsheet: unpack it, or save the sheet as CSV",
        ),
        (b"\x1f\x8b", "a gzip archive: unpack it"),
        (b"\xfd7zXZ", "an xz archive: unpack it"),
        (b"BZh", "a bzip2 archive: unpack it"),
        (b"\xff\xd8\xff", "an image: give the table of values behind it"),
        (b"\x89PNG", "an image: give the table of values behind it"),
        (b"%PDF", "a PDF document: give the table of values behind it"),
        (
            b"version https://git-lfs",
            "a pointer of Git LFS: fetch the file itself with `git lfs pull`",
        ),
    ];
    kinds
        .into_iter()
        .find(|(begins, _)| head.starts_with(begins))
        .map(|(_, kind)| kind)
}

fn of_text(text: &str) -> Option<Format> {
    // Programs may print a line or two before the XML.
    if text.trim_start().starts_with('<') || text.contains("<?xml") || text.contains("<WindowElement") {
        return Some(Format::RadianceXml);
    }
    let (mut integra, mut ssdd) = (None, None);
    let lines = text.split(['\n', '\r']).map(str::trim_start);
    // Spreadsheets put comments in quotes.
    let is_comment = |line: &str| line.trim_start_matches('"').starts_with(['#', ';']);
    for line in lines.filter(|l| !l.is_empty() && !is_comment(l)) {
        let first = line.split_whitespace().next().unwrap_or_default();
        match first {
            "DATA_TYPE" => return Some(Format::Ssdd),
            "VERSION" => ssdd = Some(Format::Ssdd),
            "VARS" => return Some(Format::Astm),
            _ if line.starts_with('[') => return Some(Format::Wif),
            _ if matches!(heading(line), Some(Heading::Plane | Heading::Sphere)) => return Some(Format::Csv),
            _ => {}
        }
        for word in line.split_whitespace() {
            match word.to_ascii_lowercase().as_str() {
                "angleofincidence" => return Some(Format::Zemax),
                "aoi" => return Some(Format::LightTools),
                "phi" | "theta" | "typesym" | "typedata" => integra = Some(Format::Ddr),
                "typecolormodel" | "sigma" => integra = integra.or(Some(Format::Sdr)),
                "def" if integra.is_some() => return integra,
                ";;" => break,
                _ => {}
            }
        }
    }
    ssdd.or(integra)
}
