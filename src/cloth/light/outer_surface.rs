use crate::cloth::{Cloth, Hit};
use crate::geometry::Vec3;
use crate::optics::fresnel::{self, Interface};
use crate::yarn::Yarn;
use rand::{Rng, RngExt};

/// Surfaces inside that a ray meets at most; what has not left by then scatters.
const INNER_HITS: usize = 16;

/// Optical depth past which nothing of a ray is left, 1e-6 of its light.
const OPAQUE: f64 = 14.0;

/// The surface of one system's yarns, for rays that meet no particle. Dispersion of the host parts rays of different wavelengths; all
/// go the way of the middle one.
#[derive(Clone, Copy, Debug)]
pub(super) struct OuterSurface {
    pub index: f64,
    /// Way through the medium after which nothing is left at its clearest wavelength.
    longest_mm: f64,
}

/// A ray behind a yarn.
pub(super) struct Passage {
    pub position: Vec3,
    pub direction: Vec3,
    /// In the medium.
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

    /// The outer surface as a ray along `direction` meets it.
    pub fn outside(&self, hit: &Hit, direction: &Vec3) -> Interface {
        fresnel::interface(cos_in(hit, direction), self.index)
    }

    /// Where a ray comes out that the outer surface does not reflect: at each surface inside it is reflected with the probability of
    /// the reflectance. `None` if nothing is left of it before.
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
            // A search that found no surface is infinitely far.
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

/// Unit direction of a ray that the outer surface reflects.
pub(super) fn mirrored(hit: &Hit, direction: &Vec3) -> Vec3 {
    direction + hit.frame.normal * (2.0 * cos_in(hit, direction))
}

fn cos_in(hit: &Hit, direction: &Vec3) -> f64 {
    (-hit.frame.normal.dot(direction)).clamp(0.0, 1.0)
}

/// Unit direction behind an interface whose `normal` points back to where the light comes from; `ratio` = n_i/n_t.
fn refracted(direction: &Vec3, normal: &Vec3, cos_i: f64, cos_t: f64, ratio: f64) -> Vec3 {
    (direction * ratio + normal * (ratio * cos_i - cos_t)).normalize()
}
