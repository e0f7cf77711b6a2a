//! WIF: weave drafts, which `weave` reads.

use crate::formats::descriptor::{Descriptor, FormatReader, MIB};
use crate::goniometric::Format;

pub(super) const FORMAT: Descriptor = Descriptor {
    format: Format::new("wif"),
    words: "wif",
    extensions: &[("wif", None)],
    sizes: 1..=4 * MIB,
    convention: None,
    detect: |beginning| beginning.first_line(|line| line.starts_with('[')),
    read: FormatReader::Elsewhere {
        found: "a weave draft (WIF)",
        remedy: "print it with `specval weave`, or name it as `weave` in `[cloth]` of a study",
    },
    write: None,
};
