use std::f64::consts::PI;

/// Centre line of a yarn from one crossing to the next, level at both ends. Coordinates are `d`, the distance from the
/// first crossing in the cloth's plane, and the height `z`, both in mm.
///
/// All three shapes are monotone in between, so no chord is normal to them at both ends: their reach (the distance up
/// to which nearest points are unique) is the smallest radius of curvature.
#[derive(Clone, Copy, Debug)]
pub(super) enum Piece {
    Flat {
        height: f64,
    },
    /// Arc, straight, arc. In the frame mirrored by `sign` so that the line descends: centres of the arcs (0, `z1`) and
    /// (`width`, `z2`), radii `r1` and `r2`, and the straight d sinθ + z cosθ = `w`.
    Arcs {
        sign: f64,
        width: f64,
        z1: f64,
        r1: f64,
        z2: f64,
        r2: f64,
        sin: f64,
        cos: f64,
        w: f64,
    },
    /// `mean` + `amplitude` cos(k d), k = π over the piece's width.
    Wave {
        mean: f64,
        amplitude: f64,
        k: f64,
    },
}

/// A point seen from a centre line: the signed distance from it, positive above, and its gradient.
#[derive(Clone, Copy, Debug)]
pub(super) struct Offset {
    pub v: f64,
    pub normal: [f64; 2],
}

impl Piece {
    /// Signed distance from the piece to a point above or below it, 0 <= d <= width up to rounding.
    #[inline]
    pub fn offset(&self, d: f64, z: f64) -> Offset {
        match *self {
            Self::Flat { height } => Offset {
                v: z - height,
                normal: [0.0, 1.0],
            },
            Self::Arcs {
                sign,
                width,
                z1,
                r1,
                z2,
                r2,
                sin,
                cos,
                w,
            } => {
                let z = sign * z;
                let over_first = z - z1;
                let (v, normal) = if d * cos < over_first * sin {
                    let radius = (d * d + over_first * over_first).sqrt();
                    (radius - r1, [d / radius, over_first / radius])
                } else {
                    let (to_second, under_second) = (width - d, z2 - z);
                    if to_second * cos < under_second * sin {
                        let radius = (to_second * to_second + under_second * under_second).sqrt();
                        (r2 - radius, [to_second / radius, under_second / radius])
                    } else {
                        (d * sin + z * cos - w, [sin, cos])
                    }
                };
                Offset {
                    v: sign * v,
                    normal: [sign * normal[0], normal[1]],
                }
            }
            Self::Wave { mean, amplitude, k } => {
                let below = WaveFoot::at(k, d);
                Wave { amplitude, k }.offset(d, z - mean, below, &mut { below }, 1e-8)
            }
        }
    }

    /// Heights of the lowest and highest point, mm.
    pub fn heights(&self) -> [f64; 2] {
        let ends = match *self {
            Self::Flat { height } => [height, height],
            Self::Arcs {
                sign, z1, r1, z2, r2, ..
            } => [sign * (z1 + r1), sign * (z2 - r2)],
            Self::Wave { mean, amplitude, .. } => [mean + amplitude, mean - amplitude],
        };
        [ends[0].min(ends[1]), ends[0].max(ends[1])]
    }

    /// Smallest radius of curvature, mm; infinite for a straight.
    pub fn reach(&self) -> f64 {
        match *self {
            Self::Flat { .. } => f64::INFINITY,
            Self::Arcs { r1, r2, .. } => r1.min(r2),
            Self::Wave { amplitude, k, .. } => 1.0 / (amplitude.abs() * k * k),
        }
    }
}

/// Half a period of a cosine around height 0.
#[derive(Clone, Copy)]
struct Wave {
    amplitude: f64,
    k: f64,
}

impl Wave {
    /// Signed distance of a point from the wave. `below` is the point of the wave at the same d; `foot` is an initial
    /// guess of the nearest point and on return that point. Newton's method stops after a phase step below `last`; by
    /// quadratic convergence the remaining error of the phase is about the square of that.
    fn offset(self, d: f64, z: f64, below: WaveFoot, foot: &mut WaveFoot, last: f64) -> Offset {
        let Self { amplitude, k } = self;
        let near = self.settled(d, z, foot, last);
        // A foot farther away than `below` belongs to another branch, beyond the evolute.
        if near.v.abs() <= (z - amplitude * below.cos).abs() * (1.0 + 1e-12)
            && near.v.abs() * amplitude.abs() * k * k < 1.0
        {
            return near;
        }
        const STARTS: u32 = 16;
        (0..=STARTS).fold(near, |best, n| {
            let mut start = WaveFoot::at(k, PI / k * f64::from(n) / f64::from(STARTS));
            let found = self.settled(d, z, &mut start, last);
            if found.v.abs() < best.v.abs() {
                *foot = start;
                found
            } else {
                best
            }
        })
    }

    /// Foot of the perpendicular near `foot`.
    fn settled(self, d: f64, z: f64, foot: &mut WaveFoot, last: f64) -> Offset {
        let mut bracket = [d.min(0.0), d.max(PI / self.k)];
        for _ in 0..64 {
            if self.approach(d, z, foot, &mut bracket) < last {
                break;
            }
        }
        self.offset_at(d, z, foot)
    }

