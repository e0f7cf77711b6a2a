use super::{CentreLine, ClothError, ClothSpec, System};

/// Yarns of Peirce's cloth touch all along their arcs, so distances below the sum of the radii by this fraction are
/// contact, not overlap.
const CONTACT_TOLERANCE: f64 = 1e-6;

/// Nodes of the first search along each yarn, per crossing.
const SEARCH_NODES: usize = 48;

/// Refuses a cloth whose tubes overlap, with the yarns' names and the depth of the overlap.
pub(super) fn check(spec: &ClothSpec, warps: &[CentreLine], wefts: &[CentreLine]) -> Result<(), ClothError> {
    check_curvature(System::Warp, spec.warp_radius_mm, warps)?;
    check_curvature(System::Weft, spec.weft_radius_mm, wefts)?;
    check_neighbours(spec, System::Warp)?;
    check_neighbours(spec, System::Weft)?;
    check_crossings(spec, warps, wefts)
}

/// A tube whose centre line bends tighter than the tube is thick folds into itself.
fn check_curvature(system: System, radius_mm: f64, lines: &[CentreLine]) -> Result<(), ClothError> {
    for (index, line) in lines.iter().enumerate() {
        let curvature_mm = line.curvature_radius_mm();
        if curvature_mm < radius_mm * (1.0 - CONTACT_TOLERANCE) {
            return Err(ClothError::TooCurved {
                system,
                index,
                curvature_mm,
                radius_mm,
            });
        }
    }
    Ok(())
}

/// Neighbours of one system run in parallel planes a spacing apart. Both have the same highest and lowest height and,
/// in a draft where every yarn interlaces, reach both, so somewhere along the repeat their heights agree: their
/// smallest distance is the spacing itself.
fn check_neighbours(spec: &ClothSpec, system: System) -> Result<(), ClothError> {
    let diameter_mm = 2.0 * spec.radius_mm(system);
    let spacing_mm = spec.spacing_mm(system);
    if spacing_mm < diameter_mm * (1.0 - CONTACT_TOLERANCE) {
        return Err(ClothError::Overlap {
            first: format!("each {system}"),
            second: format!("the next {system}"),
            overlap_mm: diameter_mm - spacing_mm,
            remedy: match system {
                System::Warp => "increase warp_spacing_mm or reduce warp_radius_mm",
                System::Weft => "increase weft_spacing_mm or reduce weft_radius_mm",
            },
        });
    }
    Ok(())
}

fn check_crossings(spec: &ClothSpec, warps: &[CentreLine], wefts: &[CentreLine]) -> Result<(), ClothError> {
    let contact_mm = spec.warp_radius_mm + spec.weft_radius_mm;
    for (j, warp) in warps.iter().enumerate() {
        for (i, weft) in wefts.iter().enumerate() {
            let x_mm = (i as f64 + 0.5) * spec.weft_spacing_mm;
            let y_mm = (j as f64 + 0.5) * spec.warp_spacing_mm;
            // At (dx, dy) from the crossing: a point of the warp, (x + dx, y), and one of the weft, (x, y + dy).
            let distance = |dx: f64, dy: f64| {
                let dz = warp.height_and_slope(x_mm + dx).0 - weft.height_and_slope(y_mm + dy).0;
                (dx * dx + dy * dy + dz * dz).sqrt()
            };
            let overlap_mm = contact_mm - minimum(distance, contact_mm);
            if overlap_mm > contact_mm * CONTACT_TOLERANCE {
                return Err(ClothError::Overlap {
                    first: format!("warp {j}"),
                    second: format!("weft {i}"),
                    overlap_mm,
                    remedy: "increase the yarn spacings, reduce the yarn radii, or change the amplitude of a sinusoid",
                });
            }
        }
    }
    Ok(())
}

/// Minimum of a function over the square of half width `reach` around the origin: a grid, then ever smaller grids
/// around the best point.
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
    // The error of a minimum is quadratic in the place, so 1e-5 of the reach is far below the tolerance.
    while half_width > 1e-5 * reach {
        centre = search(centre, half_width, 6);
        half_width *= 0.5;
    }
    best
}
