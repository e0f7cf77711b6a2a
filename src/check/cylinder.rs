//! The yarn without scattering: closed forms of the empty and of the purely absorbing cylinder.

use super::gate::{Gate, Law, Place};
use super::{CheckError, Context};
use crate::optics::{HenyeyGreenstein, Medium, Phase};
use crate::transport::Ledger;
use crate::yarn::{Effort, FarFieldGrid, FarFieldTracer, Yarn};
use std::f64::consts::FRAC_PI_2;

const LAW: Law = Law {
    name: "cylinder",
    words: "without particles the cylinder, empty or absorbing, reflects, transmits and absorbs as its closed form says",
};
const QUANTITIES: [&str; 3] = ["reflected", "transmitted", "absorbed"];
const TILTS: usize = 4;

pub fn closed_forms(context: &Context) -> Result<Gate, CheckError> {
    let Context { plan, judge, .. } = context;
    let medium = &plan.yarn.medium;
    let (wavelengths, radius_mm) = (plan.grid.len(), plan.yarn.cylinder.radius_mm());
    let grid = FarFieldGrid::new(TILTS, 1)?;
    let paths = context.share(4) * context.batches as u64;
    let effort = Effort::new(plan.study.seed, context.batches, context.of_estimator(paths))?;
    let mut batches: Vec<Vec<f64>> = vec![Vec::new(); context.batches];
    for mu_a in [&vec![0.0; wavelengths], &medium.mu_a_per_mm().to_vec()] {
        let isotropic = Phase::HenyeyGreenstein(HenyeyGreenstein::new(0.0)?);
        let clear = Medium::from_coefficients(
            &plan.grid,
            medium.host_index().to_vec(),
            vec![0.0; wavelengths],
            mu_a.clone(),
            vec![isotropic; wavelengths],
        )?;
        let yarn = Yarn {
            medium: clear,
            ..plan.yarn.clone()
        };
        let tracer = FarFieldTracer::new(&yarn, grid, effort)?;
        let mut expected = Vec::with_capacity(TILTS * wavelengths);
        for tilt in 0..TILTS {
            for (index, mu_a) in medium.host_index().iter().zip(mu_a) {
                expected.push(beam(*index, mu_a * radius_mm, grid.sines(tilt)));
            }
        }
        for (batch, differences) in batches.iter_mut().enumerate() {
            let traced = tracer.batch(batch).ledgers;
            for (
                Ledger {
                    reflected,
                    ballistic,
                    absorbed,
                    ..
                },
                form,
            ) in traced.iter().zip(&expected)
            {
                differences.extend([reflected - form[0], ballistic - form[1], absorbed - form[2]]);
            }
        }
    }
    let tolerance = plan.study.check.cylinder * context.widening;
    Ok(judge.zero(LAW, &batches, tolerance, |i| {
        let (cell, quantity) = (i / QUANTITIES.len(), QUANTITIES[i % QUANTITIES.len()]);
        let tilt = cell / wavelengths;
        let body = if tilt < TILTS { "empty" } else { "absorbing" };
        let [low, high] = grid.sines(tilt % TILTS).map(|sine| sine.asin().to_degrees());
        let at = format!("{body}, {quantity}, tilt {low:.0} to {high:.0} deg");
        Place::new(plan.grid.nm()[cell % wavelengths], at)
    }))
}

/// Reflected, transmitted and absorbed fractions of parallel beams over the whole width of a cylinder of index n, mean over
/// beams even in sin ψ between two sines; `depth` is μ_a R.
///
/// A ray that enters at the height h, in radii, meets every wall at the same angle: with a = exp(−μ_a L) along its chord L
/// and the reflectance r of the surface, T = (1 − r)² a / (1 − r a) and A = (1 − r)(1 − a)/(1 − r a).
fn beam(index: f64, depth: f64, sines: [f64; 2]) -> [f64; 3] {
    let [low, high] = sines.map(f64::asin);
    let sum = simpson(low, high, 64, |tilt| {
        let across = simpson(0.0, FRAC_PI_2, 256, |t| {
            ray(index, depth, tilt, t.sin()).map(|x| x * t.cos())
        });
        across.map(|x| x * tilt.cos())
    });
    sum.map(|x| x / (sines[1] - sines[0]))
}

fn ray(index: f64, depth: f64, tilt: f64, height: f64) -> [f64; 3] {
    let cos_in = tilt.cos() * (1.0 - height * height).max(0.0).sqrt();
    let cos_inside = (1.0 - (1.0 - cos_in * cos_in) / (index * index)).max(0.0).sqrt();
    // Fresnel's two polarisations as they stand in the textbooks.
    let s = (cos_in - index * cos_inside) / (cos_in + index * cos_inside);
    let p = (index * cos_in - cos_inside) / (index * cos_in + cos_inside);
    let reflected = 0.5 * (s * s + p * p);
    // Inside, the tilt is refracted as by a plane, and what is left of the cosine to the wall lies across.
    let cos_tilt_inside_squared = 1.0 - (tilt.sin() / index).powi(2);
    let chord = 2.0 * cos_inside / cos_tilt_inside_squared;
    let left = (-depth * chord).exp();
    let passes = (1.0 - reflected) / (1.0 - reflected * left);
    if !passes.is_finite() {
        // Grazing light in an empty cylinder.
        return [1.0, 0.0, 0.0];
    }
    [reflected, (1.0 - reflected) * left * passes, (1.0 - left) * passes]
}

/// Simpson's rule over an even number of panels.
fn simpson(low: f64, high: f64, panels: usize, f: impl Fn(f64) -> [f64; 3]) -> [f64; 3] {
    let step = (high - low) / panels as f64;
    let mut sum = [0.0; 3];
    for i in 0..=panels {
        let weight = match i {
            _ if i == 0 || i == panels => 1.0,
            _ if i % 2 == 1 => 4.0,
            _ => 2.0,
        };
        let values = f(low + i as f64 * step);
        sum.iter_mut()
            .zip(values)
            .for_each(|(sum, x)| *sum += weight * step / 3.0 * x);
    }
    sum
}