    /// One Newton step on (s − d) + y'(y − z) = 0 for the foot s, bracketed by the ends of the piece, where the line is
    /// level. Returns the change of the phase k s.
    #[inline]
    fn approach(self, d: f64, z: f64, foot: &mut WaveFoot, bracket: &mut [f64; 2]) -> f64 {
        let Self { amplitude, k } = self;
        let (y, slope) = (amplitude * foot.cos, -amplitude * k * foot.sin);
        let value = (foot.s - d) + slope * (y - z);
        if value < 0.0 {
            bracket[0] = bracket[0].max(foot.s)
        } else {
            bracket[1] = bracket[1].min(foot.s)
        }
        let tangent = 1.0 + slope * slope;
        // Far on the concave side the exact derivative can become small or negative.
        let rate = (tangent - k * k * y * (y - z)).max(0.25 * tangent);
        let mut step = -value / rate;
        if !(bracket[0]..=bracket[1]).contains(&(foot.s + step)) {
            step = 0.5 * (bracket[0] + bracket[1]) - foot.s;
        }
        foot.advance(k, step);
        (k * step).abs()
    }

    #[inline]
    fn offset_at(self, d: f64, z: f64, foot: &WaveFoot) -> Offset {
        let slope = -self.amplitude * self.k * foot.sin;
        let scale = 1.0 / (1.0 + slope * slope).sqrt();
        let normal = [-slope * scale, scale];
        Offset {
            v: (d - foot.s) * normal[0] + (z - self.amplitude * foot.cos) * normal[1],
            normal,
        }
    }
}

/// A position along a wave, with the sine and cosine of its phase.
#[derive(Clone, Copy, Debug)]
struct WaveFoot {
    s: f64,
    sin: f64,
    cos: f64,
}

impl WaveFoot {
    #[inline]
    fn at(k: f64, s: f64) -> Self {
        let (sin, cos) = (k * s).sin_cos();
        Self { s, sin, cos }
    }

    /// Advances by a step; small phase steps use series with a remainder below 1e-16.
    #[inline]
    fn advance(&mut self, k: f64, step: f64) {
        let phase_step = k * step;
        if phase_step.abs() > 0.25 {
            *self = Self::at(k, self.s + step);
            return;
        }
        let q = phase_step * phase_step;
        let sine =
            phase_step * (1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0 * (1.0 - q / 72.0 * (1.0 - q / 110.0)))));
        let cosine = 1.0
            - q / 2.0 * (1.0 - q / 12.0 * (1.0 - q / 30.0 * (1.0 - q / 56.0 * (1.0 - q / 90.0 * (1.0 - q / 132.0)))));
        *self = Self {
            s: self.s + step,
            sin: self.sin * cosine + self.cos * sine,
            cos: self.cos * cosine - self.sin * sine,
        };
    }
}

/// State of a ray along a piece: the point of the piece at the same d, and the nearest point, as initial guesses.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Memory {
    below: Option<WaveFoot>,
    foot: Option<WaveFoot>,
}

/// A point of a piece near another point: the vector from it, and whether it is the nearest point to rounding.
pub(super) struct Near {
    pub away: [f64; 2],
    pub settled: bool,
}

/// Distance of a piece from a point.
pub(super) enum SeenPiece {
    /// A lower bound of the distance.
    AtLeast(f64),
    Offset(Offset),
}

impl Piece {
    /// A point of the piece near (d, z). Repeated calls along a ray converge to the nearest point.
    #[inline]
    pub fn near(&self, d: f64, z: f64, memory: &mut Memory) -> Near {
        let away = match *self {
            Self::Flat { height } => [0.0, z - height],
            Self::Arcs {
                sign,
                width,
                z1,
                r1,
                z2,
                r2,
                sin,
                cos,
                w,
            } => {
                let z = sign * z;
                let past_second = d - width;
                let [x_away, z_away] = if d * cos < (z - z1) * sin {
                    let share = 1.0 - r1 / (d * d + (z - z1) * (z - z1)).sqrt();
                    [share * d, share * (z - z1)]
                } else if past_second * cos > (z - z2) * sin {
                    let share = 1.0 - r2 / (past_second * past_second + (z - z2) * (z - z2)).sqrt();
                    [share * past_second, share * (z - z2)]
                } else {
                    let v = d * sin + z * cos - w;
                    [v * sin, v * cos]
                };
                [x_away, sign * z_away]
            }
            Self::Wave { mean, amplitude, k } => {
                let (wave, z) = (Wave { amplitude, k }, z - mean);
                let Some(foot) = &mut memory.foot else {
                    // The point at the same d suffices where the surface is far.
                    let below = WaveFoot::at(k, d);
                    memory.foot = Some(below);
                    return Near {
                        away: [0.0, z - amplitude * below.cos],
                        settled: false,
                    };
                };
                let mut bracket = [d.min(0.0), d.max(PI / k)];
                let mut moved = wave.approach(d, z, foot, &mut bracket);
                if moved > 0.01 {
                    moved = wave.approach(d, z, foot, &mut bracket);
                }
                return Near {
                    away: [d - foot.s, z - amplitude * foot.cos],
                    // The error of the distance is of the fourth power of the last step.
                    settled: moved < 1e-4,
                };
            }
        };
        Near { away, settled: true }
    }

    /// The distance of a point of a ray from the piece, or a cheap lower bound that exceeds `far`.
    #[inline]
    pub fn seen(&self, d: f64, z: f64, far: f64, memory: &mut Memory) -> SeenPiece {
        let Self::Wave { mean, amplitude, k } = *self else {
            return SeenPiece::Offset(self.offset(d, z));
        };
        let z = z - mean;
        let below = memory.below.get_or_insert_with(|| WaveFoot::at(k, d));
        below.advance(k, d - below.s);
        // The line is steepest at its middle.
        let vertical = z - amplitude * below.cos;
        let least_squared = vertical * vertical / (1.0 + amplitude * amplitude * k * k);
        if least_squared > far * far {
            return SeenPiece::AtLeast(least_squared.sqrt());
        }
        let below = *below;
        let foot = memory.foot.get_or_insert(below);
        SeenPiece::Offset(Wave { amplitude, k }.offset(d, z, below, foot, 1e-5))
    }
}
