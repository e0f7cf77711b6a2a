//! The woven geometry against drawdowns and Peirce's formulas written out, without chance.

use super::gate::{Gate, Law, Where};
use super::{CheckError, Context};
use crate::cloth::{CentreLineKind, Cloth, ClothError, ClothSpec, Draft, Hit, PeirceSegment, System, Weave};
use crate::geometry::Vec3;
use crate::rig::Interaction;
use crate::run::RunError;

const CROSSINGS: Law = Law {
    name: "crossings",
    words: "at every crossing the yarn on top, seen from above, and the one below, seen from below, are those of the \
            drawdown",
};
const CROWNS: Law = Law {
    name: "crowns",
    words: "crowns of the yarns stand as high as Peirce's geometry says, whose two equations its segment solves",
};
const SHADOWS: Law = Law {
    name: "shadow-rays",
    words: "a yarn is shadowed by the others alone: from below at a crossing, and not between crossings",
};

/// Drawdowns, one row per weft: X where the warp is on top. Neither equals its mirror image or its back, and the second
/// has different numbers of warps and wefts.
const TWILL: &[&str] = &[".XX", "X.X", "XX."];
const UNEVEN: &[&str] = &[".XX", "XX.", "X.X", "..X"];

/// Crossings of the study's own cloth that are looked at, a side.
const OWN_CROSSINGS: usize = 64;

/// A cloth with a known drawdown.
struct Woven<'a> {
    name: &'static str,
    cloth: &'a Cloth,
    spec: &'a ClothSpec,
    warp_on_top: Box<dyn Fn(usize, usize) -> bool>,
    wefts: usize,
    warps: usize,
}

impl<'a> Woven<'a> {
    fn of(name: &'static str, (spec, cloth): &'a (ClothSpec, Cloth), rows: &'static [&'static str]) -> Self {
        Self {
            name,
            cloth,
            spec,
            warp_on_top: Box::new(|i, j| rows[i].as_bytes()[j] == b'X'),
            wefts: rows.len(),
            warps: rows[0].len(),
        }
    }

    /// Places of all crossings: weft, warp, and the point in the cloth's plane.
    fn crossings(&self) -> impl Iterator<Item = (usize, usize, Vec3)> + '_ {
        let Self { spec, wefts, warps, .. } = self;
        (0..*wefts).flat_map(move |i| {
            (0..*warps).map(move |j| {
                let x = (i as f64 + 0.5) * spec.weft_spacing_mm;
                let y = (j as f64 + 0.5) * spec.warp_spacing_mm;
                (i, j, Vec3::new(x, y, 0.0))
            })
        })
    }

    /// What a vertical ray meets first from above, side 1, or from below, side −1.
    fn seen(&self, at: Vec3, side: f64) -> Option<Hit> {
        let from = at + Vec3::z() * (side * 2.0 * self.cloth.top_mm());
        self.cloth.first_hit(from, Vec3::z() * -side)
    }
}

pub fn gates(context: &Context) -> Result<[Gate; 3], CheckError> {
    let rows: Vec<Vec<bool>> = UNEVEN
        .iter()
        .map(|row| row.bytes().map(|x| x == b'X').collect())
        .collect();
    let custom = Draft::new(&rows).map(Weave::Custom).map_err(RunError::from)?;
    let woven = |weave| -> Result<(ClothSpec, Cloth), ClothError> {
        let spec = ClothSpec {
            weave,
            ..ClothSpec::default()
        };
        let cloth = Cloth::new(&spec)?;
        Ok((spec, cloth))
    };
    let twill = woven(Weave::Twill21).map_err(RunError::from)?;
    let uneven = woven(custom).map_err(RunError::from)?;
    let known = [
        Woven::of("twill-2-1", &twill, TWILL),
        Woven::of("uneven draft", &uneven, UNEVEN),
    ];
    let own = own(context)?;
    let all = || known.iter().chain(&own);
    let of_own = |gate: Gate| match own {
        Some(_) => gate,
        None => gate.with_note("on a built-in twill and draft alone: where the study's yarns cross is left to chance"),
    };
    Ok([
        of_own(crossings(context, all())),
        of_own(crowns(context, all())),
        of_own(shadows(context, known.iter().take(1).chain(&own))),
    ])
}

/// The study's cloth; none where its yarns vary, so that crossings are not where the mean spacing says.
fn own<'a>(context: &Context<'a>) -> Result<Option<Woven<'a>>, CheckError> {
    let plan = context.plan;
    let spec = &plan.cloth_spec;
    if spec.spacing_variation > 0.0 || spec.radius_variation > 0.0 {
        return Ok(None);
    }
    let draft = spec.weave.draft();
    Ok(Some(Woven {
        name: "the study's cloth",
        cloth: &plan.cloth,
        spec,
        wefts: draft.yarns(System::Weft).min(OWN_CROSSINGS),
        warps: draft.yarns(System::Warp).min(OWN_CROSSINGS),
        warp_on_top: Box::new(move |i, j| draft.warp_on_top(i, j)),
    }))
}

