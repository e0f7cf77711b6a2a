use std::f64::consts::{FRAC_PI_4, PI};

use super::kinds::Placement;
use crate::geometry::Vec3;

/// Values constant on the cells of a tree that recursively halves each axis of the unit cube, adapted to the data. In
/// rank 4 the axes are the positions of the incident direction (of its opposite in azimuth) and of the outgoing
/// direction in the unit square; in rank 3 (isotropic data) ½ − ½ sin θ_in and the position of the outgoing direction.
#[derive(Clone, Debug, PartialEq)]
pub struct TensorTree {
    rank: usize,
    /// One tree: f. Three: f and CIE 1976 u′, v′, from which come X, Y, Z.
    trees: Vec<Node>,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Node {
    /// One child for each combination of lower and upper half, bit i of its number for the upper half of axis i.
    Branch(Vec<Node>),
    /// 2^(k rank) values on a regular grid, axis 0 slowest.
    Grid(Vec<f64>),
}

impl TensorTree {
    pub(crate) fn new(rank: usize, trees: Vec<Node>) -> Self {
        Self { rank, trees }
    }

    /// Number of cells of the finest tree.
    pub fn cells(&self) -> usize {
        fn count(node: &Node) -> usize {
            match node {
                Node::Branch(children) => children.iter().map(count).sum(),
                Node::Grid(values) => values.len(),
            }
        }
        self.trees.iter().map(count).max().unwrap_or(0)
    }

    /// Whether values do not change under rotation of the sample about its normal (rank 3).
    pub fn is_isotropic(&self) -> bool {
        self.rank == 3
    }

    pub(crate) fn eval(&self, omega_in: &Vec3, omega_out: &Vec3) -> Option<(Vec<f64>, Placement)> {
        let mut place = self.incident_place(omega_in);
        let outgoing = self.rank - 2..self.rank;
        if self.rank == 4 {
            place[outgoing].copy_from_slice(&square(omega_out.x, omega_out.y));
            return Some((self.at(place).0, Placement::InCell));
        }
        let sin = omega_in.x.hypot(omega_in.y);
        if sin > 1e-9 {
            // Rotated so that the light comes from azimuth 180 degrees.
            let (c, s) = (-omega_in.x / sin, -omega_in.y / sin);
            let turned = square(c * omega_out.x + s * omega_out.y, c * omega_out.y - s * omega_out.x);
            place[outgoing].copy_from_slice(&turned);
            return Some((self.at(place).0, Placement::InCell));
        }
        // Light along the normal has no azimuth: take the mean over rotations of the sample.
        const TURNS: usize = 8;
        let (r, phi) = (omega_out.x.hypot(omega_out.y).max(1e-9), omega_out.y.atan2(omega_out.x));
        let mut mean = vec![0.0; self.channels()];
        for turn in 0..TURNS {
            let phi = phi + (turn as f64 + 0.5) / TURNS as f64 * 2.0 * PI;
            place[outgoing.clone()].copy_from_slice(&square(r * phi.cos(), r * phi.sin()));
            let values = self.at(place).0;
            mean.iter_mut()
                .zip(values)
                .for_each(|(sum, v)| *sum += v / TURNS as f64);
        }
        Some((mean, Placement::InCell))
    }

    fn channels(&self) -> usize {
        if self.trees.len() == 3 { 3 } else { 1 }
    }

    /// ∫ f cos θ_out dω_out a channel, of light from a direction: exact, as f is constant on the leaves and the map
    /// from the disc of projected directions to the square keeps areas.
    pub(crate) fn hemispherical(&self, omega_in: &Vec3) -> Vec<f64> {
        let place = self.incident_place(omega_in);
        let mut sums = vec![0.0; self.channels()];
        self.add(place, [0.0, 0.0], 0, &mut sums);
        sums
    }

