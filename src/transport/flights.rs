use super::Shape;
use super::angles::{Angles, Deflections};
use super::lane_math::{LANES, ln, sin_cos_turns, unit};
use super::stream::LaneStream;
use crate::optics::fresnel::{self, Interface};

/// Length that replaces an infinite flight, mm: ∞ times a coefficient of 0 would be NaN.
pub(super) const FAR_MM: f64 = 1e300;

/// Components x, y, z of a vector in every lane.
pub(super) type Lanes3 = [[f64; LANES]; 3];

/// One bit for each lane.
pub(super) type Mask = u32;

/// Positions, directions and counters of the paths being traced.
pub(super) struct Flights {
    /// Lanes that have a path.
    pub alive: Mask,
    pub stream: LaneStream<LANES>,
    pub position: Lanes3,
    pub direction: Lanes3,
    /// Hero wavelength (its index, stored as a float) and its mean free path 1/μ_s, mm.
    pub hero: [f64; LANES],
    pub mean_free_path: [f64; LANES],
    /// Uniform random number for the first flight, in [0, 1); negative once that flight is over.
    pub preset: [f64; LANES],
    /// Path length so far, mm.
    pub length: [f64; LANES],
    /// 1 once the path was scattered; an integer as wide as the other fields, for vector instructions.
    pub scattered: [u64; LANES],
    /// Internal reflections since the last scattering event.
    pub reflections: [u64; LANES],
}

/// The event at the end of one step of every lane.
#[derive(Default)]
pub(super) struct Step {
    /// 1 for a scattering event, 0 at the surface.
    pub scatters: [u64; LANES],
    /// Lanes with a path that was scattered.
    pub scattering: Mask,
    /// Length of the step, mm, finite.
    pub length: [f64; LANES],
    /// 1 where neither a particle nor a surface is ahead.
    pub lost: [u64; LANES],
    /// Fraction that leaves: 0 at a scattering event, and on the first flight, whose transmitted part has already been
    /// scored as an expected value.
    pub leaving: [f64; LANES],
    /// Outward unit normal of the surface; undefined at a scattering event.
    pub normal: Lanes3,
    pub cos_i: [f64; LANES],
    pub cos_t: [f64; LANES],
    pub deflection: Deflections,
    /// Uniform random numbers for the azimuth of scattering and for Russian roulette.
    for_azimuth: [f64; LANES],
    pub for_roulette: [f64; LANES],
}

impl Flights {
    pub fn new(stream: LaneStream<LANES>) -> Self {
        Self {
            alive: 0,
            stream,
            position: [[0.0; LANES]; 3],
            direction: [[0.0; LANES], [0.0; LANES], [1.0; LANES]],
            hero: [0.0; LANES],
            mean_free_path: [1.0; LANES],
            preset: [0.0; LANES],
            length: [0.0; LANES],
            scattered: [0; LANES],
            reflections: [0; LANES],
        }
    }

    /// Moves every lane to its next scattering event or to the surface. The loops are separate because each then
    /// compiles to vector instructions.
    #[inline(always)]
    pub fn fly<S: Shape>(&mut self, shape: &S, inverse_index: f64, angles: &Angles<'_>, step: &mut Step) {
        let (mut flight, mut for_angle) = ([0.0; LANES], [0.0; LANES]);
        for numbers in [
            &mut flight,
            &mut for_angle,
            &mut step.for_azimuth,
            &mut step.for_roulette,
        ] {
            for (i, number) in numbers.iter_mut().enumerate() {
                *number = unit(self.stream.next(i));
            }
        }
        angles.fetch(&self.hero, &for_angle, &mut step.deflection);
        for (i, flight) in flight.iter_mut().enumerate() {
            let preset = self.preset[i];
            let random = if preset >= 0.0 { preset } else { *flight };
            *flight = -ln(1.0 - random) * self.mean_free_path[i];
        }
        let mut distance = [0.0; LANES];
        for (i, distance) in distance.iter_mut().enumerate() {
            let asked = S::SIDE_BY_SIDE || self.alive & (1 << i) != 0;
            *distance = if asked {
                shape.distance(at(&self.position, i), at(&self.direction, i), flight[i])
            } else {
                f64::INFINITY
            };
        }
        for i in 0..LANES {
            let scatters = flight[i] < distance[i];
            let length = if scatters { flight[i] } else { distance[i] };
            let (p, d) = (at(&self.position, i), at(&self.direction, i));
            let moved = [p[0] + d[0] * length, p[1] + d[1] * length, p[2] + d[2] * length];
            let [on, normal] = if S::SIDE_BY_SIDE || !scatters && self.alive & (1 << i) != 0 {
                shape.surface(moved, d)
            } else {
                [moved, d]
            };
            for axis in 0..3 {
                self.position[axis][i] = if scatters { moved[axis] } else { on[axis] };
                step.normal[axis][i] = normal[axis];
            }
            step.cos_i[i] = (d[0] * normal[0] + d[1] * normal[1] + d[2] * normal[2]).clamp(0.0, 1.0);
            let ahead = length < FAR_MM;
            let length = if ahead { length } else { FAR_MM };
            step.length[i] = length;
            step.lost[i] = u64::from(!ahead);
            step.scatters[i] = u64::from(scatters);
            self.length[i] += length;
            self.scattered[i] |= u64::from(scatters);
            self.reflections[i] = if scatters { 0 } else { self.reflections[i] + 1 };
        }
        for i in 0..LANES {
            let Interface { reflectance, cos_t } = fresnel::interface(step.cos_i[i], inverse_index);
            let stays = (step.scatters[i] == 1) | (step.lost[i] == 1) | (self.preset[i] >= 0.0);
            step.leaving[i] = if stays { 0.0 } else { 1.0 - reflectance };
            step.cos_t[i] = cos_t;
            self.preset[i] = -1.0;
        }
        angles.draw(&mut step.deflection);
        step.scattering = self.alive & lanes_where(|lane| step.scatters[lane] == 1);
    }

