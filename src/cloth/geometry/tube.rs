use super::layout::WovenYarn;
use super::piece::{Memory, Offset, Piece, SeenPiece};

/// Largest number of search steps, after which a ray counts as never reaching the surface.
const MAX_STEPS: usize = 256;

/// Value of F, up to rounding the distance from the surface in half axes, that counts as on the surface.
const ON_SURFACE: f64 = 1e-13;

/// Value of −F below which a single step ends a search, unless the ray is at grazing incidence.
const LAST_STEP: f64 = 1e-8;

/// First step, in half heights, of a ray that starts on the surface: large enough to leave it despite rounding.
const LEAVE: f64 = 1e-9;

/// Step, in half heights, along the centre line over which its curvature is measured.
const BEND_STEP: f64 = 1e-5;

/// Smooth surface of one yarn: the points whose distance u from the centre line's vertical plane and signed distance v
/// from the centre line within that plane satisfy F = (u/a)² + (v/b)² − 1 = 0.
///
/// Along a ray, with d_p its part in the plane, F'' = 2 (u'²/a² + (v'² + v v'')/b²). Where the line's radius of
/// curvature is r, its centre below, v'² + v v'' = d_p² − d_t² r/(r + v) <= d_p², d_t the part along the line: whatever
/// the bend, F'' <= M = 2 (u'²/a² + d_p²/b²), with equality along straights.
#[derive(Clone, Debug)]
pub(super) struct Tube {
    pub half_width: f64,
    pub half_height: f64,
    inverse_a2: f64,
    inverse_b2: f64,
    /// Positions where pieces begin along the yarn, mm; the last is the first plus one repeat.
    knots: Vec<f64>,
    inverse_repeat: f64,
    pieces: Vec<Piece>,
    reach: f64,
}

/// Point or direction in a yarn's coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local {
    /// Along the yarn, in the cloth's plane.
    pub x: f64,
    /// Across the yarn, from the vertical plane of the centre line.
    pub u: f64,
    pub z: f64,
}

/// The surface near a point: the vector to it, the outward normal, and the tangent of the centre line.
pub(super) struct SurfaceFrame {
    pub to_surface: Local,
    pub normal: Local,
    pub tangent: Local,
}

impl Local {
    fn moved(self, along: Self, distance: f64) -> Self {
        Self {
            x: self.x + distance * along.x,
            u: self.u + distance * along.u,
            z: self.z + distance * along.z,
        }
    }
}

impl Tube {
    pub fn new(yarn: &WovenYarn) -> Self {
        let (half_width, half_height) = (yarn.half_width_mm, yarn.half_height_mm);
        let (knots, pieces) = yarn.line.pieces();
        Self {
            half_width,
            half_height,
            inverse_a2: half_width.powi(-2),
            inverse_b2: half_height.powi(-2),
            inverse_repeat: 1.0 / (knots[pieces.len()] - knots[0]),
            knots,
            reach: pieces
                .iter()
                .fold(f64::INFINITY, |least, piece| least.min(piece.reach())),
            pieces,
        }
    }

    /// The piece at `x`, and the distance from its beginning.
    #[inline]
    fn locate(&self, x: f64) -> (usize, f64) {
        let n = self.pieces.len();
        let (first, repeat) = (self.knots[0], self.knots[n] - self.knots[0]);
        let repeats = (x - first) * self.inverse_repeat;
        let whole = floor(repeats);
        let x = x - whole * repeat;
        let mut k = (((repeats - whole) * n as f64) as usize).min(n - 1);
        while k > 0 && x < self.knots[k] {
            k -= 1;
        }
        while k + 1 < n && x > self.knots[k + 1] {
            k += 1;
        }
        (k, x - self.knots[k])
    }

    /// Moves to the neighbouring piece if `d` lies outside piece `k`; returns whether it did.
    #[inline]
    fn relocate(&self, k: &mut usize, d: &mut f64) -> bool {
        let mut moved = false;
        while *d < 0.0 {
            moved = true;
            *k = if *k == 0 { self.pieces.len() - 1 } else { *k - 1 };
            *d += self.knots[*k + 1] - self.knots[*k];
        }
        loop {
            let width = self.knots[*k + 1] - self.knots[*k];
            // Written so that NaN ends the loop.
            let past = *d > width;
            if !past {
                return moved;
            }
            moved = true;
            *d -= width;
            *k = if *k + 1 == self.pieces.len() { 0 } else { *k + 1 };
        }
    }

    /// F and half its derivative along a direction.
    #[inline]
    fn value(&self, Offset { v, normal }: Offset, u: f64, along: Local) -> (f64, f64) {
        let climb = normal[0] * along.x + normal[1] * along.z;
        (
            u * u * self.inverse_a2 + v * v * self.inverse_b2 - 1.0,
            u * along.u * self.inverse_a2 + v * climb * self.inverse_b2,
        )
    }