/// 1 for every wrong yarn.
fn crossings<'a>(context: &Context, all: impl Iterator<Item = &'a Woven<'a>>) -> Gate {
    let mut departures = Vec::new();
    let mut places = Vec::new();
    for woven in all {
        for (i, j, at) in woven.crossings() {
            let (warp, weft) = ((System::Warp, j), (System::Weft, i));
            let (top, bottom) = if (woven.warp_on_top)(i, j) {
                (warp, weft)
            } else {
                (weft, warp)
            };
            for (side, expected) in [(1.0, top), (-1.0, bottom)] {
                let right = woven
                    .seen(at, side)
                    .is_some_and(|hit| (hit.yarn.system, hit.yarn.index as usize) == expected);
                departures.push(f64::from(u8::from(!right)));
                places.push(format!("{}, weft {i}, warp {j}", woven.name));
            }
        }
    }
    context
        .judge
        .exact(CROSSINGS, &departures, 0.0, |i| Where::named(places[i].clone()))
}

/// In the warp's radius. Where yarns touch, their centre lines are the sum of both half-heights apart, of which each
/// takes half as its crest; a sinusoid's crest is its amplitude. A crown stands the yarn's half-height above the crest.
fn crowns<'a>(context: &Context, all: impl Iterator<Item = &'a Woven<'a>>) -> Gate {
    let mut departures = Vec::new();
    let mut places = Vec::new();
    for woven in all {
        let spec = woven.spec;
        let radius_mm = spec.warp_radius_mm;
        // An ellipse of the circle's area whose width is its height times the flattening.
        let half_height = |radius_mm: f64, flattening: f64| radius_mm / flattening.sqrt();
        let heights = [
            half_height(spec.warp_radius_mm, spec.warp_flattening),
            half_height(spec.weft_radius_mm, spec.weft_flattening),
        ];
        let sum = heights[0] + heights[1];
        let crest = match spec.centre_line {
            CentreLineKind::Peirce => 0.5 * sum,
            CentreLineKind::Sinusoid { amplitude_mm } => amplitude_mm,
        };
        for (i, j, at) in woven.crossings() {
            for side in [1.0, -1.0] {
                if let Some(hit) = woven.seen(at, side) {
                    let height = side * hit.position.z - heights[hit.yarn.system.index()];
                    departures.push((height - crest) / radius_mm);
                    places.push(format!("{}, weft {i}, warp {j}", woven.name));
                }
            }
        }
        if spec.centre_line != CentreLineKind::Peirce {
            continue;
        }
        let flattenings = [spec.warp_flattening, spec.weft_flattening];
        for (system, p) in [
            (System::Warp, spec.weft_spacing_mm),
            (System::Weft, spec.warp_spacing_mm),
        ] {
            let (k, crossed) = (system.index(), system.other().index());
            // Arcs about the osculating circle of a wide section at its top, a²/b; about the circle of b in a narrow
            // one.
            let d = 2.0 * (heights[k] + heights[crossed] * flattenings[crossed].powi(2).max(1.0));
            match PeirceSegment::solve(p, sum, d) {
                Some(PeirceSegment {
                    length_mm,
                    weave_angle_rad,
                }) => {
                    let straight = length_mm - d * weave_angle_rad;
                    let (sin, cos) = weave_angle_rad.sin_cos();
                    departures.push((straight * cos + d * sin - p) / radius_mm);
                    departures.push((straight * sin + d * (1.0 - cos) - sum) / radius_mm);
                }
                // A weave that never changes sides has no segment, and may lie closer.
                None => continue,
            }
            places
                .extend(["spacing", "crimp height"].map(|of| format!("{}, Peirce's {of} of the {system}", woven.name)));
        }
    }
    let rounding = context.plan.study.check.rounding;
    context
        .judge
        .exact(CROWNS, &departures, rounding, |i| Where::named(places[i].clone()))
}

/// 1 for every wrong shadow. Light from straight below, at points seen from straight above, and from above, where all
/// is lit.
fn shadows<'a>(context: &Context, all: impl Iterator<Item = &'a Woven<'a>>) -> Gate {
    let mut departures = Vec::new();
    let mut places = Vec::new();
    for woven in all {
        let spec = woven.spec;
        let half_gap = Vec3::x() * (0.5 * spec.weft_spacing_mm);
        // A warp has nothing above or below it half-way between two wefts that leave a gap.
        let gap = spec.weft_radius_mm * spec.weft_flattening.sqrt() < 0.99 * half_gap.x;
        for (i, j, crossing) in woven.crossings() {
            let behind = gap.then_some((crossing + half_gap, false));
            for (at, shadowed_from_below) in [(crossing, true)].into_iter().chain(behind) {
                let seen = woven.seen(at, 1.0).map(|hit| Interaction {
                    omega_out_local: hit.frame.to_local(&Vec3::z()),
                    hit,
                });
                let lit = |light: Vec3| seen.is_some_and(|point| point.light(woven.cloth, &light).is_some());
                let right = lit(Vec3::z()) && lit(-Vec3::z()) != shadowed_from_below;
                departures.push(f64::from(u8::from(!right)));
                let place = if shadowed_from_below { "at" } else { "behind" };
                places.push(format!("{}, warp {j}, {place} the crossing with weft {i}", woven.name));
            }
        }
    }
    context
        .judge
        .exact(SHADOWS, &departures, 0.0, |i| Where::named(places[i].clone()))
}
