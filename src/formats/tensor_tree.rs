use std::f64::consts::{FRAC_PI_4, PI};

use super::goniometric::Placement;
use crate::geometry::Vec3;

/// A value constant on the cells of a tree that halves each axis of the unit cube again and again, down to where the
/// values need it. Of rank 4 the axes are the incident direction's place in the unit square (of its opposite in azimuth)
/// and the outgoing one's; of rank 3, of isotropic data, ½ − ½ sin θ_in and the outgoing one's.
#[derive(Clone, Debug, PartialEq)]
pub struct TensorTree {
    rank: usize,
    /// One tree: f. Three: f and CIE 1976 u′, v′, from which come X, Y, Z.
    trees: Vec<Node>,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Node {
    /// One child for each combination of lower and upper half, bit i of its number for the upper half of axis i.
    Branch(Vec<Node>),
    /// 2^(k rank) values on a regular grid, axis 0 slowest.
    Grid(Vec<f64>),
}

impl TensorTree {
    pub(super) fn new(rank: usize, trees: Vec<Node>) -> Self {
        Self { rank, trees }
    }

    pub fn is_isotropic(&self) -> bool {
        self.rank == 3
    }

    pub(super) fn eval(&self, omega_in: &Vec3, omega_out: &Vec3) -> Option<(Vec<f64>, Placement)> {
        let mut place = [0.0; 4];
        if self.rank == 4 {
            place[..2].copy_from_slice(&square(-omega_in.x, -omega_in.y));
            place[2..].copy_from_slice(&square(omega_out.x, omega_out.y));
        } else {
            let sin = omega_in.x.hypot(omega_in.y).min(1.0);
            // Turned so that the light comes from azimuth 180 degrees.
            let (c, s) = if sin > 1e-12 {
                (-omega_in.x / sin, -omega_in.y / sin)
            } else {
                (1.0, 0.0)
            };
            place[0] = 0.5 - 0.5 * sin;
            let turned = square(c * omega_out.x + s * omega_out.y, c * omega_out.y - s * omega_out.x);
            place[1..3].copy_from_slice(&turned);
        }
        let values: Vec<f64> = self.trees.iter().map(|tree| at(tree, self.rank, place)).collect();
        let values = match values[..] {
            [y, u, v] if v > 0.0 => vec![y * 9.0 * u / (4.0 * v), y, y * (12.0 - 3.0 * u - 20.0 * v) / (4.0 * v)],
            [y, _, _] => vec![0.0, y, 0.0],
            _ => values,
        };
        Some((values, Placement::InCell))
    }
}

fn at(mut node: &Node, rank: usize, mut place: [f64; 4]) -> f64 {
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
            }
            Node::Grid(values) => {
                let levels = values.len().trailing_zeros() as usize / rank;
                let n = 1usize << levels;
                let cell = |x: f64| ((x.max(0.0) * n as f64) as usize).min(n - 1);
                let index = place[..rank].iter().fold(0, |index, &x| index * n + cell(x));
                return values[index];
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
