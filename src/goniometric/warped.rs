use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::axis::Axis;
use super::direction::{angles_of, direction};
use super::kinds::Placement;
use crate::geometry::Vec3;

/// Values over the half vector, through the warp that samples the visible normals (Dupuy and Jakob 2018, "An adaptive
/// parameterization for efficient material acquisition and rendering"): f cos θ_out.
///
/// An angle's place in the unit square is u(θ) = √(2θ/π), u(φ) = (φ + π)/2π. Slices over the incident direction are
/// interpolated linearly, as are tables within them.
#[derive(Clone, Debug, PartialEq)]
pub struct Warped {
    arrays: Arrays,
    incidence: Axis,
    azimuth: Axis,
    reduction: Reduction,
    warp: Vec<Density>,
}

/// Stored part of the circle of incident azimuths; the rest follows from a symmetry of the material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reduction {
    Whole,
    /// Half: the material is invariant under rotation by 180° about the normal.
    HalfTurn,
    /// A quarter: the material is invariant under reflection at either axis.
    TwoMirrors,
}

/// Values below 0 of directions above the horizon.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Negative {
    pub(crate) count: usize,
    pub(crate) lowest: f32,
    /// Sum of their magnitudes, and of the values above 0.
    pub(crate) sum: f64,
    pub(crate) positive_sum: f64,
}

/// Values in the order of the file; slices in the order φ_i, θ_i.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Arrays {
    pub(crate) isotropic: bool,
    pub(crate) phi_i: Vec<f64>,
    pub(crate) theta_i: Vec<f64>,
    /// Rows (over azimuth) and columns (over polar angle).
    pub(crate) ndf_shape: [usize; 2],
    pub(crate) ndf: Vec<f32>,
    pub(crate) sigma_shape: [usize; 2],
    pub(crate) sigma: Vec<f32>,
    pub(crate) vndf_shape: [usize; 2],
    pub(crate) vndf: Vec<f32>,
    /// Nodes along either side of the square the values are given on.
    pub(crate) size: usize,
    pub(crate) channels: usize,
    pub(crate) values: Vec<f32>,
    /// Whether the instrument saw a node, in the order φ_i, θ_i, y, x; `None` of files without a mask.
    pub(crate) seen: Option<Vec<bool>>,
    pub(crate) jacobian: bool,
}

impl Reduction {
    /// By the range of the azimuths, as Mitsuba 3 has it; and their axis.
    fn of(phi_rad: &[f64]) -> (Self, Axis) {
        let range = phi_rad[phi_rad.len() - 1] - phi_rad[0];
        match (TAU / range).round() as u64 {
            2 => (Self::HalfTurn, Axis::azimuth(phi_rad.to_vec(), PI)),
            4 => (Self::TwoMirrors, Axis::bounded(phi_rad.to_vec())),
            _ => (Self::Whole, Axis::azimuth(phi_rad.to_vec(), TAU)),
        }
    }

    /// Azimuths of incidence and of the half vector in the part that is stored, which begins at `first`.
    fn stored(self, first: f64, [phi_i, phi_m]: [f64; 2]) -> [f64; 2] {
        let beyond = match self {
            Self::Whole => return [phi_i, phi_m],
            Self::HalfTurn | Self::TwoMirrors => (phi_i - first).rem_euclid(PI),
        };
        let within = first + beyond;
        if self == Self::HalfTurn || beyond <= FRAC_PI_2 + 1e-5 {
            // Rotated by a multiple of 180°.
            [within, phi_m + within - phi_i]
        } else {
            // Mirrored at the axis of the first azimuth, and rotated.
            let mirrored = first + PI - beyond;
            [mirrored, mirrored + phi_i - phi_m]
        }
    }
}

/// A density over the unit square, bilinear between nodes and normalised, with its sums.
#[derive(Clone, Debug, PartialEq)]
struct Density {
    values: Vec<f64>,
    /// Of each row, ∫ from its first node to this one.
    along_rows: Vec<f64>,
    /// ∫ over all rows before this one.
    before_rows: Vec<f64>,
}

