//! How much work a batch is, from the study alone: a run that is to end in time takes batches small enough for it, the
//! same ones whenever it is repeated.

use super::memory::Stage;
use super::{Plan, RunError};
use crate::number::{shown, time_in_words, to_two_digits};
use crate::report::{LongPaths, Notice};
use crate::study::{MethodChoice, ShadeWith, Study, StudyError};
use crate::yarn::{Estimator, Yarn};
use std::time::Duration;

/// Seconds of a path of shared wavelengths and of one of a single wavelength, of a particle met on them, of a particle
/// that goes from yarn to yarn by f* and through media, and of a camera ray: on one core of 2020, 35 wavelengths.
const SHARED_PATH: f64 = 0.4e-6;
const SHARED_SCATTERING: f64 = 1e-7;
const SINGLE_PATH: f64 = 0.2e-6;
const SINGLE_SCATTERING: f64 = 0.7e-7;
const BY_FACTOR: f64 = 30e-6;
const THROUGH_MEDIA: f64 = 6e-6;
const CAMERA_RAY: f64 = 2e-6;
const WAVELENGTHS: f64 = 35.0;

/// A batch takes at most this part of the time allowed, by the estimate: two are made in any case, and the estimate may
/// be short.
const SHARE_OF_TIME: f64 = 0.125;
/// Paths a tilt of a batch below which it is not made smaller, and most batches of a study.
const LEAST_PATHS: u64 = 16;
const MOST_BATCHES: u32 = 100_000;

/// Scattering events per path, and seconds of a run on one core, above which the user gets a notice.
const MANY_SCATTERINGS: f64 = 1000.0;
const LONG: f64 = 60.0;
/// Seconds of a run on one core beyond which it is not begun: a hundred years.
const ENDLESS: f64 = 3.2e9;

/// A key that makes a run longer, and how to count with the value that it has by default, where that is less.
struct Load {
    key: &'static str,
    value: fn(&Study) -> u64,
    reduce: fn(&mut Study, &Study),
}

macro_rules! load {
    ($section:ident . $key:ident) => {
        Load {
            key: concat!(stringify!($section), ".", stringify!($key)),
            value: |study| u64::from(study.$section.$key),
            reduce: |study, default| study.$section.$key = study.$section.$key.min(default.$section.$key),
        }
    };
}

const LOADS: [Load; 8] = [
    load!(trace.paths_direct),
    load!(trace.paths_bssrdf),
    load!(trace.particles),
    load!(trace.particles_volumetric),
    load!(trace.tilts),
    load!(trace.zenith_cells),
    load!(trace.azimuth_cells),
    load!(rig.pixels_per_side),
];

impl Plan {
    /// Particles that a path meets in a yarn, in the mean and about. Of light that comes from everywhere and is not
    /// absorbed the mean way through a body is 4 n² times its volume over its surface, whatever scatters in it (Blanco
    /// and Fournier 2003), 2 n² R in a cylinder; absorption shortens it. A path of shared wavelengths lasts as long as
    /// that of the least absorbed.
    pub fn scatterings_per_path(&self) -> f64 {
        self.different_yarns().map(scatterings).fold(0.0, f64::max)
    }

    /// How long a run that takes long will be, and what makes it so: of a study alone, on one core.
    ///
    /// # Errors
    /// A run that would not end in a hundred years, by the key that makes it so long.
    pub fn work_notice(&self, stage: Stage) -> Result<Option<Notice>, StudyError> {
        let particles = self.scatterings_per_path();
        let seconds = self.seconds(&self.study, stage);
        if seconds <= LONG && particles <= MANY_SCATTERINGS {
            return Ok(None);
        }
        let default = Study::default();
        let with_default = |load: &&Load| {
            let mut study = self.study.clone();
            (load.reduce)(&mut study, &default);
            self.seconds(&study, stage)
        };
        // The key that lengthens the run most, if it lengthens it more than all of the others together.
        let longest = LOADS.iter().min_by(|a, b| with_default(a).total_cmp(&with_default(b)));
        let longest = longest.filter(|load| with_default(load) < 0.5 * seconds);
        if seconds > ENDLESS {
            let (key, found, remedy) = match longest {
                Some(load) => (
                    load.key.to_owned(),
                    (load.value)(&self.study).to_string(),
                    "reduce it".to_owned(),
                ),
                None => (
                    "medium.volume_fraction".into(),
                    shown(self.study.medium.volume_fraction),
                    self.paths_of(particles).to_string(),
                ),
            };
            return Err(StudyError::Value {
                place: self.study.origin.place(&key),
                key,
                expected: "a study that is traced within a hundred years".into(),
                found: format!(
                    "{found}, with which by an estimate it takes {} on one core",
                    time_in_words(seconds)
                ),
                remedy,
            });
        }
        let is_long = seconds > LONG;
        Ok(Some(Notice::LongRun {
            seconds: is_long.then_some(seconds),
            paths: (particles > MANY_SCATTERINGS).then(|| self.paths_of(particles)),
            longest: longest
                .filter(|_| is_long)
                .map(|load| (load.key.to_owned(), (load.value)(&self.study))),
        }))
    }

    /// That the medium makes paths long.
    pub fn long_paths(&self) -> Option<Notice> {
        let particles = self.scatterings_per_path();
        (particles > MANY_SCATTERINGS).then(|| Notice::LongPaths {
            paths: self.paths_of(particles),
        })
    }

