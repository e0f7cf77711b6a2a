mod circle;

use std::f64::consts::TAU;

use super::axis::{Axis, Between};
use super::direction::{angles_of, direction, every_tenth_degree};
use super::kinds::Placement;
use super::parameters::{
    Fold, Parameters, about_y, about_z, distorted_angles, from_distorted, from_specular, half_difference_angles,
    specular_angles,
};
use crate::geometry::Vec3;

/// Values over a rectangular grid of four angles, linear between the nodes. NaN marks nodes without data; they take
/// no part in interpolation.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    parameters: Parameters,
    axes: [Axis; 4],
    fold: Fold,
    channels: usize,
    /// Steps in `values` of each axis and of the channel.
    strides: [usize; 5],
    values: Vec<f64>,
    has_holes: bool,
}

/// Nodes around a point, by their offset in the values, and their weights, all above 0.
#[derive(Clone, Copy)]
struct Corners {
    nodes: [(usize, f64); 16],
    count: usize,
}

impl Default for Corners {
    /// The weights of zero axes: a single node of weight 1.
    fn default() -> Self {
        let mut nodes = [(0, 0.0); 16];
        nodes[0] = (0, 1.0);
        Self { nodes, count: 1 }
    }
}

impl Corners {
    /// Adds one of the four axes.
    fn between(&mut self, between: &Between, stride: usize) {
        let below = self.count;
        for index in 0..below {
            let (at, share) = self.nodes[index];
            if between.t > 0.0 {
                self.nodes[self.count] = (at + stride * between.above, share * between.t);
                self.count += 1;
            }
            self.nodes[index] = (at + stride * between.below, share * (1.0 - between.t));
        }
    }
}

impl Grid {
    /// Axes and channels from the slowest in `values` to the fastest, the channel being 4. Lengths must fit, and were
    /// checked by the reader.
    pub(crate) fn new(
        parameters: Parameters,
        axes: [Axis; 4],
        fold: Fold,
        channels: usize,
        slowest_to_fastest: [usize; 5],
        values: Vec<f64>,
    ) -> Self {
        let length = |axis: usize| axes.get(axis).map_or(channels, |a| a.nodes_rad().len());
        let mut strides = [0; 5];
        let mut step = 1;
        for &axis in slowest_to_fastest.iter().rev() {
            strides[axis] = step;
            step *= length(axis);
        }
        debug_assert_eq!(step, values.len());
        let has_holes = values.iter().any(|v| v.is_nan());
        Self {
            parameters,
            axes,
            fold,
            channels,
            strides,
            values,
            has_holes,
        }
    }

    /// Parametrisation of the four angles.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The four axes, in the order of the parameters.
    pub fn axes(&self) -> &[Axis; 4] {
        &self.axes
    }

    /// Symmetry of the last azimuth.
    pub fn fold(&self) -> Fold {
        self.fold
    }

    /// Whether a single incident (or half vector's) azimuth is stored.
    pub fn is_isotropic(&self) -> bool {
        self.axes[1].is_single()
    }

    /// Value at a node, by the index on each axis; NaN where there are no data.
    pub fn at(&self, node: [usize; 4], channel: usize) -> f64 {
        let axes = node
            .iter()
            .zip(&self.strides)
            .map(|(i, stride)| i * stride)
            .sum::<usize>();
        self.values[axes + channel * self.strides[4]]
    }

    pub(crate) fn channels(&self) -> usize {
        self.channels
    }

    pub(crate) fn set(&mut self, node: [usize; 4], channel: usize, value: f64) {
        let axes: usize = node.iter().zip(&self.strides).map(|(i, stride)| i * stride).sum();
        self.values[axes + channel * self.strides[4]] = value;
    }

    /// The node of the last axis at an angle in radians, if there is one.
    pub(crate) fn last_node(&self, angle_rad: f64) -> Option<usize> {
        let angle = self.fold.apply(angle_rad.rem_euclid(TAU));
        let between = self.axes[3].locate(angle).filter(|between| between.on_node)?;
        Some(if between.t < 0.5 { between.below } else { between.above })
    }

    pub(crate) fn scale(&mut self, node: [usize; 2], channel: usize, by: f64) {
        let [_, _, n2, n3] = self.shape();
        for (i2, i3) in (0..n2).flat_map(|i2| (0..n3).map(move |i3| (i2, i3))) {
            let node = [node[0], node[1], i2, i3];
            self.set(node, channel, by * self.at(node, channel));
        }
    }

