use super::{omega_in, omega_out};
use crate::cloth::light::{Beam, LitBatch, LitViews, ViewCones};
use serde::{Deserialize, Serialize};

/// Directions of light and view in the plane of incidence.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Geometry {
    /// Angle of incidence from the cloth's normal, degrees, 0 or more.
    pub theta_i_deg: f64,
    /// Signed view angle, degrees, negative on the light's side of the normal.
    pub theta_v_deg: f64,
}

impl Geometry {
    /// Normal incidence and view: the reference of the ratios in Table 1.
    pub const NORMAL: Self = Self {
        theta_i_deg: 0.0,
        theta_v_deg: 0.0,
    };
}

/// Geometries grouped by incidence: each beam once, with its views.
#[derive(Clone, Debug, PartialEq)]
pub struct BeamsOfRig {
    lit: Vec<LitViews>,
    /// For each beam, the indices of its views among the geometries.
    places: Vec<Vec<usize>>,
    geometries: usize,
}

impl BeamsOfRig {
    /// Beams in the order in which their incidences first occur. `azimuth_deg` is the azimuth of the plane of incidence
    /// from the warp; `half_angle` that of the detector's aperture, radians.
    pub fn new(geometries: &[Geometry], azimuth_deg: f64, half_angle: f64) -> Self {
        let mut incidences: Vec<f64> = Vec::new();
        for geometry in geometries {
            if !incidences.contains(&geometry.theta_i_deg) {
                incidences.push(geometry.theta_i_deg);
            }
        }
        let mut of_rig = Self {
            lit: Vec::new(),
            places: Vec::new(),
            geometries: geometries.len(),
        };
        for theta_i_deg in incidences {
            let places: Vec<usize> = (0..geometries.len())
                .filter(|&place| geometries[place].theta_i_deg == theta_i_deg)
                .collect();
            let views = || places.iter().map(|&place| geometries[place].theta_v_deg);
            of_rig.lit.push(LitViews {
                beam: Beam {
                    omega_in: omega_in(theta_i_deg, azimuth_deg),
                    number: number_of(theta_i_deg),
                },
                cones: ViewCones::new(views().map(|theta| omega_out(theta, azimuth_deg)).collect(), half_angle),
                numbers: views().map(number_of).collect(),
            });
            of_rig.places.push(places);
        }
        of_rig
    }

    /// The beams, each with its views.
    pub fn lit(&self) -> &[LitViews] {
        &self.lit
    }

    /// Index of the first geometry of each beam.
    pub fn first_of_beams(&self) -> impl Iterator<Item = usize> + '_ {
        self.places.iter().filter_map(|places| places.first().copied())
    }

    /// Sums the results of several integrators: β at `[geometry][wavelength]`.
    pub fn sum<'b>(&self, parts: impl IntoIterator<Item = &'b LitBatch>, wavelengths: usize) -> Vec<Vec<f64>> {
        self.sum_of(parts.into_iter().map(|part| &part.beta), wavelengths)
    }

    /// The same of β at `[view][wavelength]` of each beam.
    pub fn sum_of<'b>(&self, parts: impl IntoIterator<Item = &'b Vec<Vec<f64>>>, wavelengths: usize) -> Vec<Vec<f64>> {
        let mut sums = vec![vec![0.0; wavelengths]; self.geometries];
        for (part, places) in parts.into_iter().zip(self.places.iter().cycle()) {
            for (&place, beta) in places.iter().zip(part) {
                sums[place].iter_mut().zip(beta).for_each(|(sum, beta)| *sum += beta);
            }
        }
        sums
    }
}

/// Number that separates the random streams of angles: the angle in millionths of a degree.
pub fn number_of(angle_deg: f64) -> usize {
    (angle_deg * 1e6).round() as isize as usize
}
