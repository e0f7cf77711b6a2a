//! The medium: passive, dyed within its table, with phase functions that are densities and that paths turn by.

use super::gate::{Gate, Law, Where};
use super::{CheckError, Context};
use crate::geometry::Vec3;
use crate::optics::{HenyeyGreenstein, Medium, Phase, PhaseTable};
use crate::run::dye_on;
use crate::spectrum::WavelengthGrid;
use crate::transport::{Coefficients, Cylinder, Entry, Interior, Purpose, Roulette, Stream, Walk};
use crate::yarn::Yarn;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::iter::zip;

/// Of g, between table and series: what [`Medium::new`] asks of its tables.
const ASYMMETRY: f64 = 1e-6;

pub const PASSIVE: Law = Law {
    name: "passive-medium",
    words: "mu_s and mu_a are 0 or more at every wavelength: no gain",
};
const DYE: Law = Law {
    name: "dye",
    words: "the dye is between 0 and 1, its peak",
};
const NORMALISED: Law = Law {
    name: "phase-normalised",
    words: "the phase function integrates to 1 over the sphere",
};
const G: Law = Law {
    name: "phase-asymmetry",
    words: "the mean cosine of the phase function is the g of the Mie series",
};
pub const ANGLE: Law = Law {
    name: "scattering-angle",
    words: "paths turn by angles whose mean cosine is g, at every wavelength that shares them",
};

pub fn passive(medium: &Medium, tolerance: &Context) -> Gate {
    let (mu_s, mu_a) = (medium.mu_s_per_mm(), medium.mu_a_per_mm());
    let nm = medium.grid().nm();
    // What is negative is gain; NaN stays.
    let gain = |mu: &f64| if *mu >= 0.0 { 0.0 } else { -mu };
    let departures: Vec<f64> = mu_s.iter().chain(mu_a).map(gain).collect();
    tolerance.judge.exact(PASSIVE, &departures, 0.0, |i| {
        let quantity = if i < nm.len() { "mu_s, 1/mm" } else { "mu_a, 1/mm" };
        Where::new(nm[i % nm.len()], quantity)
    })
}

pub fn tables(context: &Context) -> Result<Vec<Gate>, CheckError> {
    let Context { plan, judge, .. } = context;
    let rounding = plan.study.check.rounding;
    let medium = &plan.yarn.medium;
    let nm = plan.grid.nm();
    let at = |i: usize| Where::new(nm[i], "");
    let beyond = |value: &f64| value - value.clamp(0.0, 1.0);
    let dye: Vec<f64> = dye_on(&plan.study, &plan.grid)?.values().iter().map(beyond).collect();
    let integrals: Vec<[f64; 2]> = (0..nm.len()).map(|w| integrals(medium.phase(w))).collect();
    let norms: Vec<f64> = integrals.iter().map(|of| of[0] - 1.0).collect();
    let asymmetries: Vec<f64> = integrals.iter().zip(medium.g()).map(|(of, g)| of[1] - g).collect();
    Ok(vec![
        judge.exact(DYE, &dye, rounding, at),
        judge.exact(NORMALISED, &norms, rounding, at),
        judge.exact(G, &asymmetries, ASYMMETRY, at),
    ])
}

/// ∫ p dω and ∫ p cosθ dω, exact for a density linear in cosθ between the nodes of a table.
fn integrals(phase: &Phase) -> [f64; 2] {
    match phase {
        Phase::Table(table) => of_table(table),
        Phase::HenyeyGreenstein(_) => [1.0, phase.g()],
    }
}

fn of_table(table: &PhaseTable) -> [f64; 2] {
    let density = table.density();
    let last = density.len() - 1;
    let cosine = |k: usize| 1.0 - 2.0 * (k as f64 / last as f64).powi(2);
    let mut sums = [0.0; 2];
    for k in 0..last {
        let (near, far) = (cosine(k), cosine(k + 1));
        let half = 0.5 * (near - far);
        let middle = 0.5 * (near + far);
        let mean = 0.5 * (density[k] + density[k + 1]);
        let slope = 0.5 * (density[k] - density[k + 1]);
        // p = mean + slope t, cosθ = middle + half t, t in −1..1.
        sums[0] += 2.0 * PI * half * 2.0 * mean;
        sums[1] += 2.0 * PI * half * (2.0 * mean * middle + 2.0 / 3.0 * slope * half);
    }
    sums
}

/// The yarn at the first, the middle and the last of its wavelengths, with the scattering and absorption, 1/mm, that
/// `of` makes of the number of a wavelength among them and its own.
pub fn few_wavelengths(yarn: &Yarn, of: impl Fn(usize, [f64; 2]) -> [f64; 2]) -> Result<Yarn, CheckError> {
    let medium = &yarn.medium;
    let last = medium.grid().len() - 1;
    let mut places = vec![0, last / 2, last];
    places.dedup();
    let at = |values: &[f64]| places.iter().map(|&w| values[w]).collect::<Vec<f64>>();
    let own = zip(at(medium.mu_s_per_mm()), at(medium.mu_a_per_mm()));
    let (mu_s, mu_a) = own
        .enumerate()
        .map(|(k, (mu_s, mu_a))| of(k, [mu_s, mu_a]).into())
        .unzip();
    let medium = Medium::from_coefficients(
        &WavelengthGrid::new(at(medium.grid().nm()))?,
        at(medium.host_index()),
        mu_s,
        mu_a,
        places.iter().map(|&w| medium.phase(w).clone()).collect(),
    )?;
    Ok(Yarn { medium, ..yarn.clone() })
}

