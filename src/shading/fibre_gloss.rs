use super::ShadingError;
use crate::geometry::Vec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Angular distribution of the light that the surface of a yarn of fibres reflects. The fibres lie side by side in the
/// surface and wind about the yarn's axis; the lobe is wide across them and narrow along them.
///
/// Directions are unit vectors from the surface in (tangent, axis, normal) of [`crate::geometry::Frame`]. Fibres run
/// along t = cos(twist) axis + sin(twist) tangent: as `tangent` is the same way round for either sense of `axis`, a
/// positive twist is a right-handed screw, Z twist, of every yarn, and a negative one S twist.
///
/// The slopes of the facets have the anisotropic Trowbridge–Reitz distribution (E. Heitz, J. Comput. Graph. Tech. 3
/// (2014) 2, 48)
///
/// D(h) = 1 / (π α β (h_t²/α² + h_b²/β² + h_n²)²),
///
/// α along the fibres, β across them. β = 1 is a bed of round fibres, β = b/a one of elliptical fibres of width a and
/// height b: slopes across such a bed have exactly the distribution of the slopes of D across. Light is distributed
/// over the facets by their visible area (Smith's masking G); light reflected into the surface leaves as if the surface
/// reflected it once more:
///
/// p(ω_out | ω_in) = q(ω_out) + q(ω_out with its normal component reversed), q = G(ω_in) D(h) / (4 ω_in·n),
///
/// with h half-way between ω_in and the direction, and q = 0 where h looks into the surface. ∫ p dω over the outer
/// hemisphere is 1 for every ω_in, so the reflected fraction is Fresnel's reflectance of the smooth surface, the one
/// that refracted light is computed with. Facets do not shadow what they reflect, so F p / cosθ_out is not reciprocal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FibreGloss {
    along: f64,
    across: f64,
    sin_twist: f64,
    cos_twist: f64,
}

impl FibreGloss {
    /// `twist_rad` from −π/2 to π/2; `along` and `across`, α and β, from 0.001 to 1.
    ///
    /// # Errors
    /// [`ShadingError`] for the first value out of range.
    pub fn new(twist_rad: f64, along: f64, across: f64) -> Result<Self, ShadingError> {
        if !(-FRAC_PI_2..=FRAC_PI_2).contains(&twist_rad) {
            return Err(ShadingError::Twist { found_rad: twist_rad });
        }
        if let Some(found) = [along, across].into_iter().find(|r| !(0.001..=1.0).contains(r)) {
            return Err(ShadingError::Roughness { found });
        }
        let (sin_twist, cos_twist) = twist_rad.sin_cos();
        Ok(Self {
            along,
            across,
            sin_twist,
            cos_twist,
        })
    }

    /// Whether the lobe differs from its mirror image, as that of twisted fibres does.
    pub fn is_handed(&self) -> bool {
        // The cosine of a right angle is 0 to rounding only.
        self.along != self.across && self.sin_twist != 0.0 && self.cos_twist > 1e-12
    }

    /// Density p(ω_out | ω_in), 1/sr; 0 if ω_out is not above the surface. Light below the surface by a rounding error
    /// counts as grazing.
    pub fn density(&self, omega_in: &Vec3, omega_out: &Vec3) -> f64 {
        if omega_out.z <= 0.0 {
            return 0.0;
        }
        let [light, view] = [omega_in, omega_out].map(|omega| self.along_fibres(omega));
        let light = above(light);
        self.unfolded(&light, &view) + self.unfolded(&light, &Vec3::new(view.x, view.y, -view.z))
    }

    /// Draws ω_out from two uniform random numbers: a facet among those that ω_in sees, by J. Dupuy, A. Benyoub,
    /// Comput. Graph. Forum 42 (2023) e14867, and its mirror.
    pub fn draw(&self, omega_in: &Vec3, [u, v]: [f64; 2]) -> Vec3 {
        let light = above(self.along_fibres(omega_in));
        let stretched = Vec3::new(self.along * light.x, self.across * light.y, light.z).normalize();
        let height = (1.0 - v) * (1.0 + stretched.z) - stretched.z;
        let radius = (1.0 - height * height).max(0.0).sqrt();
        let (sin, cos) = (TAU * u).sin_cos();
        let round = stretched + Vec3::new(radius * cos, radius * sin, height);
        let facet = Vec3::new(self.along * round.x, self.across * round.y, round.z).normalize();
        let mirrored = facet * (2.0 * light.dot(&facet)) - light;
        let (x, y) = (mirrored.x, mirrored.y);
        Vec3::new(
            self.sin_twist * x + self.cos_twist * y,
            self.cos_twist * x - self.sin_twist * y,
            mirrored.z.abs(),
        )
    }

    /// Components along the fibres, across them and along the normal.
    fn along_fibres(&self, local: &Vec3) -> Vec3 {
        Vec3::new(
            self.sin_twist * local.x + self.cos_twist * local.y,
            self.cos_twist * local.x - self.sin_twist * local.y,
            local.z,
        )
    }

    /// q of a direction on either side of the surface, 1/sr.
    fn unfolded(&self, light: &Vec3, direction: &Vec3) -> f64 {
        let sum = light + direction;
        if sum.z <= 0.0 {
            return 0.0;
        }
        let shape = (sum.x / self.along).powi(2) + (sum.y / self.across).powi(2) + sum.z * sum.z;
        let facets = (sum.norm_squared() / shape).powi(2) / (PI * self.along * self.across);
        // G / ω_in·n = 2 / (z + √(z² + α² x² + β² y²)), finite at grazing light too.
        let sees = light.z + (self.along * light.x).hypot(self.across * light.y).hypot(light.z);
        0.5 * facets / sees
    }
}

fn above(mut direction: Vec3) -> Vec3 {
    direction.z = direction.z.max(0.0);
    direction
}
