use super::Detector;
use crate::geometry::Vec3;
use crate::yarn::LengthBins;
use std::f64::consts::PI;

/// Moments of the light that leaves the cloth on the side of the light, by path length inside the yarns.
///
/// The radiance of reflected light is expanded in Zernike polynomials of the direction's projection (x, y) = sinθ (cosφ,
/// sinφ) on the cloth's plane, φ from the specular side of the plane of incidence. These are orthonormal over the unit
/// disk with weight dx dy = cosθ dω, so each coefficient is the mean of its polynomial over the light that leaves: every
/// particle contributes to every view, where a cone of 5° would score one of about 130. Only the terms in cos mφ are
/// kept, since those in sin mφ vanish in the plane of incidence, where views lie.
///
/// Light in the mirror direction of a smooth surface has no such density; the caller keeps it apart.
#[derive(Clone, Debug, PartialEq)]
pub struct RadianceMoments {
    polynomials: Vec<Zernike>,
    bins: LengthBins,
    /// Components x, y of the unit vector in the cloth's plane towards the specular side.
    forward: [f64; 2],
    views: Vec<Vec3>,
}

/// Polynomial R_n^m(r) cos mφ, normalised so that the integral of its square over the unit disk is 1.
#[derive(Clone, Debug, PartialEq)]
struct Zernike {
    m: u32,
    /// Coefficients of r^m, r^(m+2), … up to r^n, with the normalisation.
    coefficients: Vec<f64>,
}

impl Zernike {
    fn new(n: u32, m: u32) -> Self {
        let factorial = |k: u32| (1..=k).map(f64::from).product::<f64>();
        let norm = (f64::from(n + 1) * if m == 0 { 1.0 } else { 2.0 } / PI).sqrt();
        // Zernike 1934: R = Σ (−1)^s (n−s)! / (s! ((n+m)/2−s)! ((n−m)/2−s)!) r^(n−2s).
        let most = (n - m) / 2;
        let term = |s: u32| {
            let sign = if s.is_multiple_of(2) { 1.0 } else { -1.0 };
            sign * factorial(n - s) / (factorial(s) * factorial((n + m) / 2 - s) * factorial(most - s))
        };
        Self {
            m,
            coefficients: (0..=most).rev().map(|s| norm * term(s)).collect(),
        }
    }

    /// `angular`: real part of (x + iy)^m. `square`: r².
    fn value(&self, angular: &[f64], square: f64) -> f64 {
        let radial = self.coefficients.iter().rev().fold(0.0, |sum, c| sum * square + c);
        radial * angular[self.m as usize]
    }
}

impl RadianceMoments {
    /// Largest order n of a polynomial that may be asked for.
    pub const ORDER_AT_MOST: usize = 12;

    /// `order`: largest degree n of the polynomials, at most [`Self::ORDER_AT_MOST`], beyond which it is cut.
    /// `azimuth_deg`: of the plane of incidence from the warp. `views`: unit vectors towards views in that plane, to
    /// which scattering events are connected; the polynomials then hold the rest of the light alone.
    pub fn new(order: usize, bins: LengthBins, azimuth_deg: f64, views: Vec<Vec3>) -> Self {
        let order = order.min(Self::ORDER_AT_MOST) as u32;
        let of_degree = |n: u32| {
            (0..=n)
                .filter(move |m| (n - m).is_multiple_of(2))
                .map(move |m| Zernike::new(n, m))
        };
        let (sin, cos) = azimuth_deg.to_radians().sin_cos();
        Self {
            polynomials: (0..=order).flat_map(of_degree).collect(),
            bins,
            views,
            forward: [cos, sin],
        }
    }

    /// Number of polynomials.
    pub fn polynomials(&self) -> usize {
        self.polynomials.len()
    }

    /// Values of all polynomials for a direction with the projection (x, y) on the cloth's plane.
    fn values(&self, x: f64, y: f64, mut found: impl FnMut(usize, f64)) {
        let mut angular = [1.0; Self::ORDER_AT_MOST + 1];
        let (mut re, mut im) = (1.0, 0.0);
        for power in &mut angular[1..] {
            (re, im) = (re * x - im * y, re * y + im * x);
            *power = re;
        }
        let square = x * x + y * y;
        for (k, polynomial) in self.polynomials.iter().enumerate() {
            found(k, polynomial.value(&angular, square));
        }
    }

    /// Weights with which the moments of a length bin sum to the brightness factor at a signed view angle in degrees:
    /// β = Σ_k weight_k moment_k.
    pub fn weights(&self, theta_v_deg: f64) -> Vec<f64> {
        let mut weights = vec![0.0; self.polynomials()];
        self.values(theta_v_deg.to_radians().sin(), 0.0, |k, value| weights[k] = PI * value);
        weights
    }

    /// Index of the bin of polynomial `k` at a length bin.
    pub fn place(&self, k: usize, length_bin: usize) -> usize {
        k * self.bins.bins() + length_bin
    }

    /// Index of the bin of light connected to a view at a length bin, and of its moment in path length; in units of β.
    pub fn places_of_view(&self, view: usize, length_bin: usize) -> [usize; 2] {
        let amount = self.place(self.polynomials() + 2 * view, length_bin);
        [amount, amount + self.bins.bins()]
    }
}

impl Detector for RadianceMoments {
    fn bins(&self) -> usize {
        (self.polynomials() + 2 * self.views.len()) * self.bins.bins()
    }

    fn find(&self, direction: &Vec3, length_mm: f64, mut found: impl FnMut(usize, f64)) {
        if direction.z <= 0.0 {
            return;
        }
        let [cos, sin] = self.forward;
        let (x, y) = (
            direction.x * cos + direction.y * sin,
            direction.y * cos - direction.x * sin,
        );
        let bin = self.bins.bin(length_mm);
        self.values(x, y, |k, value| found(self.place(k, bin), value));
    }

    fn views(&self) -> &[Vec3] {
        &self.views
    }

    fn see(&self, view: usize, length_mm: f64, mut found: impl FnMut(usize, f64)) {
        let to_beta = PI / self.views[view].z;
        let [amount, moment] = self.places_of_view(view, self.bins.bin(length_mm));
        found(amount, to_beta);
        found(moment, to_beta * length_mm);
    }
}