/// Optical thickness 2 μ_s R of a yarn in which double scattering is negligible.
const THIN: f64 = 1e-6;

/// Phase functions as unlike as can be, forward, even all around and backward, and what μ_s is times: whose turn it is
/// and whose angle is drawn then shows at once, which between neighbours of a study's grid it hardly does.
const CONTRAST: [(f64, f64); 3] = [(0.7, 1.0), (0.0, 2.0), (-0.7, 4.0)];
const CONTRAST_NODES: usize = 257;

/// One scattering in an index-matched cylinder, by the kernel itself: the first flight of a path is drawn under the
/// condition that it meets a particle, so every path does. Of the study's phase functions, which all have one μ_s here
/// and share paths, and of three that are unlike. With their mean cosine goes their amount of light.
pub fn angles(context: &Context) -> Result<Gate, CheckError> {
    let Context { plan, judge, .. } = context;
    let nm = plan.grid.nm();
    let own: Vec<(&Phase, f64)> = (0..nm.len()).map(|w| (plan.yarn.medium.phase(w), 1.0)).collect();
    let mut unlike = Vec::new();
    for (g, _) in CONTRAST {
        let density = HenyeyGreenstein::new(g)?;
        let table = PhaseTable::from_density(CONTRAST_NODES, |cos| Phase::HenyeyGreenstein(density).pdf(cos))?;
        unlike.push(Phase::Table(table));
    }
    let unlike: Vec<(&Phase, f64)> = unlike
        .iter()
        .zip(CONTRAST)
        .map(|(phase, (_, times))| (phase, times))
        .collect();
    let mut batches = one_scattering(context, ANGLE_STREAM, &own, 4)?;
    for (batch, more) in batches
        .iter_mut()
        .zip(one_scattering(context, ANGLE_STREAM + 1, &unlike, 6)?)
    {
        batch.extend(more);
    }
    let tolerance = plan.study.check.scattering_angle * context.widening;
    let of_own = 2 * nm.len();
    Ok(judge.zero(ANGLE, &batches, tolerance, |i| {
        let quantity = ["mean cosine", "amount"][i % 2];
        match i < of_own {
            true => Where::new(nm[i / 2], quantity),
            false => Where::named(format!("{quantity} of g = {}", CONTRAST[(i - of_own) / 2].0)),
        }
    }))
}

/// Σ w (cosθ − g) and Σ w − the expected amount of every phase function, over that amount: [batch][phase × 2].
fn one_scattering(
    context: &Context,
    stream: usize,
    phases: &[(&Phase, f64)],
    shares: u64,
) -> Result<Vec<Vec<f64>>, CheckError> {
    let plan = context.plan;
    let radius_mm = plan.yarn.cylinder.radius_mm();
    let cylinder = Cylinder::new(radius_mm)?;
    let coefficients: Vec<Coefficients<'_>> = phases
        .iter()
        .map(|(phase, times)| Coefficients {
            mu_s: 0.5 * THIN * times / radius_mm,
            mu_a: 0.0,
            phase,
        })
        .collect();
    let interior = Interior::new(1.0, &coefficients)?;
    let walk = Walk {
        shape: &cylinder,
        interior: &interior,
        roulette: Roulette::default(),
    };
    let entry = Entry {
        position: cylinder.at(0.0),
        normal: Vec3::z(),
        omega_in: Vec3::z(),
    };
    let paths = context.share(shares) as usize;
    let batch = |batch| {
        let stream = Stream::open(plan.study.seed, Purpose::Check, stream, batch, 0);
        let mut cosines = vec![0.0; phases.len()];
        let mut amounts = vec![0.0; phases.len()];
        walk.trace(
            stream,
            paths,
            |_| entry,
            |exit| {
                if exit.scattered {
                    for ((cosine, amount), weight) in cosines.iter_mut().zip(&mut amounts).zip(exit.weights) {
                        *cosine -= weight * exit.direction.z;
                        *amount += weight;
                    }
                }
            },
        );
        let cells = cosines.iter().zip(&amounts).zip(phases);
        cells
            .flat_map(|((cosine, amount), (phase, times))| {
                // The paths times the share that scatters: free of the bias of a ratio.
                let expected = paths as f64 * -(-THIN * times).exp_m1();
                [(cosine - amount * phase.g()) / expected, amount / expected - 1.0]
            })
            .collect()
    };
    Ok((0..context.batches).into_par_iter().map(batch).collect())
}

/// In place of a direction, apart from those of the far field's tilts.
const ANGLE_STREAM: usize = 1 << 20;