impl Density {
    fn new(values: &[f32], [rows, columns]: [usize; 2]) -> Option<Self> {
        let mut values: Vec<f64> = values.iter().map(|&v| f64::from(v)).collect();
        let step = [1.0 / (rows - 1) as f64, 1.0 / (columns - 1) as f64];
        let mut along_rows = vec![0.0; rows * columns];
        let mut before_rows = vec![0.0; rows];
        for row in 0..rows {
            for column in 1..columns {
                let at = row * columns + column;
                along_rows[at] = along_rows[at - 1] + 0.5 * step[1] * (values[at - 1] + values[at]);
            }
            if row > 0 {
                let ends = along_rows[row * columns - 1] + along_rows[(row + 1) * columns - 1];
                before_rows[row] = before_rows[row - 1] + 0.5 * step[0] * ends;
            }
        }
        let total = before_rows[rows - 1];
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        for all in [&mut values, &mut along_rows, &mut before_rows] {
            all.iter_mut().for_each(|v| *v /= total);
        }
        Some(Self {
            values,
            along_rows,
            before_rows,
        })
    }
}

/// A place between the nodes of a row or column of n nodes over 0..1: the node below and the share of the next.
fn place(u: f64, n: usize) -> (usize, f64) {
    let x = u.clamp(0.0, 1.0) * (n - 1) as f64;
    let below = (x as usize).min(n - 2);
    (below, x - below as f64)
}

fn bilinear(values: &[f32], [rows, columns]: [usize; 2], [y, x]: [f64; 2]) -> f64 {
    let ((row, ty), (column, tx)) = (place(y, rows), place(x, columns));
    let at = |r: usize, c: usize| f64::from(values[(row + r) * columns + column + c]);
    (1.0 - ty) * ((1.0 - tx) * at(0, 0) + tx * at(0, 1)) + ty * ((1.0 - tx) * at(1, 0) + tx * at(1, 1))
}

fn unit_theta(theta_rad: f64) -> f64 {
    (theta_rad / FRAC_PI_2).max(0.0).sqrt()
}

fn unit_phi(phi_rad: f64) -> f64 {
    (phi_rad + PI) / TAU
}

/// An azimuth in −π..π.
fn signed(phi_rad: f64) -> f64 {
    (phi_rad + PI).rem_euclid(TAU) - PI
}