    /// The same nodes with other channels, as many as the map gives; `None` where some nodes have no data.
    pub(crate) fn with_channels(&self, channels: usize, map: impl Fn(&[f64]) -> Vec<f64>) -> Option<Self> {
        if self.has_holes {
            return None;
        }
        let [n0, n1, n2, n3] = self.shape();
        let mut values = Vec::with_capacity(n0 * n1 * n2 * n3 * channels);
        for i in 0..n0 * n1 * n2 * n3 {
            let node = [i / (n3 * n2 * n1), i / (n3 * n2) % n1, i / n3 % n2, i % n3];
            let all: Vec<f64> = (0..self.channels).map(|channel| self.at(node, channel)).collect();
            values.extend(map(&all));
        }
        let (parameters, axes) = (self.parameters.clone(), self.axes.clone());
        Some(Self::new(
            parameters,
            axes,
            self.fold,
            channels,
            [0, 1, 2, 3, 4],
            values,
        ))
    }

    /// Whether some nodes have no data.
    pub fn has_holes(&self) -> bool {
        self.has_holes
    }

    /// Number of nodes on each axis.
    pub fn shape(&self) -> [usize; 4] {
        std::array::from_fn(|axis| self.axes[axis].nodes_rad().len())
    }

    pub(crate) fn incidences_rad(&self) -> Vec<f64> {
        match self.parameters {
            Parameters::HalfDifference => every_tenth_degree(),
            _ => self.axes[0].nodes_rad().to_vec(),
        }
    }

    pub(crate) fn eval(&self, omega_in: &Vec3, omega_out: &Vec3) -> Option<(Vec<f64>, Placement)> {
        let mut angles = self.angles(omega_in, omega_out)?;
        angles[3] = self.fold.apply(angles[3]);
        let mut around = [Between::default(); 4];
        for (axis, slot) in around.iter_mut().enumerate() {
            *slot = self.axes[axis].locate(angles[axis])?;
        }
        // At a pole the azimuth is undefined.
        let pole =
            |polar: usize, azimuth: usize| angles[polar] < 1e-5 && around[polar].on_node && !around[azimuth].on_node;
        let mut on_node = around.iter().all(|b| b.on_node);
        if !on_node && (pole(0, 1) || pole(2, 3)) {
            let skip = |axis: usize| (axis == 1 && pole(0, 1)) || (axis == 3 && pole(2, 3));
            on_node = (0..4).all(|axis| around[axis].on_node || skip(axis));
        }
        let mut corners = Corners::default();
        for (axis, between) in around.iter().enumerate() {
            corners.between(between, self.strides[axis]);
        }
        let mut values = vec![0.0; self.channels];
        if !self.blend(&corners, 1.0, &mut values) {
            return None;
        }
        let placement = if on_node {
            Placement::OnNode
        } else {
            Placement::Interpolated
        };
        Some((values, placement))
    }

    /// Adds `weight` times the values of the pair rotated about the normal by each of the angles, radians, and removes
    /// from the list the angles that have values.
    pub(crate) fn add_turned(
        &self,
        omega_in: &Vec3,
        omega_out: &Vec3,
        turns_rad: &mut Vec<f64>,
        weight: f64,
        sums: &mut [f64],
    ) {
        let Some(angles) = self.angles(omega_in, omega_out) else {
            return;
        };
        // Azimuths measured from x rotate with the pair.
        let turning = |axis: usize| axis == 1 || (axis == 3 && self.parameters == Parameters::Spherical);
        let mut fixed = Corners::default();
        for axis in (0..4).filter(|&axis| !turning(axis)) {
            let angle = if axis == 3 {
                self.fold.apply(angles[3])
            } else {
                angles[axis]
            };
            let Some(between) = self.axes[axis].locate(angle) else {
                return;
            };
            fixed.between(&between, self.strides[axis]);
        }
        turns_rad.retain(|turn| {
            // In an isotropic table the outgoing azimuth is measured from the incident one.
            let turn = if self.is_isotropic() { 0.0 } else { *turn };
            let mut corners = fixed;
            for axis in (0..4).filter(|&axis| turning(axis)) {
                let angle = angles[axis] + turn;
                let angle = if angle < TAU { angle } else { angle - TAU };
                let angle = if axis == 3 { self.fold.apply(angle) } else { angle };
                let Some(between) = self.axes[axis].locate(angle) else {
                    return true;
                };
                corners.between(&between, self.strides[axis]);
            }
            !self.blend(&corners, weight, sums)
        });
    }

