use super::RigError;
use crate::cloth::{Cloth, Hit, YarnId};
use crate::fault::{self, Fault};
use crate::geometry::Vec3;
use rand::{Rng, RngExt};

/// Smallest cosine between view direction and normal at which a visible point is shaded.
const GRAZING_COSINE: f64 = 1e-6;

/// Strata of the unit cell, one jittered camera ray in each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelSamples {
    along_x: usize,
    along_y: usize,
}

impl PixelSamples {
    /// Number of strata along x and y, 1 to 65536 each.
    ///
    /// # Errors
    /// [`RigError::Samples`] if a number is out of range.
    pub fn new(along_x: usize, along_y: usize) -> Result<Self, RigError> {
        if [along_x, along_y].iter().all(|n| (1..=65536).contains(n)) {
            Ok(Self { along_x, along_y })
        } else {
            Err(RigError::Samples { along_x, along_y })
        }
    }

    /// Number of camera rays.
    pub fn count(&self) -> usize {
        self.along_x * self.along_y
    }
}

/// Intersection of a camera ray with the cloth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interaction {
    /// Unit vector (tangent, axis, normal) towards the viewer, above the surface. At a silhouette, where rounding may
    /// put it below the surface, it is rotated up to a cosine of 1e-6.
    pub omega_out_local: Vec3,
    pub hit: Hit,
}

impl Interaction {
    /// Local components of the direction towards the light; `None` if another yarn blocks it. f* includes the yarn's
    /// own shadow, so the direction may lie below the surface.
    pub fn light(&self, cloth: &Cloth, omega_in: &Vec3) -> Option<Vec3> {
        let hit = &self.hit;
        let owner = if fault::active(Fault::OwnShadow) {
            // An identity that no yarn of a cloth has.
            YarnId {
                index: u32::MAX,
                ..hit.yarn
            }
        } else {
            hit.yarn
        };
        (!cloth.shadowed(hit.position, *omega_in, owner)).then(|| hit.frame.to_local(omega_in))
    }
}

/// Views one unit cell from infinity along `omega_out`, on either side of the cloth's plane, and passes the
/// intersection of every camera ray to `visit`: `None` for a ray through a gap. Intersections do not depend on the
/// light, which may come from any direction, also from the other side.
///
/// Rays are uniform over the cell in the cloth's plane, so the mean of the radiances over all rays, gaps included, is
/// the radiance of the cloth. Do not divide by cosθ_v: the mean already includes it.
pub fn view_cell(
    cloth: &Cloth,
    omega_out: &Vec3,
    samples: &PixelSamples,
    rng: &mut impl Rng,
    mut visit: impl FnMut(Option<Interaction>),
) {
    let [cell_x, cell_y] = cloth.cell_mm();
    let away = omega_out * (2.0 * cloth.top_mm() / omega_out.z.abs());
    let inwards = -omega_out;
    let jitter = if fault::active(Fault::HalfPixel) { 0.5 } else { 1.0 };
    for row in 0..samples.along_y {
        for column in 0..samples.along_x {
            let x = (column as f64 + jitter * rng.random::<f64>()) / samples.along_x as f64 * cell_x;
            let y = (row as f64 + jitter * rng.random::<f64>()) / samples.along_y as f64 * cell_y;
            let origin = Vec3::new(x, y, 0.0) + away;
            visit(cloth.first_hit(origin, inwards).map(|hit| Interaction {
                omega_out_local: above_horizon(hit.frame.to_local(omega_out)),
                hit,
            }));
        }
    }
}

fn above_horizon(local: Vec3) -> Vec3 {
    if local.z >= GRAZING_COSINE {
        return local;
    }
    // The direction is never opposite to the normal, because the viewer sees the point.
    let along_surface = Vec3::new(local.x, local.y, 0.0).normalize();
    along_surface * (1.0 - GRAZING_COSINE * GRAZING_COSINE).sqrt() + Vec3::z() * GRAZING_COSINE
}
