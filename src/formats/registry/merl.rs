//! MERL: three counts (90, 90, 180), then 64-bit values of red, green, blue over θ_h (even in its square), θ_d, φ_d;
//! φ_d has period 180°. Isotropic BRDFs in linear RGB of no stated primaries. A value below 0 stands for no data.
//!
//! Values are taken as nodes at θ_h = i²/90, θ_d = i, φ_d = i degrees; other readers take them as cells.

use rayon::prelude::*;

use crate::formats::byte_order::{is_implausible, swapped};
use crate::formats::descriptor::{Beginning, Descriptor, FormatReader, FormatWriter, Holds, Input, Mark};
use crate::formats::error::{FormatError, remedy};
use crate::formats::merl_table::{HEADER, NODES, PHI_D, SCALE, SIZE, directions, grid};
use crate::formats::write::merl as write;
use crate::goniometric::{
    ChannelSet, Component, FileProvenance, Format, Goniometric, Quantity, ReadNotice, Scatter, Side, Table,
};
use crate::number::shown;

pub(super) const FORMAT: Descriptor = Descriptor {
    format: Format::new("merl"),
    words: "merl",
    extensions: &[("binary", None)],
    sizes: SIZE..=SIZE,
    convention: None,
    detect: told,
    read: FormatReader::Goniometric(read),
    write: Some(FormatWriter {
        holds: Holds::Reflection,
        errors: false,
        variant: None,
        write: write::write,
    }),
};

fn told(beginning: &Beginning) -> Option<Mark> {
    const REMEDY: &str =
        "reverse the bytes of each count (4 bytes) and of each value (8 bytes), or copy the original file";
    if begins(beginning.head) {
        Some(Mark::Magic)
    } else {
        begins_swapped(beginning.head).then_some(Mark::Swapped(REMEDY))
    }
}

fn begins(head: &[u8]) -> bool {
    counts_are(head, u32::from_le_bytes)
}

/// As [`begins`], of a file of a big-endian machine.
fn begins_swapped(head: &[u8]) -> bool {
    counts_are(head, u32::from_be_bytes)
}

fn counts_are(head: &[u8], number: fn([u8; 4]) -> u32) -> bool {
    let counts: Vec<u32> = head
        .chunks_exact(4)
        .take(3)
        .map(|b| number([b[0], b[1], b[2], b[3]]))
        .collect();
    // The variant without reciprocity has 360; it is known, and then refused by its size.
    matches!(counts[..], [90, 90, 180 | 360])
}

fn read(input: &Input) -> Result<Goniometric, FormatError> {
    let (path, bytes) = (input.path, input.bytes);
    if bytes.len() as u64 != SIZE || !begins(bytes) || bytes[8] != PHI_D as u8 {
        let expected = format!("{SIZE} bytes: counts 90, 90, 180, and 3 values of 8 bytes for each node");
        let remedy = "copy the file again in binary mode; the variant with 360 azimuths is not read";
        return Err(FormatError::file(
            path,
            expected,
            format!("{} bytes", bytes.len()),
            remedy,
        ));
    }
    let stored = |index: usize| {
        let mut word = [0; 8];
        word.copy_from_slice(&bytes[HEADER + 8 * index..HEADER + 8 * index + 8]);
        f64::from_le_bytes(word)
    };
    let all = || (0..3 * NODES).into_par_iter();
    if is_implausible((0..3 * NODES).step_by(97).map(stored)) {
        return Err(swapped(path, HEADER));
    }
    if let Some(index) = all().find_first(|&index| !stored(index).is_finite()) {
        let found = shown(stored(index));
        let at = HEADER + 8 * index;
        return Err(FormatError::byte(path, at, "a finite value", found, remedy::DAMAGED));
    }
    // A node has data in all channels or in none.
    let is_hole = |node: usize| (0..3).any(|plane| stored(plane * NODES + node) < 0.0);
    let value = |index: usize| match is_hole(index % NODES) {
        true => f64::NAN,
        false => stored(index) * SCALE[index / NODES],
    };
    let values: Vec<f64> = all().map(value).collect();
    if values.par_iter().all(|v| v.is_nan()) {
        let expected = "values of 0 or more, a negative one where there are no data";
        let remedy = "check the sign of the data: such a file holds nothing";
        return Err(FormatError::byte(path, HEADER, expected, "negative ones alone", remedy));
    }
    // Of nodes with light and viewer above the surface, instruments miss some near the horizon.
    let is_above = |node: &usize| {
        let (omega_in, omega_out) = directions(*node);
        omega_in.z > 0.1 && omega_out.z > 0.1
    };
    let above = (0..NODES).step_by(97).filter(is_above);
    let (holes, nodes) = above.fold((0usize, 0usize), |(holes, nodes), node| {
        (holes + usize::from(is_hole(node)), nodes + 1)
    });
    if 10 * holes > 9 * nodes {
        let expected = "values of 0 or more, a negative one where there are no data";
        let found = format!("negative ones at {holes} of {nodes} nodes well above the horizon");
        let remedy = "check the sign of the data: such a file holds next to nothing";
        return Err(FormatError::byte(path, HEADER, expected, found, remedy));
    }
    let mut warnings = vec![ReadNotice::NoProvenance { format: "MERL".into() }];
    if 4 * holes > nodes {
        warnings.push(ReadNotice::Holes { holes, nodes });
    }
    let grid = grid(values);
    Ok(Goniometric {
        format: FORMAT.format,
        provenance: FileProvenance::default(),
        components: vec![Component {
            scatter: Scatter::Reflection,
            side: Side::Front,
            quantity: Quantity::Bsdf,
            channels: ChannelSet::Rgb,
            table: Table::Grid(grid),
        }],
        warnings,
    })
}
