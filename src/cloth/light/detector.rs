use crate::geometry::Vec3;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Bins of exit directions. They may overlap and need not cover the sphere.
pub trait Detector: Sync {
    /// Number of bins.
    fn bins(&self) -> usize;

    /// Calls `found` for every bin that scores light leaving along the unit vector `direction`, with the factor by which
    /// it scores. `length_mm` is the path length inside yarns of light traced through media, and 0 of other light.
    fn find(&self, direction: &Vec3, length_mm: f64, found: impl FnMut(usize, f64));
}

/// A cone about each view of a rig, like the aperture of a goniophotometer.
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

    /// Unit vectors towards the viewers.
    pub fn views(&self) -> &[Vec3] {
        &self.views
    }

    /// ∫ cosθ dω over the cone about view k, sr; exact for a cone entirely above the cloth.
    pub fn projected_solid_angle(&self, k: usize) -> f64 {
        std::f64::consts::PI * (1.0 - self.cos_half_angle * self.cos_half_angle) * self.views[k].z
    }
}

impl Detector for ViewCones {
    fn bins(&self) -> usize {
        self.views.len()
    }

    fn find(&self, direction: &Vec3, _: f64, mut found: impl FnMut(usize, f64)) {
        for (k, view) in self.views.iter().enumerate() {
            if view.dot(direction) > self.cos_half_angle {
                found(k, 1.0);
            }
        }
    }
}

/// Nodes of the hemisphere about +z: the normal, then rings in equal polar steps out to the horizon, each with nodes at
/// equal azimuths from x on.
///
/// Light is distributed over the four nodes around its direction with the weights of bilinear interpolation in polar
/// angle and azimuth. A node's f is its light divided by its projected solid angle; the bilinear interpolation of these
/// f conserves the energy exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HemisphereNodes {
    rings: usize,
    azimuths: usize,
}

impl HemisphereNodes {
    /// `rings`: number of rings in a right angle, 2 or more. `azimuths`: nodes of each ring, a multiple of 4, so that
    /// reversing or exchanging x and y maps nodes to nodes. `None` otherwise.
    pub fn new(rings: usize, azimuths: usize) -> Option<Self> {
        (rings >= 2 && azimuths >= 4 && azimuths.is_multiple_of(4)).then_some(Self { rings, azimuths })
    }

    /// Number of rings from the normal to the horizon.
    pub fn rings(&self) -> usize {
        self.rings
    }

    /// Number of nodes of each ring.
    pub fn azimuths(&self) -> usize {
        self.azimuths
    }

    /// Number of all nodes.
    pub fn count(&self) -> usize {
        1 + self.rings * self.azimuths
    }

    /// Index of a node; ring 0 is the normal whatever the azimuth.
    pub fn node(&self, ring: usize, azimuth: usize) -> usize {
        match ring {
            0 => 0,
            _ => 1 + (ring - 1) * self.azimuths + azimuth,
        }
    }

    /// Polar angle and azimuth of a node, radians.
    pub fn angles_rad(&self, node: usize) -> [f64; 2] {
        let Some(beside) = node.checked_sub(1) else {
            return [0.0; 2];
        };
        let [ring, azimuth] = [beside / self.azimuths + 1, beside % self.azimuths];
        [self.polar_rad(ring as f64), azimuth as f64 * TAU / self.azimuths as f64]
    }

    /// Index of the node nearest to an upward direction.
    pub fn nearest(&self, d: &Vec3) -> usize {
        let [polar, around] = self.coordinates(d);
        let ring = (polar.round() as usize).min(self.rings);
        self.node(ring, around.round() as usize % self.azimuths)
    }

    /// ∫ s cosθ dω, sr, with s the node's weight for light of each direction; the sum over nodes is π.
    pub fn projected_solid_angle(&self, node: usize) -> f64 {
        let ring = match node {
            0 => 0.0,
            _ => ((node - 1) / self.azimuths + 1) as f64,
        };
        let [inner, own, outer] = [ring - 1.0, ring, ring + 1.0].map(|ring| self.polar_rad(ring));
        let step = own - inner;
        // ∫ (θ − a) sinθ cosθ dθ = sin 2θ / 8 − (θ − a) cos 2θ / 4
        let from = |a: f64, theta: f64| (2.0 * theta).sin() / 8.0 - (theta - a) * (2.0 * theta).cos() / 4.0;
        let rising = if node == 0 {
            0.0
        } else {
            from(inner, own) - from(inner, inner)
        };
        let falling = if ring == self.rings as f64 {
            0.0
        } else {
            from(outer, own) - from(outer, outer)
        };
        let azimuths = if node == 0 { 1 } else { self.azimuths };
        (rising + falling) / step * TAU / azimuths as f64
    }

    /// Calls `found` for the nodes around an upward unit vector with the weight of each; the weights sum to 1.
    pub fn share(&self, d: &Vec3, mut found: impl FnMut(usize, f64)) {
        let [polar, around] = self.coordinates(d);
        let ring = (polar as usize).min(self.rings - 1);
        let outwards = polar - ring as f64;
        let sector = around as usize;
        let onwards = around - sector as f64;
        let mut both = |ring: usize, share: f64| {
            if ring == 0 {
                found(0, share);
                return;
            }
            found(self.node(ring, sector % self.azimuths), share * (1.0 - onwards));
            found(self.node(ring, (sector + 1) % self.azimuths), share * onwards);
        };
        both(ring, 1.0 - outwards);
        both(ring + 1, outwards);
    }

    fn polar_rad(&self, ring: f64) -> f64 {
        ring * FRAC_PI_2 / self.rings as f64
    }

    /// Polar angle and azimuth (0 to 2π) in units of the steps between nodes.
    fn coordinates(&self, d: &Vec3) -> [f64; 2] {
        let polar = d.x.hypot(d.y).atan2(d.z).min(FRAC_PI_2) / FRAC_PI_2;
        let around = d.y.atan2(d.x) / TAU;
        [
            polar * self.rings as f64,
            (if around < 0.0 { around + 1.0 } else { around }) * self.azimuths as f64,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use std::f64::consts::PI;

    fn up(theta: f64, phi: f64) -> Vec3 {
        Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    }

    #[test]
    fn nodes_take_all_light_and_know_their_solid_angle() {
        let nodes = HemisphereNodes::new(6, 8).unwrap();
        let all: f64 = (0..nodes.count()).map(|node| nodes.projected_solid_angle(node)).sum();
        assert_relative_eq!(all, PI, epsilon = 1e-14);
        // Weights under uniform radiance, by the midpoint rule.
        let (rows, columns) = (600, 96);
        let mut taken = vec![0.0; nodes.count()];
        for i in 0..rows {
            let theta = (i as f64 + 0.5) / rows as f64 * FRAC_PI_2;
            let flux = theta.sin() * theta.cos() * FRAC_PI_2 / rows as f64 * TAU / columns as f64;
            for j in 0..columns {
                let mut sum = 0.0;
                nodes.share(&up(theta, (j as f64 + 0.5) / columns as f64 * TAU), |node, share| {
                    assert!(share >= 0.0);
                    sum += share;
                    taken[node] += share * flux;
                });
                assert_relative_eq!(sum, 1.0, epsilon = 1e-14);
            }
        }
        for (node, taken) in taken.iter().enumerate() {
            assert_relative_eq!(*taken, nodes.projected_solid_angle(node), max_relative = 1e-4);
            let [theta, phi] = nodes.angles_rad(node);
            assert_eq!(nodes.nearest(&up(theta, phi)), node);
        }
    }
}
