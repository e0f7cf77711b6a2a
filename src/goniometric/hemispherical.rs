//! Directional-hemispherical values: ∫ f cos θ_out dω_out, adaptively in the parameters a table is stored in.
//!
//! The hemisphere is cut at the table's own nodes and at the horizon, so that the integrand is smooth on every cell and
//! no lobe that the table resolves is missed. A cell is integrated by the tensor rules of Gauss and Legendre of 3 and
//! of 2 points a side; the difference is the estimate of its error, far above the error of the 3-point rule that is
//! kept. The cell of the largest error is cut in four until the errors add up to [`TOLERANCE`]. Klems patches and the
//! leaves of tensor trees are constant, and their sum is exact.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::PI;

use super::chart::{Chart, GAUSS_3};
use super::data::{Component, Table};
use super::direction::direction;
use super::kinds::Quantity;
use super::parameters::about_z;
use crate::geometry::Vec3;

/// Estimated error, relative to the largest channel's value, at which refinement stops.
const TOLERANCE: f64 = 3e-5;
/// Largest number of cells; the remaining error is reported.
const MOST_CELLS: usize = 20_000;
/// Nodes and weights over 0..1.
const GAUSS_2: [(f64, f64); 2] = [(0.211_324_865_405_187_1, 0.5), (0.788_675_134_594_812_9, 0.5)];
/// Directional-hemispherical value ∫ f cos θ_out dω_out for light from one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Hemispherical {
    /// One a channel.
    pub values: Vec<f64>,
    /// Estimated errors of the integration, one a channel; 0 where it is exact.
    pub errors: Vec<f64>,
    /// Fraction of the projected hemisphere that was measured; the rest counts as 0.
    pub measured: f64,
}

#[derive(Clone)]
struct Cell {
    polar: [f64; 2],
    around: [f64; 2],
    sums: Vec<f64>,
    errors: Vec<f64>,
    measured: f64,
    worst: f64,
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Cell {}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Ordered by error, ties by position, so that the order is deterministic.
impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        let place = |c: &Self| [c.polar[0], c.around[0]];
        let places = place(self).into_iter().zip(place(other));
        self.worst
            .total_cmp(&other.worst)
            .then_with(|| places.fold(Ordering::Equal, |order, (a, b)| order.then(a.total_cmp(&b))))
    }
}

struct Integral<'a> {
    component: &'a Component,
    omega_in: Vec3,
    chart: Chart,
}

impl Integral<'_> {
    /// Visits the points of a cell's rule: direction, cos θ dω, and f cos θ dω a channel where there is a value.
    fn points(&self, cell: [[f64; 2]; 2], rule: &[(f64, f64)], mut visit: impl FnMut(&Vec3, f64, &[f64])) {
        let [polar, around] = cell;
        for (u, weight_u) in rule {
            let phi = around[0] + u * (around[1] - around[0]);
            let above = polar[1].min(self.chart.parameters.horizon(phi));
            if above <= polar[0] {
                continue;
            }
            let weight = weight_u * (around[1] - around[0]) * (above - polar[0]);
            for (v, weight_v) in rule {
                let (out, solid_angle) = self.chart.parameters.at(polar[0] + v * (above - polar[0]), phi);
                let out = about_z(&out, self.chart.turn);
                let projected = weight * weight_v * solid_angle * out.z.max(0.0);
                if out.z <= 0.0 {
                    continue;
                }
                let Some((mut values, _)) = self.component.table.eval(&self.omega_in, &out) else {
                    continue;
                };
                // Values that include the cosine are used as they are.
                let factor = match self.component.quantity {
                    Quantity::BsdfCosine => projected / out.z,
                    Quantity::BrightnessFactor => projected / PI,
                    Quantity::Bsdf | Quantity::Fraction | Quantity::Unscaled => projected,
                };
                values.iter_mut().for_each(|v| *v *= factor);
                visit(&out, projected, &values);
            }
        }
    }

    fn cell(&self, polar: [f64; 2], around: [f64; 2]) -> Cell {
        let channels = self.component.channels.count();
        let (mut sums, mut rough, mut measured) = (vec![0.0; channels], vec![0.0; channels], 0.0);
        self.points([polar, around], &GAUSS_3, |_, projected, values| {
            measured += projected;
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        });
        self.points([polar, around], &GAUSS_2, |_, _, values| {
            rough.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        });
        let errors: Vec<f64> = sums.iter().zip(&rough).map(|(a, b)| (a - b).abs()).collect();
        let worst = errors.iter().copied().fold(0.0, f64::max);
        Cell {
            polar,
            around,
            sums,
            errors,
            measured,
            worst,
        }
    }

    /// Refines until the errors of the cells sum to the tolerance, or the largest number of cells is reached.
    fn cells(&self) -> Vec<Cell> {
        let mut heap = BinaryHeap::new();
        for polar in self.chart.polar.windows(2) {
            for around in self.chart.around.windows(2) {
                heap.push(self.cell([polar[0], polar[1]], [around[0], around[1]]));
            }
        }
        let most_of = |cell: &Cell| cell.sums.iter().copied().fold(0.0, f64::max);
        let mut total: f64 = heap.iter().map(most_of).sum();
        let mut error: f64 = heap.iter().map(|cell| cell.worst).sum();
        while error > TOLERANCE * total && heap.len() < MOST_CELLS {
            let Some(worst) = heap.pop() else { break };
            total -= most_of(&worst);
            error -= worst.worst;
            let halves = |[a, b]: [f64; 2]| [[a, 0.5 * (a + b)], [0.5 * (a + b), b]];
            for polar in halves(worst.polar) {
                for around in halves(worst.around) {
                    let part = self.cell(polar, around);
                    total += most_of(&part);
                    error += part.worst;
                    heap.push(part);
                }
            }
        }
        heap.into_sorted_vec()
    }
}

