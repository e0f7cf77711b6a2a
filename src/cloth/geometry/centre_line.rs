use super::piece::Piece;
use crate::cloth::{CentreLineKind, ClothError, System};
use std::f64::consts::PI;

/// Peirce's geometry between two neighbouring crossings where the yarn changes sides. With p the spacing of the yarns
/// crossed, D the sum of both diameters, l the length of yarn, θ the weave angle and h the crimp height,
/// p = (l − Dθ) cosθ + D sinθ and h = (l − Dθ) sinθ + D (1 − cosθ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeirceSegment {
    pub length_mm: f64,
    pub weave_angle_rad: f64,
}

impl PeirceSegment {
    /// Solution of Peirce's two equations, or `None` where the yarns jam: no straight remains between the arcs. Jamming
    /// begins below p² = h (2D − h); for equal yarns that share the crimp, below p = √3 diameters.
    pub fn solve(spacing_mm: f64, crimp_height_mm: f64, diameter_sum_mm: f64) -> Option<Self> {
        let (p, h, d) = (spacing_mm, crimp_height_mm, diameter_sum_mm);
        // By the equations, (p, D − h) is (l − Dθ, D) rotated by −θ: the lengths give the straight, the polar angles
        // give θ.
        let straight_squared = p * p - Self::jam_spacing_mm(h, d).powi(2);
        // A cloth exactly at the jam is valid; rounding must not reject it.
        if straight_squared < -1e-14 * d * d {
            return None;
        }
        let straight = straight_squared.max(0.0).sqrt();
        let angle = d.atan2(straight) - (d - h).atan2(p);
        Some(Self {
            length_mm: straight + d * angle,
            weave_angle_rad: angle,
        })
    }

    /// Smallest spacing √(h (2D − h)), mm.
    pub fn jam_spacing_mm(crimp_height_mm: f64, diameter_sum_mm: f64) -> f64 {
        (crimp_height_mm * (2.0 * diameter_sum_mm - crimp_height_mm)).sqrt()
    }
}

/// Crossing of a yarn over or under another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crossing {
    pub at_mm: f64,
    pub on_top: bool,
    /// Distance of the centre line from the cloth's middle plane, mm.
    pub crest_mm: f64,
    /// Radius of Peirce's arc around the other yarn, mm.
    pub arc_radius_mm: f64,
}

/// Shape of a centre line from one crossing to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Span {
    Flat,
    Peirce(PeirceSegment),
    Cosine,
}

/// Periodic centre line of one yarn: height over the cloth's middle plane as a function of the position along the yarn.
#[derive(Clone, Debug, PartialEq)]
pub struct CentreLine {
    repeat_mm: f64,
    /// Spacing of the crossings if it is uniform: crossing `k` is then at (k + ½) times the spacing.
    spacing_mm: Option<f64>,
    crossings: Vec<Crossing>,
    /// `spans[k]` begins at crossing `k`.
    spans: Vec<Span>,
}

impl CentreLine {
    /// `on_top`: whether the yarn is on top at each crossing of the repeat; `spacing_mm`: distance of the yarns
    /// crossed; `radius_sum_mm`: this yarn's radius plus theirs. Lengths must be finite and positive. `system` names
    /// the yarn in errors.
    pub fn new(
        kind: CentreLineKind,
        system: System,
        on_top: Vec<bool>,
        spacing_mm: f64,
        radius_sum_mm: f64,
    ) -> Result<Self, ClothError> {
        let repeat_mm = spacing_mm * on_top.len() as f64;
        let crossing = |(k, on_top)| Crossing {
            at_mm: (k as f64 + 0.5) * spacing_mm,
            on_top,
            crest_mm: match kind {
                // h1 + h2 = d1 + d2, shared equally by the two systems.
                CentreLineKind::Peirce => 0.5 * radius_sum_mm,
                CentreLineKind::Sinusoid { amplitude_mm } => amplitude_mm,
            },
            arc_radius_mm: radius_sum_mm,
        };
        let crossings = on_top.into_iter().enumerate().map(crossing).collect();
        Self::through(kind, system, crossings, repeat_mm, Some(spacing_mm))
    }

