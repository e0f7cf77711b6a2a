//! The angular parameters of tables, and the directions they represent.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::direction::{angles_of, direction};
use crate::geometry::Vec3;

/// The four angles that parametrise a file's values. Formulas take directions rotated to incident azimuth 0; in
/// transmission, the outgoing direction is first mirrored to the incident side.
#[derive(Clone, Debug, PartialEq)]
pub enum Parameters {
    /// Incident polar angle and azimuth, outgoing polar angle and azimuth. In anisotropic tables the outgoing azimuth
    /// counts from x, in isotropic ones from the incident azimuth.
    Spherical,
    /// Incident polar angle and azimuth, angle from the mirror direction, azimuth about it from the side of the normal.
    /// The offset at each incident polar angle is added to the polar angle of the mirror direction (refraction).
    Specular { offsets_rad: Vec<f64> },
    /// Half vector's polar angle and azimuth, incident direction's relative to it (Rusinkiewicz 1998).
    HalfDifference,
    /// As `Specular`, but equal circles about the mirror direction are squeezed into the disc r = 2θ/π.
    Distorted { offsets_rad: Vec<f64> },
}

/// Symmetry that gives the values outside the stored range of the last azimuth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fold {
    /// The whole circle is stored.
    None,
    /// φ and 360° − φ are the same: 0..180° is stored.
    Mirror,
    /// φ and φ + 180° are the same: 0..180° is stored.
    HalfTurn,
    /// Both: 0..90° is stored.
    MirrorAndHalfTurn,
}

impl Fold {
    /// The azimuths in radians represented by the value at a stored azimuth.
    pub(crate) fn images(self, phi_rad: f64) -> Vec<f64> {
        match self {
            Self::None => vec![phi_rad],
            Self::Mirror => vec![phi_rad, -phi_rad],
            Self::HalfTurn => vec![phi_rad, phi_rad + PI],
            Self::MirrorAndHalfTurn => vec![phi_rad, -phi_rad, phi_rad + PI, PI - phi_rad],
        }
    }

    /// An azimuth in radians, mapped to the stored range.
    pub(super) fn apply(self, phi_rad: f64) -> f64 {
        match self {
            Self::None => phi_rad,
            Self::Mirror if phi_rad > PI => TAU - phi_rad,
            Self::Mirror => phi_rad,
            Self::HalfTurn => phi_rad.rem_euclid(PI),
            Self::MirrorAndHalfTurn => {
                let half = phi_rad.rem_euclid(PI);
                if half > FRAC_PI_2 { PI - half } else { half }
            }
        }
    }
}

pub(crate) fn about_z(d: &Vec3, angle_rad: f64) -> Vec3 {
    let (sin, cos) = angle_rad.sin_cos();
    Vec3::new(cos * d.x - sin * d.y, sin * d.x + cos * d.y, d.z)
}

pub(super) fn about_y(d: &Vec3, angle_rad: f64) -> Vec3 {
    let (sin, cos) = angle_rad.sin_cos();
    Vec3::new(cos * d.x + sin * d.z, d.y, cos * d.z - sin * d.x)
}

/// Angle from the axis that is tilted away from the light, and azimuth about it.
pub(super) fn specular_angles(omega_out: &Vec3, tilt_rad: f64) -> (f64, f64) {
    angles_of(&about_y(omega_out, tilt_rad))
}

pub(crate) fn from_specular(theta_rad: f64, phi_rad: f64, tilt_rad: f64) -> Vec3 {
    about_y(&direction(theta_rad, phi_rad), -tilt_rad)
}

/// On the disc of radius 2θ/π, the circle of parameter r about the mirror direction has radius r and its centre at
/// (1 − r) times that direction's place; r and the azimuth about the centre.
pub(super) fn distorted_angles(omega_out: &Vec3, tilt_rad: f64) -> (f64, f64) {
    let (theta, phi) = angles_of(omega_out);
    let radius = theta / FRAC_PI_2;
    let mirror = -tilt_rad / FRAC_PI_2;
    let (x, y) = (radius * phi.cos() - mirror, radius * phi.sin());
    // |e + r d| = r with e from the mirror direction's place d to the point.
    let (ed, ee, a) = (x * mirror, x * x + y * y, 1.0 - mirror * mirror);
    let r = if a > 1e-12 {
        (ed + (ed * ed + a * ee).sqrt()) / a
    } else if ed < 0.0 {
        -ee / (2.0 * ed)
    } else {
        0.0
    };
    let azimuth = y.atan2(x + r * mirror).rem_euclid(TAU);
    (r * FRAC_PI_2, azimuth)
}

pub(crate) fn from_distorted(theta_rad: f64, phi_rad: f64, tilt_rad: f64) -> Vec3 {
    let r = theta_rad / FRAC_PI_2;
    let mirror = -tilt_rad / FRAC_PI_2;
    let (x, y) = (r * phi_rad.cos() + (1.0 - r) * mirror, r * phi_rad.sin());
    direction(x.hypot(y) * FRAC_PI_2, y.atan2(x))
}

pub(super) fn half_difference_angles(omega_in: &Vec3, omega_out: &Vec3) -> [f64; 4] {
    let (theta_h, phi_h) = angles_of(&(omega_in + omega_out));
    let (theta_d, phi_d) = angles_of(&about_y(&about_z(omega_in, -phi_h), -theta_h));
    [theta_h, phi_h, theta_d, phi_d]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mirror direction, and the side of the normal at azimuth 0.
    #[test]
    fn specular_angles_begin_at_the_mirror_direction_towards_the_normal() {
        let mirror = direction(0.4, PI);
        assert!(specular_angles(&mirror, 0.4).0 < 1e-12);
        let (theta, phi) = specular_angles(&direction(0.3, PI), 0.4);
        assert!((theta - 0.1).abs() < 1e-12 && phi.abs() < 1e-9);
    }
}
