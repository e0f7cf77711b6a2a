use super::YarnError;
use crate::geometry::Vec3;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Incident directions over the hemisphere of the local normal: the centres of zenith × azimuth cells (the preprint's
/// 144). The cylinder's two mirror planes let a quarter of them stand for all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IncidentGrid {
    zenith: usize,
    azimuth: usize,
    folded: bool,
}

/// Weight of one traced direction in an interpolation, and the mirrors that take it to where it is needed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Corner {
    pub traced: usize,
    pub mirror_tangent: bool,
    pub mirror_axis: bool,
    pub weight: f64,
}

impl IncidentGrid {
    /// `folded`: trace only the first quadrant of azimuth.
    pub fn new(zenith: usize, azimuth: usize, folded: bool) -> Result<Self, YarnError> {
        if zenith == 0 || azimuth < 4 || !azimuth.is_multiple_of(4) {
            return Err(YarnError::Count {
                quantity: "azimuth cells of the incident directions",
                expected: "a multiple of 4, with at least 1 zenith cell",
                found: azimuth,
            });
        }
        Ok(Self {
            zenith,
            azimuth,
            folded,
        })
    }

    /// All directions, traced or mirrored.
    pub fn len(&self) -> usize {
        self.zenith * self.azimuth
    }

    /// Never true: construction refuses an empty grid.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Directions that are traced.
    pub fn traced(&self) -> usize {
        self.zenith * self.traced_azimuths()
    }

    fn traced_azimuths(&self) -> usize {
        if self.folded { self.azimuth / 4 } else { self.azimuth }
    }

    /// Zenith angle and azimuth (from the tangent towards the axis) of direction i, degrees.
    pub fn angles_deg(&self, i: usize) -> [f64; 2] {
        [
            ((i / self.azimuth) as f64 + 0.5) * 90.0 / self.zenith as f64,
            ((i % self.azimuth) as f64 + 0.5) * 360.0 / self.azimuth as f64,
        ]
    }

    /// (tangent, axis, normal) of traced direction t, towards the light.
    pub(super) fn traced_direction(&self, t: usize) -> Vec3 {
        let n = self.traced_azimuths();
        let theta = ((t / n) as f64 + 0.5) * FRAC_PI_2 / self.zenith as f64;
        let phi = ((t % n) as f64 + 0.5) * TAU / self.azimuth as f64;
        Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    }

    /// The traced direction that stands for direction i, and the mirrors between them.
    pub fn representative(&self, i: usize) -> (usize, bool, bool) {
        let (row, mut column) = (i / self.azimuth, i % self.azimuth);
        if !self.folded {
            return (i, false, false);
        }
        let axis = column >= self.azimuth / 2;
        if axis {
            column = self.azimuth - 1 - column;
        }
        let tangent = column >= self.azimuth / 4;
        if tangent {
            column = self.azimuth / 2 - 1 - column;
        }
        (row * (self.azimuth / 4) + column, tangent, axis)
    }

    /// Bilinear interpolation in zenith and azimuth between directions, across the pole to the opposite azimuth,
    /// constant beyond the outermost zenith.
    pub(super) fn corners(&self, omega_in: &Vec3) -> [Corner; 4] {
        let theta = omega_in.z.clamp(0.0, 1.0).acos() / FRAC_PI_2 * self.zenith as f64 - 0.5;
        let phi = omega_in.y.atan2(omega_in.x) / TAU * self.azimuth as f64 - 0.5;
        let (row, column) = (theta.floor(), phi.floor());
        let (wr, wc) = (theta - row, phi - column);
        let corner = |dr: f64, dc: f64| {
            let r = row + dr;
            let turn = if r < 0.0 { self.azimuth as f64 / 2.0 } else { 0.0 };
            let c = (column + dc + turn).rem_euclid(self.azimuth as f64) as usize % self.azimuth;
            let r = (r.max(0.0) as usize).min(self.zenith - 1);
            let (traced, mirror_tangent, mirror_axis) = self.representative(r * self.azimuth + c);
            let weight = if dr == 0.0 { 1.0 - wr } else { wr } * if dc == 0.0 { 1.0 - wc } else { wc };
            Corner {
                traced,
                mirror_tangent,
                mirror_axis,
                weight,
            }
        };
        [corner(0.0, 0.0), corner(0.0, 1.0), corner(1.0, 0.0), corner(1.0, 1.0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn mirrors_lead_back_to_the_direction() {
        for folded in [true, false] {
            let grid = IncidentGrid::new(9, 16, folded).unwrap();
            assert_eq!(grid.len(), 144);
            assert_eq!(grid.traced(), if folded { 36 } else { 144 });
            for i in 0..grid.len() {
                let [theta, phi] = grid.angles_deg(i).map(f64::to_radians);
                let (t, mirror_tangent, mirror_axis) = grid.representative(i);
                let mut d = grid.traced_direction(t);
                if mirror_tangent {
                    d.x = -d.x;
                }
                if mirror_axis {
                    d.y = -d.y;
                }
                let wanted = Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
                assert_relative_eq!(d, wanted, epsilon = 1e-14);
                let at_node: f64 = grid
                    .corners(&wanted)
                    .iter()
                    .filter(|c| (c.traced, c.mirror_tangent, c.mirror_axis) == (t, mirror_tangent, mirror_axis))
                    .map(|c| c.weight)
                    .sum();
                assert_relative_eq!(at_node, 1.0, epsilon = 1e-12);
            }
        }
    }
}
