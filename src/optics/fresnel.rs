//! Fresnel's equations of a smooth dielectric interface for unpolarised light (Born & Wolf, Principles of Optics,
//! §1.5).

use crate::fault::{self, Fault};

/// Reflection and refraction of unpolarised light at an interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Reflected fraction of the power, mean of both polarisations; 1 at total internal reflection.
    pub reflectance: f64,
    /// Cosine of the refraction angle; 0 at total internal reflection.
    pub cos_t: f64,
}

/// `cos_i` in 0..=1 is the cosine of the angle of incidence, `eta` = n_t/n_i the index beyond the interface relative to
/// the one on the side the light comes from.
#[inline(always)]
pub fn interface(cos_i: f64, eta: f64) -> Interface {
    // One `eta` for many angles: this division then leaves the loop over them.
    let sin2_t = (1.0 - cos_i * cos_i) * (1.0 / (eta * eta));
    let cos_t = (1.0 - sin2_t).max(0.0).sqrt();
    // Both amplitudes over one denominator: a division less, and no branch, so that loops over lanes stay vectors.
    let (s, s_sum) = (cos_i - eta * cos_t, cos_i + eta * cos_t);
    let (p, p_sum) = (eta * cos_i - cos_t, eta * cos_i + cos_t);
    let (a, b, c) = (s * p_sum, p * s_sum, s_sum * p_sum);
    let both = if fault::active(Fault::FresnelPolarisation) {
        a * a
    } else {
        0.5 * (a * a + b * b)
    };
    let partial = both / (c * c);
    Interface {
        reflectance: if sin2_t < 1.0 { partial } else { 1.0 },
        cos_t,
    }
}

/// Reflected fraction of unpolarised power.
pub fn reflectance(cos_i: f64, eta: f64) -> f64 {
    interface(cos_i, eta).reflectance
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn normal_incidence_and_reciprocity() {
        let n: f64 = 1.557;
        assert_relative_eq!(reflectance(1.0, n), ((n - 1.0) / (n + 1.0)).powi(2), epsilon = 1e-15);
        for cos_i in [0.05, 0.3, 0.7, 0.99] {
            let outside = interface(cos_i, n);
            let inside = interface(outside.cos_t, 1.0 / n);
            assert_relative_eq!(outside.reflectance, inside.reflectance, epsilon = 1e-13);
            assert_relative_eq!(inside.cos_t, cos_i, epsilon = 1e-13);
        }
    }

    #[test]
    fn limits() {
        assert_eq!(reflectance(0.6, 1.0), 0.0);
        assert_relative_eq!(reflectance(1e-9, 1.5), 1.0, epsilon = 1e-6);
        assert_eq!(reflectance(0.2, 1.0 / 1.5), 1.0);
        let brewster = (1.0f64 / (1.0 + 1.5 * 1.5)).sqrt();
        let cos_t = interface(brewster, 1.5).cos_t;
        let s = (brewster - 1.5 * cos_t) / (brewster + 1.5 * cos_t);
        assert_relative_eq!(reflectance(brewster, 1.5), 0.5 * s * s, epsilon = 1e-15);
    }
}
