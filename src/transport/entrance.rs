use super::Shape;
use super::flights::{FAR_MM, Lanes3, refract};
use super::lane_math::{LANES, unit};
use super::path::{ENTRY_COORDINATES, Entry};
use super::stream::LaneStream;
use crate::geometry::Vec3;
use crate::optics::fresnel;

/// A set of new paths, one for each lane, refracted into the body and followed straight to the far side: all that the
/// expected value of crossing light needs.
pub(super) struct Entrance {
    stream: LaneStream<LANES>,
    /// Total number of paths, and number of paths drawn so far.
    paths: usize,
    begun: usize,
    /// Number of paths in the present set, and number of these already started.
    ready: usize,
    fetched: usize,
    pub position: Lanes3,
    normal: Lanes3,
    omega_in: Lanes3,
    pub entries: [Entry; LANES],
    /// Index of each path among all paths.
    pub number: [usize; LANES],
    /// Direction inside the body, after refraction.
    pub direction: Lanes3,
    /// Uniform random number in [0, 1) for the first flight.
    pub for_flight: [f64; LANES],
    /// Fresnel reflectance at the entry point.
    pub reflectance: [f64; LANES],
    /// Straight path across the body: length, mm (finite), Fresnel transmittance at its end, and where and in which
    /// direction it leaves.
    pub chord_mm: [f64; LANES],
    pub transmittance: [f64; LANES],
    pub far_position: Lanes3,
    pub far_normal: Lanes3,
    pub far_direction: Lanes3,
}

impl Entrance {
    pub fn new(stream: LaneStream<LANES>, paths: usize) -> Self {
        Self {
            stream,
            paths,
            begun: 0,
            ready: 0,
            fetched: 0,
            position: [[0.0; LANES]; 3],
            normal: [[0.0; LANES], [0.0; LANES], [1.0; LANES]],
            omega_in: [[0.0; LANES], [0.0; LANES], [1.0; LANES]],
            entries: [Entry {
                position: Vec3::zeros(),
                normal: Vec3::z(),
                omega_in: Vec3::z(),
            }; LANES],
            number: [0; LANES],
            direction: [[0.0; LANES]; 3],
            for_flight: [0.0; LANES],
            reflectance: [0.0; LANES],
            chord_mm: [0.0; LANES],
            transmittance: [0.0; LANES],
            far_position: [[0.0; LANES]; 3],
            far_normal: [[0.0; LANES]; 3],
            far_direction: [[0.0; LANES]; 3],
        }
    }

    /// Number of paths not yet started.
    #[inline(always)]
    pub fn waiting(&self) -> usize {
        self.ready - self.fetched
    }

    /// Position in the set of the next path to start, if any.
    #[inline(always)]
    pub fn next(&mut self) -> Option<usize> {
        let place = self.fetched;
        (place < self.ready).then(|| {
            self.fetched += 1;
            // `place` is always below LANES; the remainder lets the compiler drop bounds checks.
            place % LANES
        })
    }

    /// Draws a new set of paths: as many as lanes, or as many as remain.
    #[inline(always)]
    pub fn fill<S: Shape>(&mut self, shape: &S, index: f64, entry: &mut dyn FnMut(&[f64; ENTRY_COORDINATES]) -> Entry) {
        self.ready = LANES.min(self.paths - self.begun);
        self.fetched = 0;
        let mut coordinates = [[0.0; LANES]; ENTRY_COORDINATES];
        for numbers in coordinates.iter_mut().chain([&mut self.for_flight]) {
            for (i, number) in numbers.iter_mut().enumerate() {
                *number = unit(self.stream.next(i));
            }
        }
        for i in 0..self.ready {
            let mut coordinates = coordinates.map(|numbers| numbers[i]);
            coordinates[0] = (self.begun as f64 + coordinates[0]) / self.paths as f64;
            self.number[i] = self.begun;
            self.begun += 1;
            let entry = entry(&coordinates);
            for axis in 0..3 {
                self.position[axis][i] = entry.position[axis];
                self.normal[axis][i] = entry.normal[axis];
                self.omega_in[axis][i] = entry.omega_in[axis];
            }
            self.entries[i] = entry;
        }
        let inverse_index = 1.0 / index;
        for i in 0..LANES {
            let at = |v: &Lanes3| [v[0][i], v[1][i], v[2][i]];
            let (position, normal, omega_in) = (at(&self.position), at(&self.normal), at(&self.omega_in));
            let cos_in = dot(normal, omega_in).clamp(0.0, 1.0);
            let outside = fresnel::interface(cos_in, index);
            let inwards = omega_in.map(|c| -c);
            let direction = refract(inwards, normal, cos_in, outside.cos_t, inverse_index);
            let distance = shape.distance(position, direction, f64::INFINITY);
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
