use super::Vec3;

/// Right-handed orthonormal frame of a yarn's surface: `tangent` runs around the yarn, `axis` along it, `normal`
/// outwards, and `tangent × axis = normal`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    pub tangent: Vec3,
    pub axis: Vec3,
    pub normal: Vec3,
}

impl Frame {
    /// The frame whose axis is along `axis` and whose normal is the part of `normal` perpendicular to it. Both must be
    /// finite, and not parallel.
    pub fn from_axis_normal(axis: Vec3, normal: Vec3) -> Self {
        let axis = axis.normalize();
        let normal = (normal - axis * axis.dot(&normal)).normalize();
        Self {
            tangent: axis.cross(&normal),
            axis,
            normal,
        }
    }

    /// Components (tangent, axis, normal) of a world vector.
    pub fn to_local(&self, world: &Vec3) -> Vec3 {
        Vec3::new(self.tangent.dot(world), self.axis.dot(world), self.normal.dot(world))
    }

    /// World vector with the given (tangent, axis, normal) components.
    pub fn to_world(&self, local: &Vec3) -> Vec3 {
        self.tangent * local.x + self.axis * local.y + self.normal * local.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn frame_is_right_handed_and_inverts_itself() {
        let frame = Frame::from_axis_normal(Vec3::new(1.0, 2.0, -0.5), Vec3::new(0.3, 0.1, 0.9));
        assert_relative_eq!(frame.tangent.cross(&frame.axis), frame.normal, epsilon = 1e-14);
        let v = Vec3::new(0.2, -0.7, 0.4);
        assert_relative_eq!(frame.to_world(&frame.to_local(&v)), v, epsilon = 1e-14);
    }
}
