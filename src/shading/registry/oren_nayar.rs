use super::facets::finite;
use crate::geometry::Vec3;
use crate::shading::model::DIFFUSE;
use crate::shading::{ClassicalModel, Lobes, Parameter, ShadingError, ShadingModel};

/// Slope of the grooves where no fit has found one; theirs for a rough surface of plaster is 20° to 40°.
const START_DEG: f64 = 20.0;

/// A rough surface without gloss.
pub(super) static MODEL: ClassicalModel = ClassicalModel {
    id: "oren-nayar",
    label: "Oren–Nayar",
    parameters: &[
        DIFFUSE,
        Parameter {
            name: "slope",
            unit: "degrees",
            range: [0.0, 90.0],
            meaning: "standard deviation of the angle of the grooves' walls",
        },
    ],
    start: |_| vec![1.0, START_DEG],
    build: |basis, values| {
        let &[diffuse, slope_deg] = values else {
            return Err(MODEL.wrong_count(values));
        };
        if !(0.0..=90.0).contains(&slope_deg) {
            return Err(ShadingError::Slope { found_deg: slope_deg });
        }
        let s2 = slope_deg.to_radians().powi(2);
        Ok(Box::new(OrenNayar {
            albedo: finite(basis.normal.map(|factor| diffuse * factor))?,
            a: 1.0 - 0.5 * s2 / (s2 + 0.33),
            b: 0.45 * s2 / (s2 + 0.09),
        }))
    },
};

/// V-shaped grooves with Lambertian walls, M. Oren, S. K. Nayar (SIGGRAPH 1994, 239, eq. 30), the qualitative model
/// without interreflection, which is linear in the albedo a:
///
/// f = a/π (A + B max(0, cos φ) sin α tan β), A = 1 − 0.5 σ²/(σ² + 0.33), B = 0.45 σ²/(σ² + 0.09),
///
/// σ the slope in radians, φ the azimuth between light and viewer, α the larger and β the smaller of their angles from
/// the normal. The approximation reflects up to 1.5 % more than its albedo at grazing incidence, where the
/// directional-hemispherical reflectance is a (A + B/2).
struct OrenNayar {
    albedo: [f64; 4],
    a: f64,
    b: f64,
}

impl ShadingModel for OrenNayar {
    fn albedo(&self) -> [f64; 4] {
        self.albedo
    }

    fn lobes(&self, omega_in: &Vec3, omega_out: &Vec3) -> Lobes {
        let (n_l, n_v) = (omega_in.z, omega_out.z);
        if n_l <= 0.0 || n_v <= 0.0 {
            return Lobes::default();
        }
        // sin θ_l sin θ_v cos φ is the scalar product within the plane; over the larger cosine it is
        // cos φ sin α tan β.
        let in_plane = omega_in.x * omega_out.x + omega_in.y * omega_out.y;
        Lobes {
            base: self.a + self.b * in_plane.max(0.0) / n_l.max(n_v),
            gloss: 0.0,
        }
    }
}
