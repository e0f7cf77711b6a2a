use std::f64::consts::TAU;

/// Angles in radians closer than this are one angle, written or computed with rounding: 0.0006 degrees.
const SAME_RAD: f64 = 1e-5;

/// Ascending angles in radians, and the rule beyond the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    nodes_rad: Vec<f64>,
    beyond: Beyond,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Beyond {
    Nothing,
    /// Constant at the value of the last node.
    Last,
    /// Periodic, with this period in radians.
    First(f64),
    /// A single node that represents every angle.
    Everything,
}

/// The two nodes around an angle, and the position between them.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub(crate) struct Between {
    pub(crate) below: usize,
    pub(crate) above: usize,
    pub(crate) t: f64,
    pub(crate) on_node: bool,
}

/// Two nodes and their interpolation weights.
pub(crate) type Shares = [(usize, f64); 2];

impl Axis {
    /// Nodes ascend strictly and are not empty.
    pub(crate) fn bounded(nodes_rad: Vec<f64>) -> Self {
        let beyond = Beyond::Nothing;
        Self { nodes_rad, beyond }
    }

    /// An axis that is constant beyond its last node.
    pub(crate) fn held(nodes_rad: Vec<f64>) -> Self {
        let beyond = Beyond::Last;
        Self { nodes_rad, beyond }
    }

    /// An azimuth axis; a single node represents the whole circle. The arc from the last node to the first counts as
    /// measured if it is not wider than the widest arc between neighbours.
    pub(crate) fn azimuth(nodes_rad: Vec<f64>, period_rad: f64) -> Self {
        let beyond = match nodes_rad.as_slice() {
            [_] => Beyond::Everything,
            nodes => {
                let widest = nodes.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
                let gap = nodes[0] + period_rad - nodes[nodes.len() - 1];
                if gap <= widest + SAME_RAD {
                    Beyond::First(period_rad)
                } else {
                    Beyond::Nothing
                }
            }
        };
        Self { nodes_rad, beyond }
    }

    /// Nodes in radians, ascending.
    pub fn nodes_rad(&self) -> &[f64] {
        &self.nodes_rad
    }

    /// Whether it has a single node that represents every angle.
    pub(crate) fn is_single(&self) -> bool {
        self.beyond == Beyond::Everything
    }

    /// The axis with added nodes at 0 and 360°, for programs that do not close the circle themselves, and for each of
    /// its nodes the original nodes and weights of which its value is the mean. `None` if nothing is added: axes that
    /// do not cover the circle, single azimuths, and closed circles.
    pub(crate) fn closed(&self) -> Option<(Self, Vec<Shares>)> {
        if self.beyond != Beyond::First(TAU) {
            return None;
        }
        let [first, last] = [self.nodes_rad[0], self.nodes_rad[self.nodes_rad.len() - 1]];
        if first < 0.0 || (first == 0.0 && last >= TAU - SAME_RAD) {
            return None;
        }
        let seam = self.locate(0.0)?;
        let seam = [(seam.below, 1.0 - seam.t), (seam.above, seam.t)];
        let own = |node: usize| [(node, 1.0), (node, 0.0)];
        let mut nodes_rad = self.nodes_rad.clone();
        let mut shares: Vec<Shares> = (0..nodes_rad.len()).map(own).collect();
        if first > 0.0 {
            nodes_rad.insert(0, 0.0);
            shares.insert(0, seam);
        }
        if last < TAU - SAME_RAD {
            nodes_rad.push(TAU);
            shares.push(seam);
        }
        let beyond = self.beyond;
        Some((Self { nodes_rad, beyond }, shares))
    }

