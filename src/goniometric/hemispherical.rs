//! Directional-hemispherical values: ∫ f cos θ_out dω_out, adaptively in the parameters a table is stored in.
//!
//! The hemisphere is cut at the table's own nodes and at the horizon, so that the integrand is smooth on every cell and
//! no lobe that the table resolves is missed. A cell is integrated by the tensor rules of Gauss and Legendre of 3 and
//! of 2 points a side; the difference is the estimate of its error, far above the error of the 3-point rule that is
//! kept. The cell of the largest error is cut in four until the errors add up to [`TOLERANCE`]. Klems patches and the
//! leaves of tensor trees are constant, and their sum is exact.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::data::{Component, Table};
use super::direction::direction;
use super::grid::Grid;
use super::kinds::Quantity;
use super::parameters::{Parameters, about_z, from_distorted, from_specular};
use super::scattered::{Directions, Scattered};
use super::warped::Warped;
use crate::geometry::Vec3;

/// Estimated error, relative to the largest channel's value, at which refinement stops.
const TOLERANCE: f64 = 3e-5;
/// Largest number of cells; the remaining error is reported.
const MOST_CELLS: usize = 20_000;
/// Widest cell about the axis, in radians.
const WIDEST: f64 = PI / 12.0;
/// Most nodes of scattered readings along an angle that cells are cut at.
const MOST_NODES: usize = 360;