impl Warped {
    /// Lengths fit and were checked by the reader. The error says what was expected of the values.
    pub(crate) fn new(arrays: Arrays) -> Result<Self, &'static str> {
        let slice = arrays.vndf_shape[0] * arrays.vndf_shape[1];
        let warp: Option<Vec<Density>> = arrays
            .vndf
            .chunks_exact(slice)
            .map(|values| Density::new(values, arrays.vndf_shape))
            .collect();
        if arrays.jacobian && arrays.sigma.iter().any(|&s| s <= 0.0) {
            return Err("values of `sigma` above 0");
        }
        let (reduction, azimuth) = match arrays.isotropic {
            true => (Reduction::Whole, Axis::azimuth(vec![0.0], TAU)),
            false => Reduction::of(&arrays.phi_i),
        };
        Ok(Self {
            warp: warp.ok_or("`vndf` with a total above 0 in each slice")?,
            incidence: Axis::bounded(arrays.theta_i.clone()),
            azimuth,
            reduction,
            arrays,
        })
    }

    /// Whether values do not change under rotation of the sample about its normal.
    pub fn is_isotropic(&self) -> bool {
        self.arrays.isotropic
    }

    /// Axis of the incident polar angle.
    pub fn incidence(&self) -> &Axis {
        &self.incidence
    }

    /// Axis of the incident azimuth.
    pub fn azimuth(&self) -> &Axis {
        &self.azimuth
    }

    /// Nodes along either side of the unit square.
    pub fn size(&self) -> usize {
        self.arrays.size
    }

    /// Whether the warp is the identity and its Jacobian's factor 1, so that values are those at the half vectors
    /// θ = x² π/2, φ = 2π y − π of the nodes.
    pub fn is_unwarped(&self) -> bool {
        let a = &self.arrays;
        a.vndf.iter().all(|&v| v == a.vndf[0]) && a.ndf.iter().zip(&a.sigma).all(|(n, s)| *n == 1.0 && *s == 0.25)
    }

    /// Negative values that are not merely a continuation below the horizon, which smooths what lies above it.
    pub(crate) fn negative_above_horizon(&self) -> Negative {
        let a = &self.arrays;
        let unwarped = self.is_unwarped();
        let square = a.size * a.size;
        let mut found = Negative::default();
        for (index, &value) in a.values.iter().enumerate() {
            if value >= 0.0 {
                found.positive_sum += f64::from(value);
                continue;
            }
            let (slice, node) = (index / (square * a.channels), index % square);
            let theta_i = a.theta_i[slice % a.theta_i.len()];
            let phi_i = a.phi_i[slice / a.theta_i.len()];
            let place = [node / a.size, node % a.size];
            if !unwarped || unwarped_node(theta_i, phi_i, a.isotropic, a.size, place).1.z > 1e-6 {
                found.count += 1;
                found.sum -= f64::from(value);
                found.lowest = found.lowest.min(value);
            }
        }
        found
    }

    /// Whether incident azimuths cover the full circle, as pbrt and powitacq require, or there is only one.
    pub(crate) fn covers_circle(&self) -> bool {
        let phi_i = &self.arrays.phi_i;
        self.arrays.isotropic || phi_i[phi_i.len() - 1] - phi_i[0] > TAU - 1e-3
    }

    /// The symmetry by which azimuths that are not stored follow; `None` where the whole circle is, or one azimuth.
    pub fn symmetry(&self) -> Option<&'static str> {
        match self.reduction {
            Reduction::Whole => None,
            Reduction::HalfTurn => Some("the same after a half turn about the normal"),
            Reduction::TwoMirrors => Some("mirror-symmetric about both axes"),
        }
    }

    /// Polar angles of half vectors in radians at which the warp, the distribution of normals or, without a warp, the
    /// values have their nodes.
    pub(crate) fn polar_nodes(&self) -> Vec<f64> {
        let a = &self.arrays;
        let mut columns = vec![a.vndf_shape[1], a.ndf_shape[1]];
        if self.is_unwarped() {
            columns.push(a.size);
        }
        let nodes = columns
            .into_iter()
            .flat_map(|n| (0..n).map(move |k| k as f64 / (n - 1) as f64));
        nodes.map(|x| x * x * FRAC_PI_2).collect()
    }

    pub(crate) fn incidences_rad(&self) -> Vec<f64> {
        self.arrays.theta_i.clone()
    }

    /// The slices around a direction of incidence with their weights, and whether it is one of the file's.
    fn slices(&self, theta_i: f64, phi_i: f64) -> Option<([(usize, f64); 4], bool)> {
        let theta = self.incidence.locate(theta_i)?;
        let phi = self
            .azimuth
            .locate(signed(phi_i))
            .or_else(|| self.azimuth.locate(phi_i))?;
        let thetas = self.arrays.theta_i.len();
        let corner = |p: usize, wp: f64, t: usize, wt: f64| (p * thetas + t, wp * wt);
        let slices = [
            corner(phi.below, 1.0 - phi.t, theta.below, 1.0 - theta.t),
            corner(phi.below, 1.0 - phi.t, theta.above, theta.t),
            corner(phi.above, phi.t, theta.below, 1.0 - theta.t),
            corner(phi.above, phi.t, theta.above, theta.t),
        ];
        Some((slices, theta.on_node && phi.on_node))
    }

    pub(crate) fn eval(&self, omega_in: &Vec3, omega_out: &Vec3) -> Option<(Vec<f64>, Placement)> {
        let [incident, half] = half_angles(omega_in, omega_out)?;
        self.at(incident, half)
    }

    /// As [`super::Grid::add_turned`].
    pub(crate) fn add_turned(
        &self,
        omega_in: &Vec3,
        omega_out: &Vec3,
        turns_rad: &mut Vec<f64>,
        weight: f64,
        sums: &mut [f64],
    ) {
        let Some([incident, half]) = half_angles(omega_in, omega_out) else {
            return;
        };
        turns_rad.retain(|turn| {
            let turned = |(theta, phi): (f64, f64)| (theta, (phi + turn).rem_euclid(TAU));
            let Some((values, _)) = self.at(turned(incident), turned(half)) else {
                return true;
            };
            sums.iter_mut()
                .zip(values)
                .for_each(|(sum, value)| *sum += weight * value);
            false
        });
    }

    /// Values at polar angles and azimuths of the direction to the light and of the half vector.
    fn at(&self, (theta_i, phi_i): (f64, f64), (theta_m, phi_m): (f64, f64)) -> Option<(Vec<f64>, Placement)> {
        let a = &self.arrays;
        let [phi_i, phi_m] = self.reduction.stored(a.phi_i[0], [phi_i, phi_m]);
        let (slices, on_slice) = self.slices(theta_i, phi_i)?;
        let x = unit_theta(theta_m);
        let y = if a.isotropic {
            unit_phi(signed(phi_m - phi_i)).rem_euclid(1.0)
        } else {
            unit_phi(signed(phi_m))
        };
        let s = self.inverse_warp(&slices, y, x);
        let ((row, ty), (column, tx)) = (place(s[0], a.size), place(s[1], a.size));
        let mut values = vec![0.0; a.channels];
        let mut filled_in = false;
        for &(slice, weight) in slices.iter().filter(|(_, weight)| *weight != 0.0) {
            if let Some(seen) = &a.seen {
                let corners = [(0, 0), (0, 1), (1, 0), (1, 1)];
                let weights = [(1.0 - ty) * (1.0 - tx), (1.0 - ty) * tx, ty * (1.0 - tx), ty * tx];
                let node = |(r, c): (usize, usize)| (slice * a.size + row + r) * a.size + column + c;
                // Less is what rounding lends a node.
                let used = |share: f64| weight * share > 1e-6;
                filled_in |= std::iter::zip(corners, weights).any(|(at, share)| used(share) && !seen[node(at)]);
            }
            for (channel, value) in values.iter_mut().enumerate() {
                let table = (slice * a.channels + channel) * a.size * a.size + row * a.size + column;
                let at = |r: usize, c: usize| f64::from(a.values[table + r * a.size + c]);
                let lower = (1.0 - tx) * at(0, 0) + tx * at(0, 1);
                let upper = (1.0 - tx) * at(1, 0) + tx * at(1, 1);
                *value += weight * ((1.0 - ty) * lower + ty * upper);
            }
        }
        if a.jacobian {
            let ndf = bilinear(&a.ndf, a.ndf_shape, [y, x]);
            let incident = [unit_phi(signed(phi_i)), unit_theta(theta_i)];
            let factor = ndf / (4.0 * bilinear(&a.sigma, a.sigma_shape, incident));
            values.iter_mut().for_each(|v| *v *= factor);
        }
        values.iter_mut().for_each(|v| *v = v.max(0.0));
        let near = |t: f64| t.min(1.0 - t) < 1e-4;
        let placement = if filled_in {
            Placement::FilledIn
        } else if on_slice && near(tx) && near(ty) {
            Placement::OnNode
        } else {
            Placement::Interpolated
        };
        Some((values, placement))
    }

    /// Inverse warp of the half vector's position in the unit square: marginal over rows, then conditional along
    /// columns, of the interpolated density.
    fn inverse_warp(&self, slices: &[(usize, f64); 4], y: f64, x: f64) -> [f64; 2] {
        let [rows, columns] = self.arrays.vndf_shape;
        let ((row, ty), (column, tx)) = (place(y, rows), place(x, columns));
        let step = [1.0 / (rows - 1) as f64, 1.0 / (columns - 1) as f64];
        let blend = |part: fn(&Density) -> &[f64], at: usize| -> f64 {
            slices
                .iter()
                .map(|&(slice, weight)| weight * part(&self.warp[slice])[at])
                .sum()
        };
        let density = |r: usize, c: usize| blend(|d| &d.values, r * columns + c);
        let along = |r: usize, c: usize| blend(|d| &d.along_rows, r * columns + c);
        let full = [along(row, columns - 1), along(row + 1, columns - 1)];
        let marginal = blend(|d| &d.before_rows, row) + step[0] * ty * (full[0] + 0.5 * ty * (full[1] - full[0]));
        let up_to_x = |r: usize| {
            let (low, high) = (density(r, column), density(r, column + 1));
            along(r, column) + step[1] * tx * (low + 0.5 * tx * (high - low))
        };
        let whole_row = (1.0 - ty) * full[0] + ty * full[1];
        let part = (1.0 - ty) * up_to_x(row) + ty * up_to_x(row + 1);
        [marginal, if whole_row > 0.0 { part / whole_row } else { 0.0 }]
    }
}

/// Polar angles and azimuths of the direction to the light and of the half vector; `None` where there is none.
fn half_angles(omega_in: &Vec3, omega_out: &Vec3) -> Option<[(f64, f64); 2]> {
    let half = omega_in + omega_out;
    (half.norm_squared() >= 1e-24).then(|| [angles_of(omega_in), angles_of(&half)])
}

/// Directions to light and viewer of a node of an unwarped square of n × n nodes, row y and column x; the viewer's may
/// be below the horizon.
pub(crate) fn unwarped_node(theta_i: f64, phi_i: f64, isotropic: bool, n: usize, [y, x]: [usize; 2]) -> (Vec3, Vec3) {
    let unit = |node: usize| node as f64 / (n - 1) as f64;
    let theta_m = unit(x) * unit(x) * FRAC_PI_2;
    let phi_m = unit(y) * TAU - PI + if isotropic { phi_i } else { 0.0 };
    let omega_in = direction(theta_i, phi_i);
    let half = direction(theta_m, phi_m);
    (omega_in, half * (2.0 * half.dot(&omega_in)) - omega_in)
}
