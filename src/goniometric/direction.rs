//! Directions and the angles that tables hold.

use crate::geometry::Vec3;

pub(crate) fn every_tenth_degree() -> Vec<f64> {
    (0..9).map(|i| f64::from(10 * i).to_radians()).collect()
}

/// Degrees as written in the file: converts from radians and removes the rounding error of the conversion.
pub(crate) fn rounded_deg(angle_rad: f64) -> f64 {
    (angle_rad.to_degrees() * 1e9).round() / 1e9
}

/// Unit vector of a polar angle and an azimuth.
pub fn direction(theta_rad: f64, phi_rad: f64) -> Vec3 {
    let (sin, cos) = theta_rad.sin_cos();
    Vec3::new(sin * phi_rad.cos(), sin * phi_rad.sin(), cos)
}

/// Polar angle and azimuth, 0..2π, of a vector; exact near the poles too.
pub(crate) fn angles_of(v: &Vec3) -> (f64, f64) {
    let theta = v.x.hypot(v.y).atan2(v.z);
    (theta, v.y.atan2(v.x).rem_euclid(std::f64::consts::TAU))
}

pub(crate) fn radians(degrees: &[f64]) -> Vec<f64> {
    degrees.iter().map(|angle| angle.to_radians()).collect()
}

pub(crate) fn degrees(nodes_rad: &[f64]) -> Vec<f64> {
    nodes_rad.iter().map(|&angle| rounded_deg(angle)).collect()
}
