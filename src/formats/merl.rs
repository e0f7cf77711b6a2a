//! MERL: three counts (90, 90, 180), then 64-bit values of red, green, blue over θ_h (even in its square), θ_d, φ_d; φ_d
//! has period 180°. Isotropic BRDFs in linear RGB of no stated primaries. A value below 0 stands for no data.
//!
//! Values are taken as nodes at θ_h = i²/90, θ_d = i, φ_d = i degrees; other readers take them as cells.

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

use super::FormatError;
use super::axis::Axis;
use super::detect::Format;
use super::error::remedy;
use super::goniometric::{Channels, Component, Goniometric, Provenance, Quantity, Scatter, Side, Table, direction};
use super::grid::{Fold, Grid, Parameters};
use super::source::{is_implausible, swapped};
use crate::geometry::Vec3;
use crate::number::shown;

const THETA_H: usize = 90;
const THETA_D: usize = 90;
const PHI_D: usize = 180;
const HEADER: usize = 12;
/// Nodes of a plane.
pub(super) const NODES: usize = THETA_H * THETA_D * PHI_D;

/// Bytes of every file.
pub(super) const SIZE: u64 = (HEADER + 3 * 8 * NODES) as u64;

/// 1/sr for a unit of the stored red, green, blue.
const SCALE: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];

pub(super) fn begins(head: &[u8]) -> bool {
    counts_are(head, u32::from_le_bytes)
}

/// As [`begins`], of a file of a big-endian machine.
pub(super) fn begins_swapped(head: &[u8]) -> bool {
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

pub(super) fn read(path: &str, bytes: &[u8]) -> Result<Goniometric, FormatError> {
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
    let mut warnings = vec!["MERL files state neither their RGB primaries nor any provenance".to_owned()];
    if 4 * holes > nodes {
        warnings.push(format!(
            "values are negative, which stands for no data, at {holes} of {nodes} nodes well above the horizon"
        ));
    }
    let grid = grid(values);
    Ok(Goniometric {
        format: Format::Merl,
        provenance: Provenance::default(),
        components: vec![Component {
            scatter: Scatter::Reflection,
            side: Side::Front,
            quantity: Quantity::Bsdf,
            channels: Channels::Rgb,
            table: Table::Grid(grid),
        }],
        warnings,
    })
}

/// A table of these values in 1/sr, planes one after the other; NaN where there are no data.
fn grid(values: Vec<f64>) -> Grid {
    let axes = [
        Axis::held((0..THETA_H).map(theta_h_rad).collect()),
        Axis::azimuth(vec![0.0], TAU),
        Axis::held((0..THETA_D).map(|i| (i as f64).to_radians()).collect()),
        Axis::azimuth((0..PHI_D).map(|i| (i as f64).to_radians()).collect(), PI),
    ];
    Grid::new(
        Parameters::HalfDifference,
        axes,
        Fold::HalfTurn,
        3,
        [4, 1, 0, 2, 3],
        values,
    )
}

/// As [`bytes`] are read.
pub(super) fn table(rgb: &[Option<[f64; 3]>]) -> Grid {
    let planes = (0..3).flat_map(|channel| {
        rgb.iter()
            .map(move |node| node.map_or(f64::NAN, |values| values[channel]))
    });
    grid(planes.collect())
}

fn theta_h_rad(index: usize) -> f64 {
    ((index * index) as f64 / 90.0).to_radians()
}

/// Directions to light and viewer at a node, counted in the order of a plane; either may be below the horizon.
pub(super) fn directions(node: usize) -> (Vec3, Vec3) {
    let theta_h = theta_h_rad(node / (THETA_D * PHI_D));
    let theta_d = ((node / PHI_D % THETA_D) as f64).to_radians();
    let d = direction(theta_d, ((node % PHI_D) as f64).to_radians());
    let (sin, cos) = theta_h.sin_cos();
    let half = direction(theta_h, 0.0);
    let omega_in = Vec3::new(cos * d.x + sin * d.z, d.y, cos * d.z - sin * d.x);
    (omega_in, half * (2.0 * half.dot(&omega_in)) - omega_in)
}

/// A file of these values in 1/sr, one triple a node; `None` where there are no data.
pub(super) fn bytes(rgb: &[Option<[f64; 3]>]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(SIZE as usize);
    for count in [THETA_H, THETA_D, PHI_D] {
        bytes.extend((count as u32).to_le_bytes());
    }
    for (channel, scale) in SCALE.iter().enumerate() {
        for node in rgb {
            bytes.extend(node.map_or(-1.0, |values| values[channel] / scale).to_le_bytes());
        }
    }
    bytes
}
