use super::TransportError;
use crate::geometry::{Frame, Vec3};

/// A body in which paths can be traced. Points, mm, and directions are (x, y, z) components. Both functions run in
/// loops over lanes; shapes in this file avoid branches so that these loops compile to vector instructions.
pub trait Shape: Sync {
    /// Whether evaluating both functions in every lane is cheaper than skipping lanes that do not need them.
    const SIDE_BY_SIDE: bool = true;

    /// Distance to the surface ahead of a point inside (or on the surface, looking in) along a unit direction, mm;
    /// infinite if the ray never leaves. May be any value above `limit_mm` where the surface is not nearer than that.
    fn distance(&self, position: [f64; 3], direction: [f64; 3], limit_mm: f64) -> f64;

    /// Position on the surface, and outward unit normal there, for a point that [`Shape::distance`] along `direction`
    /// placed on it to rounding.
    fn surface(&self, position: [f64; 3], direction: [f64; 3]) -> [[f64; 3]; 2];
}

/// Infinite circular cylinder about the y axis. A surface point at azimuth φ lies at (R sin φ, y, R cos φ), so that
/// (x, y, z) are the (tangent, axis, normal) components at azimuth 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    radius_mm: f64,
}

impl Cylinder {
    /// Cylinder of a radius in mm.
    ///
    /// # Errors
    /// [`TransportError::Domain`] if the radius is not finite and above 0.
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

    /// Radius, mm.
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
    #[inline(always)]
    fn distance(&self, [px, _, pz]: [f64; 3], [dx, _, dz]: [f64; 3], _: f64) -> f64 {
        let a = dx * dx + dz * dz;
        let b = px * dx + pz * dz;
        let c = px * px + pz * pz - self.radius_mm * self.radius_mm;
        let root = (b * b - a * c).max(0.0).sqrt();
        // The farther root, in a form without cancellation.
        let numerator = if b > 0.0 { (-c).max(0.0) } else { root - b };
        let denominator = if b > 0.0 { b + root } else { a };
        // A ray parallel to the axis, to rounding, never leaves.
        if a > 1e-30 {
            numerator / denominator
        } else {
            f64::INFINITY
        }
    }

    #[inline(always)]
    fn surface(&self, [x, y, z]: [f64; 3], _: [f64; 3]) -> [[f64; 3]; 2] {
        let inverse = 1.0 / self.radius_mm;
        let normal = [x * inverse, 0.0, z * inverse];
        // One Newton step renormalises a vector whose length is 1 to rounding.
        let scale = 1.5 - 0.5 * (normal[0] * normal[0] + normal[2] * normal[2]);
        let normal = [normal[0] * scale, 0.0, normal[2] * scale];
        [[normal[0] * self.radius_mm, y, normal[2] * self.radius_mm], normal]
    }
}

/// Plane-parallel slab −thickness ≤ z ≤ 0, lit from above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slab {
    thickness_mm: f64,
}

impl Slab {
    /// Thickness in mm; infinite for a half space.
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
    #[inline(always)]
    fn distance(&self, [_, _, z]: [f64; 3], [_, _, dz]: [f64; 3], _: f64) -> f64 {
        let left = if dz > 0.0 { -z } else { self.thickness_mm + z };
        if dz.abs() > 1e-300 {
            left.max(0.0) / dz.abs()
        } else {
            f64::INFINITY
        }
    }

    #[inline(always)]
    fn surface(&self, [x, y, _]: [f64; 3], [_, _, dz]: [f64; 3]) -> [[f64; 3]; 2] {
        let up = dz > 0.0;
        let z = if up { 0.0 } else { -self.thickness_mm };
        [[x, y, z], [0.0, 0.0, if up { 1.0 } else { -1.0 }]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const FAR: f64 = f64::INFINITY;

    #[test]
    fn cylinder_chords() {
        let cylinder = Cylinder::new(0.15).unwrap();
        let entry = cylinder.at(0.3);
        let frame = cylinder.frame(&entry);
        let d = frame.to_world(&Vec3::new(0.2, 0.3, -1.0).normalize());
        let distance = cylinder.distance(entry.into(), d.into(), FAR);
        let in_plane = d.x * d.x + d.z * d.z;
        assert_relative_eq!(distance, -2.0 * 0.15 * d.dot(&frame.normal) / in_plane, epsilon = 1e-14);
        let there = entry + d * distance;
        let [position, normal] = cylinder.surface(there.into(), d.into());
        assert_relative_eq!(Vec3::from(position), there, epsilon = 1e-14);
        assert_relative_eq!(
            Vec3::from(normal) * 0.15,
            Vec3::new(there.x, 0.0, there.z),
            epsilon = 1e-14
        );
        let from_inside = cylinder.distance((entry + d * (0.9 * distance)).into(), d.into(), FAR);
        assert_relative_eq!(from_inside, 0.1 * distance, epsilon = 1e-13);
        assert_eq!(cylinder.distance([0.0; 3], [0.0, 1.0, 0.0], FAR), f64::INFINITY);
    }

    #[test]
    fn slab_faces() {
        let slab = Slab::new(2.0).unwrap();
        let p = [0.0, 0.0, -0.5];
        let (up, down) = ([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]);
        assert_eq!(slab.distance(p, up, FAR), 0.5);
        assert_eq!(slab.distance(p, down, FAR), 1.5);
        assert_eq!(slab.surface([0.1, 0.2, -1.9999], down), [[0.1, 0.2, -2.0], down]);
        assert_eq!(slab.surface([0.1, 0.2, 1e-9], up), [[0.1, 0.2, 0.0], up]);
        assert_eq!(slab.distance(p, [1.0, 0.0, 0.0], FAR), f64::INFINITY);
        assert_eq!(Slab::new(f64::INFINITY).unwrap().distance(p, down, FAR), f64::INFINITY);
        assert!(Slab::new(0.0).is_err() && Cylinder::new(-1.0).is_err() && Cylinder::new(f64::NAN).is_err());
    }
}