    /// M / 2 along a direction.
    #[inline]
    fn bend(&self, along: Local) -> f64 {
        along.u * along.u * self.inverse_a2 + (along.x * along.x + along.z * along.z) * self.inverse_b2
    }

    /// Distance to the surface from a point inside, or on the surface with the direction inward; any value of at least
    /// `limit` if the surface is at least that far.
    ///
    /// Around any point c of the centre line, (u/a)² + |p − c|²/b² < 1 is inside the tube, and along the ray a parabola
    /// whose second derivative is M bounds F from above. Each step ends where the parabola is 0, so no step overshoots.
    /// c follows the ray and converges to the nearest point, where the parabola equals F to second order.
    pub fn inside_distance(&self, from: Local, along: Local, limit: f64) -> f64 {
        let bend = self.bend(along);
        let (mut k, mut d) = self.locate(from.x);
        let (mut u, mut z) = (from.u, from.z);
        let mut memory = Memory::default();
        let mut distance = 0.0;
        for _ in 0..MAX_STEPS {
            let near = self.pieces[k].near(d, z, &mut memory);
            let [x_away, z_away] = near.away;
            let f = u * u * self.inverse_a2 + (x_away * x_away + z_away * z_away) * self.inverse_b2 - 1.0;
            let slope = u * along.u * self.inverse_a2 + (x_away * along.x + z_away * along.z) * self.inverse_b2;
            if !near.settled && (f > -0.01 || distance == 0.0) {
                // The circle around this point of the line may not yet contain the point of the ray.
                let rest = limit - distance;
                if f < 0.0 && f + rest * (2.0 * slope + bend * rest) < 0.0 {
                    return limit;
                }
                continue;
            }
            if f > -ON_SURFACE && distance > 0.0 {
                // The remainder is below rounding except at grazing incidence.
                return distance + if slope > 0.0 { (-0.5 * f / slope).max(0.0) } else { 0.0 };
            }
            let f = f.min(0.0);
            let rest = limit - distance;
            if f + rest * (2.0 * slope + bend * rest) < 0.0 {
                return limit;
            }
            let root = (slope * slope - bend * f).sqrt();
            let mut step = if slope > 0.0 {
                -f / (slope + root)
            } else {
                (root - slope) / bend
            };
            // The error of F there is at most M / 2 times the square of the step, below rounding.
            if near.settled && f > -LAST_STEP && slope > 0.0 && slope * slope > 1e-3 * bend {
                return distance + step;
            }
            if distance == 0.0 {
                step = step.max(LEAVE * self.half_height);
            }
            distance += step;
            if distance >= limit {
                return distance;
            }
            d += step * along.x;
            z += step * along.z;
            u += step * along.u;
            if self.relocate(&mut k, &mut d) {
                memory = Memory::default();
            }
        }
        f64::INFINITY
    }

    /// First distance within `range` at which a ray enters the part of the tube over piece `k`, `from.x` counted from
    /// the piece's beginning. The range must keep the ray over the piece and within the tube's half width. A start on
    /// the surface with the direction outward is not an entry.
    pub fn entry(&self, k: usize, from: Local, along: Local, range: [f64; 2]) -> Option<f64> {
        let piece = &self.pieces[k];
        let steepest = self.bend(along).sqrt();
        let sideways = along.u * along.u * self.inverse_a2;
        let in_plane = along.x * along.x + along.z * along.z;
        let speed = in_plane.sqrt();
        let mut memory = Memory::default();
        let mut distance = range[0];
        for _ in 0..MAX_STEPS {
            if distance > range[1] {
                return None;
            }
            let at = from.moved(along, distance);
            let offset = match piece.seen(at.x, at.z, 1.25 * self.half_height, &mut memory) {
                SeenPiece::Offset(offset) => offset,
                SeenPiece::AtLeast(least) => {
                    // √(F + 1) changes by at most √(M / 2) per unit of distance.
                    let section = (at.u * at.u * self.inverse_a2 + least * least * self.inverse_b2).sqrt();
                    distance += (section - 1.0) / steepest;
                    continue;
                }
            };
            let (f, slope) = self.value(offset, at.u, along);
            if f <= ON_SURFACE && slope < 0.0 {
                return Some(distance);
            }
            let outside = f.max(0.0);
            let mut step = ((outside + 1.0).sqrt() - 1.0) / steepest;
            // On a window in which |v| stays below `farthest` < r, v v'' >= −d_p² farthest / (r − farthest).
            let beside = offset.v.abs();
            if beside < self.reach {
                let (least_bend, window) = if self.reach.is_infinite() {
                    (sideways, f64::INFINITY)
                } else {
                    let farthest = 0.5 * (beside + self.reach);
                    (
                        sideways - in_plane * self.inverse_b2 * farthest / (self.reach - farthest),
                        (farthest - beside) / speed,
                    )
                };
                step = step.max(window.min(first_root(outside, slope, least_bend)));
            }
            if f <= ON_SURFACE {
                step = step.max(LEAVE * self.half_height);
            } else if slope < 0.0 && distance + step <= distance {
                return Some(distance);
            }
            distance += step;
        }
        None
    }

