//! The tensor file of the Realistic Graphics Lab (`.bsdf` of the RGL material database, Mitsuba's and pbrt's
//! `measured`): named arrays in one binary file, little-endian.

use crate::formats::descriptor::{Descriptor, FormatReader, FormatWriter, Holds, MIB, Mark};
use crate::formats::rgl_arrays::{MAGIC, RGL};
use crate::formats::rgl_read::read;
use crate::formats::write::rgl as write;

pub(super) const FORMAT: Descriptor = Descriptor {
    format: RGL,
    words: "rgl",
    extensions: &[("bsdf", None)],
    // The largest of the public database, anisotropic and spectral, have a few hundred megabytes.
    sizes: 1..=1024 * MIB,
    convention: None,
    detect: |beginning| beginning.head.starts_with(MAGIC).then_some(Mark::Magic),
    read: FormatReader::Goniometric(|input| read(input.path, input.bytes)),
    write: Some(FormatWriter {
        holds: Holds::Reflection,
        errors: false,
        variant: None,
        write: write::write,
    }),
};