    /// Centre line through crossings in ascending order within one repeat. `spacing_mm`: their spacing if it is
    /// uniform.
    pub(super) fn through(
        kind: CentreLineKind,
        system: System,
        crossings: Vec<Crossing>,
        repeat_mm: f64,
        spacing_mm: Option<f64>,
    ) -> Result<Self, ClothError> {
        let mut line = Self {
            repeat_mm,
            spacing_mm,
            crossings,
            spans: Vec::new(),
        };
        line.spans = (0..line.crossings.len())
            .map(|k| {
                let [from, to] = line.ends(k);
                if from.on_top == to.on_top {
                    return Ok(if from.crest_mm == to.crest_mm {
                        Span::Flat
                    } else {
                        Span::Cosine
                    });
                }
                if kind != CentreLineKind::Peirce {
                    return Ok(Span::Cosine);
                }
                let (width_mm, h) = (line.width_mm(k), from.crest_mm + to.crest_mm);
                let d = from.arc_radius_mm + to.arc_radius_mm;
                let segment = PeirceSegment::solve(width_mm, h, d).ok_or(ClothError::Jammed {
                    system,
                    crossed: system.other(),
                    spacing_mm: width_mm,
                    minimum_mm: PeirceSegment::jam_spacing_mm(h, d),
                    radius_sum_mm: h,
                })?;
                Ok(Span::Peirce(segment))
            })
            .collect::<Result<_, ClothError>>()?;
        Ok(line)
    }

    /// The crossings at both ends of a span.
    fn ends(&self, k: usize) -> [Crossing; 2] {
        [self.crossings[k], self.crossings[(k + 1) % self.crossings.len()]]
    }

    /// Length of a span in the cloth's plane, mm.
    fn width_mm(&self, k: usize) -> f64 {
        self.spacing_mm.unwrap_or_else(|| {
            let wraps = k + 1 == self.crossings.len();
            let [from, to] = self.ends(k);
            to.at_mm - from.at_mm + if wraps { self.repeat_mm } else { 0.0 }
        })
    }

    /// The span at a position along the yarn, its width, and the fraction of the width before the position.
    fn locate(&self, along_mm: f64) -> (usize, f64, f64) {
        let n = self.crossings.len();
        if let Some(spacing_mm) = self.spacing_mm {
            let crossings = along_mm / spacing_mm - 0.5;
            let before = crossings.floor();
            // `rem_euclid` of a float is below n up to rounding, hence the second remainder.
            let k = before.rem_euclid(n as f64) as usize % n;
            return (k, spacing_mm, crossings - before);
        }
        let past = (along_mm - self.crossings[0].at_mm).rem_euclid(self.repeat_mm);
        let x = past + self.crossings[0].at_mm;
        let k = self.crossings.partition_point(|c| c.at_mm <= x).clamp(1, n) - 1;
        let width_mm = self.width_mm(k);
        (k, width_mm, (x - self.crossings[k].at_mm) / width_mm)
    }

    /// Height in mm and slope of the centre line at a distance along the yarn, measured in the cloth's plane.
    pub fn height_and_slope(&self, along_mm: f64) -> (f64, f64) {
        let (k, width_mm, fraction) = self.locate(along_mm);
        let [from, to] = self.ends(k);
        let sign = if from.on_top { 1.0 } else { -1.0 };
        let (height, slope) = match self.spans[k] {
            Span::Flat => (from.crest_mm, 0.0),
            Span::Peirce(segment) => {
                let from_crest_mm = fraction * width_mm;
                if fraction <= 0.5 || from_crest_mm < from.arc_radius_mm * segment.weave_angle_rad.sin() {
                    descent(from, segment, from_crest_mm)
                } else {
                    let (height, slope) = descent(to, segment, (1.0 - fraction) * width_mm);
                    (-height, slope)
                }
            }
            Span::Cosine => {
                // The side is that of the first crossing; a float over unequal yarns stays on that side.
                let end_mm = if from.on_top == to.on_top {
                    to.crest_mm
                } else {
                    -to.crest_mm
                };
                let (mean, amplitude) = (0.5 * (from.crest_mm + end_mm), 0.5 * (from.crest_mm - end_mm));
                let (turned, phase) = if fraction <= 0.5 {
                    (1.0, PI * (fraction * width_mm) / width_mm)
                } else {
                    (-1.0, PI * ((1.0 - fraction) * width_mm) / width_mm)
                };
                (
                    mean + turned * (amplitude * phase.cos()),
                    -amplitude * PI / width_mm * phase.sin(),
                )
            }
        };
        (sign * height, sign * slope)
    }

