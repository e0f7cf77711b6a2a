//! Cells of f*: light goes into the cell of where and in what direction it leaves, and a table is read where it says.

use super::gate::{Gate, Law, Where};
use super::{CheckError, Context};
use crate::geometry::Vec3;
use crate::optics::{Medium, Phase, PhaseTable};
use crate::spectrum::WavelengthGrid;
use crate::yarn::{DirectTracer, Effort, Estimator, SurfaceGrid, WeightTally, Yarn, YarnResponse, YarnResponseGrid};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

const LOOKUP: Law = Law {
    name: "lookup-table",
    words: "a table of f*/cosψ that is linear in tilt, azimuth and each angle of exit is looked up as just that \
            function",
};
const CELLS: Law = Law {
    name: "exit-cells",
    words: "light that particles do not turn goes straight through the yarn, into the cell of where it comes out",
};

/// Pairs of directions that the table is looked up at.
const LOOKUPS: usize = 256;
/// Powers of the inverse of the plastic number of dimension 4, whose multiples fill a four-dimensional interval evenly.
const EVEN: [f64; 4] = [
    0.856_674_883_854_502_9,
    0.733_891_856_627_126_1,
    0.628_706_721_023_416_3,
    0.538_597_257_223_612_6,
];

/// At the azimuth φ from the light the yarn's normal is φ beyond the light's meridian, so that light from the tilt ψ
/// has there the components (tangent, axis, normal) = (−sinφ cosψ, sinψ, cosφ cosψ).
pub fn lookup(context: &Context) -> Gate {
    let grid = context.plan.factor_grid;
    let exit = *grid.surface().exit();
    let counts = [grid.tilts(), grid.azimuths(), exit.theta_cells(), exit.phi_cells()];
    let widths = [FRAC_PI_2, PI, FRAC_PI_2, TAU];
    // Of a place in cells from the first node, the coordinate.
    let at = |axis: usize, place: f64| (place + 0.5) * widths[axis] / counts[axis] as f64;
    let function = |of: [f64; 4]| {
        let terms = std::array::from_fn::<f64, 4, _>(|axis| 1.0 + (axis + 1) as f64 * of[axis] / widths[axis]);
        terms.iter().product::<f64>() / 120.0
    };
    let response = YarnResponse::from_fn(grid, 1, |[tilt, azimuth, cell, _]| {
        let node = [tilt, azimuth, cell / exit.phi_cells(), cell % exit.phi_cells()];
        grid.mean_cosine(tilt) * function(std::array::from_fn(|axis| at(axis, node[axis] as f64)))
    });
    let mut tally = WeightTally::new(grid);
    let departures: Vec<f64> = (0..LOOKUPS)
        .map(|k| {
            // Between the first and the last node of each axis, where no mirror image is read.
            let of: [f64; 4] = std::array::from_fn(|axis| {
                let share = (0.5 + k as f64 * EVEN[axis]).fract();
                at(axis, share * (counts[axis] - 1) as f64)
            });
            let [tilt, azimuth, theta, phi] = of;
            let light = Vec3::new(-azimuth.sin() * tilt.cos(), tilt.sin(), azimuth.cos() * tilt.cos());
            let view = Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
            tally.add(&light, &exit.bilinear(&view));
            tally.drain(1.0).contract(&response)[0] - tilt.cos() * function(of)
        })
        .collect();
    let rounding = context.plan.study.check.rounding;
    context
        .judge
        .exact(LOOKUP, &departures, rounding, |i| Where::named(format!("pair {i}")))
}

/// Axes of the cells that light is followed into.
const TILTS: usize = 3;
const AZIMUTHS: usize = 12;
const THETAS: usize = 3;
const PHIS: usize = 8;
/// Nodes of a phase function that turns light by less than 0.01°.
const NODES: usize = 16_385;
/// μ_s times the yarn's diameter.
const DEPTH: f64 = 3.0;
const PATHS: u64 = 4096;
/// Of the light of a tilt, in any cell. With 4096 paths, even across the yarn, chance moves at most 0.01 from cell to
/// cell; one cell beside moves 0.1 and more.
const TOLERANCE: f64 = 0.03;
/// Of the sum over beams, across the yarn and over the tilts of a cell.
const HEIGHTS: usize = 1000;
const SINES: usize = 40;