    /// What makes paths long that meet so many particles.
    fn paths_of(&self, particles: f64) -> LongPaths {
        let medium = |yarn: &Yarn| {
            let strongest = yarn.medium.mu_s_per_mm().iter().copied().fold(0.0, f64::max);
            let index = yarn.medium.host_index().iter().copied().fold(0.0, f64::max);
            (strongest, index)
        };
        let media = self.different_yarns().map(medium);
        let (strongest, host_index) = media.fold((0.0f64, 0.0f64), |a, b| (a.0.max(b.0), a.1.max(b.1)));
        LongPaths {
            particles: to_two_digits(particles),
            mu_s_per_mm: to_two_digits(strongest),
            host_index,
        }
    }

    /// Estimate of a run on one core, of this plan's media with the counts of a study.
    fn seconds(&self, study: &Study, stage: Stage) -> f64 {
        let (paths, fixed) = self.batch_seconds(study, stage);
        f64::from(study.trace.batches) * (paths + fixed)
    }

    /// This plan with batches small enough that `limit` can be kept: a power of two times as many, each of so much
    /// fewer paths; and how many times as many. It depends on the study and the limit alone.
    ///
    /// # Errors
    /// None for a study that a plan was made of.
    pub fn split_for(self, limit: Duration, stage: Stage) -> Result<(Self, u32), RunError> {
        let allowed = SHARE_OF_TIME * limit.as_secs_f64();
        let (paths, fixed) = self.batch_seconds(&self.study, stage);
        let trace = &self.study.trace;
        let possible = |parts: u32| {
            let batches = trace.batches.saturating_mul(parts);
            batches <= MOST_BATCHES && trace.paths_direct / u64::from(batches) >= LEAST_PATHS
        };
        let mut parts = 1;
        while paths / f64::from(parts) + fixed > allowed && possible(2 * parts) {
            parts *= 2;
        }
        if parts == 1 {
            return Ok((self, 1));
        }
        let mut study = self.study;
        study.trace.batches *= parts;
        // Each batch has one at least.
        let batches = u64::from(study.trace.batches);
        let trace = &mut study.trace;
        for paths in [
            &mut trace.paths_bssrdf,
            &mut trace.particles,
            &mut trace.particles_volumetric,
        ] {
            *paths = (*paths).max(batches);
        }
        Ok((Self::with_sample(study, self.chosen)?, parts))
    }

    /// Seconds of one batch on one core: those in proportion to its paths, and the others.
    fn batch_seconds(&self, study: &Study, stage: Stage) -> (f64, f64) {
        let trace = &study.trace;
        let of_batch = |paths: u64| paths as f64 / f64::from(trace.batches);
        let wavelengths = self.grid.len() as f64;
        let many = (wavelengths / WAVELENGTHS).max(0.2);
        let path = |yarn: &Yarn| match yarn.estimator_in_use() {
            Estimator::Shared => many * (SHARED_PATH + SHARED_SCATTERING * scatterings(yarn)),
            Estimator::Independent => wavelengths * (SINGLE_PATH + SINGLE_SCATTERING * scatterings(yarn)),
        };
        let paths: f64 = self.different_yarns().map(path).sum();
        let direct = of_batch(trace.paths_direct) * f64::from(trace.tilts) * paths;
        let fold = if trace.fold_symmetry { 4 } else { 1 };
        let directions = trace.zenith_cells * trace.azimuth_cells / fold;
        let patch = of_batch(trace.paths_bssrdf) * f64::from(directions) * path(&self.yarn);
        let incidences = study.rig.incidences_deg.len() as f64;
        let pixels = f64::from(study.rig.pixels_per_side).powi(2);
        let camera = pixels * study.rig.views_deg().len() as f64 * CAMERA_RAY;
        match (stage, study.cloth.method, trace.shade_with) {
            (Stage::Yarn | Stage::Check | Stage::Full { .. }, ..) => (direct + 2.0 * patch, 0.0),
            (_, MethodChoice::Volumetric, _) => {
                let particles = of_batch(trace.particles_volumetric) * incidences;
                (patch + particles * (many * THROUGH_MEDIA + paths), 0.0)
            }
            (_, MethodChoice::RadianceFactor, shade_with) => {
                let tables = match shade_with {
                    ShadeWith::Direct => direct,
                    ShadeWith::Bssrdf => patch,
                };
                let between = of_batch(trace.particles) * incidences * many * BY_FACTOR;
                (patch + tables + between, camera)
            }
        }
    }
}

fn scatterings(yarn: &Yarn) -> f64 {
    let medium = &yarn.medium;
    let way_mm = |w: usize| {
        let n = medium.host_index()[w];
        1.0 / (medium.mu_a_per_mm()[w] + 1.0 / (2.0 * n * n * yarn.cylinder.radius_mm()))
    };
    let wavelengths = medium.mu_s_per_mm().len();
    let mean = |of: &dyn Fn(usize) -> f64| (0..wavelengths).map(of).sum::<f64>() / wavelengths as f64;
    match yarn.estimator_in_use() {
        Estimator::Shared => {
            let longest = (0..wavelengths).map(way_mm).fold(0.0, f64::max);
            longest * mean(&|w| medium.mu_s_per_mm()[w])
        }
        Estimator::Independent => mean(&|w| way_mm(w) * medium.mu_s_per_mm()[w]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::Side;
    use crate::sample::Chosen;

    #[test]
    fn smaller_batches_keep_the_component_that_was_chosen() {
        let chosen = Chosen {
            side: Some(Side::Front),
            ..Chosen::default()
        };
        let plan = Plan::with_sample(Study::default(), chosen).unwrap();
        let (split, parts) = plan.split_for(Duration::from_millis(1), Stage::Views).unwrap();
        assert!(parts > 1 && split.chosen == chosen, "{parts} {:?}", split.chosen);
    }
}
