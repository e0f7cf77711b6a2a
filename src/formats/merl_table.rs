//! The nodes of a MERL table, and the bytes of a file of them.

use std::f64::consts::{PI, TAU};

use crate::geometry::Vec3;
use crate::goniometric::{Axis, Fold, Grid, Parameters, direction};

pub(super) const THETA_H: usize = 90;
pub(super) const THETA_D: usize = 90;
pub(super) const PHI_D: usize = 180;
pub(super) const HEADER: usize = 12;
/// Nodes of a plane.
pub(super) const NODES: usize = THETA_H * THETA_D * PHI_D;

/// Bytes of every file.
pub(super) const SIZE: u64 = (HEADER + 3 * 8 * NODES) as u64;

/// 1/sr for a unit of the stored red, green, blue.
pub(super) const SCALE: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];

/// A table of these values in 1/sr, planes one after the other; NaN where there are no data.
pub(super) fn grid(values: Vec<f64>) -> Grid {
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

pub(super) fn theta_h_rad(index: usize) -> f64 {
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