/// The yarn in a host of index 1, with particles that scatter straight ahead.
pub fn straight(context: &Context) -> Result<Gate, CheckError> {
    let Context { plan, judge, .. } = context;
    let ahead = PhaseTable::from_density(NODES, |cos| if cos == 1.0 { 1.0 } else { 0.0 })?;
    let radius_mm = plan.yarn.cylinder.radius_mm();
    let yarn = Yarn {
        medium: Medium::from_coefficients(
            &WavelengthGrid::new(vec![550.0])?,
            vec![1.0],
            vec![0.5 * DEPTH / radius_mm],
            vec![0.0],
            vec![Phase::Table(ahead)],
        )?,
        estimator: Estimator::Independent,
        ..plan.yarn.clone()
    };
    let grid = YarnResponseGrid::new(TILTS, SurfaceGrid::new(AZIMUTHS, THETAS, PHIS)?)?;
    let tracer = DirectTracer::new(&yarn, grid, Effort::new(plan.study.seed, 2, 2 * PATHS)?, None)?;
    let found = tracer.batch(0).response;
    let per_tilt = grid.cells() / TILTS;
    let departures: Vec<f64> = (0..TILTS)
        .flat_map(|tilt| {
            let values = &found.values()[tilt * per_tilt..][..per_tilt];
            let fractions = values.iter().enumerate();
            let fractions =
                fractions.map(move |(cell, f)| f / grid.response_per_fraction(tilt, cell % (THETAS * PHIS)));
            fractions.zip(expected(tilt)).map(|(found, expected)| found - expected)
        })
        .collect();
    Ok(judge.exact(CELLS, &departures, TOLERANCE, |i| {
        let (tilt, azimuth) = (i / per_tilt, i % per_tilt / (THETAS * PHIS));
        let (theta, phi) = (i % (THETAS * PHIS) / PHIS, i % PHIS);
        Where::named(format!(
            "cells: tilt {tilt}, azimuth {azimuth}, exit theta {theta}, phi {phi}"
        ))
    }))
}

/// Fraction of the light of a tilt cell that scatters and leaves through each of its cells: a beam at the height h, in
/// radii, comes out at the normal (h, 0, −√(1 − h²)) along (0, −sinψ, −cosψ), after 2R √(1 − h²)/cosψ.
fn expected(tilt: usize) -> Vec<f64> {
    let edge = |k: usize| (k as f64 * FRAC_PI_2 / TILTS as f64).sin();
    let (low, high) = (edge(tilt), edge(tilt + 1));
    let half = AZIMUTHS / 2;
    let mut fractions = vec![0.0; half * THETAS * PHIS];
    let cell = |angle: f64, range: f64, cells: usize| ((angle / range * cells as f64) as usize).min(cells - 1);
    for k in 0..SINES {
        let sine = low + (high - low) * (k as f64 + 0.5) / SINES as f64;
        let cosine = (1.0 - sine * sine).sqrt();
        // Both halves of the yarn are mirror images.
        for j in 0..HEIGHTS {
            let h = (j as f64 + 0.5) / HEIGHTS as f64;
            let depth = (1.0 - h * h).sqrt();
            let azimuth = h.atan2(-depth);
            let (tangent, axis, normal) = (cosine * h, -sine, cosine * depth);
            let phi = axis.atan2(tangent).rem_euclid(TAU);
            let place = (cell(azimuth, PI, half) * THETAS + cell(normal.acos(), FRAC_PI_2, THETAS)) * PHIS;
            let scattered = -(-DEPTH * depth / cosine).exp_m1();
            fractions[place + cell(phi, TAU, PHIS)] += scattered / (SINES * HEIGHTS) as f64;
        }
    }
    fractions
}
