use crate::geometry::Vec3;

/// Bins of directions that light leaves the cloth in. They may overlap, and need not cover the sphere.
pub trait Detector: Sync {
    fn bins(&self) -> usize;

    /// Hands over every bin that holds a unit direction away from the cloth.
    fn find(&self, direction: &Vec3, found: impl FnMut(usize));
}

/// A cone about each view of a rig, as the aperture of a goniophotometer.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewCones {
    views: Vec<Vec3>,
    cos_half_angle: f64,
}

impl ViewCones {
    /// Unit vectors towards the viewers, above the cloth; half angle of the cones in radians, below a right angle.
    pub fn new(views: Vec<Vec3>, half_angle: f64) -> Self {
        Self {
            views,
            cos_half_angle: half_angle.cos(),
        }
    }

    pub fn views(&self) -> &[Vec3] {
        &self.views
    }

    /// ∫ cosθ dω over the cone about view k, sr: of a cone wholly above the cloth.
    pub fn projected_solid_angle(&self, k: usize) -> f64 {
        std::f64::consts::PI * (1.0 - self.cos_half_angle * self.cos_half_angle) * self.views[k].z
    }
}

impl Detector for ViewCones {
    fn bins(&self) -> usize {
        self.views.len()
    }

    fn find(&self, direction: &Vec3, mut found: impl FnMut(usize)) {
        for (k, view) in self.views.iter().enumerate() {
            if view.dot(direction) > self.cos_half_angle {
                found(k);
            }
        }
    }
}
