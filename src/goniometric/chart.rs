//! The hemisphere of outgoing directions in the parameters of a table, cut where the table has its nodes.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::data::Table;
use super::direction::direction;
use super::grid::Grid;
use super::parameters::{Parameters, from_distorted, from_specular};
use super::scattered::{Directions, Scattered};
use super::warped::Warped;
use crate::geometry::Vec3;

/// Widest cell about the axis, in radians.
const WIDEST: f64 = PI / 12.0;
/// Most nodes of scattered readings along an angle that cells are cut at.
const MOST_NODES: usize = 360;

/// Nodes and weights over 0..1 of Gauss and Legendre's rule of 3 points.
pub(super) const GAUSS_3: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 5.0 / 18.0),
    (0.5, 4.0 / 9.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

/// Parametrisation of the outgoing direction by two numbers.
#[derive(Clone, Copy)]
pub(super) enum Parametrisation {
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
    pub(super) fn horizon(self, around: f64) -> f64 {
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
    pub(super) fn at(self, polar: f64, around: f64) -> (Vec3, f64) {
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

/// The hemisphere in the parameters of a table, cut at the table's nodes.
pub(super) struct Chart {
    pub(super) parameters: Parametrisation,
    /// Azimuth that the second number counts from.
    pub(super) turn: f64,
    /// Limits of the cells.
    pub(super) polar: Vec<f64>,
    pub(super) around: Vec<f64>,
}

impl Chart {
    /// Of a table with light from this polar angle and azimuth, radians. `None` for tables that are constant on cells,
    /// and where nothing was measured.
    pub(super) fn of(table: &Table, theta_i: f64, phi_i: f64) -> Option<Self> {
        match table {
            Table::Grid(grid) => of_grid(grid, theta_i, phi_i),
            Table::Scattered(scattered) => of_scattered(scattered, theta_i, phi_i),
            Table::Warped(warped) => Some(of_warped(warped, theta_i, phi_i)),
            Table::Klems(_) | Table::Tree(_) | Table::Specular(_) => None,
        }
    }

    /// Nodes may be in any order. Azimuths may have any value and are measured from `turn`.
    fn new(parameters: Parametrisation, turn: f64, polar_nodes: &[f64], azimuth_nodes: &[f64]) -> Self {
        let last = parameters.farthest();
        let inside = polar_nodes.iter().copied().filter(|a| *a > 1e-9 && *a < last - 1e-9);
        let mut polar: Vec<f64> = inside.chain([0.0, last]).collect();
        sort(&mut polar);
        let mut around: Vec<f64> = azimuth_nodes.iter().map(|a| a.rem_euclid(TAU)).collect();
        around.extend([0.0, TAU]);
        sort(&mut around);
        Self {
            parameters,
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

fn of_grid(grid: &Grid, theta_i: f64, phi_i: f64) -> Option<Chart> {
    let [first, _, third, last] = grid.axes().each_ref().map(|axis| axis.nodes_rad());
    let azimuths: Vec<f64> = if grid.axes()[3].is_single() {
        Vec::new()
    } else {
        last.iter().flat_map(|&phi| grid.fold().images(phi)).collect()
    };
    Some(match grid.parameters() {
        Parameters::Spherical => {
            let turn = if grid.is_isotropic() { phi_i } else { 0.0 };
            Chart::new(Parametrisation::Sphere, turn, third, &azimuths)
        }
        Parameters::Specular { offsets_rad } => {
            let tilt = theta_i + grid.offset(offsets_rad, theta_i)?;
            Chart::new(Parametrisation::Mirror { tilt }, phi_i, third, &azimuths)
        }
        Parameters::Distorted { offsets_rad } => {
            let tilt = theta_i + grid.offset(offsets_rad, theta_i)?;
            Chart::new(Parametrisation::Distorted { tilt }, phi_i, third, &azimuths)
        }
        Parameters::HalfDifference => Chart::new(Parametrisation::Half { theta_i }, phi_i, first, &[]),
    })
}

fn of_scattered(scattered: &Scattered, theta_i: f64, phi_i: f64) -> Option<Chart> {
    if scattered.directions() == Directions::Plane {
        return None;
    }
    let (polar, azimuths) = scattered.outgoing_nodes(theta_i, phi_i)?;
    let few = |nodes: Vec<f64>| if nodes.len() > MOST_NODES { Vec::new() } else { nodes };
    Some(Chart::new(Parametrisation::Sphere, 0.0, &few(polar), &few(azimuths)))
}

fn of_warped(warped: &Warped, theta_i: f64, phi_i: f64) -> Chart {
    Chart::new(Parametrisation::Half { theta_i }, phi_i, &warped.polar_nodes(), &[])
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
        for parameters in [
            Parametrisation::Sphere,
            Parametrisation::Mirror { tilt: 0.0 },
            Parametrisation::Mirror { tilt: 0.7 },
            Parametrisation::Mirror { tilt: FRAC_PI_2 },
            Parametrisation::Distorted { tilt: 0.9 },
            Parametrisation::Half { theta_i: 0.0 },
            Parametrisation::Half { theta_i: 1.2 },
        ] {
            let chart = Chart::new(parameters, 0.3, &polar, &azimuths);
            let mut sum = 0.0;
            for around in chart.around.windows(2) {
                for polar in chart.polar.windows(2) {
                    for (u, weight_u) in GAUSS_3 {
                        let phi = around[0] + u * (around[1] - around[0]);
                        let high = polar[1].min(parameters.horizon(phi)).max(polar[0]);
                        for (v, weight_v) in GAUSS_3 {
                            let (out, solid_angle) = parameters.at(polar[0] + v * (high - polar[0]), phi);
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
