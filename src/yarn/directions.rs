use super::YarnError;
use crate::geometry::Vec3;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Incident directions over the hemisphere of the local normal: the centres of zenith × azimuth cells (the preprint's
/// 144). By the cylinder's two mirror planes a quarter of them represents all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IncidentGrid {
    zenith: usize,
    azimuth: usize,
    folded: bool,
}

/// The cell of the hemisphere that an incident direction represents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DirectionCell {
    cos_theta: [f64; 2],
    phi: [f64; 2],
}

impl DirectionCell {
    pub fn solid_angle(&self) -> f64 {
        (self.cos_theta[0] - self.cos_theta[1]) * (self.phi[1] - self.phi[0])
    }

    /// Direction towards the light, (tangent, axis, normal), uniform in solid angle over the cell if `zenith` and
    /// `azimuth` are uniform random numbers in [0, 1].
    pub fn direction(&self, zenith: f64, azimuth: f64) -> Vec3 {
        let cos = self.cos_theta[0] + (self.cos_theta[1] - self.cos_theta[0]) * zenith;
        let phi = self.phi[0] + (self.phi[1] - self.phi[0]) * azimuth;
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        Vec3::new(sin * phi.cos(), sin * phi.sin(), cos)
    }

    /// Smallest and largest |sin ψ| of the tilt ψ out of the normal plane; no cell straddles a mirror plane.
    pub fn sine_of_tilt(&self) -> [f64; 2] {
        let sin_theta = self.cos_theta.map(|cos| (1.0 - cos * cos).max(0.0).sqrt());
        let sin_phi = self.phi.map(|phi| phi.sin().abs());
        [
            sin_theta[0] * sin_phi[0].min(sin_phi[1]),
            sin_theta[1] * sin_phi[0].max(sin_phi[1]),
        ]
    }
}

impl IncidentGrid {
    /// Numbers of zenith and azimuth cells. `folded`: trace only the first quadrant of azimuth.
    ///
    /// # Errors
    /// [`YarnError::Count`] if `azimuth` is not a multiple of 4 or a number is 0.
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

    /// Number of all directions, traced or mirrored.
    pub fn len(&self) -> usize {
        self.zenith * self.azimuth
    }

    /// Always false: construction rejects an empty grid.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of traced directions.
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

    /// Unit vector (tangent, axis, normal) towards the light of traced direction t.
    pub(super) fn traced_direction(&self, t: usize) -> Vec3 {
        let n = self.traced_azimuths();
        let theta = ((t / n) as f64 + 0.5) * FRAC_PI_2 / self.zenith as f64;
        let phi = ((t % n) as f64 + 0.5) * TAU / self.azimuth as f64;
        Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    }

    /// The traced direction that represents direction i, and the two reflections between them.
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

    /// The cell around traced direction t.
    pub(super) fn cell(&self, t: usize) -> DirectionCell {
        let n = self.traced_azimuths();
        let edge = |i: usize| (i as f64 * FRAC_PI_2 / self.zenith as f64).cos();
        let azimuth_of = |j: usize| j as f64 * TAU / self.azimuth as f64;
        DirectionCell {
            cos_theta: [edge(t / n), edge(t / n + 1)],
            phi: [azimuth_of(t % n), azimuth_of(t % n + 1)],
        }
    }

    /// Number of directions of the hemisphere that a traced one represents.
    pub(super) fn images(&self) -> f64 {
        (self.len() / self.traced()) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Each traced direction lies in its cell, and the cells with their mirror images cover the hemisphere.
    #[test]
    fn cells_hold_their_directions() {
        for folded in [true, false] {
            let grid = IncidentGrid::new(9, 16, folded).unwrap();
            let mut solid_angle = 0.0;
            for t in 0..grid.traced() {
                let cell = grid.cell(t);
                let d = grid.traced_direction(t);
                assert!(cell.cos_theta[1] < d.z && d.z < cell.cos_theta[0]);
                let phi = d.y.atan2(d.x).rem_euclid(TAU);
                assert!(cell.phi[0] < phi && phi < cell.phi[1]);
                let [low, high] = cell.sine_of_tilt();
                for (zenith, azimuth) in [(0.0, 0.0), (0.3, 0.9), (1.0, 0.5), (1.0, 1.0)] {
                    let sine = cell.direction(zenith, azimuth).y.abs();
                    assert!((low - 1e-12..=high + 1e-12).contains(&sine));
                }
                solid_angle += grid.images() * cell.solid_angle();
            }
            assert_relative_eq!(solid_angle, TAU, epsilon = 1e-12);
        }
    }

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
            }
        }
    }
}
