use super::Shape;
use super::lane_math::{ln, sin_cos_turns, unit};
use super::stream::LaneStream;
use crate::optics::fresnel::{self, Interface};

/// Paths that fly side by side.
pub(super) const LANES: usize = 16;

/// In place of an infinite flight, so that no product with a coefficient of 0 arises.
pub(super) const FAR_MM: f64 = 1e300;

/// Components of a vector in every lane.
pub(super) type Lanes3 = [[f64; LANES]; 3];

/// Where the paths under way are.
pub(super) struct Flights {
    pub stream: LaneStream<LANES>,
    pub position: Lanes3,
    pub direction: Lanes3,
    /// Of the angle that a particle will turn the path by.
    pub cos_theta: [f64; LANES],
    /// 1/μ_s of the hero.
    pub mean_free_path: [f64; LANES],
    /// The next flight is drawn from `preset` + `drawn` × an even number: the first drawn at the entrance, later ones at random.
    pub preset: [f64; LANES],
    pub drawn: [f64; LANES],
    /// In mm: of the path so far, and since the weights were last worked out.
    pub length: [f64; LANES],
    pub since: [f64; LANES],
}

/// What one step of every lane met.
#[derive(Default)]
pub(super) struct Step {
    /// 1 where a particle was met, 0 at the surface; a number, to be as wide as the others.
    pub scatters: [u64; LANES],
    /// Infinite where neither is ahead.
    pub distance: [f64; LANES],
    /// Of the surface there, and what it lets out; of no meaning where a particle was met.
    pub normal: Lanes3,
    pub cos_i: [f64; LANES],
    pub cos_t: [f64; LANES],
    pub transmittance: [f64; LANES],
    /// Even numbers for the particle's angle, its azimuth, and roulette.
    pub for_angle: [f64; LANES],
    pub for_azimuth: [f64; LANES],
    pub for_roulette: [f64; LANES],
}

impl Flights {
    pub fn new(stream: LaneStream<LANES>) -> Self {
        Self {
            stream,
            position: [[0.0; LANES]; 3],
            direction: [[0.0; LANES], [0.0; LANES], [1.0; LANES]],
            cos_theta: [0.0; LANES],
            mean_free_path: [1.0; LANES],
            preset: [0.0; LANES],
            drawn: [0.0; LANES],
            length: [0.0; LANES],
            since: [0.0; LANES],
        }
    }

    /// Every lane to its next particle or to the surface. The loops are apart because each then compiles to vectors.
    #[inline(always)]
    pub fn fly<S: Shape>(&mut self, shape: &S, inverse_index: f64, step: &mut Step) {
        let mut flight = [0.0; LANES];
        for numbers in [
            &mut flight,
            &mut step.for_angle,
            &mut step.for_azimuth,
            &mut step.for_roulette,
        ] {
            for (i, number) in numbers.iter_mut().enumerate() {
                *number = unit(self.stream.next(i));
            }
        }
        for (i, flight) in flight.iter_mut().enumerate() {
            let random = self.preset[i] + self.drawn[i] * *flight;
            *flight = -ln(1.0 - random) * self.mean_free_path[i];
        }
        for (i, &flight) in flight.iter().enumerate() {
            let p = [self.position[0][i], self.position[1][i], self.position[2][i]];
            let d = [self.direction[0][i], self.direction[1][i], self.direction[2][i]];
            let distance = shape.distance(p, d);
            let scatters = flight < distance;
            let length = if scatters { flight } else { distance };
            let moved = [p[0] + d[0] * length, p[1] + d[1] * length, p[2] + d[2] * length];
            let [on, normal] = shape.surface(moved, d);
            let cos_i = (d[0] * normal[0] + d[1] * normal[1] + d[2] * normal[2]).clamp(0.0, 1.0);
            let Interface { reflectance, cos_t } = fresnel::interface(cos_i, inverse_index);
            for axis in 0..3 {
                self.position[axis][i] = if scatters { moved[axis] } else { on[axis] };
                step.normal[axis][i] = normal[axis];
            }
            let length = if length < FAR_MM { length } else { FAR_MM };
            self.length[i] += length;
            self.since[i] += length;
            self.preset[i] = 0.0;
            self.drawn[i] = 1.0;
            step.scatters[i] = u64::from(scatters);
            step.distance[i] = distance;
            step.transmittance[i] = 1.0 - reflectance;
            step.cos_i[i] = cos_i;
            step.cos_t[i] = cos_t;
        }
    }

    /// New directions: mirrored at the surface, turned by a particle.
    #[inline(always)]
    pub fn turn(&mut self, step: &Step) {
        for i in 0..LANES {
            let d = [self.direction[0][i], self.direction[1][i], self.direction[2][i]];
            let turned = scatter(d, self.cos_theta[i], step.for_azimuth[i]);
            let twice = 2.0 * step.cos_i[i];
            let scatters = step.scatters[i] == 1;
            for axis in 0..3 {
                let mirrored = d[axis] - step.normal[axis][i] * twice;
                self.direction[axis][i] = if scatters { turned[axis] } else { mirrored };
            }
        }
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

/// Turns a direction by the angle of cosine `cos_theta` to the side at `turns` of a full turn.
#[inline(always)]
fn scatter([dx, dy, dz]: [f64; 3], cos_theta: f64, turns: f64) -> [f64; 3] {
    let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
    let (sin, cos) = sin_cos_turns(turns);
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