/// Nodes and weights over 0..1.
const GAUSS_2: [(f64, f64); 2] = [(0.211_324_865_405_187_1, 0.5), (0.788_675_134_594_812_9, 0.5)];
const GAUSS_3: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 5.0 / 18.0),
    (0.5, 4.0 / 9.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

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

/// Parametrisation of the outgoing direction by two numbers.
#[derive(Clone, Copy)]
enum Parametrisation {
    /// Polar angle and azimuth.
    Sphere,
    /// Angle from a direction tilted away from the light, and azimuth about it.
    Mirror { tilt: f64 },
    /// As [`Parameters::Distorted`].
    Distorted { tilt: f64 },
    /// Polar angle and azimuth of the half vector, of light at this polar angle.
    Half { theta_i: f64 },
}

impl Parametrisation {
    fn farthest(self) -> f64 {
        match self {
            Self::Mirror { .. } => PI,
            Self::Sphere | Self::Distorted { .. } | Self::Half { .. } => FRAC_PI_2,
        }
    }

    /// The first number at which the direction is on the horizon.
    fn horizon(self, around: f64) -> f64 {
        match self {
            Self::Sphere | Self::Distorted { .. } => FRAC_PI_2,
            // cos θ_out = cos(tilt) cos θ + sin(tilt) cos(φ) sin θ.
            Self::Mirror { tilt } => tilt.cos().atan2(-tilt.sin() * around.cos()).max(0.0),
            // cos θ_out is proportional to cos(2 θ_h − α).
            Self::Half { theta_i } => {
                let alpha = (theta_i.sin() * around.cos()).atan2(theta_i.cos());
                (FRAC_PI_2 + alpha).max(0.0) / 2.0
            }
        }
    }

    /// The direction, light being at azimuth 0, and the solid angle of a unit of both numbers.
    fn at(self, polar: f64, around: f64) -> (Vec3, f64) {
        match self {
            Self::Sphere => (direction(polar, around), polar.sin()),
            Self::Mirror { tilt } => (from_specular(polar, around, tilt), polar.sin()),
            Self::Distorted { tilt } => {
                let out = from_distorted(polar, around, tilt);
                // Of the disc r = 2θ/π: area over r and azimuth, and solid angle over area.
                let r = polar / FRAC_PI_2;
                let area = r * (1.0 + tilt / FRAC_PI_2 * around.cos());
                let theta = out.z.clamp(-1.0, 1.0).acos();
                let sinc = if theta > 1e-6 { theta.sin() / theta } else { 1.0 };
                (out, area * sinc * FRAC_PI_2)
            }
            Self::Half { theta_i } => {
                let half = direction(polar, around);
                let omega_in = direction(theta_i, 0.0);
                let cos = half.dot(&omega_in);
                (half * (2.0 * cos) - omega_in, 4.0 * cos.max(0.0) * polar.sin())
            }
        }
    }
}

/// A chart with its cells' limits.
struct Cut {
    chart: Parametrisation,
    /// Azimuth that the second number counts from.
    turn: f64,
    polar: Vec<f64>,
    around: Vec<f64>,
}

impl Cut {
    /// Nodes may be in any order. Azimuths may have any value and are measured from `turn`.
    fn new(chart: Parametrisation, turn: f64, polar_nodes: &[f64], azimuth_nodes: &[f64]) -> Self {
        let last = chart.farthest();
        let inside = polar_nodes.iter().copied().filter(|a| *a > 1e-9 && *a < last - 1e-9);
        let mut polar: Vec<f64> = inside.chain([0.0, last]).collect();
        sort(&mut polar);
        let mut around: Vec<f64> = azimuth_nodes.iter().map(|a| a.rem_euclid(TAU)).collect();
        around.extend([0.0, TAU]);
        sort(&mut around);
        Self {
            chart,
            turn,
            polar: filled(&polar),
            around: filled(&around),
        }
    }
}

fn sort(limits: &mut Vec<f64>) {
    limits.sort_by(f64::total_cmp);
    limits.dedup_by(|a, b| *a - *b < 1e-9);
}

/// Adds uniform cuts where limits are farther apart than [`WIDEST`].
fn filled(limits: &[f64]) -> Vec<f64> {
    let mut all = vec![limits[0]];
    for pair in limits.windows(2) {
        let parts = ((pair[1] - pair[0]) / WIDEST - 1e-9).ceil().max(1.0) as usize;
        all.extend((1..=parts).map(|k| pair[0] + (pair[1] - pair[0]) * k as f64 / parts as f64));
    }
    all
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
    cut: Cut,
}

impl Integral<'_> {
    /// Visits the points of a cell's rule: direction, cos θ dω, and f cos θ dω a channel where there is a value.
    fn points(&self, cell: [[f64; 2]; 2], rule: &[(f64, f64)], mut visit: impl FnMut(&Vec3, f64, &[f64])) {
        let [polar, around] = cell;
        for (u, weight_u) in rule {
            let phi = around[0] + u * (around[1] - around[0]);
            let above = polar[1].min(self.cut.chart.horizon(phi));
            if above <= polar[0] {
                continue;
            }
            let weight = weight_u * (around[1] - around[0]) * (above - polar[0]);
            for (v, weight_v) in rule {
                let (out, solid_angle) = self.cut.chart.at(polar[0] + v * (above - polar[0]), phi);
                let out = about_z(&out, self.cut.turn);
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
        for polar in self.cut.polar.windows(2) {
            for around in self.cut.around.windows(2) {
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
        let cut = match &self.table {
            Table::Grid(grid) => of_grid(grid, theta_i, phi_i)?,
            Table::Scattered(scattered) => of_scattered(scattered, theta_i, phi_i)?,
            Table::Warped(warped) => of_warped(warped, theta_i, phi_i),
            Table::Klems(_) | Table::Tree(_) | Table::Specular(_) => return None,
        };
        Some(Integral {
            component: self,
            omega_in: direction(theta_i, phi_i),
            cut,
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

fn of_grid(grid: &Grid, theta_i: f64, phi_i: f64) -> Option<Cut> {
    let [first, _, third, last] = grid.axes().each_ref().map(|axis| axis.nodes_rad());
    let azimuths: Vec<f64> = if grid.axes()[3].is_single() {
        Vec::new()
    } else {
        last.iter().flat_map(|&phi| grid.fold().images(phi)).collect()
    };
    Some(match grid.parameters() {
        Parameters::Spherical => {
            let turn = if grid.is_isotropic() { phi_i } else { 0.0 };
            Cut::new(Parametrisation::Sphere, turn, third, &azimuths)
        }
        Parameters::Specular { offsets_rad } => {
            let tilt = theta_i + grid.offset(offsets_rad, theta_i)?;
            Cut::new(Parametrisation::Mirror { tilt }, phi_i, third, &azimuths)
        }
        Parameters::Distorted { offsets_rad } => {
            let tilt = theta_i + grid.offset(offsets_rad, theta_i)?;
            Cut::new(Parametrisation::Distorted { tilt }, phi_i, third, &azimuths)
        }
        Parameters::HalfDifference => Cut::new(Parametrisation::Half { theta_i }, phi_i, first, &[]),
    })
}

fn of_scattered(scattered: &Scattered, theta_i: f64, phi_i: f64) -> Option<Cut> {
    if scattered.directions() == Directions::Plane {
        return None;
    }
    let (polar, azimuths) = scattered.outgoing_nodes(theta_i, phi_i)?;
    let few = |nodes: Vec<f64>| if nodes.len() > MOST_NODES { Vec::new() } else { nodes };
    Some(Cut::new(Parametrisation::Sphere, 0.0, &few(polar), &few(azimuths)))
}

fn of_warped(warped: &Warped, theta_i: f64, phi_i: f64) -> Cut {
    Cut::new(Parametrisation::Half { theta_i }, phi_i, &warped.polar_nodes(), &[])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every chart covers the hemisphere: ∫ cos θ dω = π. The nodes are close, so that cells need not be halved,
    /// those over azimuth the most, because the horizon of a tilted chart has kinks there.
    #[test]
    fn charts_cover_the_hemisphere() {
        let polar: Vec<f64> = (1..16).map(|i| 0.1 * f64::from(i)).collect();
        let azimuths: Vec<f64> = (1..629).map(|i| 0.01 * f64::from(i)).collect();
        for chart in [
            Parametrisation::Sphere,
            Parametrisation::Mirror { tilt: 0.0 },
            Parametrisation::Mirror { tilt: 0.7 },
            Parametrisation::Mirror { tilt: FRAC_PI_2 },
            Parametrisation::Distorted { tilt: 0.9 },
            Parametrisation::Half { theta_i: 0.0 },
            Parametrisation::Half { theta_i: 1.2 },
        ] {
            let cut = Cut::new(chart, 0.3, &polar, &azimuths);
            let mut sum = 0.0;
            for around in cut.around.windows(2) {
                for polar in cut.polar.windows(2) {
                    for (u, weight_u) in GAUSS_3 {
                        let phi = around[0] + u * (around[1] - around[0]);
                        let high = polar[1].min(chart.horizon(phi)).max(polar[0]);
                        for (v, weight_v) in GAUSS_3 {
                            let (out, solid_angle) = chart.at(polar[0] + v * (high - polar[0]), phi);
                            let area = (around[1] - around[0]) * (high - polar[0]);
                            sum += weight_u * weight_v * area * solid_angle * out.z;
                        }
                    }
                }
            }
            assert!((sum / PI - 1.0).abs() < 2e-4, "{sum}");
        }
    }
}