    /// Adds `weight` times the multilinear value; over nodes that have data. False where none has.
    fn blend(&self, corners: &Corners, weight: f64, sums: &mut [f64]) -> bool {
        let all = &corners.nodes[..corners.count];
        let has_data = |at: usize| !self.has_holes || !self.values[at].is_nan();
        let mut weight = weight;
        if self.has_holes {
            let total: f64 = all.iter().filter(|(at, _)| has_data(*at)).map(|(_, share)| share).sum();
            weight /= total;
            if total == 0.0 {
                return false;
            }
        }
        for &(at, share) in all.iter().filter(|(at, _)| has_data(*at)) {
            let values = self.values[at..].iter().step_by(self.strides[4]);
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += weight * share * value;
            }
        }
        true
    }

    /// The file's four angles of a pair of directions, the last not folded.
    fn angles(&self, omega_in: &Vec3, omega_out: &Vec3) -> Option<[f64; 4]> {
        let (theta_i, phi_i) = angles_of(omega_in);
        let angles = match &self.parameters {
            Parameters::Spherical => {
                let (theta_o, phi_o) = angles_of(omega_out);
                let turned = if self.is_isotropic() { phi_o - phi_i } else { phi_o };
                [theta_i, phi_i, theta_o, turned.rem_euclid(TAU)]
            }
            Parameters::Specular { offsets_rad } => {
                let tilt = theta_i + self.offset(offsets_rad, theta_i)?;
                let (theta, phi) = specular_angles(&about_z(omega_out, -phi_i), tilt);
                [theta_i, phi_i, theta, phi]
            }
            Parameters::Distorted { offsets_rad } => {
                let tilt = theta_i + self.offset(offsets_rad, theta_i)?;
                let (theta, phi) = distorted_angles(&about_z(omega_out, -phi_i), tilt);
                [theta_i, phi_i, theta, phi]
            }
            Parameters::HalfDifference => half_difference_angles(omega_in, omega_out),
        };
        Some(angles)
    }

    pub(crate) fn offset(&self, offsets_rad: &[f64], theta_i: f64) -> Option<f64> {
        let b = self.axes[0].locate(theta_i)?;
        Some(offsets_rad[b.below] + b.t * (offsets_rad[b.above] - offsets_rad[b.below]))
    }

    /// Directions to light and viewer at a node. The viewer's may be below the horizon; both are `None` where there is
    /// no such pair.
    pub(crate) fn directions(&self, node: [usize; 4]) -> Option<(Vec3, Vec3)> {
        let angle: [f64; 4] = std::array::from_fn(|axis| self.axes[axis].nodes_rad()[node[axis]]);
        let incident = direction(angle[0], angle[1]);
        let turn = |d: Vec3| about_z(&d, angle[1]);
        match &self.parameters {
            Parameters::Spherical => {
                let base = if self.is_isotropic() { angle[1] } else { 0.0 };
                Some((incident, direction(angle[2], base + angle[3])))
            }
            Parameters::Specular { offsets_rad } => {
                let tilt = angle[0] + offsets_rad[node[0]];
                Some((incident, turn(from_specular(angle[2], angle[3], tilt))))
            }
            Parameters::Distorted { offsets_rad } => {
                let tilt = angle[0] + offsets_rad[node[0]];
                Some((incident, turn(from_distorted(angle[2], angle[3], tilt))))
            }
            Parameters::HalfDifference => {
                let difference = direction(angle[2], angle[3]);
                let omega_in = about_z(&about_y(&difference, angle[0]), angle[1]);
                let half = direction(angle[0], angle[1]);
                let omega_out = half * (2.0 * half.dot(&omega_in)) - omega_in;
                (omega_in.z >= -1e-12).then_some((omega_in, omega_out))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Converting angles to directions and back gives the same angles.
    #[test]
    fn parameters_invert() {
        let degrees = |d: [f64; 4]| d.map(f64::to_radians);
        for parameters in [
            Parameters::Spherical,
            Parameters::Specular { offsets_rad: vec![0.1] },
            Parameters::Distorted { offsets_rad: vec![0.0] },
            Parameters::HalfDifference,
        ] {
            for angles in [
                [30.0, 40.0, 20.0, 110.0],
                [12.0, 200.0, 35.0, 300.0],
                [50.0, 0.5, 5.0, 181.0],
            ] {
                let wanted = degrees(angles);
                let axes = wanted.map(|angle| Axis::bounded(vec![angle]));
                let grid = Grid::new(parameters.clone(), axes, Fold::None, 1, [0, 1, 2, 3, 4], vec![1.0]);
                let (omega_in, omega_out) = grid.directions([0; 4]).unwrap();
                let found = grid.angles(&omega_in, &omega_out).unwrap();
                for (f, w) in found.iter().zip(wanted) {
                    assert!((f - w).abs() < 1e-9, "{parameters:?}: {found:?} {wanted:?}");
                }
            }
        }
    }
}
