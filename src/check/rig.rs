//! Rig and colour: a perfect diffuser is white and has β = 1, and the cloth is shaded with f* and no further cosine.

use super::gate::{Gate, Law, Where};
use super::{CheckError, Context};
use crate::cloth::light::Integrator;
use crate::colour::{Adaptation, ColourSystem, Convention, Illuminant, Observer, RgbSpace, Xyz};
use crate::geometry::Vec3;
use crate::rig::{brightness_factor, number_of, view_cell};
use crate::run::directions;
use crate::spectrum::WavelengthGrid;
use crate::transport::{Purpose, Stream};
use crate::yarn::{WeightTally, YarnResponse};
use std::f64::consts::TAU;

const DIFFUSER: Law = Law {
    name: "perfect-diffuser",
    words: "a perfect diffuser has β = 1 on the rig at every incidence, and the white of the illuminant",
};
const WHITES: Law = Law {
    name: "whites",
    words: "the whites of observers and illuminants are those of ASTM E308, and sRGB has the primaries of IEC \
            61966-2-1",
};
const LOOKUP: Law = Law {
    name: "lookup-mirror",
    words: "f* looked up at the mirror image of a pair of directions is the same",
};
const SHADING: Law = Law {
    name: "shading",
    words: "a yarn with f* = cosψ shades the cloth with the mean of V cosψ over the camera's rays, and no further \
            cosine",
};

/// Pairs of directions that a table of f* is looked up at.
const LOOKUPS: usize = 64;
/// Fraction of the golden ratio: its multiples fill an interval evenly.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// A table with another value in every cell, looked up at pairs of directions and at their images in the yarn's two
/// mirror planes and in both.
pub fn lookup(context: &Context) -> Gate {
    let grid = context.plan.factor_grid;
    let response = YarnResponse::from_fn(grid, 1, |[tilt, azimuth, exit, _]| {
        (grid.cell(tilt, azimuth, exit) as f64 * GOLDEN).fract()
    });
    let mut tally = WeightTally::new(grid);
    let mut departures = Vec::new();
    for k in 0..LOOKUPS {
        let share = (k as f64 + 0.5) / LOOKUPS as f64;
        let turn = |times: f64| TAU * (k as f64 * GOLDEN * times).fract();
        let towards = |z: f64, azimuth: f64| {
            let sin = (1.0 - z * z).sqrt();
            Vec3::new(sin * azimuth.cos(), sin * azimuth.sin(), z)
        };
        let (light, view) = (towards(1.0 - 2.0 * share, turn(1.0)), towards(share, turn(3.0)));
        let mut at = |tangent: f64, axis: f64| {
            let image = |d: &Vec3| Vec3::new(tangent * d.x, axis * d.y, d.z);
            tally.add(&image(&light), &grid.surface().exit().bilinear(&image(&view)));
            tally.drain(1.0).contract(&response)[0]
        };
        let own = at(1.0, 1.0);
        departures.extend([(-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)].map(|(tangent, axis)| at(tangent, axis) - own));
    }
    let rounding = context.plan.study.check.rounding;
    context.judge.exact(LOOKUP, &departures, rounding, |i| {
        let image = ["tangent", "axis", "tangent and axis"][i % 3];
        Where::named(format!("pair {}, {image} reversed", i / 3))
    })
}

/// L/E⊥ of a perfect diffuser is cosθ_i/π.
pub fn diffuser(context: &Context) -> Gate {
    let plan = context.plan;
    let mut departures = Vec::new();
    let mut places = Vec::new();
    for theta_i_deg in plan.rig.incidences_deg() {
        let cos_i = theta_i_deg.to_radians().cos();
        let beta = brightness_factor(cos_i / std::f64::consts::PI, cos_i).0;
        let colour = plan.colour.convert(&vec![beta; plan.grid.len()]);
        let white = plan.colour.white();
        let [l, a, b] = colour.lab.0;
        for (quantity, departure) in [
            ("beta", beta - 1.0),
            ("X", colour.xyz.x - white.x),
            ("Y", colour.xyz.y - 1.0),
            ("Z", colour.xyz.z - white.z),
            ("L*, of 100", l / 100.0 - 1.0),
            ("a*, of 100", a / 100.0),
            ("b*, of 100", b / 100.0),
        ] {
            departures.push(departure);
            places.push(Where::named(format!("{quantity} at {theta_i_deg} deg")));
        }
    }
    context
        .judge
        .exact(DIFFUSER, &departures, plan.study.check.rounding, |i| places[i].clone())
}

