//! Nodes of a table that is resampled, closer where its values bend.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BinaryHeap};

use super::WriteError;
use super::balance::hemispherical;
use super::sampling::Sampler;
use crate::geometry::Vec3;
use crate::goniometric::{Component, Parameters, Table};

/// Share of the hemispherical value that straight lines between nodes may miss, over all of the angle.
const TOLERANCE: f64 = 3e-3;
/// Closest nodes, in degrees.
const CLOSEST_DEG: f64 = 0.01;

/// Directions of incidence whose values decide on the nodes, with the source's hemispherical value, the mean over
/// channels.
pub(super) struct Probe<'a> {
    sampler: Sampler<'a>,
    incidences_deg: Vec<([f64; 2], f64)>,
}

/// Cuts intervals in half, the one of the largest error first, until the errors add up to the tolerance or there are
/// `most` nodes.
fn refined(
    start: Vec<f64>,
    most: usize,
    mut error: impl FnMut(f64, f64) -> Result<f64, WriteError>,
) -> Result<Vec<f64>, WriteError> {
    // Errors are not negative, and so are ordered as their bits are.
    let mut intervals = BinaryHeap::new();
    let mut total = 0.0;
    for pair in start.windows(2) {
        let e = error(pair[0], pair[1])?;
        total += e;
        intervals.push((e.to_bits(), pair[0].to_bits(), pair[1].to_bits()));
    }
    let mut nodes = start;
    while total > TOLERANCE && nodes.len() < most {
        let Some((e, a, b)) = intervals.pop() else { break };
        let (a, b) = (f64::from_bits(a), f64::from_bits(b));
        let middle = 0.5 * (a + b);
        total -= f64::from_bits(e);
        if b - a < 2.0 * CLOSEST_DEG {
            continue;
        }
        nodes.push(middle);
        for (a, b) in [(a, middle), (middle, b)] {
            let e = error(a, b)?;
            total += e;
            intervals.push((e.to_bits(), a.to_bits(), b.to_bits()));
        }
    }
    nodes.sort_by(f64::total_cmp);
    Ok(nodes)
}

impl<'a> Probe<'a> {
    pub(super) fn new(component: &'a Component, sampler: Sampler<'a>, theta_i_deg: &[f64], phi_i_deg: &[f64]) -> Self {
        let mut incidences_deg = Vec::new();
        if !is_coarse(component) {
            for &theta in theta_i_deg {
                for &phi in phi_i_deg {
                    if let Some(found) = hemispherical(component, theta, phi) {
                        let mean = found.values.iter().sum::<f64>() / found.values.len() as f64;
                        if mean > 0.0 {
                            incidences_deg.push(([theta, phi], mean));
                        }
                    }
                }
            }
        }
        Self {
            sampler,
            incidences_deg,
        }
    }

    /// Both lists of nodes in degrees, from even ones on, at most so many. `directions` gives the directions to light
    /// and viewer of an incidence, polar angle and azimuth, in degrees.
    pub(super) fn nodes(
        &self,
        [polar, around]: [Vec<f64>; 2],
        [most_polar, most_around]: [usize; 2],
        directions: impl Fn([f64; 2], f64, f64) -> (Vec3, Vec3),
    ) -> Result<[Vec<f64>; 2], WriteError> {
        let value = |incidence: [f64; 2], theta: f64, phi: f64| -> Result<f64, WriteError> {
            let (omega_in, omega_out) = directions(incidence, theta, phi);
            let f = self.sampler.bsdf(&omega_in, &omega_out)?;
            Ok(f.iter().sum::<f64>() / f.len() as f64)
        };
        let projected = |incidence: [f64; 2], theta: f64, phi: f64| {
            let (_, omega_out) = directions(incidence, theta, phi);
            omega_out.z.max(0.0) * theta.to_radians().sin()
        };
        // Of the area between a parabola and its chord, over height and width.
        const PARABOLA: f64 = 2.0 / 3.0;
        let mut rows: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
        let probed = every_third(&around);
        let polar = refined(polar, most_polar, |a, b| {
            let middle = 0.5 * (a + b);
            for theta in [a, middle, b] {
                keep(&mut rows, theta, || {
                    let places = self
                        .incidences_deg
                        .iter()
                        .flat_map(|(i, _)| probed.iter().map(move |&phi| (*i, phi)));
                    places.map(|(incidence, phi)| value(incidence, theta, phi)).collect()
                })?;
            }
            let [low, mid, high] = [a, middle, b].map(|theta| &rows[&theta.to_bits()]);
            let mut worst = 0.0f64;
            for (i, (incidence, reflectance)) in self.incidences_deg.iter().enumerate() {
                let mut sum = 0.0;
                for (k, &phi) in probed.iter().enumerate() {
                    let at = i * probed.len() + k;
                    let bend = (mid[at] - 0.5 * (low[at] + high[at])).abs();
                    sum += bend * projected(*incidence, middle, phi) / probed.len() as f64;
                }
                let area = PARABOLA * std::f64::consts::TAU * (b - a).to_radians();
                worst = worst.max(sum * area / reflectance);
            }
            Ok(worst)
        })?;
        let mut columns: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
        let around = refined(around, most_around, |a, b| {
            let middle = 0.5 * (a + b);
            for phi in [a, middle, b] {
                keep(&mut columns, phi, || {
                    let places = self
                        .incidences_deg
                        .iter()
                        .flat_map(|(i, _)| polar.iter().map(move |&theta| (*i, theta)));
                    places.map(|(incidence, theta)| value(incidence, theta, phi)).collect()
                })?;
            }
            let [low, mid, high] = [a, middle, b].map(|phi| &columns[&phi.to_bits()]);
            let mut worst = 0.0f64;
            for (i, (incidence, reflectance)) in self.incidences_deg.iter().enumerate() {
                let mut sum = 0.0;
                for (k, &theta) in polar.iter().enumerate() {
                    let at = i * polar.len() + k;
                    let bend = (mid[at] - 0.5 * (low[at] + high[at])).abs();
                    let width = 0.5 * (polar[(k + 1).min(polar.len() - 1)] - polar[k.saturating_sub(1)]);
                    sum += bend * projected(*incidence, theta, middle) * width.to_radians();
                }
                worst = worst.max(sum * PARABOLA * (b - a).to_radians() / reflectance);
            }
            Ok(worst)
        })?;
        Ok([polar, around])
    }
}

/// Steps in degrees from which on a source's own nodes hold no lobe that the even ones of a table would miss.
const COARSE_DEG: f64 = 5.0 - 1e-6;

/// Whether a source has no closer nodes than a table of even steps: patches, and spherical grids of wide polar steps.
fn is_coarse(component: &Component) -> bool {
    match &component.table {
        Table::Klems(_) => true,
        Table::Grid(grid) if *grid.parameters() == Parameters::Spherical => {
            let polar = grid.axes()[2].nodes_rad();
            polar
                .windows(2)
                .all(|pair| (pair[1] - pair[0]).to_degrees() >= COARSE_DEG)
        }
        _ => false,
    }
}

/// Values at an angle, worked out once.
fn keep(
    all: &mut BTreeMap<u64, Vec<f64>>,
    angle_deg: f64,
    values: impl FnOnce() -> Result<Vec<f64>, WriteError>,
) -> Result<(), WriteError> {
    if let Entry::Vacant(vacant) = all.entry(angle_deg.to_bits()) {
        vacant.insert(values()?);
    }
    Ok(())
}

fn every_third(nodes: &[f64]) -> Vec<f64> {
    nodes.iter().copied().step_by(3).collect()
}
