//! Reference problems: results of the optics and the transport kernel for cases with independently known answers.
//!
//! | problems | reference | exact to |
//! | --- | --- | --- |
//! | slabs with Henyey–Greenstein scattering, collimated and Lambertian light | discrete ordinates | 1e-10 |
//! | cylinders without scattering, in a tilted parallel beam | closed forms | 1e-12 |
//! | scattering yarns in a parallel beam | Mitsuba 3 photon tracing, 4·10⁷ photons each | its standard errors |
//! | spheres (Mie series) | 60-digit arithmetic | 1e-14 |
//!
//! All but the spheres run through the same [`Walk`](crate::transport::Walk) as the yarn of a study. Everything is a
//! fraction of the incident flux except efficiencies, asymmetry parameters and chords (in radii).

mod check;
mod cylinder;
mod reference;
mod slab;
mod sphere;
mod statistics;
mod yarn;

use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use crate::transport::{Estimate, Purpose, Stream};
use check::BATCHES;
pub use check::{Check, MIN_PATHS, ValidateError};
use cylinder::CylinderProblem;
use slab::SlabProblem;
use statistics::estimates;
use yarn::YarnProblem;

/// A problem solved by Monte Carlo.
enum Problem {
    Slab(SlabProblem),
    Cylinder(CylinderProblem),
    Yarn(Box<YarnProblem>),
}

impl Problem {
    fn name(&self) -> String {
        match self {
            Self::Slab(p) => p.name(),
            Self::Cylinder(p) => p.name(),
            Self::Yarn(p) => p.name(),
        }
    }

    /// Means over the paths of one batch, in the order of the problem.
    fn batch(&self, paths: u64, stream: Xoshiro256PlusPlus) -> Result<Vec<f64>, ValidateError> {
        match self {
            Self::Slab(p) => p.batch(paths, stream),
            Self::Cylinder(p) => p.batch(paths, stream),
            Self::Yarn(p) => p.batch(paths, stream),
        }
    }

    fn checks(&self, estimates: &[Estimate]) -> Vec<Check> {
        match self {
            Self::Slab(p) => p.checks(estimates),
            Self::Cylinder(p) => p.checks(estimates),
            Self::Yarn(p) => p.checks(estimates),
        }
    }
}

/// Solves every reference problem with `paths` paths each.
///
/// # Errors
/// [`ValidateError`] if `paths` is below [`MIN_PATHS`].
pub fn run(paths: u64, seed: u64) -> Result<Vec<Check>, ValidateError> {
    run_each(|_| paths, seed)
}

/// The same with a number of paths for each problem, by its name as in [`Check::problem`]; 0 skips the problem. The
/// result of a problem depends neither on the other problems nor on the number of threads.
///
/// # Errors
/// [`ValidateError`] for a number of paths above 0 and below [`MIN_PATHS`].
pub fn run_each(paths: impl Fn(&str) -> u64, seed: u64) -> Result<Vec<Check>, ValidateError> {
    let mut problems = Vec::new();
    problems.extend(slab::problems()?.into_iter().map(Problem::Slab));
    problems.extend(cylinder::problems()?.into_iter().map(Problem::Cylinder));
    problems.extend(yarn::problems()?.into_iter().map(|p| Problem::Yarn(Box::new(p))));
    let mut tasks = Vec::new();
    for (index, problem) in problems.iter().enumerate() {
        let found = paths(&problem.name());
        if found == 0 {
            continue;
        }
        if found < MIN_PATHS {
            return Err(ValidateError::TooFewPaths { found });
        }
        tasks.extend((0..BATCHES).map(|batch| (index, batch, found.div_ceil(BATCHES as u64))));
    }
    let means: Vec<Vec<f64>> = tasks
        .par_iter()
        .map(|&(index, batch, paths)| {
            let stream = Stream::open(seed, Purpose::Validation, index, batch, 0);
            problems[index].batch(paths, stream)
        })
        .collect::<Result<_, _>>()?;
    let mut checks = Vec::new();
    for (batches, tasks) in means.chunks(BATCHES).zip(tasks.chunks(BATCHES)) {
        checks.extend(problems[tasks[0].0].checks(&estimates(batches)));
    }
    for problem in sphere::problems()? {
        if paths(&problem.name()) > 0 {
            checks.extend(problem.checks()?);
        }
    }
    Ok(checks)
}