/// X and Z of the whites for Y = 1, 2° and 10° observer: ASTM E308-18, table 5, sums of 5 nm.
const E308: [(Illuminant, [f64; 2], [f64; 2]); 5] = [
    (Illuminant::D65, [0.95047, 1.08883], [0.94811, 1.07304]),
    (Illuminant::D50, [0.96422, 0.82521], [0.96720, 0.81427]),
    (Illuminant::A, [1.09850, 0.35585], [1.11144, 0.35200]),
    (Illuminant::C, [0.98074, 1.18232], [0.97285, 1.16145]),
    (Illuminant::E, [1.0, 1.0], [1.0, 1.0]),
];
/// Primaries of sRGB in XYZ (IEC 61966-2-1), of white Y = 1.
const SRGB: [[f64; 3]; 3] = [
    [0.4124, 0.2126, 0.0193],
    [0.3576, 0.7152, 0.1192],
    [0.1805, 0.0722, 0.9505],
];
/// What the ends of the spectrum, 360 nm and 780 nm here, and the step leave open.
const WHITE_TOLERANCE: f64 = 1e-3;

pub fn whites(context: &Context) -> Result<Gate, CheckError> {
    let grid = WavelengthGrid::new((0..=80).map(|k| 365.0 + 5.0 * f64::from(k)).collect())?;
    let mut departures = Vec::new();
    let mut places = Vec::new();
    for (illuminant, two, ten) in E308 {
        for (observer, [x, z]) in [(Observer::Cie1931, two), (Observer::Cie1964, ten)] {
            let place = |quantity| Where::named(format!("{quantity}, {illuminant}, {observer}"));
            let convention = Convention {
                observer: observer.clone(),
                illuminant: illuminant.clone(),
                rgb: RgbSpace::Srgb,
                adaptation: Adaptation::None,
            };
            let system = ColourSystem::new(&grid, convention)?;
            let white = system.white();
            for (primary, [x, y, z]) in SRGB.into_iter().enumerate() {
                let rgb = system.linear_rgb(Xyz { x, y, z }).0;
                for (channel, found) in rgb.into_iter().enumerate() {
                    departures.push(found - f64::from(u8::from(channel == primary)));
                    places.push(Where::named(format!("sRGB primary {primary}, channel {channel}")));
                }
            }
            for (quantity, departure) in [("X", white.x - x), ("Y", white.y - 1.0), ("Z", white.z - z)] {
                departures.push(departure);
                places.push(place(quantity));
            }
        }
    }
    Ok(context
        .judge
        .exact(WHITES, &departures, WHITE_TOLERANCE, |i| places[i].clone()))
}

/// The table of f* = cosψ through the camera, against the same rays summed here; twice that of wefts of another yarn.
pub fn shading(context: &Context) -> Result<Gate, CheckError> {
    let Context { plan, judge, .. } = context;
    let of_yarn = |number: usize| (number + 1) as f64;
    let grid = plan.factor_grid;
    let responses: Vec<YarnResponse> = (0..plan.different_yarns().count())
        .map(|yarn| {
            YarnResponse::from_fn(grid, plan.grid.len(), |[tilt, ..]| {
                of_yarn(yarn) * grid.mean_cosine(tilt)
            })
        })
        .collect();
    let geometries = plan.geometries();
    let beams = plan.beams(&geometries);
    let shaded = plan.direct().brightness(&responses, beams.lit(), 0)?;
    let shaded = beams.sum(&shaded, plan.grid.len());
    let departures: Vec<f64> = geometries
        .iter()
        .zip(&shaded)
        .map(|(geometry, beta)| {
            let (omega_in, omega_out) = directions(plan, *geometry);
            let mut rng = Stream::open(plan.study.seed, Purpose::Camera, number_of(geometry.theta_v_deg), 0, 0);
            let mut sum = 0.0;
            view_cell(&plan.cloth, &omega_out, &plan.pixels, &mut rng, |interaction| {
                let light = interaction.and_then(|point| point.light(&plan.cloth, &omega_in));
                let yarn = interaction.map_or(0, |point| point.hit.yarn.system.index().min(responses.len() - 1));
                sum += light.map_or(0.0, |light| of_yarn(yarn) * (1.0 - light.y * light.y).max(0.0).sqrt());
            });
            let mean = sum / plan.pixels.count() as f64;
            let expected = std::f64::consts::PI * mean / geometry.theta_i_deg.to_radians().cos();
            let furthest = |far: f64, b: &f64| {
                if (b - expected).abs() > far.abs() {
                    b - expected
                } else {
                    far
                }
            };
            beta.iter().fold(0.0, furthest)
        })
        .collect();
    Ok(judge.exact(SHADING, &departures, plan.study.check.rounding, |i| {
        let geometry = geometries[i];
        Where::named(format!(
            "theta_i {} deg, theta_v {} deg",
            geometry.theta_i_deg, geometry.theta_v_deg
        ))
    }))
}
