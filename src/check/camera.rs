//! Camera, angles and gloss against what geometry and Fresnel's formulas say of them, without chance.

use super::Context;
use super::gate::{Gate, Law, Where};
use crate::compare::Geometry;
use crate::geometry::Vec3;
use crate::optics::gauss_legendre;
use crate::rig::{PixelSamples, omega_in, omega_out, view_cell};
use crate::run::{directions, gloss};
use crate::shading::{Distribution, FibreGloss};
use rand::TryRng;
use std::convert::Infallible;
use std::f64::consts::PI;

const PIXELS: Law = Law {
    name: "pixels",
    words: "a camera ray drawn with u and v from [0, 1) goes through its pixel at those fractions of its sides",
};
const DIRECTIONS: Law = Law {
    name: "directions",
    words: "light and viewer stand at their angles to the normal, on their sides of it, in the plane at the rig's \
            azimuth",
};
const GLOSS: Law = Law {
    name: "gloss",
    words: "in the mirror direction the gloss is w F(θ) / (4π m² cos²θ), its facets cover the plane, and that of \
            fibres along the normal is 1 / (4π α β)",
};

const AREA_NODES: usize = 200;

/// A generator of one number over and over.
struct Always(u64);

impl TryRng for Always {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok((self.0 >> 32) as u32)
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        Ok(self.0)
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        bytes
            .iter_mut()
            .zip(self.0.to_le_bytes().into_iter().cycle())
            .for_each(|(to, from)| *to = from);
        Ok(())
    }
}

/// Pixels of the camera, a side.
const SIDE: usize = 8;
/// Where all rays go through their pixels, and the 64 random bits that are so drawn.
const PLACES: [(f64, u64); 3] = [(0.0, 0), (0.5, 1 << 63), (1.0, u64::MAX)];
const VIEWS_DEG: [[f64; 2]; 3] = [[0.0, 0.0], [50.0, 20.0], [-35.0, 110.0]];

/// The study's cloth through the camera: where rays meet it, followed back to the cloth's plane, in pixels.
pub fn pixels(context: &Context) -> Result<Gate, super::CheckError> {
    let cloth = &context.plan.cloth;
    let samples = PixelSamples::new(SIDE, SIDE).map_err(crate::run::RunError::from)?;
    let [pixel_x, pixel_y] = cloth.cell_mm().map(|cell| cell / SIDE as f64);
    let mut departures = Vec::new();
    let mut places = Vec::new();
    for (fraction, bits) in PLACES {
        for [theta_v_deg, azimuth_deg] in VIEWS_DEG {
            let view = omega_out(theta_v_deg, azimuth_deg);
            let mut ray = 0;
            view_cell(cloth, &view, &samples, &mut Always(bits), |interaction| {
                if let Some(point) = interaction {
                    let at = point.hit.position;
                    let in_plane = at - view * (at.z / view.z);
                    let expected = [(ray % SIDE) as f64 + fraction, (ray / SIDE) as f64 + fraction];
                    departures.push(in_plane.x / pixel_x - expected[0]);
                    departures.push(in_plane.y / pixel_y - expected[1]);
                    let place = format!("pixel {ray}, u = v = {fraction}, view {theta_v_deg} deg");
                    places.extend([place.clone(), place]);
                }
                ray += 1;
            });
        }
    }
    Ok(context
        .judge
        .exact(PIXELS, &departures, context.plan.study.check.rounding, |i| {
            Where::named(places[i].clone())
        }))
}

/// Components along the plane of incidence, across it and along the normal, at azimuths of which none hides another.
pub fn rig_directions(context: &Context) -> Gate {
    let plan = context.plan;
    let own = plan.study.cloth.azimuth_deg;
    let mut departures = Vec::new();
    let mut places = Vec::new();
    for azimuth_deg in [0.0, 25.0, 90.0, -130.0, own] {
        for theta_deg in [0.0, 30.0, 60.0, 85.0] {
            let mut pairs = vec![(omega_in(theta_deg, azimuth_deg), omega_out(theta_deg, azimuth_deg))];
            if azimuth_deg == own {
                let geometry = Geometry {
                    theta_i_deg: theta_deg,
                    theta_v_deg: theta_deg,
                };
                pairs.push(directions(plan, geometry));
            }
            let (sin_a, cos_a) = azimuth_deg.to_radians().sin_cos();
            let (sin, cos) = theta_deg.to_radians().sin_cos();
            let turned = |d: Vec3| [cos_a * d.x + sin_a * d.y, cos_a * d.y - sin_a * d.x, d.z];
            for (light, viewer) in pairs {
                for (of, direction, expected) in
                    [("light", light, [-sin, 0.0, cos]), ("viewer", viewer, [sin, 0.0, cos])]
                {
                    for (found, expected) in turned(direction).iter().zip(expected) {
                        departures.push(found - expected);
                        places.push(format!("{of} at {theta_deg} deg, azimuth {azimuth_deg} deg"));
                    }
                }
            }
        }
    }
    context
        .judge
        .exact(DIRECTIONS, &departures, plan.study.check.rounding, |i| {
            Where::named(places[i].clone())
        })
}

