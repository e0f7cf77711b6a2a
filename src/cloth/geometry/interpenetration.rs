use super::layout::{Layout, WovenYarn};
use super::tube::{Local, Tube};
use crate::cloth::{CentreLineKind, ClothError, ClothSpec, System};
use crate::fault::{self, Fault};
use std::f64::consts::PI;

/// Yarns of Peirce's cloth touch all along their arcs. Distances below the sum of the half axes by up to this fraction
/// count as contact, not overlap.
const CONTACT_TOLERANCE: f64 = 1e-6;

/// Nodes of the initial search along each yarn, per crossing.
const SEARCH_NODES: usize = 48;

impl ClothSpec {
    /// Checks that the yarns of this cloth do not overlap and are in range.
    ///
    /// # Errors
    /// As [`Cloth::new`](crate::cloth::Cloth::new).
    pub fn check(&self) -> Result<(), ClothError> {
        Layout::new(self).map(drop)
    }

    /// The cloth with sinusoidal centre lines of the smallest amplitude without overlap, searched in steps of 2 % of
    /// the amplitude at which yarns touch at crossings, up to twice that; at that amplitude itself if none is found.
    pub fn with_least_amplitude(self) -> Self {
        const STEPS: u32 = 50;
        let touching_mm = [System::Warp, System::Weft]
            .map(|system| 0.5 * self.half_axes_mm(system, self.radius_mm(system))[1])
            .iter()
            .sum::<f64>();
        let with = |step: u32| Self {
            centre_line: CentreLineKind::Sinusoid {
                amplitude_mm: touching_mm * (1.0 + f64::from(step) / f64::from(STEPS)),
            },
            ..self.clone()
        };
        let possible = (0..=STEPS).map(with).find(|spec| spec.check().is_ok());
        possible.unwrap_or_else(|| with(0))
    }
}

impl Layout {
    /// # Errors
    /// [`ClothError`] if tubes overlap (with the yarns' names and the depth of the overlap) or a value is out of range.
    pub(super) fn new(spec: &ClothSpec) -> Result<Self, ClothError> {
        let layout = Self::unchecked(spec)?;
        // With the injected fault, yarns overlap, so the check is skipped.
        if !fault::active(Fault::CrimpLow) {
            check(spec, &layout)?;
        }
        Ok(layout)
    }
}

fn check(spec: &ClothSpec, layout: &Layout) -> Result<(), ClothError> {
    for system in [System::Warp, System::Weft] {
        check_curvature(system, layout.yarns(system))?;
    }
    for system in [System::Warp, System::Weft] {
        check_neighbours(spec, system, layout)?;
    }
    check_crossings(spec, layout)
}

/// A tube folds into itself if the radius of curvature of its centre line is below its half height.
fn check_curvature(system: System, yarns: &[WovenYarn]) -> Result<(), ClothError> {
    for (index, yarn) in yarns.iter().enumerate() {
        let curvature_mm = yarn.line.curvature_radius_mm();
        if curvature_mm < yarn.half_height_mm * (1.0 - CONTACT_TOLERANCE) {
            return Err(ClothError::TooCurved {
                system,
                index,
                curvature_mm,
                radius_mm: yarn.half_height_mm,
            });
        }
    }
    Ok(())
}

/// Neighbours of one system run in parallel planes and must not overlap in plan. Without variation both have the same
/// highest and lowest height and reach both in a draft where every yarn interlaces. Their heights are therefore equal
/// somewhere along the repeat, and their smallest distance is that of the planes. With variation, yarns that only clear
/// each other by passing at unequal heights count as overlapping.
fn check_neighbours(spec: &ClothSpec, system: System, layout: &Layout) -> Result<(), ClothError> {
    let yarns = layout.yarns(system);
    let repeat_mm = match system {
        System::Warp => layout.cell_mm[1],
        System::Weft => layout.cell_mm[0],
    };
    for (index, yarn) in yarns.iter().enumerate() {
        let following = (index + 1) % yarns.len();
        let next = &yarns[following];
        let contact_mm = yarn.half_width_mm + next.half_width_mm;
        let spacing_mm = if spec.spacing_variation == 0.0 {
            spec.spacing_mm(system)
        } else {
            next.place_mm - yarn.place_mm + if following == 0 { repeat_mm } else { 0.0 }
        };
        if spacing_mm < contact_mm * (1.0 - CONTACT_TOLERANCE) {
            let [first, second] = if spec.is_varied() {
                [index, following].map(|k| format!("{system} {k}"))
            } else {
                [format!("each {system}"), format!("the next {system}")]
            };
            return Err(ClothError::Overlap {
                first,
                second,
                neighbours: Some(system),
                overlap_mm: contact_mm - spacing_mm,
                remedy: match (system, spec.is_varied()) {
                    (System::Warp, false) => "increase warp_spacing_mm or reduce warp_radius_mm",
                    (System::Weft, false) => "increase weft_spacing_mm or reduce weft_radius_mm",
                    (System::Warp, true) => "increase warp_spacing_mm, or reduce warp_radius_mm or the variations",
                    (System::Weft, true) => "increase weft_spacing_mm, or reduce weft_radius_mm or the variations",
                },
            });
        }
    }
    Ok(())
}

