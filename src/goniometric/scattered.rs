use std::collections::HashMap;
use std::f64::consts::TAU;

use super::axis::Axis;
use super::direction::angles_of;
use super::kinds::Placement;
use crate::geometry::Vec3;

/// Readings at pairs of directions, sorted into a tree of angles: incident polar angle and azimuth, outgoing polar
/// angle and azimuth, or, of readings in the plane of incidence alone, incident polar angle and signed view angle.
/// Interpolation is linear in each angle, one after the other, without extrapolation. At a pole, where readings of
/// several azimuths have the same direction, the value is their mean.
#[derive(Clone, Debug, PartialEq)]
pub struct Scattered {
    directions: Directions,
    /// Whether only one side of the plane of incidence was measured; the other is its mirror image.
    mirrored: bool,
    isotropic: bool,
    tree: Branch,
    channels: usize,
    /// One row per reading, channel fastest.
    values: Vec<f64>,
    /// Standard errors in the order of the values, if the file states them.
    errors: Option<Vec<f64>>,
}

/// Directions of the readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Directions {
    /// Four angles a reading, in radians: θ_in, φ_in, θ_out, φ_out.
    Sphere,
    /// θ_in and θ_v, the latter negative on the side of the light.
    Plane,
}

#[derive(Clone, Debug, PartialEq)]
struct Branch {
    axis: Axis,
    below: Vec<Node>,
    /// For azimuths about a pole, the fraction of the circle of each node.
    about_pole: Option<Vec<f64>>,
}

#[derive(Clone, Debug, PartialEq)]
enum Node {
    Branch(Branch),
    Reading(usize),
}

/// A pair of readings of the same directions, by their positions in the file.
pub(crate) struct Twice(pub(crate) usize, pub(crate) usize);

impl Scattered {
    /// `angles` has as many angles in each row as `directions` has; there is at least one row.
    pub(crate) fn new(
        directions: Directions,
        angles: &[Vec<f64>],
        channels: usize,
        values: Vec<f64>,
    ) -> Result<Self, Twice> {
        debug_assert_eq!(angles.len() * channels, values.len());
        let mut order: Vec<usize> = (0..angles.len()).collect();
        order.sort_by(|&a, &b| {
            let pairs = angles[a].iter().zip(&angles[b]);
            pairs.fold(std::cmp::Ordering::Equal, |order, (x, y)| order.then(x.total_cmp(y)))
        });
        if let Some(pair) = order.windows(2).find(|pair| angles[pair[0]] == angles[pair[1]]) {
            return Err(Twice(pair[0].min(pair[1]), pair[0].max(pair[1])));
        }
        let sphere = directions == Directions::Sphere;
        if let Some(pair) = contradiction(angles, channels, &values).filter(|_| sphere) {
            return Err(pair);
        }
        let isotropic = !sphere || angles.iter().all(|a| a[1] == angles[0][1]);
        let sides = || {
            angles
                .iter()
                .map(|a| (a[3] - a[1]).sin())
                .filter(|side| side.abs() > 1e-9)
        };
        let one_side = |sign: f64| sides().next().is_some() && sides().all(|side| side * sign > 0.0);
        Ok(Self {
            directions,
            mirrored: sphere && isotropic && (one_side(1.0) || one_side(-1.0)),
            isotropic,
            tree: Branch::new(angles, &order, 0, sphere),
            channels,
            values,
            errors: None,
        })
    }

    /// With standard errors, as many as there are values and in their order.
    pub(crate) fn with_errors(self, errors: Option<Vec<f64>>) -> Self {
        Self { errors, ..self }
    }

    pub fn directions(&self) -> Directions {
        self.directions
    }

    /// Whether values do not change under rotation of the sample about its normal.
    pub fn is_isotropic(&self) -> bool {
        self.isotropic
    }

    pub(crate) fn is_mirrored(&self) -> bool {
        self.mirrored
    }

    /// Every reading, ascending by its angles in radians.
    pub fn readings(&self) -> Vec<(Vec<f64>, &[f64])> {
        self.rows(&self.values)
    }

    pub(crate) fn states_errors(&self) -> bool {
        self.errors.is_some()
    }

    /// Standard errors of the readings, in their order; empty where none were stated.
    pub fn reading_errors(&self) -> Vec<(Vec<f64>, &[f64])> {
        self.errors.as_ref().map_or_else(Vec::new, |errors| self.rows(errors))
    }