impl Component {
    /// ∫ f cos θ_out dω_out per channel for light from a polar angle and azimuth in radians. `None` where nothing was
    /// measured over solid angle, or where the quantity has no f.
    pub fn directional_hemispherical(&self, theta_i_rad: f64, phi_i_rad: f64) -> Option<Hemispherical> {
        if matches!(self.quantity, Quantity::Fraction | Quantity::Unscaled) {
            return None;
        }
        self.integrated(theta_i_rad, phi_i_rad)
    }

    /// As [`Self::directional_hemispherical`], of whatever the values are a multiple of.
    pub(crate) fn integrated(&self, theta_i_rad: f64, phi_i_rad: f64) -> Option<Hemispherical> {
        let omega_in = direction(theta_i_rad, phi_i_rad);
        let exact = |values: Vec<f64>| Hemispherical {
            errors: vec![0.0; values.len()],
            values,
            measured: 1.0,
        };
        match &self.table {
            Table::Klems(matrix) => return Some(exact(matrix.hemispherical(&omega_in))),
            Table::Tree(tree) => return Some(exact(tree.hemispherical(&omega_in))),
            _ => {}
        }
        let integral = self.integral(theta_i_rad, phi_i_rad)?;
        self.summed(&integral.cells())
    }

    /// [`Self::integrated`] of the cells of an integral.
    fn summed(&self, cells: &[Cell]) -> Option<Hemispherical> {
        let mut sums = Hemispherical {
            values: vec![0.0; self.channels.count()],
            errors: vec![0.0; self.channels.count()],
            measured: 0.0,
        };
        for cell in cells {
            sums.measured += cell.measured;
            sums.values.iter_mut().zip(&cell.sums).for_each(|(sum, v)| *sum += v);
            sums.errors.iter_mut().zip(&cell.errors).for_each(|(sum, e)| *sum += e);
        }
        // The same rule integrates the projected hemisphere, with an error far below any gap of a table. The ratio of
        // the integrals is exact for constant f.
        sums.measured /= PI;
        if (sums.measured - 1.0).abs() < 1e-4 {
            sums.values.iter_mut().for_each(|v| *v /= sums.measured);
            sums.measured = 1.0;
        }
        (sums.measured > 0.0).then_some(sums)
    }

    fn integral(&self, theta_i: f64, phi_i: f64) -> Option<Integral<'_>> {
        Some(Integral {
            component: self,
            omega_in: direction(theta_i, phi_i),
            chart: Chart::of(&self.table, theta_i, phi_i)?,
        })
    }

    /// Integral over the hemisphere of outgoing directions (upright), with light from above. It has no points for
    /// tables that are constant on cells, or if nothing was measured.
    pub(crate) fn hemisphere(&self, theta_i: f64, phi_i: f64) -> Hemisphere {
        let mut points = Vec::new();
        let total = match self.integral(theta_i, phi_i) {
            Some(integral) => {
                let cells = integral.cells();
                for cell in &cells {
                    integral.points([cell.polar, cell.around], &GAUSS_3, |out, projected, values| {
                        points.push((*out, projected, values.to_vec()));
                    });
                }
                self.summed(&cells)
            }
            None => self.directional_hemispherical(theta_i, phi_i),
        };
        Hemisphere { points, total }
    }
}

/// Quadrature points over the hemisphere of outgoing directions, and the integral.
pub(crate) struct Hemisphere {
    /// Direction, cos θ dω, and f cos θ dω per channel.
    points: Vec<(Vec3, f64, Vec<f64>)>,
    /// As [`Component::directional_hemispherical`]; equals the sums of the points to its error.
    total: Option<Hemispherical>,
}

impl Hemisphere {
    pub(crate) fn total(&self) -> Option<&Hemispherical> {
        self.total.as_ref()
    }

    /// Visits the points rotated about the normal by `turn_rad`: direction, cos θ dω, and f cos θ dω per channel.
    pub(crate) fn visit(&self, turn_rad: f64, mut visit: impl FnMut(&Vec3, f64, &[f64])) {
        for (out, projected, values) in &self.points {
            visit(&about_z(out, turn_rad), *projected, values);
        }
    }
}
