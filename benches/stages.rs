//! Time of each stage on its own, and what a second of tracing tells. How to run it, and figures: `benches/README.md`.

use std::hint::black_box;
use std::process::Command;
use std::time::{Duration, Instant};

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use num_complex::Complex64;
use rayon::prelude::*;
use specval::geometry::{Sectors, Vec3};
use specval::optics::{Interference, Medium, MediumSpec, Mie};
use specval::rig::Geometry;
use specval::run::Plan;
use specval::spectrum::{Spectrum, WavelengthGrid};
use specval::study::Study;
use specval::transport::{Coefficients, Cylinder, Entry, Estimate, Interior, Purpose, Roulette, Stream, Walk};
use specval::yarn::DirectTracer;

/// Absorption coefficients at which the tracer is timed, 1/mm.
const MU_A_PER_MM: [f64; 3] = [0.0, 2.0, 20.0];
/// Paths of one call of the tracer.
const PATHS: usize = 20_000;
/// Azimuth bins of the exit histogram.
const BINS: usize = 36;

/// The medium of the reference yarn at all 35 wavelengths, or at 650 nm alone.
fn medium(wavelengths_nm: Vec<f64>, mu_a_per_mm: f64) -> Medium {
    let spec = MediumSpec {
        host_index: Spectrum::Constant(1.557),
        particle_index: Spectrum::Constant(1.61),
        particle_kappa: Spectrum::Constant(0.0),
        host_mu_a_per_mm: Spectrum::Constant(mu_a_per_mm),
        particle_diameter_nm: 150.0,
        volume_fraction: 0.14,
        interference: Interference::Independent,
    };
    let grid = WavelengthGrid::new(wavelengths_nm).expect("ascending");
    Medium::new(&spec, &grid).expect("a valid medium")
}

fn all_wavelengths() -> Vec<f64> {
    (0..35).map(|i| 390.0 + 10.0 * f64::from(i)).collect()
}

/// Azimuth histogram of scattered light from a parallel beam across a yarn of radius 0.125 mm, bin × wavelength, and
/// the particles met.
fn histogram(medium: &Medium, paths: usize, batch: usize) -> (Vec<f64>, u64) {
    let coefficients: Vec<Coefficients<'_>> = (0..medium.grid().len())
        .map(|w| Coefficients {
            mu_s: medium.mu_s_per_mm()[w],
            mu_a: medium.mu_a_per_mm()[w],
            phase: medium.phase(w),
        })
        .collect();
    let cylinder = Cylinder::new(0.125).expect("a radius");
    let interior = Interior::new(1.557, &coefficients).expect("a valid interior");
    let walk = Walk {
        shape: &cylinder,
        interior: &interior,
        roulette: Roulette::default(),
    };
    let sectors = Sectors::new(BINS).expect("a multiple of 4");
    let wavelengths = coefficients.len();
    let mut sums = vec![0.0; BINS * wavelengths];
    let traced = walk.trace(
        Stream::open(1, Purpose::Validation, 0, batch, 0),
        paths,
        |[across, ..]| {
            let h = 2.0 * across - 1.0;
            let normal = Vec3::new(h, 0.0, (1.0 - h * h).max(0.0).sqrt());
            Entry {
                position: normal * 0.125,
                normal,
                omega_in: Vec3::z(),
            }
        },
        |exit| {
            if exit.scattered {
                let bin = sectors.sector(-exit.direction.z, exit.direction.x);
                let row = &mut sums[bin * wavelengths..][..wavelengths];
                row.iter_mut()
                    .zip(exit.weights)
                    .for_each(|(sum, weight)| *sum += weight);
            }
        },
    );
    sums.iter_mut().for_each(|sum| *sum /= paths as f64);
    (sums, traced.scatterings)
}

fn mie(c: &mut Criterion) {
    let mut group = c.benchmark_group("mie");
    for x in [1.3, 1000.0] {
        group.bench_with_input(BenchmarkId::from_parameter(x), &x, |b, &x| {
            b.iter(|| Mie::sphere(black_box(Complex64::new(1.034, 0.0)), x).map(|mie| mie.efficiencies()));
        });
    }
    group.finish();
}

fn phase(c: &mut Criterion) {
    let medium = medium(vec![650.0], 0.0);
    let phase = medium.phase(0);
    let mut u = 0.0;
    c.bench_function("phase sampling", |b| {
        b.iter(|| {
            u = (u + 0.618_033_988_749_895) % 1.0;
            phase.sample(black_box(u))
        });
    });
}

