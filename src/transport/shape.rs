use super::TransportError;
use crate::geometry::{Frame, Vec3};

/// Where a ray inside a body meets its surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boundary {
    /// Along the ray, mm; infinite if the ray never leaves.
    pub distance: f64,
    /// On the surface.
    pub position: Vec3,
    /// Outward unit normal.
    pub normal: Vec3,
}

/// A body the walk can run in.
pub trait Shape: Sync {
    /// The surface ahead of a point inside (or on the surface, looking in) along a unit direction.
    fn boundary(&self, position: &Vec3, direction: &Vec3) -> Boundary;
}

/// Infinite circular cylinder about the y axis. A surface point at azimuth φ lies at (R sin φ, y, R cos φ), so that
/// (x, y, z) are the (tangent, axis, normal) components at azimuth 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    radius_mm: f64,
}

impl Cylinder {
    pub fn new(radius_mm: f64) -> Result<Self, TransportError> {
        if radius_mm > 0.0 && radius_mm.is_finite() {
            Ok(Self { radius_mm })
        } else {
            Err(TransportError::Domain {
                quantity: "yarn radius",
                expected: "a finite length > 0 mm",
                found: radius_mm,
                remedy: "set [yarn] radius_mm to the radius of the yarn in mm",
            })
        }
    }

    pub fn radius_mm(&self) -> f64 {
        self.radius_mm
    }

    /// Surface point at an azimuth, y = 0.
    pub fn at(&self, azimuth: f64) -> Vec3 {
        Vec3::new(self.radius_mm * azimuth.sin(), 0.0, self.radius_mm * azimuth.cos())
    }

    /// Local frame of a surface point.
    #[inline]
    pub fn frame(&self, position: &Vec3) -> Frame {
        let normal = Vec3::new(position.x / self.radius_mm, 0.0, position.z / self.radius_mm);
        Frame {
            tangent: Vec3::new(normal.z, 0.0, -normal.x),
            axis: Vec3::y(),
            normal,
        }
    }
}

impl Shape for Cylinder {
    #[inline]
    fn boundary(&self, p: &Vec3, d: &Vec3) -> Boundary {
        let a = d.x * d.x + d.z * d.z;
        let b = p.x * d.x + p.z * d.z;
        let c = p.x * p.x + p.z * p.z - self.radius_mm * self.radius_mm;
        let root = (b * b - a * c).max(0.0).sqrt();
        // The farther root, in the form that does not cancel.
        let distance = if b > 0.0 {
            -c.min(0.0) / (b + root)
        } else {
            (root - b) / a
        };
        if !distance.is_finite() {
            return Boundary {
                distance: f64::INFINITY,
                position: *p,
                normal: Vec3::z(),
            };
        }
        let (x, z) = (p.x + distance * d.x, p.z + distance * d.z);
        let inverse = 1.0 / (x * x + z * z).sqrt();
        let normal = Vec3::new(x * inverse, 0.0, z * inverse);
        Boundary {
            distance,
            position: Vec3::new(
                normal.x * self.radius_mm,
                p.y + distance * d.y,
                normal.z * self.radius_mm,
            ),
            normal,
        }
    }
}

/// Plane-parallel slab −thickness ≤ z ≤ 0, lit from above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slab {
    thickness_mm: f64,
}

impl Slab {
    /// The thickness may be infinite: a half space.
    pub fn new(thickness_mm: f64) -> Result<Self, TransportError> {
        if thickness_mm > 0.0 {
            Ok(Self { thickness_mm })
        } else {
            Err(TransportError::Domain {
                quantity: "slab thickness",
                expected: "a length > 0 mm, infinity allowed",
                found: thickness_mm,
                remedy: "give the slab a thickness",
            })
        }
    }
}

impl Shape for Slab {
    #[inline]
    fn boundary(&self, p: &Vec3, d: &Vec3) -> Boundary {
        let (distance, z, normal) = if d.z > 0.0 {
            (-p.z / d.z, 0.0, Vec3::z())
        } else {
            ((self.thickness_mm + p.z) / -d.z, -self.thickness_mm, -Vec3::z())
        };
        if !distance.is_finite() {
            return Boundary {
                distance: f64::INFINITY,
                position: *p,
                normal,
            };
        }
        let distance = distance.max(0.0);
        Boundary {
            distance,
            position: Vec3::new(p.x + distance * d.x, p.y + distance * d.y, z),
            normal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn cylinder_chords() {
        let cylinder = Cylinder::new(0.15).unwrap();
        let entry = cylinder.at(0.3);
        let frame = cylinder.frame(&entry);
        let d = frame.to_world(&Vec3::new(0.2, 0.3, -1.0).normalize());
        let hit = cylinder.boundary(&entry, &d);
        let in_plane = d.x * d.x + d.z * d.z;
        assert_relative_eq!(
            hit.distance,
            -2.0 * 0.15 * d.dot(&frame.normal) / in_plane,
            epsilon = 1e-14
        );
        assert_relative_eq!(hit.position, entry + d * hit.distance, epsilon = 1e-14);
        let from_inside = cylinder.boundary(&(entry + d * (0.9 * hit.distance)), &d);
        assert_relative_eq!(from_inside.distance, 0.1 * hit.distance, epsilon = 1e-13);
        assert_eq!(cylinder.boundary(&Vec3::zeros(), &Vec3::y()).distance, f64::INFINITY);
    }

    #[test]
    fn slab_faces() {
        let slab = Slab::new(2.0).unwrap();
        let p = Vec3::new(0.0, 0.0, -0.5);
        assert_eq!(slab.boundary(&p, &Vec3::z()).distance, 0.5);
        assert_eq!(slab.boundary(&p, &-Vec3::z()).distance, 1.5);
        assert_eq!(slab.boundary(&p, &Vec3::x()).distance, f64::INFINITY);
        assert_eq!(
            Slab::new(f64::INFINITY).unwrap().boundary(&p, &-Vec3::z()).distance,
            f64::INFINITY
        );
        assert!(Slab::new(0.0).is_err() && Cylinder::new(-1.0).is_err() && Cylinder::new(f64::NAN).is_err());
    }
}