    /// Fraction of the axis that each node represents: half the gaps to its neighbours. The fractions sum to 1.
    pub(crate) fn shares(&self) -> Vec<f64> {
        let nodes = &self.nodes_rad;
        let last = nodes.len() - 1;
        if last == 0 {
            return vec![1.0];
        }
        let mut shares = vec![0.0; nodes.len()];
        for (below, pair) in nodes.windows(2).enumerate() {
            shares[below] += pair[1] - pair[0];
            shares[below + 1] += pair[1] - pair[0];
        }
        if let Beyond::First(period) = self.beyond {
            let gap = (nodes[0] + period - nodes[last]).max(0.0);
            shares[0] += gap;
            shares[last] += gap;
        }
        let total: f64 = shares.iter().sum();
        shares.iter_mut().for_each(|share| *share /= total);
        shares
    }

    /// `None` outside what was measured.
    pub(crate) fn locate(&self, angle_rad: f64) -> Option<Between> {
        let nodes = &self.nodes_rad;
        let last = nodes.len() - 1;
        let at = |node| {
            Some(Between {
                below: node,
                above: node,
                t: 0.0,
                on_node: true,
            })
        };
        let mut angle = angle_rad;
        match self.beyond {
            Beyond::Everything => return at(0),
            Beyond::First(period) => {
                angle = nodes[0] + (angle - nodes[0]).rem_euclid(period);
                if angle > nodes[last] {
                    let gap = (nodes[0] + period - nodes[last]).max(f64::MIN_POSITIVE);
                    let t = ((angle - nodes[last]) / gap).min(1.0);
                    let near = (angle - nodes[last]).min(nodes[last] + gap - angle) < SAME_RAD;
                    return Some(Between {
                        below: last,
                        above: 0,
                        t,
                        on_node: near,
                    });
                }
            }
            Beyond::Nothing | Beyond::Last => {
                // On an azimuth axis that does not cover the full circle, 0 and 360 degrees are still the same angle.
                if angle < nodes[0] - SAME_RAD && angle + TAU <= nodes[last] + SAME_RAD {
                    angle += TAU;
                } else if angle > nodes[last] + SAME_RAD && angle - TAU >= nodes[0] - SAME_RAD {
                    angle -= TAU;
                }
            }
        }
        if angle <= nodes[0] {
            return if angle >= nodes[0] - SAME_RAD { at(0) } else { None };
        }
        if angle >= nodes[last] {
            let inside = angle <= nodes[last] + SAME_RAD;
            return match (inside, self.beyond) {
                (true, _) => at(last),
                (false, Beyond::Last) => at(last).map(|b| Between { on_node: false, ..b }),
                _ => None,
            };
        }
        let above = nodes.partition_point(|&node| node <= angle);
        let (low, high) = (nodes[above - 1], nodes[above]);
        Some(Between {
            below: above - 1,
            above,
            t: (angle - low) / (high - low),
            on_node: (angle - low).min(high - angle) < SAME_RAD,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn deg(angles: &[f64]) -> Vec<f64> {
        angles.iter().map(|a| a.to_radians()).collect()
    }

    #[test]
    fn azimuths_close_only_where_measured_all_round() {
        let round = Axis::azimuth(deg(&[0.0, 90.0, 180.0, 270.0]), TAU);
        let found = round.locate(315f64.to_radians()).unwrap();
        assert_eq!((found.below, found.above), (3, 0));
        assert!((found.t - 0.5).abs() < 1e-12 && !found.on_node);
        let quarter = Axis::azimuth(deg(&[0.0, 45.0, 90.0]), TAU);
        assert_eq!(quarter.locate(200f64.to_radians()), None);
        assert!(quarter.locate(-1e-9).unwrap().on_node);
        assert!(Axis::azimuth(deg(&[7.0]), TAU).locate(1.0).unwrap().on_node);
    }

    #[test]
    fn nothing_is_measured_beyond_the_ends() {
        let axis = Axis::bounded(deg(&[10.0, 20.0]));
        assert_eq!(axis.locate(9f64.to_radians()), None);
        assert_eq!(axis.locate(21f64.to_radians()), None);
        assert!(!Axis::held(deg(&[10.0, 20.0])).locate(0.5).unwrap().on_node);
    }
}
