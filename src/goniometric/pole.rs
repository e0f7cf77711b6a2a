//! At a pole a grid has one node for each azimuth, and all are one direction: they get one value.

use super::data::{Goniometric, Table};
use super::grid::Grid;
use super::notice::ReadNotice;
use super::parameters::Parameters;

/// Relative difference of nodes at a pole below which it counts as rounding.
const ROUNDING: f64 = 1e-9;
/// Relative difference above which a warning is given.
const TOLD: f64 = 1e-3;
/// Distance from the pole, radians, that counts as the pole.
const AT_POLE_RAD: f64 = 1e-9;

/// Sets the nodes of every pole to their mean over azimuth, weighted by each node's fraction of the circle, and warns
/// if they differed.
pub(crate) fn give_one_value(data: &mut Goniometric) {
    let mut largest = 0.0f64;
    for component in &mut data.components {
        if let Table::Grid(grid) = &mut component.table {
            largest = largest.max(outgoing(grid)).max(incident(grid));
        }
    }
    if largest > TOLD {
        data.warnings.push(ReadNotice::Pole { difference: largest });
    }
}

/// The pole of the last two angles. The largest difference from the mean, over the mean.
fn outgoing(grid: &mut Grid) -> f64 {
    let axes = grid.axes();
    if axes[2].nodes_rad()[0].abs() > AT_POLE_RAD || axes[3].nodes_rad().len() == 1 {
        return 0.0;
    }
    let shares = axes[3].shares();
    let [n0, n1, _, n3] = grid.shape();
    let mut largest = 0.0f64;
    for (i0, i1) in (0..n0).flat_map(|i0| (0..n1).map(move |i1| (i0, i1))) {
        for channel in 0..grid.channels() {
            let column: Vec<f64> = (0..n3).map(|i3| grid.at([i0, i1, 0, i3], channel)).collect();
            let Some((mean, difference)) = mean(&column, &shares) else {
                continue;
            };
            largest = largest.max(difference);
            for (i3, value) in column.iter().enumerate() {
                if !value.is_nan() {
                    grid.set([i0, i1, 0, i3], channel, mean);
                }
            }
        }
    }
    largest
}

/// The pole of the first two angles, for tables that depend on the second. If the last azimuth rotates with the second
/// angle, nodes of one direction exist only if rotations map nodes to nodes; otherwise the columns are unchanged.
fn incident(grid: &mut Grid) -> f64 {
    let axes = grid.axes();
    if axes[0].nodes_rad()[0].abs() > AT_POLE_RAD || axes[1].nodes_rad().len() == 1 {
        return 0.0;
    }
    let shares = axes[1].shares();
    let azimuths = axes[1].nodes_rad().to_vec();
    let last = axes[3].nodes_rad().to_vec();
    // In spherical tables the last azimuth is measured from x; in the others it rotates with the first one.
    let turns = *grid.parameters() != Parameters::Spherical;
    let same_direction = |i1: usize, i3: usize| -> Option<Vec<usize>> {
        if !turns {
            return Some(vec![i3; azimuths.len()]);
        }
        let node = |k: &f64| grid.last_node(last[i3] + azimuths[i1] - k);
        azimuths.iter().map(node).collect()
    };
    let [_, n1, n2, n3] = grid.shape();
    let of_one: Option<Vec<Vec<usize>>> = (0..n1 * n3).map(|at| same_direction(at / n3, at % n3)).collect();
    let Some(of_one) = of_one else {
        return 0.0;
    };
    let mut largest = 0.0f64;
    let before = grid.clone();
    for (at, nodes) in of_one.iter().enumerate() {
        let (i1, i3) = (at / n3, at % n3);
        for (i2, channel) in (0..n2).flat_map(|i2| (0..before.channels()).map(move |c| (i2, c))) {
            let all = nodes.iter().enumerate();
            let column: Vec<f64> = all.map(|(k, &node)| before.at([0, k, i2, node], channel)).collect();
            if let Some((mean, difference)) = mean(&column, &shares) {
                largest = largest.max(difference);
                grid.set([0, i1, i2, i3], channel, mean);
            }
        }
    }
    largest
}

/// Mean of the existing values, and largest relative difference from it; `None` if they differ by rounding only.
fn mean(values: &[f64], shares: &[f64]) -> Option<(f64, f64)> {
    let there = || values.iter().zip(shares).filter(|(value, _)| !value.is_nan());
    let (low, high) = there().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (v, _)| {
        (low.min(*v), high.max(*v))
    });
    if low.is_infinite() || high - low <= ROUNDING * high.abs().max(low.abs()) {
        return None;
    }
    let total: f64 = there().map(|(_, share)| share).sum();
    let mean = there().map(|(value, share)| value * share).sum::<f64>() / total;
    let difference = (high - mean).max(mean - low) / mean.abs().max(f64::MIN_POSITIVE);
    (total > 0.0).then_some((mean, difference))
}
