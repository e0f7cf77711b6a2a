use super::{Ledger, Shape, TransportError};
use crate::geometry::Vec3;
use crate::optics::Phase;
use crate::optics::fresnel::{self, Interface};
use rand::{Rng, RngExt};

/// Optical properties inside a body at one wavelength.
#[derive(Clone, Copy, Debug)]
pub struct Interior<'a> {
    /// Index of the host relative to the outside.
    pub index: f64,
    /// Scattering coefficient, 1/mm.
    pub mu_s: f64,
    /// Absorption coefficient, 1/mm.
    pub mu_a: f64,
    pub phase: &'a Phase,
}

/// Unbiased end of a path: below `threshold` of the weight it entered with, a path survives with probability
/// `survival` and is then worth 1/`survival` times as much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roulette {
    threshold: f64,
    survival: f64,
}

impl Roulette {
    pub fn new(threshold: f64, survival: f64) -> Result<Self, TransportError> {
        for (quantity, found, top) in [
            ("roulette threshold", threshold, 1.0),
            ("roulette survival", survival, 1.0),
        ] {
            if !(found > 0.0 && found < top) {
                return Err(TransportError::Domain {
                    quantity,
                    expected: "a fraction between 0 and 1, exclusive",
                    found,
                    remedy: "take the default by leaving it out of [trace]",
                });
            }
        }
        Ok(Self { threshold, survival })
    }
}

impl Default for Roulette {
    fn default() -> Self {
        Self {
            threshold: 0.1,
            survival: 0.2,
        }
    }
}

/// Reflections in a row, with no particle between them, after which roulette is played whatever the weight. Light that
/// entered at a grazing angle, or that total reflection traps in a body that hardly scatters, loses next to nothing in
/// each and would go round without end.
const REFLECTIONS_IN_A_ROW: u32 = 10_000;

/// A part of a path's weight that leaves the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exit {
    pub position: Vec3,
    /// Outward unit normal.
    pub normal: Vec3,
    /// Unit direction outside, away from the body.
    pub direction: Vec3,
    /// Fraction of the path's incident flux.
    pub weight: f64,
    /// Whether it met a particle; if not it is ballistic, and its direction a delta.
    pub scattered: bool,
}

/// The transport kernel: one path at one wavelength. Flights are drawn from the scattering coefficient alone,
/// absorption is the weight exp(−μ_a s); at each inner hit the transmitted part leaves as an expected value and the
/// rest flies on, total internal reflection included. Nothing ends a path but an empty weight and roulette.
#[derive(Clone, Copy, Debug)]
pub struct Walk<'a, S> {
    pub shape: &'a S,
    pub interior: Interior<'a>,
    pub roulette: Roulette,
}

impl<S: Shape> Walk<'_, S> {
    /// Follows light from `omega_in` (towards the light, above the surface) that meets the surface at `position` with
    /// outward `normal`, hands every exit to `sink`, and returns the ledger of the path, which sums to 1 to rounding.
    #[inline]
    pub fn run(
        &self,
        rng: &mut impl Rng,
        position: &Vec3,
        normal: &Vec3,
        omega_in: &Vec3,
        mut sink: impl FnMut(&Exit),
    ) -> Ledger {
        let Interior {
            index,
            mu_s,
            mu_a,
            phase,
        } = self.interior;
        let cos_in = normal.dot(omega_in).clamp(0.0, 1.0);
        let Interface { reflectance, cos_t } = fresnel::interface(cos_in, index);
        let mut ledger = Ledger {
            reflected: reflectance,
            ..Ledger::default()
        };
        let mut weight = 1.0 - reflectance;
        let threshold = self.roulette.threshold * weight;
        let mut direction = refract(&-omega_in, normal, cos_in, cos_t, 1.0 / index);
        let mut position = *position;
        let mut scattered = false;
        let mut reflections = 0;
        while weight > 0.0 {
            let boundary = self.shape.boundary(&position, &direction);
            let flight = -(1.0 - rng.random::<f64>()).ln() / mu_s;
            let step = flight.min(boundary.distance);
            let after = if mu_a > 0.0 {
                weight * (-mu_a * step).exp()
            } else {
                weight
            };
            ledger.absorbed += weight - after;
            weight = after;
            if flight < boundary.distance {
                position += direction * step;
                direction = scatter(&direction, phase.sample(rng.random()), rng);
                scattered = true;
                reflections = 0;
            } else if boundary.distance == f64::INFINITY {
                // Neither a particle nor a surface ahead: what is left is absorbed on the way to infinity.
                ledger.absorbed += weight;
                break;
            } else {
                position = boundary.position;
                let cos_i = direction.dot(&boundary.normal).clamp(0.0, 1.0);
                let Interface { reflectance, cos_t } = fresnel::interface(cos_i, 1.0 / index);
                if reflectance < 1.0 {
                    let leaving = weight * (1.0 - reflectance);
                    if scattered {
                        ledger.scattered += leaving;
                    } else {
                        ledger.ballistic += leaving;
                    }
                    sink(&Exit {
                        position,
                        normal: boundary.normal,
                        direction: refract(&direction, &-boundary.normal, cos_i, cos_t, index),
                        weight: leaving,
                        scattered,
                    });
                    weight -= leaving;
                }
                direction -= boundary.normal * (2.0 * cos_i);
                reflections += 1;
            }
            if (weight < threshold && weight > 0.0) || reflections == REFLECTIONS_IN_A_ROW {
                reflections = 0;
                if rng.random::<f64>() < self.roulette.survival {
                    let worth = weight / self.roulette.survival;
                    ledger.roulette -= worth - weight;
                    weight = worth;
                } else {
                    ledger.roulette += weight;
                    break;
                }
            }
        }
        ledger
    }
}

/// Direction behind an interface. `normal` points back to the side `direction` comes from; `ratio` = n_i/n_t.
#[inline]
fn refract(direction: &Vec3, normal: &Vec3, cos_i: f64, cos_t: f64, ratio: f64) -> Vec3 {
    (direction * ratio + normal * (ratio * cos_i - cos_t)).normalize()
}

/// Turns `direction` by the angle of cosine `cos_theta` to a side drawn evenly.
#[inline]
fn scatter(direction: &Vec3, cos_theta: f64, rng: &mut impl Rng) -> Vec3 {
    // A point in the unit disc gives an even azimuth without trigonometry.
    let (mut x, mut y, mut r2): (f64, f64, f64);
    loop {
        x = 2.0 * rng.random::<f64>() - 1.0;
        y = 2.0 * rng.random::<f64>() - 1.0;
        r2 = x * x + y * y;
        if r2 <= 1.0 && r2 > 1e-20 {
            break;
        }
    }
    let scale = ((1.0 - cos_theta * cos_theta).max(0.0) / r2).sqrt();
    // Orthonormal basis without a branch on the direction (Duff et al. 2017).
    let sign = 1.0f64.copysign(direction.z);
    let a = -1.0 / (sign + direction.z);
    let b = direction.x * direction.y * a;
    let u = Vec3::new(
        1.0 + sign * direction.x * direction.x * a,
        sign * b,
        -sign * direction.x,
    );
    let v = Vec3::new(b, sign + direction.y * direction.y * a, -direction.y);
    let turned = direction * cos_theta + (u * x + v * y) * scale;
    // One Newton step keeps the length at 1 over any number of turns.
    turned * (1.5 - 0.5 * turned.norm_squared())
}