    /// Largest distance of the centre line from the cloth's middle plane, mm.
    pub fn crest_mm(&self) -> f64 {
        self.crossings.iter().fold(0.0, |crest, c| crest.max(c.crest_mm))
    }

    /// Number of crossings in one repeat.
    pub fn crossings(&self) -> usize {
        self.crossings.len()
    }

    /// Length of one repeat in the cloth's plane, mm.
    pub fn repeat_mm(&self) -> f64 {
        self.repeat_mm
    }

    /// Length of yarn in one repeat, mm. Its excess over [`Self::repeat_mm`] is the crimp.
    pub fn length_mm(&self) -> f64 {
        (0..self.spans.len())
            .map(|k| {
                let width_mm = self.width_mm(k);
                let [from, to] = self.ends(k);
                match self.spans[k] {
                    Span::Flat => width_mm,
                    // Arc, straight, arc: the same length as with equal arcs of the same sum.
                    Span::Peirce(segment) => segment.length_mm,
                    Span::Cosine => {
                        // The trapezoidal rule over a period converges exponentially for a smooth integrand.
                        const NODES: usize = 1024;
                        let sign = if from.on_top == to.on_top { -1.0 } else { 1.0 };
                        let slope = 0.5 * (from.crest_mm + sign * to.crest_mm) * PI / width_mm;
                        let sum: f64 = (0..NODES)
                            .map(|k| 1f64.hypot(slope * (PI * k as f64 / NODES as f64).sin()))
                            .sum();
                        width_mm * sum / NODES as f64
                    }
                }
            })
            .sum()
    }

    /// The pieces between crossings over one repeat, and the position where each begins; a last position closes the
    /// repeat.
    pub(super) fn pieces(&self) -> (Vec<f64>, Vec<Piece>) {
        let first = self.crossings[0].at_mm;
        let knots = self.crossings.iter().map(|c| c.at_mm).chain([first + self.repeat_mm]);
        let pieces = (0..self.spans.len()).map(|k| self.piece(k)).collect();
        (knots.collect(), pieces)
    }

    fn piece(&self, k: usize) -> Piece {
        let [from, to] = self.ends(k);
        let width = self.width_mm(k);
        let [start, end] = [from, to].map(|c| if c.on_top { c.crest_mm } else { -c.crest_mm });
        match self.spans[k] {
            Span::Flat => Piece::Flat { height: start },
            Span::Peirce(segment) => {
                let (sin, cos) = segment.weave_angle_rad.sin_cos();
                let z1 = from.crest_mm - from.arc_radius_mm;
                Piece::Arcs {
                    sign: if from.on_top { 1.0 } else { -1.0 },
                    width,
                    z1,
                    r1: from.arc_radius_mm,
                    z2: to.arc_radius_mm - to.crest_mm,
                    r2: to.arc_radius_mm,
                    sin,
                    cos,
                    w: z1 * cos + from.arc_radius_mm,
                }
            }
            Span::Cosine => Piece::Wave {
                mean: 0.5 * (start + end),
                amplitude: 0.5 * (start - end),
                k: PI / width,
            },
        }
    }

    /// Smallest radius of curvature, mm.
    pub fn curvature_radius_mm(&self) -> f64 {
        let radii = (0..self.spans.len()).map(|k| self.piece(k).reach());
        radii.fold(f64::INFINITY, f64::min)
    }
}

/// Height and slope on the way down from a crest, along its arc and the straight after it.
fn descent(crest: Crossing, segment: PeirceSegment, from_crest_mm: f64) -> (f64, f64) {
    let Crossing {
        crest_mm,
        arc_radius_mm,
        ..
    } = crest;
    let (sin, cos) = segment.weave_angle_rad.sin_cos();
    if from_crest_mm < arc_radius_mm * sin {
        let rise = (arc_radius_mm * arc_radius_mm - from_crest_mm * from_crest_mm).sqrt();
        (crest_mm - (arc_radius_mm - rise), -from_crest_mm / rise)
    } else {
        let on_straight_mm = from_crest_mm - arc_radius_mm * sin;
        let slope = -sin / cos;
        (crest_mm - arc_radius_mm * (1.0 - cos) + on_straight_mm * slope, slope)
    }
}