fn check_crossings(spec: &ClothSpec, layout: &Layout) -> Result<(), ClothError> {
    let draft = spec.weave.draft();
    // Without variation every repeat of the draft equals the first.
    let different = |system| {
        if spec.is_varied() {
            usize::MAX
        } else {
            draft.yarns(system)
        }
    };
    let wefts: Vec<(&WovenYarn, Tube)> = layout.wefts.iter().map(|weft| (weft, Tube::new(weft))).collect();
    for (j, warp) in layout.warps.iter().enumerate().take(different(System::Warp)) {
        for (i, (weft, tube)) in wefts.iter().enumerate().take(different(System::Weft)) {
            let contact_mm = warp.half_height_mm + weft.half_height_mm;
            let circular = [warp, weft]
                .iter()
                .all(|yarn| yarn.half_width_mm == yarn.half_height_mm);
            let overlap_mm = if circular {
                contact_mm - distance_of_lines(warp, weft, contact_mm)
            } else {
                depth_mm(warp, weft, tube)
            };
            if overlap_mm > contact_mm * CONTACT_TOLERANCE {
                return Err(ClothError::Overlap {
                    first: format!("warp {j}"),
                    second: format!("weft {i}"),
                    neighbours: None,
                    overlap_mm,
                    remedy: "increase the yarn spacings, reduce the yarn radii, or change the amplitude of a sinusoid",
                });
            }
        }
    }
    Ok(())
}

/// Smallest distance of two centre lines near their crossing.
fn distance_of_lines(warp: &WovenYarn, weft: &WovenYarn, reach_mm: f64) -> f64 {
    let (x_mm, y_mm) = (weft.place_mm, warp.place_mm);
    // At (dx, dy) from the crossing: a point of the warp, (x + dx, y), and one of the weft, (x, y + dy).
    let distance = |dx: f64, dy: f64| {
        let dz = warp.line.height_and_slope(x_mm + dx).0 - weft.line.height_and_slope(y_mm + dy).0;
        (dx * dx + dy * dy + dz * dz).sqrt()
    };
    minimum(distance, reach_mm)
}

/// Depth of a warp's surface inside a weft near their crossing, mm.
fn depth_mm(warp: &WovenYarn, weft: &WovenYarn, tube: &Tube) -> f64 {
    let reach_mm = weft.half_width_mm + warp.half_height_mm;
    let distance = |along: f64, around: f64| {
        let x_mm = weft.place_mm + along * reach_mm;
        let (height_mm, slope) = warp.line.height_and_slope(x_mm);
        let (sin, cos) = (PI * around).sin_cos();
        let up_mm = warp.half_height_mm * sin / slope.hypot(1.0);
        tube.signed_distance(Local {
            x: warp.place_mm + warp.half_width_mm * cos,
            u: x_mm - up_mm * slope - weft.place_mm,
            z: height_mm + up_mm,
        })
    };
    -minimum(distance, 1.0)
}

/// Minimum of a function over the square of half width `reach` around the origin, by a grid search refined around the
/// best point.
fn minimum(f: impl Fn(f64, f64) -> f64, reach: f64) -> f64 {
    let (mut best, mut at) = (f(0.0, 0.0), (0.0, 0.0));
    let mut search = |centre: (f64, f64), half_width: f64, nodes: usize| {
        for a in 0..=nodes {
            for b in 0..=nodes {
                let offset = |k: usize| half_width * (2.0 * k as f64 / nodes as f64 - 1.0);
                let candidate = (centre.0 + offset(a), centre.1 + offset(b));
                let value = f(candidate.0, candidate.1);
                if value < best {
                    (best, at) = (value, candidate);
                }
            }
        }
        at
    };
    let mut centre = search((0.0, 0.0), reach, SEARCH_NODES);
    let mut half_width = 2.0 * reach / SEARCH_NODES as f64;
    // The error of a minimum is quadratic in the position, so 1e-5 of the reach is far below the tolerance.
    while half_width > 1e-5 * reach {
        centre = search(centre, half_width, 6);
        half_width *= 0.5;
    }
    best
}