    /// New directions: reflected at the surface, or deflected by the scattering angle.
    #[inline(always)]
    pub fn turn(&mut self, step: &Step) {
        let (mut sin, mut cos) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            (sin[i], cos[i]) = sin_cos_turns(step.for_azimuth[i]);
        }
        for i in 0..LANES {
            let d = at(&self.direction, i);
            let scattered = scatter(d, step.deflection.cos_theta[i], sin[i], cos[i]);
            let twice = 2.0 * step.cos_i[i];
            let scatters = step.scatters[i] == 1;
            for axis in 0..3 {
                let mirrored = d[axis] - step.normal[axis][i] * twice;
                self.direction[axis][i] = if scatters { scattered[axis] } else { mirrored };
            }
        }
    }
}

#[inline(always)]
fn at(of: &Lanes3, lane: usize) -> [f64; 3] {
    [of[0][lane], of[1][lane], of[2][lane]]
}

/// Mask of the lanes for which `holds` is true.
#[inline(always)]
pub(super) fn lanes_where(holds: impl Fn(usize) -> bool) -> Mask {
    let mut mask = 0;
    for lane in 0..LANES {
        mask |= Mask::from(holds(lane)) << lane;
    }
    mask
}

/// Iterates over the lanes of a mask. Used in `for` loops because closures would not be compiled for the instruction
/// set of the enclosing function.
pub(super) struct LanesOf(pub Mask);

impl Iterator for LanesOf {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        // The mask has no bits above the lanes; the remainder lets the compiler drop bounds checks.
        let lane = self.0.trailing_zeros() as usize % LANES;
        self.0 &= self.0 - 1;
        Some(lane)
    }
}

/// Unit direction after refraction. `normal` points to the side `direction` comes from; `ratio` = n_i/n_t.
#[inline(always)]
pub(super) fn refract(direction: [f64; 3], normal: [f64; 3], cos_i: f64, cos_t: f64, ratio: f64) -> [f64; 3] {
    let along = ratio * cos_i - cos_t;
    rescaled([
        direction[0] * ratio + normal[0] * along,
        direction[1] * ratio + normal[1] * along,
        direction[2] * ratio + normal[2] * along,
    ])
}

/// Deflects a direction by the polar angle of cosine `cos_theta`, at the azimuth of sine `sin` and cosine `cos`.
#[inline(always)]
fn scatter([dx, dy, dz]: [f64; 3], cos_theta: f64, sin: f64, cos: f64) -> [f64; 3] {
    let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
    let (x, y) = (sin_theta * cos, sin_theta * sin);
    // Orthonormal basis without a branch on the direction (Duff et al. 2017).
    let sign = 1.0f64.copysign(dz);
    let a = -1.0 / (sign + dz);
    let b = dx * dy * a;
    rescaled([
        dx * cos_theta + (1.0 + sign * dx * dx * a) * x + b * y,
        dy * cos_theta + sign * b * x + (sign + dy * dy * a) * y,
        dz * cos_theta - sign * dx * x - dy * y,
    ])
}

/// One Newton step towards length 1, which keeps rounding errors from growing over any number of scattering events.
#[inline(always)]
fn rescaled([x, y, z]: [f64; 3]) -> [f64; 3] {
    let scale = 1.5 - 0.5 * (x * x + y * y + z * z);
    [x * scale, y * scale, z * scale]
}
