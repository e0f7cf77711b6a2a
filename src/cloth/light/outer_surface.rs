use crate::cloth::{Cloth, Hit};
use crate::geometry::Vec3;
use crate::optics::fresnel::{self, Interface};
use crate::yarn::Yarn;
use rand::{Rng, RngExt};

/// Upper limit of internal hits of a ray; light that has not left by then counts as scattered.
const INNER_HITS: usize = 16;

/// Optical depth beyond which the light of a ray is neglected (about 1e-6 of it).
const OPAQUE: f64 = 14.0;

/// Smooth surface of one system's yarns, for unscattered rays. Dispersion of the host would separate rays of different
/// wavelengths; the index at the middle wavelength is used for all.
#[derive(Clone, Copy, Debug)]
pub(super) struct OuterSurface {
    pub index: f64,
    /// Path length in the medium, mm, after which the light is negligible even at the most transparent wavelength.
    longest_mm: f64,
}

/// A ray that has passed through a yarn.
pub(super) struct Passage {
    pub position: Vec3,
    pub direction: Vec3,
    /// Path length in the medium, mm.
    pub length_mm: f64,
}

impl OuterSurface {
    pub fn new(yarn: &Yarn) -> Self {
        let medium = &yarn.medium;
        let hosts = medium.host_index();
        Self {
            index: hosts[hosts.len() / 2],
            longest_mm: OPAQUE / medium.extinction_per_mm().fold(f64::INFINITY, f64::min),
        }
    }

    /// Interface at the outer surface for a ray along `direction`.
    pub fn outside(&self, hit: &Hit, direction: &Vec3) -> Interface {
        fresnel::interface(cos_in(hit, direction), self.index)
    }

    /// Traces a refracted ray through the yarn. At each internal hit it is reflected with a probability equal to the
    /// reflectance. `None` if its light becomes negligible before it leaves.
    pub fn passage(
        &self,
        cloth: &Cloth,
        hit: &Hit,
        direction: &Vec3,
        outside: &Interface,
        rng: &mut impl Rng,
    ) -> Option<Passage> {
        let system = hit.yarn.system;
        let cos_in = cos_in(hit, direction);
        let mut position = hit.position;
        let mut direction = refracted(direction, &hit.frame.normal, cos_in, outside.cos_t, 1.0 / self.index);
        let mut length_mm = 0.0;
        for _ in 0..INNER_HITS {
            let step_mm = cloth.inside_distance(system, position.into(), direction.into(), f64::INFINITY);
            length_mm += step_mm;
            // An infinite length means that no surface was found.
            if length_mm.is_infinite() || length_mm > self.longest_mm {
                return None;
            }
            let (on_surface, normal) = cloth.surface(system, (position + direction * step_mm).into());
            let normal = Vec3::from(normal);
            position = on_surface.into();
            let cos_i = direction.dot(&normal).clamp(0.0, 1.0);
            let surface = fresnel::interface(cos_i, 1.0 / self.index);
            if rng.random::<f64>() >= surface.reflectance {
                return Some(Passage {
                    position,
                    direction: refracted(&direction, &-normal, cos_i, surface.cos_t, self.index),
                    length_mm,
                });
            }
            direction -= normal * (2.0 * cos_i);
        }
        None
    }
}

/// Unit direction of a ray after specular reflection at the outer surface.
pub(super) fn mirrored(hit: &Hit, direction: &Vec3) -> Vec3 {
    direction + hit.frame.normal * (2.0 * cos_in(hit, direction))
}

fn cos_in(hit: &Hit, direction: &Vec3) -> f64 {
    (-hit.frame.normal.dot(direction)).clamp(0.0, 1.0)
}

/// Unit direction after refraction. `normal` points to the side the light comes from; `ratio` = n_i/n_t.
fn refracted(direction: &Vec3, normal: &Vec3, cos_i: f64, cos_t: f64, ratio: f64) -> Vec3 {
    (direction * ratio + normal * (ratio * cos_i - cos_t)).normalize()
}
