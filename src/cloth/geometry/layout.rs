use super::centre_line::{CentreLine, Crossing};
use crate::cloth::{CentreLineKind, ClothError, ClothSpec, System};
use crate::fault::{self, Fault};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::{SplitMix64, Xoshiro256PlusPlus};
use std::f64::consts::TAU;

/// Cut-off of normal deviates, in standard deviations.
const CUT: f64 = 2.0;

/// Largest number of crossings; each takes about 500 bytes.
const MAX_CROSSINGS: usize = 1 << 16;

/// One yarn of the cell.
#[derive(Clone, Debug)]
pub(super) struct WovenYarn {
    /// Position across the yarn's direction, mm.
    pub place_mm: f64,
    pub half_width_mm: f64,
    pub half_height_mm: f64,
    pub line: CentreLine,
}

/// The yarns of one cell: the repeated draft, with the section and position of each yarn. They do not overlap.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    pub warps: Vec<WovenYarn>,
    pub wefts: Vec<WovenYarn>,
    /// Size of the cell along x and y, mm.
    pub cell_mm: [f64; 2],
}

/// Section and position of a yarn, before its centre line is known.
struct Strand {
    place_mm: f64,
    half_width_mm: f64,
    half_height_mm: f64,
}

impl Layout {
    /// Layout without the check for overlap of [`Layout::new`].
    pub fn unchecked(spec: &ClothSpec) -> Result<Self, ClothError> {
        spec.check_ranges()?;
        let draft = spec.weave.draft();
        let numbers = |system| draft.yarns(system) * spec.repeats_across(system);
        let crossings = numbers(System::Warp).saturating_mul(numbers(System::Weft));
        if crossings > MAX_CROSSINGS {
            return Err(ClothError::TooManyCrossings {
                found: crossings,
                limit: MAX_CROSSINGS,
            });
        }
        let (warps, wefts) = (
            strands(spec, System::Warp, numbers),
            strands(spec, System::Weft, numbers),
        );
        let cell_mm = [
            wefts.len() as f64 * spec.weft_spacing_mm,
            warps.len() as f64 * spec.warp_spacing_mm,
        ];
        let weave = |system: System, own: &[Strand], crossed: &[Strand], repeat_mm: f64| {
            own.iter()
                .enumerate()
                .map(|(index, strand)| {
                    let on_top = draft.on_top(system, index % draft.yarns(system));
                    let crossings = crossed
                        .iter()
                        .enumerate()
                        .map(|(k, other)| Crossing {
                            at_mm: other.place_mm,
                            on_top: on_top[k % on_top.len()],
                            crest_mm: crest_mm(spec, strand, other),
                            arc_radius_mm: arc_radius_mm(strand, other),
                        })
                        .collect();
                    let spacing_mm = spec.spacing_mm(system.other());
                    // Uniform spacing is passed on so that positions are exact multiples of it.
                    let spacing_mm = (spec.spacing_variation == 0.0).then_some(spacing_mm);
                    Ok(WovenYarn {
                        place_mm: strand.place_mm,
                        half_width_mm: strand.half_width_mm,
                        half_height_mm: strand.half_height_mm,
                        line: CentreLine::through(spec.centre_line, system, crossings, repeat_mm, spacing_mm)?,
                    })
                })
                .collect::<Result<Vec<_>, ClothError>>()
        };
        Ok(Self {
            warps: weave(System::Warp, &warps, &wefts, cell_mm[0])?,
            wefts: weave(System::Weft, &wefts, &warps, cell_mm[1])?,
            cell_mm,
        })
    }

    pub fn yarns(&self, system: System) -> &[WovenYarn] {
        match system {
            System::Warp => &self.warps,
            System::Weft => &self.wefts,
        }
    }

    /// Height of the highest points of the yarns, mm.
    pub fn top_mm(&self) -> f64 {
        let all = self.warps.iter().chain(&self.wefts);
        all.fold(0.0, |top, yarn| top.max(yarn.line.crest_mm() + yarn.half_height_mm))
    }
}

/// Height of a yarn's centre line at a crossing. In Peirce's geometry it is half the sum of the two half heights. The
/// amplitude of a sinusoid holds for mean yarns and scales with the half heights.
fn crest_mm(spec: &ClothSpec, own: &Strand, other: &Strand) -> f64 {
    let heights_mm = own.half_height_mm + other.half_height_mm;
    let crest_mm = match spec.centre_line {
        CentreLineKind::Peirce => 0.5 * heights_mm,
        CentreLineKind::Sinusoid { amplitude_mm } => {
            let mean_mm = [System::Warp, System::Weft].map(|s| spec.half_axes_mm(s, spec.radius_mm(s))[1]);
            let ratio = heights_mm / (mean_mm[0] + mean_mm[1]);
            amplitude_mm * ratio
        }
    };
    let crimp = if fault::active(Fault::CrimpLow) { 0.9 } else { 1.0 };
    crimp * crest_mm
}

/// Radius r of the arc with which a yarn of half height b wraps around another of half axes a', b'. The near side of
/// its surface has radius of curvature r − b. That must be at least a'²/b', the radius of curvature of the other
/// section at its top, whose osculating circle contains the whole ellipse if a' >= b'; a narrower ellipse lies in the
/// circle of radius b'. For circles r = b + b'.
fn arc_radius_mm(own: &Strand, other: &Strand) -> f64 {
    let ratio = other.half_width_mm / other.half_height_mm;
    own.half_height_mm + other.half_height_mm * (ratio * ratio).max(1.0)
}

fn strands(spec: &ClothSpec, system: System, numbers: impl Fn(System) -> usize) -> Vec<Strand> {
    let n = numbers(system);
    let spacing_mm = spec.spacing_mm(system);
    let widths = deviates(spec.variation_seed, system, Quantity::Radius, n);
    let gaps = deviates(spec.variation_seed, system, Quantity::Spacing, n);
    let mut moved = 0.0;
    (0..n)
        .map(|k| {
            let radius_mm = spec.radius_mm(system) * (1.0 + spec.radius_variation * widths[k]);
            let [half_width_mm, half_height_mm] = spec.half_axes_mm(system, radius_mm);
            let place_mm = (k as f64 + 0.5) * spacing_mm + moved;
            moved += spacing_mm * spec.spacing_variation * gaps[k];
            Strand {
                place_mm,
                half_width_mm,
                half_height_mm,
            }
        })
        .collect()
}

#[derive(Clone, Copy)]
enum Quantity {
    Radius,
    Spacing,
}

/// Normal deviates truncated at [`CUT`] and shifted to mean 0, one for each yarn. Each depends only on seed, system,
/// quantity and index of the yarn, so more repeats change the shift only.
fn deviates(seed: u64, system: System, quantity: Quantity, n: usize) -> Vec<f64> {
    let key = 2 * (system as u64) + quantity as u64;
    let raw: Vec<f64> = (0..n as u64)
        .map(|index| {
            let mut keys = SplitMix64::seed_from_u64(seed);
            let stream = keys.random::<u64>() ^ (4 * index + key);
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(stream);
            loop {
                // Box and Muller's transform; 1 − u is never 0.
                let radius = (-2.0 * (1.0 - rng.random::<f64>()).ln()).sqrt();
                let deviate = radius * (TAU * rng.random::<f64>()).cos();
                if deviate.abs() <= CUT {
                    return deviate;
                }
            }
        })
        .collect();
    let mean = raw.iter().sum::<f64>() / n as f64;
    raw.into_iter().map(|x| x - mean).collect()
}
