//! UTIA: 64-bit values of red, green, blue over incident and outgoing direction, every 15° in polar angle up to 75° and
//! every 7.5° in azimuth, without any header. The scale is not stated and differs between readers.

use std::f64::consts::TAU;

use crate::formats::byte_order::{is_implausible, swapped};
use crate::formats::descriptor::{Beginning, Descriptor, FormatReader, Input, Mark};
use crate::formats::error::{FormatError, remedy};
use crate::goniometric::{
    Axis, ChannelSet, Component, FileProvenance, Fold, Format, Goniometric, Grid, Parameters, Quantity, ReadNotice,
    Scatter, Side, Table,
};

pub(super) const FORMAT: Descriptor = Descriptor {
    format: Format::new("utia"),
    words: "utia",
    extensions: &[("bin", None)],
    sizes: SIZE..=SIZE,
    convention: None,
    detect: told,
    read: FormatReader::Goniometric(read),
    write: None,
};

/// Numbers without a header may begin with any byte: their size tells.
fn told(beginning: &Beginning) -> Option<Mark> {
    let is_binary = beginning.head.contains(&0);
    (beginning.size == SIZE).then_some(if is_binary { Mark::Binary } else { Mark::Likely })
}

const POLAR: usize = 6;
const AZIMUTHS: usize = 48;
const COUNT: usize = 3 * POLAR * AZIMUTHS * POLAR * AZIMUTHS;

/// Bytes of every file.
const SIZE: u64 = 8 * COUNT as u64;

fn read(input: &Input) -> Result<Goniometric, FormatError> {
    let (path, bytes, options) = (input.path, input.bytes, input.options);
    if bytes.len() as u64 != SIZE {
        return Err(FormatError::file(
            path,
            format!("{SIZE} bytes"),
            format!("{} bytes", bytes.len()),
            "copy the file again in binary mode; files of other steps in angle are not read",
        ));
    }
    let stored = |bytes: &[u8]| {
        let mut word = [0; 8];
        word.copy_from_slice(bytes);
        f64::from_le_bytes(word)
    };
    if is_implausible(bytes.chunks_exact(8).map(stored)) {
        return Err(swapped(path, 0));
    }
    let mut negative = 0;
    let mut values = Vec::with_capacity(COUNT);
    for (index, stored) in bytes.chunks_exact(8).map(stored).enumerate() {
        if !stored.is_finite() || stored.abs() > 1e30 {
            let found = format!("{stored:?}");
            return Err(FormatError::byte(
                path,
                8 * index,
                "a finite value",
                found,
                remedy::DAMAGED,
            ));
        }
        negative += usize::from(stored < 0.0);
        values.push(stored * options.scale.unwrap_or(1.0));
    }
    if values.iter().all(|v| *v <= 0.0) {
        let remedy = "check the sign of the data, and that the file is of this format: it has no header to tell by";
        return Err(FormatError::byte(path, 0, "values above 0", "none above 0", remedy));
    }
    let polar = || Axis::bounded((0..POLAR).map(|i| (15.0 * i as f64).to_radians()).collect());
    let azimuth = || Axis::azimuth((0..AZIMUTHS).map(|i| (7.5 * i as f64).to_radians()).collect(), TAU);
    let axes = [polar(), azimuth(), polar(), azimuth()];
    let grid = Grid::new(Parameters::Spherical, axes, Fold::None, 3, [4, 0, 1, 2, 3], values);
    let mut warnings = Vec::new();
    if negative > 0 {
        warnings.push(ReadNotice::NegativeValues { count: negative });
    }
    if options.scale.is_none() {
        warnings.push(ReadNotice::ScaleNotStated);
    }
    Ok(Goniometric {
        format: FORMAT.format,
        provenance: FileProvenance::default(),
        components: vec![Component {
            scatter: Scatter::Reflection,
            side: Side::Front,
            quantity: if options.scale.is_some() {
                Quantity::Bsdf
            } else {
                Quantity::Unscaled
            },
            channels: ChannelSet::Rgb,
            table: Table::Grid(grid),
        }],
        warnings,
    })
}
