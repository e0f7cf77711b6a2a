use std::f64::consts::PI;

/// Centre line of a yarn from one crossing to the next, where it is level at both ends. Coordinates are `d`, the
/// distance from the first crossing in the cloth's plane, and the height `z`, both in mm.
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
    /// Distance of a point over the piece, 0 <= d <= width up to rounding, from it.
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
            Self::Wave { mean, amplitude, k } => Wave { amplitude, k }.offset(d, z - mean),
        }
    }

    /// A cheap lower bound of the distance, where the shape has one.
    #[inline]
    pub fn at_least(&self, d: f64, z: f64) -> Option<f64> {
        match *self {
            Self::Wave { mean, amplitude, k } => {
                // The line is steeper than its slope at the middle nowhere.
                let slope = amplitude * k;
                let vertical = z - mean - amplitude * (k * d).cos();
                Some((vertical * vertical / (1.0 + slope * slope)).sqrt())
            }
            _ => None,
        }
    }

    /// Lowest and highest point.
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

    /// Smallest radius of curvature, infinite for a straight.
    pub fn reach(&self) -> f64 {
        match *self {
            Self::Flat { .. } => f64::INFINITY,
            Self::Arcs { r1, r2, .. } => r1.min(r2),
            Self::Wave { amplitude, k, .. } => 1.0 / (amplitude.abs() * k * k),
        }
    }
}

/// Half a cosine around height 0.
#[derive(Clone, Copy)]
struct Wave {
    amplitude: f64,
    k: f64,
}

impl Wave {
    fn offset(self, d: f64, z: f64) -> Offset {
        let Self { amplitude, k } = self;
        let (sin, cos) = (k * d).sin_cos();
        let near = self.foot(d, z, d, (sin, cos));
        // A foot farther than the point straight above or below is that of another branch, past the evolute.
        if near.v.abs() <= (z - amplitude * cos).abs() * (1.0 + 1e-12) && near.v.abs() * amplitude.abs() * k * k < 1.0 {
            return near;
        }
        const STARTS: u32 = 16;
        (0..=STARTS).fold(near, |best, n| {
            let start = PI / k * f64::from(n) / f64::from(STARTS);
            let found = self.foot(d, z, start, (k * start).sin_cos());
            if found.v.abs() < best.v.abs() { found } else { best }
        })
    }

    /// The foot of a perpendicular near `start`, whose sine and cosine are given: Newton's method on
    /// (s − d) + y'(y − z) = 0, kept in a bracket, since the line is level at both ends of the piece.
    fn foot(self, d: f64, z: f64, start: f64, (mut sin, mut cos): (f64, f64)) -> Offset {
        let Self { amplitude, k } = self;
        let width = PI / k;
        let (mut low, mut high) = (d.min(0.0), d.max(width));
        let mut s = start;
        for n in 0..64 {
            let (y, slope) = (amplitude * cos, -amplitude * k * sin);
            let value = (s - d) + slope * (y - z);
            if value < 0.0 {
                low = low.max(s)
            } else {
                high = high.min(s)
            }
            // The first step leaves out the curvature: it cannot go wrong far from the line.
            let bend = if n == 0 { 0.0 } else { -k * k * y * (y - z) };
            let mut step = -value / (1.0 + slope * slope + bend);
            if !(low..=high).contains(&(s + step)) || 1.0 + slope * slope + bend <= 0.0 {
                step = 0.5 * (low + high) - s;
            }
            s += step;
            let turn = k * step;
            (sin, cos) = if turn.abs() < 0.02 {
                turned(sin, cos, turn)
            } else {
                (k * s).sin_cos()
            };
            // Convergence is quadratic: the error left is the square of this step.
            if turn.abs() < 1e-8 {
                break;
            }
        }
        let slope = -amplitude * k * sin;
        let scale = 1.0 / (1.0 + slope * slope).sqrt();
        let normal = [-slope * scale, scale];
        Offset {
            v: (d - s) * normal[0] + (z - amplitude * cos) * normal[1],
            normal,
        }
    }
}

/// Sine and cosine after a turn below 0.02 rad, by series whose remainder is below 1e-16.
fn turned(sin: f64, cos: f64, turn: f64) -> (f64, f64) {
    let square = turn * turn;
    let sine = turn * (1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0)));
    let cosine = 1.0 - square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0));
    (sin * cosine + cos * sine, cos * cosine - sin * sine)
}
