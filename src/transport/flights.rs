use super::Shape;
use super::angles::{Angles, Turns};
use super::lane_math::{LANES, ln, sin_cos_turns, unit};
use super::stream::LaneStream;
use crate::optics::fresnel::{self, Interface};

/// In place of an infinite flight, so that no product with a coefficient of 0 arises.
pub(super) const FAR_MM: f64 = 1e300;

/// Components of a vector in every lane.
pub(super) type Lanes3 = [[f64; LANES]; 3];

/// A bit for each lane.
pub(super) type Mask = u32;

/// Where the paths under way are.
pub(super) struct Flights {
    /// Lanes that have a path.
    pub alive: Mask,
    pub stream: LaneStream<LANES>,
    pub position: Lanes3,
    pub direction: Lanes3,
    /// Wavelength that flights and angles are drawn for, a whole number, and 1/μ_s of it.
    pub hero: [f64; LANES],
    pub mean_free_path: [f64; LANES],
    /// Even number that the first flight is drawn with; negative once it is over.
    pub preset: [f64; LANES],
    /// Of the path so far, mm.
    pub length: [f64; LANES],
    /// 1 once a particle was met; a number, to be as wide as the others.
    pub scattered: [u64; LANES],
    /// Reflections since the last particle.
    pub reflections: [u64; LANES],
}

/// What one step of every lane met.
#[derive(Default)]
pub(super) struct Step {
    /// 1 where a particle was met, 0 at the surface.
    pub scatters: [u64; LANES],
    /// Lanes that have a path and met a particle.
    pub scattering: Mask,
    /// Finite, mm.
    pub length: [f64; LANES],
    /// 1 where neither a particle nor a surface is ahead.
    pub lost: [u64; LANES],
    /// Fraction that leaves: 0 at a particle, and on the first flight, whose share has left already.
    pub leaving: [f64; LANES],
    /// Of the surface; of no meaning where a particle was met.
    pub normal: Lanes3,
    pub cos_i: [f64; LANES],
    pub cos_t: [f64; LANES],
    pub turns: Turns,
    /// Even numbers for the azimuth of the turn, and roulette.
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

    /// Every lane to its next particle or to the surface. The loops are apart because each then compiles to vectors.
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
        angles.fetch(&self.hero, &for_angle, &mut step.turns);
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
        angles.draw(&mut step.turns);
        step.scattering = self.alive & lanes_where(|lane| step.scatters[lane] == 1);
    }

    /// New directions: mirrored at the surface, turned by a particle.
    #[inline(always)]
    pub fn turn(&mut self, step: &Step) {
        let (mut sin, mut cos) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            (sin[i], cos[i]) = sin_cos_turns(step.for_azimuth[i]);
        }
        for i in 0..LANES {
            let d = at(&self.direction, i);
            let turned = scatter(d, step.turns.cos_theta[i], sin[i], cos[i]);
            let twice = 2.0 * step.cos_i[i];
            let scatters = step.scatters[i] == 1;
            for axis in 0..3 {
                let mirrored = d[axis] - step.normal[axis][i] * twice;
                self.direction[axis][i] = if scatters { turned[axis] } else { mirrored };
            }
        }
    }
}

#[inline(always)]
fn at(of: &Lanes3, lane: usize) -> [f64; 3] {
    [of[0][lane], of[1][lane], of[2][lane]]
}

/// The lanes of which something holds.
#[inline(always)]
pub(super) fn lanes_where(holds: impl Fn(usize) -> bool) -> Mask {
    let mut mask = 0;
    for lane in 0..LANES {
        mask |= Mask::from(holds(lane)) << lane;
    }
    mask
}

/// Goes through the lanes of a mask. Loops over it stand where closures would not be compiled for the instruction set of
/// their surroundings.
pub(super) struct LanesOf(pub Mask);

impl Iterator for LanesOf {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        // The mask has no bits above the lanes; said for the compiler.
        let lane = self.0.trailing_zeros() as usize % LANES;
        self.0 &= self.0 - 1;
        Some(lane)
    }
}

/// Unit direction behind an interface. `normal` points back to the side `direction` comes from; `ratio` = n_i/n_t.
#[inline(always)]
pub(super) fn refract(direction: [f64; 3], normal: [f64; 3], cos_i: f64, cos_t: f64, ratio: f64) -> [f64; 3] {
    let along = ratio * cos_i - cos_t;
    rescaled([
        direction[0] * ratio + normal[0] * along,
        direction[1] * ratio + normal[1] * along,
        direction[2] * ratio + normal[2] * along,
    ])
}

/// Turns a direction by the angle of cosine `cos_theta` to the side at an azimuth.
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

/// One Newton step keeps a length at 1 over any number of turns.
#[inline(always)]
fn rescaled([x, y, z]: [f64; 3]) -> [f64; 3] {
    let scale = 1.5 - 0.5 * (x * x + y * y + z * z);
    [x * scale, y * scale, z * scale]
}