    /// The surface near a point that is on it to rounding.
    pub fn surface_frame(&self, near: Local) -> SurfaceFrame {
        let (k, d) = self.locate(near.x);
        let Offset { v, normal } = self.pieces[k].offset(d, near.z);
        let (gu, gv) = (near.u * self.inverse_a2, v * self.inverse_b2);
        let f = near.u * gu + v * gv - 1.0;
        let inverse = 1.0 / (gu * gu + gv * gv).sqrt();
        let outward = Local {
            x: gv * normal[0] * inverse,
            u: gu * inverse,
            z: gv * normal[1] * inverse,
        };
        let back = -0.5 * f * inverse;
        SurfaceFrame {
            to_surface: Local {
                x: back * outward.x,
                u: back * outward.u,
                z: back * outward.z,
            },
            normal: outward,
            tangent: Local {
                x: normal[1],
                u: 0.0,
                z: -normal[0],
            },
        }
    }

    /// Vector from a surface point to the point of the same section with the outward normal `outward`.
    pub fn around(&self, near: Local, outward: Local) -> Local {
        let (k, d) = self.locate(near.x);
        let Offset { v, normal } = self.pieces[k].offset(d, near.z);
        let (a2, b2) = (self.half_width * self.half_width, self.half_height * self.half_height);
        let (across, up) = (outward.u, outward.x * normal[0] + outward.z * normal[1]);
        let scale = 1.0 / (a2 * across * across + b2 * up * up).sqrt();
        let lift = b2 * up * scale - v;
        Local {
            x: lift * normal[0],
            u: a2 * across * scale - near.u,
            z: lift * normal[1],
        }
    }

    /// Position along the yarn and height of the nearest point of the centre line, mm.
    pub fn foot(&self, near: Local) -> [f64; 2] {
        let (k, d) = self.locate(near.x);
        let Offset { v, normal } = self.pieces[k].offset(d, near.z);
        [near.x - v * normal[0], near.z - v * normal[1]]
    }

    /// Surface area at a point per length along the yarn (of the foot on the centre line, in the cloth's plane) and per
    /// radian of rotation of the normal within the section, mm. It is the section's radius of curvature times the ratio
    /// of the length along the surface to that length, which depends on slope and curvature of the centre line.
    pub fn surface_per_place(&self, near: Local) -> f64 {
        let (k, d) = self.locate(near.x);
        let Offset { v, normal } = self.pieces[k].offset(d, near.z);
        let foot = self.foot(near);
        let lean = |step: f64| {
            let (k, d) = self.locate(foot[0] + step * normal[1]);
            let there = self.pieces[k].offset(d, foot[1] - step * normal[0]).normal;
            there[0].atan2(there[1])
        };
        let step = BEND_STEP * self.half_height;
        let bend = (lean(step) - lean(-step)) / (2.0 * step);
        let (a, b) = (self.half_width, self.half_height);
        // Radius of curvature of the ellipse (u/a)² + (v/b)² = 1.
        let radius = (a * b).powi(2) * (near.u / (a * a)).hypot(v / (b * b)).powi(3);
        radius * (1.0 + bend * v) / normal[1]
    }

    /// Signed distance from a point to the surface to first order, negative inside; exact at the surface and for a
    /// circular section.
    pub fn signed_distance(&self, at: Local) -> f64 {
        let (k, d) = self.locate(at.x);
        let v = self.pieces[k].offset(d, at.z).v;
        let (p, q) = (at.u * self.inverse_a2, v * self.inverse_b2);
        let section = (at.u * p + v * q).sqrt();
        // On the centre line itself the distance is the smaller half axis.
        let gradient = (p * p + q * q).sqrt() / section;
        if section > 1e-9 {
            (section - 1.0) / gradient
        } else {
            -self.half_width.min(self.half_height)
        }
    }

    /// Lowest and highest point of the part of the tube over piece `k`.
    pub fn heights(&self, k: usize) -> [f64; 2] {
        let [low, high] = self.pieces[k].heights();
        [low - self.half_height, high + self.half_height]
    }
}

/// Floor of a number of repeats, without the function call that f64::floor becomes on processors without SSE 4.1.
#[inline]
pub(super) fn floor(x: f64) -> f64 {
    let truncated = x as i64 as f64;
    if truncated > x { truncated - 1.0 } else { truncated }
}

/// Smallest positive root of f + 2 s h + c h², f >= 0, or infinity.
#[inline]
fn first_root(f: f64, s: f64, c: f64) -> f64 {
    let square = s * s - c * f;
    if square < 0.0 {
        f64::INFINITY
    } else if s < 0.0 {
        f / (square.sqrt() - s)
    } else if c < 0.0 {
        (s + square.sqrt()) / -c
    } else {
        f64::INFINITY
    }
}
