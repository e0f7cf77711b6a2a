use super::Shape;
use super::flights::{FAR_MM, LANES, Lanes3, refract};
use super::lane_math::unit;
use super::walk::{ENTRY_COORDINATES, Entry};
use crate::optics::fresnel;
use rand_xoshiro::{Xoshiro256PlusPlus, rand_core::Rng};

/// Paths on the way in, as many as lanes: refracted, and followed straight to the other side.
pub(super) struct Entrance<T> {
    stream: Xoshiro256PlusPlus,
    /// Paths in all, and how many of them have come here.
    paths: usize,
    begun: usize,
    /// Paths that are ready, and how many of them have been fetched.
    ready: usize,
    fetched: usize,
    pub position: Lanes3,
    normal: Lanes3,
    omega_in: Lanes3,
    /// Inside.
    pub direction: Lanes3,
    /// Even number for the first flight.
    pub for_flight: [f64; LANES],
    pub reflectance: [f64; LANES],
    /// Straight through: distance (finite), what the surface there lets out, and where it leaves.
    pub chord_mm: [f64; LANES],
    pub transmittance: [f64; LANES],
    pub far_position: Lanes3,
    pub far_normal: Lanes3,
    pub far_direction: Lanes3,
    pub tag: [Option<T>; LANES],
}

impl<T: Copy> Entrance<T> {
    pub fn new(stream: Xoshiro256PlusPlus, paths: usize) -> Self {
        Self {
            stream,
            paths,
            begun: 0,
            ready: 0,
            fetched: 0,
            position: [[0.0; LANES]; 3],
            normal: [[0.0; LANES], [0.0; LANES], [1.0; LANES]],
            omega_in: [[0.0; LANES], [0.0; LANES], [1.0; LANES]],
            direction: [[0.0; LANES]; 3],
            for_flight: [0.0; LANES],
            reflectance: [0.0; LANES],
            chord_mm: [0.0; LANES],
            transmittance: [0.0; LANES],
            far_position: [[0.0; LANES]; 3],
            far_normal: [[0.0; LANES]; 3],
            far_direction: [[0.0; LANES]; 3],
            tag: [None; LANES],
        }
    }

    /// Place of the next path, if one is left.
    #[inline(always)]
    pub fn next<S: Shape>(
        &mut self,
        shape: &S,
        index: f64,
        entry: &mut impl FnMut(&[f64; ENTRY_COORDINATES]) -> Entry<T>,
    ) -> Option<usize> {
        if self.fetched == self.ready {
            self.ready = LANES.min(self.paths - self.begun);
            self.fetched = 0;
            self.fill(shape, index, entry);
        }
        let place = self.fetched;
        (place < self.ready).then(|| {
            self.fetched += 1;
            place
        })
    }

    #[inline(always)]
    fn fill<S: Shape>(&mut self, shape: &S, index: f64, entry: &mut impl FnMut(&[f64; ENTRY_COORDINATES]) -> Entry<T>) {
        for i in 0..self.ready {
            let mut coordinates = [0.0; ENTRY_COORDINATES];
            coordinates.iter_mut().for_each(|c| *c = unit(self.stream.next_u64()));
            coordinates[0] = (self.begun as f64 + coordinates[0]) / self.paths as f64;
            self.begun += 1;
            let entry = entry(&coordinates);
            self.for_flight[i] = unit(self.stream.next_u64());
            self.tag[i] = Some(entry.tag);
            for axis in 0..3 {
                self.position[axis][i] = entry.position[axis];
                self.normal[axis][i] = entry.normal[axis];
                self.omega_in[axis][i] = entry.omega_in[axis];
            }
        }
        let inverse_index = 1.0 / index;
        for i in 0..LANES {
            let at = |v: &Lanes3| [v[0][i], v[1][i], v[2][i]];
            let (position, normal, omega_in) = (at(&self.position), at(&self.normal), at(&self.omega_in));
            let cos_in = dot(normal, omega_in).clamp(0.0, 1.0);
            let outside = fresnel::interface(cos_in, index);
            let inwards = omega_in.map(|c| -c);
            let direction = refract(inwards, normal, cos_in, outside.cos_t, inverse_index);
            let distance = shape.distance(position, direction);
            let ahead = distance < FAR_MM;
            let chord = if ahead { distance } else { FAR_MM };
            let there = [
                position[0] + direction[0] * chord,
                position[1] + direction[1] * chord,
                position[2] + direction[2] * chord,
            ];
            let [far, far_normal] = shape.surface(there, direction);
            let cos_i = dot(direction, far_normal).clamp(0.0, 1.0);
            let inside = fresnel::interface(cos_i, inverse_index);
            let back = far_normal.map(|c| -c);
            let far_direction = refract(direction, back, cos_i, inside.cos_t, index);
            for axis in 0..3 {
                self.direction[axis][i] = direction[axis];
                self.far_position[axis][i] = far[axis];
                self.far_normal[axis][i] = far_normal[axis];
                self.far_direction[axis][i] = far_direction[axis];
            }
            self.reflectance[i] = outside.reflectance;
            self.chord_mm[i] = chord;
            self.transmittance[i] = if ahead { 1.0 - inside.reflectance } else { 0.0 };
        }
    }
}

#[inline(always)]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