    fn rows<'a>(&self, of: &'a [f64]) -> Vec<(Vec<f64>, &'a [f64])> {
        let mut rows = Vec::new();
        self.tree.collect(&mut Vec::new(), &mut |angles, reading| {
            rows.push((
                angles.to_vec(),
                &of[reading * self.channels..(reading + 1) * self.channels],
            ));
        });
        rows
    }

    /// Standard errors of a value, in its quantity, assuming independent readings. `None` if none are stated, and
    /// outside the measured range.
    pub(crate) fn standard_errors(&self, omega_in: &Vec3, omega_out: &Vec3) -> Option<Vec<f64>> {
        let errors = self.errors.as_ref()?;
        let around = self.around_pair(omega_in, omega_out)?;
        let mut squares = vec![0.0; self.channels];
        for (reading, share) in &around.readings {
            let row = &errors[reading * self.channels..(reading + 1) * self.channels];
            let pairs = squares.iter_mut().zip(row);
            pairs.for_each(|(sum, error)| *sum += (share * error).powi(2));
        }
        Some(squares.into_iter().map(f64::sqrt).collect())
    }

    /// The same readings with other channels, as many as the map gives.
    pub(crate) fn with_channels(&self, channels: usize, map: impl Fn(&[f64]) -> Vec<f64>) -> Self {
        Self {
            channels,
            values: self.values.chunks_exact(self.channels).flat_map(map).collect(),
            errors: None,
            ..self.clone()
        }
    }

    /// Outgoing polar angles and azimuths, radians, of the interpolation nodes for light from a direction, with
    /// possible duplicates. `None` outside the measured range.
    pub(crate) fn outgoing_nodes(&self, theta_i: f64, phi_i: f64) -> Option<(Vec<f64>, Vec<f64>)> {
        let around = |branch: &'_ Branch, angle: f64| {
            let between = branch.axis.locate(angle)?;
            Some(if between.t > 0.0 {
                vec![between.below, between.above]
            } else {
                vec![between.below]
            })
        };
        let (mut polar, mut azimuths) = (Vec::new(), Vec::new());
        for of_theta in around(&self.tree, theta_i)? {
            let Node::Branch(by_phi) = &self.tree.below[of_theta] else {
                return None;
            };
            let all = (0..by_phi.below.len()).collect();
            let nodes = if by_phi.about_pole.is_some() {
                all
            } else {
                around(by_phi, phi_i)?
            };
            // Azimuths of isotropic readings are kept with the light's.
            let turn = if self.isotropic {
                phi_i - self.tree.below[0].first()
            } else {
                0.0
            };
            for of_phi in nodes {
                let Node::Branch(by_polar) = &by_phi.below[of_phi] else {
                    return None;
                };
                polar.extend(by_polar.axis.nodes_rad());
                for node in &by_polar.below {
                    if let Node::Branch(by_azimuth) = node
                        && by_azimuth.about_pole.is_none()
                    {
                        for phi in by_azimuth.axis.nodes_rad() {
                            azimuths.push(phi + turn);
                            if self.mirrored {
                                azimuths.push(2.0 * phi_i - phi - turn);
                            }
                        }
                    }
                }
            }
        }
        for nodes in [&mut polar, &mut azimuths] {
            nodes.sort_by(f64::total_cmp);
            nodes.dedup_by(|a, b| *a - *b < 1e-6);
        }
        Some((polar, azimuths))
    }

    pub(crate) fn incidences_rad(&self) -> Vec<f64> {
        self.tree.axis.nodes_rad().to_vec()
    }

    pub(crate) fn eval(&self, omega_in: &Vec3, omega_out: &Vec3) -> Option<(Vec<f64>, Placement)> {
        let around = self.around_pair(omega_in, omega_out)?;
        let mut values = vec![0.0; self.channels];
        self.add(&around, 1.0, &mut values);
        let placement = if around.on_node {
            Placement::OnNode
        } else {
            Placement::Interpolated
        };
        Some((values, placement))
    }

    fn around_pair(&self, omega_in: &Vec3, omega_out: &Vec3) -> Option<Around> {
        let ((theta_i, phi_i), (theta_o, phi_o)) = (angles_of(omega_in), angles_of(omega_out));
        match self.directions {
            Directions::Plane => {
                // Light from the normal counts as coming from the side of -x.
                let (x, y) = if theta_i < 1e-9 {
                    (-1.0, 0.0)
                } else {
                    (phi_i.cos(), phi_i.sin())
                };
                if (x * omega_out.y - y * omega_out.x).abs() > 1e-9 {
                    return None;
                }
                let towards_light = x * omega_out.x + y * omega_out.y;
                let sign = if towards_light > 0.0 { -1.0 } else { 1.0 };
                self.around(&[theta_i, sign * theta_o])
            }
            Directions::Sphere if self.isotropic => {
                // Azimuths are kept as they were read, with the light's.
                let first = self.tree.below[0].first();
                let at = |phi: f64| self.around(&[theta_i, phi_i, theta_o, (first + phi).rem_euclid(TAU)]);
                let mirrored = || self.mirrored.then(|| at(phi_i - phi_o)).flatten();
                at(phi_o - phi_i).or_else(mirrored)
            }
            Directions::Sphere => self.around(&[theta_i, phi_i, theta_o, phi_o]),
        }
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
        let ((theta_i, phi_i), (theta_o, phi_o)) = (angles_of(omega_in), angles_of(omega_out));
        turns_rad.retain(|turn| {
            let turned = |phi: f64| if phi + turn < TAU { phi + turn } else { phi + turn - TAU };
            let around = match self.isotropic {
                // Isotropic readings are invariant under rotation.
                true => self.around_pair(omega_in, omega_out),
                false => self.around(&[theta_i, turned(phi_i), theta_o, turned(phi_o)]),
            };
            let Some(around) = around else { return true };
            self.add(&around, weight, sums);
            false
        });
    }

    /// The readings around a point; `None` outside the measured range.
    fn around(&self, angles: &[f64]) -> Option<Around> {
        let mut around = Around {
            readings: Vec::with_capacity(16),
            on_node: true,
        };
        self.tree.find(angles, 1.0, &mut around)?;
        Some(around)
    }

    fn add(&self, around: &Around, weight: f64, sums: &mut [f64]) {
        for (reading, share) in &around.readings {
            let row = &self.values[reading * self.channels..(reading + 1) * self.channels];
            let weight = weight * share;
            sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += weight * value);
        }
    }
}