    /// Adds π times the integral over a square of the outgoing place, of side 2^−`level` from `corner` on.
    fn add(&self, mut place: [f64; 4], corner: [f64; 2], level: usize, sums: &mut [f64]) {
        let side = 0.5f64.powi(level as i32);
        let centre = corner.map(|x| x + 0.5 * side);
        place[self.rank - 2..self.rank].copy_from_slice(&centre);
        let (values, depth) = self.at(place);
        if depth <= level {
            let area = PI * side * side;
            sums.iter_mut()
                .zip(values)
                .for_each(|(sum, value)| *sum += area * value);
            return;
        }
        for part in 0..4usize {
            let offset = [part & 1, part >> 1].map(|upper| 0.5 * side * upper as f64);
            let corner = [corner[0] + offset[0], corner[1] + offset[1]];
            self.add(place, corner, level + 1, sums);
        }
    }

    /// Place of an incident direction on the first axes.
    fn incident_place(&self, omega_in: &Vec3) -> [f64; 4] {
        let mut place = [0.0; 4];
        if self.rank == 4 {
            place[..2].copy_from_slice(&square(-omega_in.x, -omega_in.y));
        } else {
            let sin = omega_in.x.hypot(omega_in.y).min(1.0);
            // The normal is the end of the lower half: the upper one is not used.
            place[0] = (0.5 - 0.5 * sin).min(0.5f64.next_down());
        }
        place
    }

    /// Values of the channels at a place, and the most halvings of an axis down to the leaves there.
    fn at(&self, place: [f64; 4]) -> (Vec<f64>, usize) {
        let leaves: Vec<(f64, usize)> = self.trees.iter().map(|tree| leaf(tree, self.rank, place)).collect();
        let depth = leaves.iter().map(|(_, depth)| *depth).max().unwrap_or(0);
        let values = match leaves[..] {
            [(y, _), (u, _), (v, _)] if v > 0.0 => {
                vec![y * 9.0 * u / (4.0 * v), y, y * (12.0 - 3.0 * u - 20.0 * v) / (4.0 * v)]
            }
            [(y, _), _, _] => vec![0.0, y, 0.0],
            _ => leaves.iter().map(|(value, _)| *value).collect(),
        };
        (values, depth)
    }
}

/// The value of a leaf, and the number of halvings of the axes down to it.
fn leaf(mut node: &Node, rank: usize, mut place: [f64; 4]) -> (f64, usize) {
    let mut depth = 0;
    loop {
        match node {
            Node::Branch(children) => {
                let mut child = 0;
                for (axis, x) in place[..rank].iter_mut().enumerate() {
                    let upper = *x >= 0.5;
                    child |= usize::from(upper) << axis;
                    *x = 2.0 * *x - if upper { 1.0 } else { 0.0 };
                }
                node = &children[child];
                depth += 1;
            }
            Node::Grid(values) => {
                let levels = values.len().trailing_zeros() as usize / rank;
                let n = 1usize << levels;
                let cell = |x: f64| ((x.max(0.0) * n as f64) as usize).min(n - 1);
                let index = place[..rank].iter().fold(0, |index, &x| index * n + cell(x));
                return (values[index], depth + levels);
            }
        }
    }
}

/// Shirley's and Chiu's map from the disc to the unit square, which keeps areas.
fn square(x: f64, y: f64) -> [f64; 2] {
    let r = x.hypot(y).min(1.0);
    // Azimuth from −45 to 315 degrees: one of four wedges.
    let mut phi = y.atan2(x);
    if phi < -FRAC_PI_4 {
        phi += 2.0 * PI;
    }
    let (a, b) = match phi / FRAC_PI_4 {
        wedge if wedge < 1.0 => (r, phi * r / FRAC_PI_4),
        wedge if wedge < 3.0 => ((PI / 2.0 - phi) * r / FRAC_PI_4, r),
        wedge if wedge < 5.0 => (-r, (PI - phi) * r / FRAC_PI_4),
        _ => ((phi - 1.5 * PI) * r / FRAC_PI_4, -r),
    };
    [(a + 1.0) / 2.0, (b + 1.0) / 2.0]
}