fn tracer(c: &mut Criterion) {
    let mut group = c.benchmark_group("tracer, one core");
    group.sample_size(20);
    for mu_a in MU_A_PER_MM {
        let single = medium(vec![650.0], mu_a);
        group.throughput(Throughput::Elements(PATHS as u64));
        group.bench_function(BenchmarkId::new("one wavelength, paths", mu_a), |b| {
            b.iter(|| histogram(&single, PATHS, 0));
        });
        let shared = medium(all_wavelengths(), mu_a);
        group.throughput(Throughput::Elements(35 * PATHS as u64));
        group.bench_function(BenchmarkId::new("shared, wavelength-paths", mu_a), |b| {
            b.iter(|| histogram(&shared, PATHS, 0));
        });
    }
    group.finish();
}

/// Batches of the histogram on some threads: wall-clock time in seconds, and what came of them.
fn batches(medium: &Medium, count: usize, threads: usize) -> (f64, Vec<(Vec<f64>, u64)>) {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .expect("a pool of threads");
    let start = Instant::now();
    let batches = pool.install(|| {
        (0..count)
            .into_par_iter()
            .map(|batch| histogram(medium, PATHS, batch))
            .collect()
    });
    (start.elapsed().as_secs_f64(), batches)
}

/// Figure of merit 1/(r² t) on all cores, r being the relative error of the median bin (mirror images folded) at the
/// worst wavelength, and with it the time for r = 1 %; time per scattering; and what a second thread brings. The best
/// of several runs, which is the one that other programs disturbed least.
fn figure_of_merit(_: &mut Criterion) {
    const BATCHES: usize = 64;
    const RUNS: usize = 5;
    for (name, wavelengths) in [("35 wavelengths", all_wavelengths()), ("650 nm alone", vec![650.0])] {
        for mu_a in MU_A_PER_MM {
            let medium = medium(wavelengths.clone(), mu_a);
            let best = |threads: usize| {
                let runs = (0..RUNS).map(|_| batches(&medium, BATCHES, threads));
                runs.min_by(|a, b| a.0.total_cmp(&b.0)).expect("a run")
            };
            let (alone, _) = best(1);
            let threads = std::thread::available_parallelism().map_or(1, usize::from);
            let (seconds, batches) = best(threads);
            let scatterings: u64 = batches.iter().map(|(_, scatterings)| scatterings).sum();
            let worst = (0..wavelengths.len())
                .map(|w| median_error(batches.iter().map(|(sums, _)| sums.as_slice()), w, wavelengths.len()))
                .fold(0.0, f64::max);
            println!(
                "{name}, mu_a {mu_a}/mm, {threads} threads: {:.1} M wavelength-paths/s, {:.1} ns of one thread per \
                 scattering, {:.2} times one thread, 1/(r² t) = {:.3e}/s, 1 % at every wavelength in {:.3} s",
                1e-6 * (wavelengths.len() * BATCHES * PATHS) as f64 / seconds,
                1e9 * alone / scatterings as f64,
                alone / seconds,
                1.0 / (worst * worst * seconds),
                seconds * (worst / 0.01).powi(2),
            );
        }
    }
}

/// Relative standard error of the median azimuth bin of one wavelength, mirror images folded.
fn median_error<'a>(
    batches: impl ExactSizeIterator<Item = &'a [f64]> + Clone,
    wavelength: usize,
    wavelengths: usize,
) -> f64 {
    let mut errors: Vec<f64> = (0..BINS / 2)
        .map(|bin| {
            let at = |bin: usize| bin * wavelengths + wavelength;
            let folded = batches.clone().map(|sums| sums[at(bin)] + sums[at(BINS - 1 - bin)]);
            let Estimate { value, se } = Estimate::from_batches(folded);
            se / value
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    0.5 * (errors[BINS / 4 - 1] + errors[BINS / 4])
}

fn chain(c: &mut Criterion) {
    let plan = Plan::new(Study::default()).expect("the built-in study");
    let mut group = c.benchmark_group("chain");
    group.sample_size(10).measurement_time(Duration::from_secs(10));
    let tracer = DirectTracer::new(&plan.yarn, plan.factor_grid, plan.direct_effort, None).expect("a yarn");
    group.bench_function("f* table, one batch", |b| b.iter(|| tracer.batch(0)));
    let tables = [tracer.batch(0).response];
    let view = [Geometry {
        theta_i_deg: 30.0,
        theta_v_deg: 30.0,
    }];
    let beams = plan.beams(&view);
    group.bench_function("shading, one view and batch", |b| {
        b.iter(|| plan.direct().look(beams.lit(), 0).shade(&tables));
    });
    let folder = std::env::temp_dir().join(format!("specval-bench-{}", std::process::id()));
    group.bench_function("report --quick", |b| {
        b.iter(|| {
            let status = Command::new(env!("CARGO_BIN_EXE_specval"))
                .args(["report", "--quick", "--json", "--out"])
                .arg(&folder)
                .output()
                .expect("specval runs")
                .status;
            assert!(status.success());
        });
    });
    // Not there if a filter left the report out.
    let _ = std::fs::remove_dir_all(&folder);
    group.finish();
}

criterion_group!(stages, mie, phase, tracer, figure_of_merit, chain);
criterion_main!(stages);