/// The first two readings whose azimuths differ by a multiple of 360° only and whose values differ.
fn contradiction(angles: &[Vec<f64>], channels: usize, values: &[f64]) -> Option<Twice> {
    /// Rounding error of a file with few digits.
    const SAME: f64 = 1e-3;
    let mut seen: HashMap<Vec<i64>, usize> = HashMap::new();
    let row = |reading: usize| &values[reading * channels..(reading + 1) * channels];
    for (reading, angles) in angles.iter().enumerate() {
        let turned = |(level, angle): (usize, &f64)| {
            let angle = if level % 2 == 1 { angle.rem_euclid(TAU) } else { *angle };
            let rounded = (angle * 1e9).round();
            if level % 2 == 1 && rounded == (TAU * 1e9).round() {
                0
            } else {
                rounded as i64
            }
        };
        let first = *seen
            .entry(angles.iter().enumerate().map(turned).collect())
            .or_insert(reading);
        let differ = |(a, b): (&f64, &f64)| (a - b).abs() > SAME * a.abs().max(b.abs());
        if row(first).iter().zip(row(reading)).any(differ) {
            return Some(Twice(first, reading));
        }
    }
    None
}

/// Readings around a point with their weights.
struct Around {
    readings: Vec<(usize, f64)>,
    on_node: bool,
}

impl Node {
    fn find(&self, angles: &[f64], share: f64, around: &mut Around) -> Option<()> {
        match self {
            Self::Branch(branch) => branch.find(angles, share, around),
            Self::Reading(reading) => {
                around.readings.push((*reading, share));
                Some(())
            }
        }
    }

    fn first(&self) -> f64 {
        match self {
            Self::Branch(branch) => branch.axis.nodes_rad()[0],
            Self::Reading(_) => 0.0,
        }
    }
}

impl Branch {
    /// Of the readings `order`, sorted, that agree in the angles before `level`.
    fn new(angles: &[Vec<f64>], order: &[usize], level: usize, sphere: bool) -> Self {
        let mut nodes_rad = Vec::new();
        let mut below = Vec::new();
        for group in order.chunk_by(|&a, &b| angles[a][level] == angles[b][level]) {
            nodes_rad.push(angles[group[0]][level]);
            below.push(if level + 1 == angles[group[0]].len() {
                Node::Reading(group[0])
            } else {
                Node::Branch(Self::new(angles, group, level + 1, sphere))
            });
        }
        let at_pole = level > 0 && angles[order[0]][level - 1] == 0.0;
        let axis = match level {
            // A single outgoing azimuth is one direction, not all; but at the pole, and for the light's, it is all.
            3 if sphere && nodes_rad.len() == 1 && !at_pole => Axis::bounded(nodes_rad),
            1 | 3 if sphere => Axis::azimuth(nodes_rad, TAU),
            _ => Axis::bounded(nodes_rad),
        };
        let about_pole = (sphere && level % 2 == 1 && at_pole).then(|| axis.shares());
        Self {
            axis,
            below,
            about_pole,
        }
    }

    fn find(&self, angles: &[f64], share: f64, around: &mut Around) -> Option<()> {
        if let Some(shares) = &self.about_pole {
            let nodes = self.below.iter().zip(shares);
            return nodes
                .into_iter()
                .try_for_each(|(node, part)| node.find(&angles[1..], share * part, around));
        }
        let between = self.axis.locate(angles[0])?;
        around.on_node &= between.on_node;
        for (node, part) in [(between.below, 1.0 - between.t), (between.above, between.t)] {
            if part > 0.0 {
                self.below[node].find(&angles[1..], share * part, around)?;
            }
        }
        Some(())
    }

    fn collect(&self, path: &mut Vec<f64>, each: &mut impl FnMut(&[f64], usize)) {
        for (angle, node) in self.axis.nodes_rad().iter().zip(&self.below) {
            path.push(*angle);
            match node {
                Node::Branch(branch) => branch.collect(path, each),
                Node::Reading(reading) => each(path, *reading),
            }
            path.pop();
        }
    }
}