/// Relative departures; D of either distribution is 1/(π m²) along the normal, and G is 1 in the mirror direction.
/// Rounding of the half-way vector goes into D over m².
pub fn mirror_gloss(context: &Context) -> Result<Gate, super::CheckError> {
    let plan = context.plan;
    let specular = &plan.study.specular;
    let shines = !specular.surface.is_of_yarns();
    let m2 = specular.roughness * specular.roughness;
    let mut departures = Vec::new();
    let mut places = Vec::new();
    let mut compare = |found: f64, expected: f64, at: String| {
        departures.push(if expected == 0.0 { found } else { found / expected - 1.0 });
        places.push(at);
    };
    for theta_deg in [0.0, 30.0, 60.0] {
        let geometry = Geometry {
            theta_i_deg: theta_deg,
            theta_v_deg: theta_deg,
        };
        let cos = f64::to_radians(theta_deg).cos();
        let lobe = specular.weight * reflectance(cos, specular.index) / (4.0 * PI * m2 * cos * cos);
        let (omega_in, omega_out) = directions(plan, geometry);
        compare(
            plan.specular.brdf(&omega_in, &omega_out).0,
            lobe,
            format!("BRDF at {theta_deg} deg"),
        );
        let shown = if shines { PI * lobe } else { 0.0 };
        compare(gloss(plan, geometry), shown, format!("beta at {theta_deg} deg"));
    }
    for (name, distribution) in [
        ("Beckmann", Distribution::Beckmann),
        ("Trowbridge-Reitz", Distribution::TrowbridgeReitz),
    ] {
        let area = projected_area(distribution, specular.roughness);
        compare(area, 1.0, format!("area of the facets, {name}"));
    }
    let (along, across) = (0.2, 0.6);
    let fibres = FibreGloss::new(0.3, along, across).map_err(crate::run::RunError::from)?;
    let density = fibres.density(&Vec3::z(), &Vec3::z());
    compare(
        density,
        1.0 / (4.0 * PI * along * across),
        "fibres, along the normal".into(),
    );
    let tolerance = plan.study.check.rounding / m2;
    Ok(context
        .judge
        .exact(GLOSS, &departures, tolerance, |i| Where::named(places[i].clone())))
}

/// ∫ D cosα dω over the hemisphere = π ∫ D cos⁴α d(tan²α), with tan²α = m² x/(1 − x).
fn projected_area(distribution: Distribution, roughness: f64) -> f64 {
    let nodes = gauss_legendre(AREA_NODES).into_iter();
    let m2 = roughness * roughness;
    nodes
        .map(|(node, share)| {
            let x = 0.5 * (1.0 + node);
            let tan2 = m2 * x / (1.0 - x);
            let cos2 = 1.0 / (1.0 + tan2);
            let density = distribution.density(cos2.sqrt(), roughness);
            0.5 * share * PI * density * cos2 * cos2 * m2 / ((1.0 - x) * (1.0 - x))
        })
        .sum()
}

/// Fresnel's reflectance for unpolarised light in the form of sines and tangents, of air to a body.
fn reflectance(cos_in: f64, index: f64) -> f64 {
    let incident = cos_in.acos();
    let refracted = (incident.sin() / index).asin();
    if incident < 1e-6 {
        return ((index - 1.0) / (index + 1.0)).powi(2);
    }
    let s = (incident - refracted).sin() / (incident + refracted).sin();
    let p = (incident - refracted).tan() / (incident + refracted).tan();
    0.5 * (s * s + p * p)
}
