use super::piece::Piece;
use super::{ClothError, System};
use std::f64::consts::PI;

/// Shape of the yarns' centre lines.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum CentreLineKind {
    /// Circular arcs wrapped around the crossing yarns, joined by straights: F. T. Peirce, "The geometry of cloth
    /// structure", J. Textile Inst. 28 (1937) T45. The crimp is shared equally by the two systems.
    #[default]
    Peirce,
    /// Half a cosine between a crossing above and one below, straight along floats.
    Sinusoid { amplitude_mm: f64 },
}

/// Peirce's geometry between two neighbouring crossings where the yarn changes sides. With p the spacing of the yarns
/// crossed, D the sum of both diameters, l the length of yarn, θ the weave angle and h the crimp height,
/// p = (l − Dθ) cosθ + D sinθ and h = (l − Dθ) sinθ + D (1 − cosθ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeirceSegment {
    pub length_mm: f64,
    pub weave_angle_rad: f64,
}

impl PeirceSegment {
    /// Solution of Peirce's two equations, or `None` where the yarns jam: no straight is left between the arcs, which
    /// happens below p² = h (2D − h), for equal yarns that share the crimp below p = √3 diameters.
    pub fn solve(spacing_mm: f64, crimp_height_mm: f64, diameter_sum_mm: f64) -> Option<Self> {
        let (p, h, d) = (spacing_mm, crimp_height_mm, diameter_sum_mm);
        // The equations say that (p, D − h) is (l − Dθ, D) turned by −θ: the lengths give the straight, the
        // polar angles give θ.
        let straight_squared = p * p - Self::jam_spacing_mm(h, d).powi(2);
        // The jam itself is a legal cloth; rounding must not refuse it.
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

    /// Smallest spacing √(h (2D − h)).
    pub fn jam_spacing_mm(crimp_height_mm: f64, diameter_sum_mm: f64) -> f64 {
        (crimp_height_mm * (2.0 * diameter_sum_mm - crimp_height_mm)).sqrt()
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Profile {
    Peirce { arc_radius_mm: f64, segment: PeirceSegment },
    Sinusoid,
}

/// Periodic centre line of one yarn: its height over the cloth's middle plane as a function of the place along the
/// yarn. Crossing `k` stands at (k + ½) times the spacing of the yarns crossed.
#[derive(Clone, Debug, PartialEq)]
pub struct CentreLine {
    spacing_mm: f64,
    crest_mm: f64,
    on_top: Vec<bool>,
    profile: Profile,
}

impl CentreLine {
    /// `on_top`: the side at each crossing of the repeat; `spacing_mm`: distance of the yarns crossed;
    /// `radius_sum_mm`: this yarn's radius plus theirs, all finite and positive. `system` is what an error calls it.
    pub fn new(
        kind: CentreLineKind,
        system: System,
        on_top: Vec<bool>,
        spacing_mm: f64,
        radius_sum_mm: f64,
    ) -> Result<Self, ClothError> {
        let (crest_mm, profile) = match kind {
            CentreLineKind::Peirce => {
                // h1 + h2 = d1 + d2, each system taking half.
                let (h, d) = (radius_sum_mm, 2.0 * radius_sum_mm);
                let segment = PeirceSegment::solve(spacing_mm, h, d).ok_or(ClothError::Jammed {
                    system,
                    crossed: system.other(),
                    spacing_mm,
                    minimum_mm: PeirceSegment::jam_spacing_mm(h, d),
                    radius_sum_mm,
                })?;
                let arc_radius_mm = 0.5 * d;
                (0.5 * h, Profile::Peirce { arc_radius_mm, segment })
            }
            CentreLineKind::Sinusoid { amplitude_mm } => (amplitude_mm, Profile::Sinusoid),
        };
        Ok(Self {
            spacing_mm,
            crest_mm,
            on_top,
            profile,
        })
    }

    /// Height in mm and slope of the centre line at a distance along the yarn, measured in the cloth's plane.
    pub fn height_and_slope(&self, along_mm: f64) -> (f64, f64) {
        let crossings = along_mm / self.spacing_mm - 0.5;
        let before = crossings.floor();
        let fraction = crossings - before;
        let n = self.on_top.len();
        // `rem_euclid` of a float is below n up to rounding, hence the second remainder.
        let k = before.rem_euclid(n as f64) as usize % n;
        let (from, to) = (self.on_top[k], self.on_top[(k + 1) % n]);
        let sign = if from { 1.0 } else { -1.0 };
        let (height, slope) = if from == to {
            (self.crest_mm, 0.0)
        } else if fraction <= 0.5 {
            self.descent(fraction * self.spacing_mm)
        } else {
            let (height, slope) = self.descent((1.0 - fraction) * self.spacing_mm);
            (-height, slope)
        };
        (sign * height, sign * slope)
    }

    /// Height and slope at 0 to half a spacing past a crest, on the way down.
    fn descent(&self, from_crest_mm: f64) -> (f64, f64) {
        match self.profile {
            Profile::Peirce { arc_radius_mm, segment } => {
                let (sin, cos) = segment.weave_angle_rad.sin_cos();
                if from_crest_mm < arc_radius_mm * sin {
                    let rise = (arc_radius_mm * arc_radius_mm - from_crest_mm * from_crest_mm).sqrt();
                    (self.crest_mm - (arc_radius_mm - rise), -from_crest_mm / rise)
                } else {
                    let on_straight_mm = from_crest_mm - arc_radius_mm * sin;
                    let slope = -sin / cos;
                    (
                        self.crest_mm - arc_radius_mm * (1.0 - cos) + on_straight_mm * slope,
                        slope,
                    )
                }
            }
            Profile::Sinusoid => {
                let phase = PI * from_crest_mm / self.spacing_mm;
                (
                    self.crest_mm * phase.cos(),
                    -self.crest_mm * PI / self.spacing_mm * phase.sin(),
                )
            }
        }
    }

    /// Highest distance of the centre line from the cloth's middle plane.
    pub fn crest_mm(&self) -> f64 {
        self.crest_mm
    }

    /// Crossings in one repeat.
    pub fn crossings(&self) -> usize {
        self.on_top.len()
    }

    /// Length of one repeat in the cloth's plane.
    pub fn repeat_mm(&self) -> f64 {
        self.spacing_mm * self.on_top.len() as f64
    }

    /// Length of yarn in one repeat. Its excess over [`Self::repeat_mm`] is the crimp.
    pub fn length_mm(&self) -> f64 {
        let n = self.on_top.len();
        let changes = (0..n).filter(|&k| self.on_top[k] != self.on_top[(k + 1) % n]).count();
        let change_mm = match self.profile {
            Profile::Peirce { segment, .. } => segment.length_mm,
            Profile::Sinusoid => {
                // The trapezoidal rule over a period converges exponentially for a smooth integrand.
                const NODES: usize = 1024;
                let slope = self.crest_mm * PI / self.spacing_mm;
                let sum: f64 = (0..NODES)
                    .map(|k| 1f64.hypot(slope * (PI * k as f64 / NODES as f64).sin()))
                    .sum();
                self.spacing_mm * sum / NODES as f64
            }
        };
        (n - changes) as f64 * self.spacing_mm + changes as f64 * change_mm
    }

    /// The pieces between crossings over one repeat, and where each begins; one more beginning closes the repeat.
    pub(super) fn pieces(&self) -> (Vec<f64>, Vec<Piece>) {
        let n = self.on_top.len();
        let knots = (0..=n).map(|k| (k as f64 + 0.5) * self.spacing_mm).collect();
        let pieces = (0..n)
            .map(|k| {
                let sign = if self.on_top[k] { 1.0 } else { -1.0 };
                if self.on_top[k] == self.on_top[(k + 1) % n] {
                    return Piece::Flat {
                        height: sign * self.crest_mm,
                    };
                }
                match self.profile {
                    Profile::Peirce { arc_radius_mm, segment } => {
                        let (sin, cos) = segment.weave_angle_rad.sin_cos();
                        let z1 = self.crest_mm - arc_radius_mm;
                        Piece::Arcs {
                            sign,
                            width: self.spacing_mm,
                            z1,
                            r1: arc_radius_mm,
                            z2: -z1,
                            r2: arc_radius_mm,
                            sin,
                            cos,
                            w: z1 * cos + arc_radius_mm,
                        }
                    }
                    Profile::Sinusoid => Piece::Wave {
                        mean: 0.0,
                        amplitude: sign * self.crest_mm,
                        k: PI / self.spacing_mm,
                    },
                }
            })
            .collect();
        (knots, pieces)
    }

    /// Smallest radius of curvature.
    pub fn curvature_radius_mm(&self) -> f64 {
        match self.profile {
            Profile::Peirce { arc_radius_mm, .. } => arc_radius_mm,
            // At the crest, where the slope is zero and the second derivative A (π/p)².
            Profile::Sinusoid => self.spacing_mm.powi(2) / (PI * PI * self.crest_mm),
        }
    }
}
