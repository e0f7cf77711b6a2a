//! The yarn without scattering: closed forms of the empty and of the purely absorbing cylinder.

use super::gate::{Gate, Law, Where};
use super::{CheckError, Context};
use crate::optics::{HenyeyGreenstein, Medium, Phase, gauss_legendre};
use crate::transport::Fraction;
use crate::yarn::{Effort, FarFieldGrid, FarFieldTracer, Yarn};
use std::f64::consts::FRAC_PI_2;
use std::iter::zip;

pub const LAW: Law = Law {
    name: "cylinder",
    words: "without particles the cylinder, empty or absorbing, reflects, transmits and absorbs as its closed form \
            says",
};
const QUANTITIES: [&str; 3] = ["reflected", "transmitted", "absorbed"];
const TILTS: usize = 4;

/// Nodes of the closed form across a cell of tilts, and over the heights at which light meets the cylinder.
const TILT_NODES: usize = 24;
const HEIGHT_NODES: usize = 96;

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
            for (ledger, form) in traced.iter().zip(&expected) {
                let fractions = [Fraction::Reflected, Fraction::Ballistic, Fraction::Absorbed];
                differences.extend(
                    fractions
                        .into_iter()
                        .zip(form)
                        .map(|(fraction, form)| ledger[fraction] - form),
                );
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
        Where::new(plan.grid.nm()[cell % wavelengths], at)
    }))
}

/// Reflected, transmitted and absorbed fractions of parallel beams over the whole width of a cylinder of index n, mean
/// over beams even in sin ψ between two sines; `depth` is μ_a R.
///
/// A ray that enters at the height h, in radii, meets every wall at the same angle: with a = exp(−μ_a L) along its
/// chord L and the reflectance r of the surface, T = (1 − r)² a / (1 − r a) and A = (1 − r)(1 − a)/(1 − r a).
pub(super) fn beam(index: f64, depth: f64, sines: [f64; 2]) -> [f64; 3] {
    let [low, high] = sines.map(f64::asin);
    let heights = gauss_legendre(HEIGHT_NODES);
    let mut mean = [0.0; 3];
    for (x, share) in gauss_legendre(TILT_NODES) {
        let tilt = 0.5 * (low + high + (high - low) * x);
        let of_tilt = 0.5 * (high - low) * share * tilt.cos() / (sines[1] - sines[0]);
        for (x, share) in &heights {
            let around = 0.5 * FRAC_PI_2 * (1.0 + x);
            let weight = of_tilt * 0.5 * FRAC_PI_2 * share * around.cos();
            let fractions = ray(index, depth, tilt, around.sin());
            zip(&mut mean, fractions).for_each(|(mean, x)| *mean += weight * x);
        }
    }
    mean
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Without a surface, index 1, nothing is reflected and the empty cylinder transmits all light; with any index and
    /// depth the three fractions add up to 1 and are those of a rule with ten and forty times as many nodes.
    #[test]
    fn closed_form_is_accurate_at_every_index_and_depth() {
        for sines in [[0.0, 0.25], [0.75, 1.0]] {
            let [reflected, transmitted, absorbed] = beam(1.0, 0.0, sines);
            assert!(reflected.abs() < 1e-14 && (transmitted - 1.0).abs() < 1e-14 && absorbed == 0.0);
            for index in [1.0, 1.0001, 1.05, 1.557, 4.0] {
                for depth in [0.0, 0.1, 3.0, 100.0] {
                    let found = beam(index, depth, sines);
                    assert!((found.iter().sum::<f64>() - 1.0).abs() < 1e-13, "{index} {depth}");
                    let fine = midpoints(index, depth, sines);
                    for (found, fine) in zip(found, fine) {
                        assert!((found - fine).abs() < 1e-6, "{index} {depth} {sines:?}: {found} {fine}");
                    }
                }
            }
        }
    }

    /// The midpoint rule, over sin ψ and over the height itself.
    fn midpoints(index: f64, depth: f64, sines: [f64; 2]) -> [f64; 3] {
        const NODES: usize = 1000;
        let middle = |k: usize| (k as f64 + 0.5) / NODES as f64;
        let mut mean = [0.0; 3];
        for i in 0..NODES {
            // Denser towards the grazing end of both.
            let near = middle(i);
            let sine = sines[1] - (sines[1] - sines[0]) * near * near;
            for k in 0..NODES {
                let height = 1.0 - middle(k) * middle(k);
                let weight = 4.0 * near * middle(k) / (NODES * NODES) as f64;
                let fractions = ray(index, depth, sine.asin(), height);
                zip(&mut mean, fractions).for_each(|(mean, x)| *mean += weight * x);
            }
        }
        mean
    }
}
