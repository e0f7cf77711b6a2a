//! One path for all wavelengths against a path for each: both have the same expectation, at the study's 35 wavelengths
//! with its dye, without absorption and with much of it, and both agree with the photon tracing of another program.
//!
//! Seeds are fixed; a stated false-alarm rate is that of new seeds. Wavelengths that share paths are almost one value,
//! so a χ² of them has far fewer degrees of freedom than terms: its distribution comes from random signs of whole
//! batches (`batch_statistics/mod.rs`), which keeps the correlation as it is.

use crate::batch_statistics::all_zero;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::Deserialize;
use specval::geometry::Vec3;
use specval::optics::{Interference, Medium, MediumSpec};
use specval::run::medium;
use specval::spectrum::{Samples, Spectrum, WavelengthGrid};
use specval::study::Study;
use specval::transport::{
    Coefficients, Cylinder, Entry, Estimate, Fraction, FractionList, Interior, Ledger, Purpose, Roulette, Stream, Walk,
};
use specval::yarn::{DirectTracer, Effort, EnergyTracer, Estimator, IncidentGrid, SurfaceGrid, Yarn, YarnResponseGrid};
use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};

const BATCHES: usize = 40;
const NETS: [Fraction; 2] = [Fraction::MisNet, Fraction::RouletteNet];
/// Absorption coefficients in place of the dye's, 1/mm.
const EVEN_ABSORPTION: [f64; 3] = [0.0, 2.0, 20.0];

/// A yarn of the default study.
fn yarn(medium: Medium, estimator: Estimator) -> Yarn {
    Yarn {
        cylinder: Cylinder::new(Study::default().yarn.radius_mm).unwrap(),
        medium,
        roulette: Roulette::default(),
        estimator,
    }
}

fn dyed() -> Medium {
    medium(&Study::default()).unwrap()
}

/// The same scattering with an absorption of its own at each wavelength.
fn absorbing(of: &Medium, mu_a_per_mm: impl Fn(f64) -> f64) -> Medium {
    Medium::from_coefficients(
        of.grid(),
        of.host_index().to_vec(),
        of.mu_s_per_mm().to_vec(),
        of.grid().nm().iter().map(|&nm| mu_a_per_mm(nm)).collect(),
        (0..of.grid().len()).map(|w| of.phase(w).clone()).collect(),
    )
    .unwrap()
}

/// Every medium of these tests by its name.
fn media() -> Vec<(String, Medium)> {
    let dyed = dyed();
    let mut media: Vec<(String, Medium)> = EVEN_ABSORPTION
        .iter()
        .map(|&mu_a| (format!("mu_a {mu_a} per mm"), absorbing(&dyed, |_| mu_a)))
        .collect();
    media.push(("preprint-red".into(), dyed));
    media
}

/// \[batch\]\[incident direction × wavelength\] of 6 directions between 15° and 75° from the normal.
fn ledgers(yarn: &Yarn, seed: u64, paths_per_batch: u64) -> Vec<Vec<Ledger>> {
    let incident = IncidentGrid::new(3, 8, true).unwrap();
    let effort = Effort::new(seed, BATCHES, paths_per_batch * BATCHES as u64).unwrap();
    let tracer = EnergyTracer::new(yarn, incident, effort, None).unwrap();
    (0..BATCHES).map(|batch| tracer.batch(batch).ledgers).collect()
}

/// \[batch\]\[2 tilts × 18 azimuths × wavelength\] of the light under a parallel beam, as fractions of it: f* summed
/// over the directions in which it leaves.
fn histograms(yarn: &Yarn, seed: u64, paths_per_batch: u64) -> Vec<Vec<f64>> {
    let grid = YarnResponseGrid::new(2, SurfaceGrid::new(36, 1, 4).unwrap()).unwrap();
    let effort = Effort::new(seed, BATCHES, paths_per_batch * BATCHES as u64).unwrap();
    let tracer = DirectTracer::new(yarn, grid, effort, None).unwrap();
    let wavelengths = yarn.medium.grid().len();
    let fractions = |batch: usize| {
        let response = tracer.batch(batch).response;
        let mut sums = vec![0.0; grid.tilts() * grid.azimuths() * wavelengths];
        for tilt in 0..grid.tilts() {
            for azimuth in 0..grid.azimuths() {
                let row = &mut sums[(tilt * grid.azimuths() + azimuth) * wavelengths..][..wavelengths];
                for exit in 0..grid.surface().exit().cells() {
                    let factor = grid.response_per_fraction(tilt, exit);
                    let cell = response.row(grid.cell(tilt, azimuth, exit));
                    row.iter_mut().zip(cell).for_each(|(sum, f)| *sum += f / factor);
                }
            }
        }
        sums
    };
    (0..BATCHES).map(fractions).collect()
}

/// Differences of the values whose relative error in batches `a` is below `known_to`.
fn differences(a: &[Vec<f64>], b: &[Vec<f64>], known_to: f64) -> Vec<Vec<f64>> {
    let known = |i: &usize| {
        let of = Estimate::from_batches(a.iter().map(|batch| batch[*i]));
        of.se <= known_to * of.value
    };
    let kept: Vec<usize> = (0..a[0].len()).filter(known).collect();
    let difference = |(a, b): (&Vec<f64>, &Vec<f64>)| kept.iter().map(|&i| a[i] - b[i]).collect();
    a.iter().zip(b).map(difference).collect()
}

/// |t| that one of `values` exceeds by chance in one of 1000 new seeds (Šidák).
fn limit(values: usize, batches: usize) -> f64 {
    let t = StudentsT::new(0.0, 1.0, (batches - 1) as f64).unwrap();
    t.inverse_cdf(1.0 - 0.5 * (1.0 - 0.999f64.powf(1.0 / values as f64)))
}

/// Compares both estimators for each medium, with `times` times the smallest number of paths: joint tests of scattered
/// and absorbed totals and of histograms, restricted to values with a relative error below 4 % in the shared run,
/// because batch means of bins that few paths reach are far from normal.
///
/// Ballistic light is exact except for the internally reflected part, which is so rare at short wavelengths that the
/// independent estimator has one such path or none: the tolerance of each value is its own error plus five paths.
fn agree(times: u64) {
    const KNOWN_TO: f64 = 0.04;
    for (name, medium) in media() {
        let shared = yarn(medium.clone(), Estimator::Shared);
        let independent = yarn(medium, Estimator::Independent);
        let (own_paths, beams) = (80 * times, 200 * times);
        let five_paths = 5.0 / (own_paths * BATCHES as u64) as f64;
        let a = ledgers(&shared, 31, 4 * own_paths);
        let b = ledgers(&independent, 32, own_paths);
        let of = |ledgers: &[Vec<Ledger>], each: fn(&Ledger) -> Vec<f64>| -> Vec<Vec<f64>> {
            ledgers
                .iter()
                .map(|batch| batch.iter().flat_map(each).collect())
                .collect()
        };
        let totals = |l: &Ledger| vec![l[Fraction::Scattered], l[Fraction::Absorbed]];
        let joint = all_zero(&differences(&of(&a, totals), &of(&b, totals), KNOWN_TO));
        println!("{name}, totals: {joint}");
        assert!(joint.values >= 35 * 6 && joint.holds(1e-3), "{name}, totals: {joint}");
        let ballistic = |l: &Ledger| vec![l[Fraction::Ballistic]];
        let ballistic = differences(&of(&a, ballistic), &of(&b, ballistic), f64::INFINITY);
        let values = ballistic[0].len();
        assert_eq!(values, 35 * 6);
        for i in 0..values {
            let of = Estimate::from_batches(ballistic.iter().map(|batch| batch[i]));
            let most = limit(values, BATCHES) * of.se + five_paths;
            assert!(of.value.abs() <= most, "{name}, ballistic {i}: {of:?}");
        }
        let a = histograms(&shared, 33, 4 * beams);
        let b = histograms(&independent, 34, beams);
        let joint = all_zero(&differences(&a, &b, KNOWN_TO));
        println!("{name}, f*: {joint}");
        assert!(joint.values > 100 && joint.holds(1e-3), "{name}, f*: {joint}");
    }
}

/// False alarms: 12 tests of 0.1 % each.
#[test]
fn shared_and_independent_paths_agree() {
    agree(1);
}

/// The same with 20 times the paths.
#[test]
#[ignore = "minutes"]
fn shared_and_independent_paths_agree_at_length() {
    agree(20);
}

/// The ledger of shared paths closes to rounding at every wavelength and direction. The net effects of the balance
/// heuristic and of Russian roulette are 0 in the mean; without absorption nothing is absorbed. False-alarm rate: 2
/// quantities × 4 media, each 0.1 % by the largest of 210 |t| and 0.1 % by the joint test.
#[test]
fn shared_ledgers_close_and_sampling_nets_have_zero_mean() {
    for (name, medium) in media() {
        let white = medium.mu_a_per_mm().iter().all(|mu_a| *mu_a == 0.0);
        let batches = ledgers(&yarn(medium, Estimator::Shared), 35, 1000);
        let entries = batches[0].len();
        assert_eq!(entries, 35 * 6);
        let limit = limit(entries, BATCHES);
        let mut worst = [0.0f64; 2];
        for i in 0..entries {
            let of_entry: Vec<Ledger> = batches.iter().map(|batch| batch[i]).collect();
            let [mean, se] = Ledger::mean_and_se(&of_entry);
            assert_eq!(mean[Fraction::Absorbed] == 0.0, white, "{name}: {mean:?}");
            assert!(mean.residual().abs() <= 1e-12, "{name}: {mean:?}");
            for (k, net) in NETS.into_iter().enumerate() {
                let (value, se) = (mean[net], se[net]);
                worst[k] = worst[k].max((value / se).abs());
                assert!(
                    value.abs() <= limit * se,
                    "{name}, entry {i}: {value} ± {se} of {mean:?}"
                );
            }
        }
        for (k, net) in NETS.into_iter().enumerate() {
            let quantity = net.name();
            let of = |l: &Ledger| l[net];
            let joint = all_zero(&batches.iter().map(|b| b.iter().map(of).collect()).collect::<Vec<_>>());
            println!(
                "{name}, {quantity}: |t| at most {:.2}, limit {limit:.2}; {joint}",
                worst[k]
            );
            assert!(joint.holds(1e-3), "{name}, {quantity}: {joint}");
        }
    }
}

#[derive(Deserialize)]
struct Row {
    lambda_nm: f64,
    mu_a_per_mm: f64,
    psi_deg: f64,
    kind: String,
    component: String,
    fraction: f64,
    se: f64,
}

/// Yarns of the photon tracer at one tilt, out of one run of all 35 wavelengths: where the reference has a wavelength
/// the medium has the reference's absorption, elsewhere one of its own, and all share the paths.
fn against_photon_tracer(psi_deg: f64, paths_per_batch: usize) -> Vec<(String, f64)> {
    const BATCHES: usize = 100;
    /// Ballistic, scattered, absorbed; 36 bins of the azimuth and 18 of the angle to the axis of scattered light.
    const VALUES: usize = 3 + 36 + 18;
    /// Last digit of the reference's fractions.
    const PRINTED_TO: f64 = 1e-8;
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_reader(include_str!("../data/yarn/yarn_mitsuba.csv").as_bytes());
    let rows: Vec<Row> = reader.deserialize().map(Result::unwrap).collect();
    let rows: Vec<Row> = rows.into_iter().filter(|row| row.psi_deg == psi_deg).collect();
    let clear = MediumSpec {
        host_index: Spectrum::Constant(1.557),
        particle_index: Spectrum::Constant(1.61),
        particle_kappa: Spectrum::Constant(0.0),
        host_mu_a_per_mm: Spectrum::Constant(0.0),
        particle_diameter_nm: 150.0,
        volume_fraction: 0.14,
        interference: Interference::Independent,
    };
    let clear = Medium::new(&clear, &WavelengthGrid::preprint()).unwrap();
    let medium = absorbing(&clear, |nm| {
        let known = rows.iter().find(|row| row.lambda_nm == nm);
        known.map_or(1.0, |row| row.mu_a_per_mm)
    });
    let nm = medium.grid().nm();
    let coefficients: Vec<Coefficients<'_>> = (0..nm.len())
        .map(|w| Coefficients {
            mu_s: medium.mu_s_per_mm()[w],
            mu_a: medium.mu_a_per_mm()[w],
            phase: medium.phase(w),
        })
        .collect();
    let cylinder = Cylinder::new(0.125).unwrap();
    let walk = Walk {
        shape: &cylinder,
        interior: &Interior::new(1.557, &coefficients).unwrap(),
        roulette: Roulette::default(),
    };
    let psi = psi_deg.to_radians();
    // \[batch\]\[wavelength\]\[value\].
    let batches: Vec<Vec<[f64; VALUES]>> = (0..BATCHES)
        .map(|batch| {
            let mut sums = vec![[0.0; VALUES]; nm.len()];
            let traced = walk.trace(
                Stream::open(36, Purpose::Validation, psi_deg as usize, batch, 0),
                paths_per_batch,
                |[across, ..]| {
                    let position = cylinder.at((2.0 * across - 1.0).asin());
                    Entry {
                        position,
                        normal: cylinder.frame(&position).normal,
                        omega_in: Vec3::new(0.0, -psi.sin(), psi.cos()),
                    }
                },
                |exit| {
                    if exit.scattered {
                        let d = exit.direction;
                        // 0 is forward, 180° backward.
                        let azimuth_deg = d.x.atan2(-d.z).to_degrees().rem_euclid(360.0);
                        let to_axis_deg = d.y.clamp(-1.0, 1.0).acos().to_degrees();
                        let azimuth = 3 + ((azimuth_deg / 10.0) as usize).min(35);
                        let to_axis = 39 + ((to_axis_deg / 10.0) as usize).min(17);
                        for (sums, weight) in sums.iter_mut().zip(exit.weights) {
                            sums[azimuth] += weight;
                            sums[to_axis] += weight;
                        }
                    }
                },
            );
            for (sums, ledger) in sums.iter_mut().zip(traced.ledgers) {
                [sums[0], sums[1], sums[2]] = [
                    ledger[Fraction::Ballistic],
                    ledger[Fraction::Scattered],
                    ledger[Fraction::Absorbed],
                ];
                sums.iter_mut().for_each(|sum| *sum /= paths_per_batch as f64);
            }
            sums
        })
        .collect();
    let mut found = Vec::new();
    for (w, nm) in nm.iter().enumerate() {
        let mut joint = |place: usize, kind: &str, component: &str| {
            let rows = rows
                .iter()
                .filter(|row| row.lambda_nm == *nm && row.kind == kind && row.component == component);
            let (mut chi2, mut bins) = (0.0, 0.0);
            for (k, row) in rows.enumerate() {
                let own = Estimate::from_batches(batches.iter().map(|batch| batch[w][place + k]));
                if own.se == 0.0 && row.se == 0.0 {
                    assert_eq!(own.value, row.fraction);
                    continue;
                }
                let variance = own.se.powi(2) + row.se.powi(2) + PRINTED_TO.powi(2);
                chi2 += (own.value - row.fraction).powi(2) / variance;
                bins += 1.0;
            }
            if bins > 0.0 {
                let p = ChiSquared::new(bins).unwrap().sf(chi2);
                found.push((
                    format!("{nm} nm, tilt {psi_deg}°, {component} {kind}: χ² {chi2:.1} of {bins}"),
                    p,
                ));
            }
        };
        joint(0, "total", "unscattered");
        joint(1, "total", "scattered");
        joint(2, "total", "absorbed");
        joint(3, "azimuth", "scattered");
        joint(39, "theta", "scattered");
    }
    found
}

/// 450, 550 and 650 nm, absorption 0, 2 and 20 per mm, tilts 0 and 45°. False alarms: 0.1 % of 23 totals and histograms
/// together (Šidák, as if independent: fewer alarms if not).
#[test]
fn shared_paths_agree_with_the_photon_tracer() {
    let mut found = against_photon_tracer(0.0, 3000);
    found.extend(against_photon_tracer(45.0, 3000));
    // Two of the five yarns do not absorb.
    assert_eq!(found.len(), 5 * 5 - 2);
    let limit = 1.0 - 0.999f64.powf(1.0 / found.len() as f64);
    for (what, p) in found {
        println!("{what}, p {p:.4}");
        assert!(p > limit, "{what}, p {p:e}");
    }
}

/// In a dispersive host the independent estimator is used whatever was requested, with the same bits, and its ledger
/// closes to rounding.
#[test]
fn dispersive_host_uses_independent_paths() {
    let grid = WavelengthGrid::new(vec![450.0, 550.0, 650.0]).unwrap();
    let of = |host_index: Vec<f64>| {
        let spec = MediumSpec {
            host_index: Spectrum::Table {
                name: "host".into(),
                samples: Samples::new("host", &grid, host_index).unwrap(),
            },
            particle_index: Spectrum::Constant(1.61),
            particle_kappa: Spectrum::Constant(0.001),
            host_mu_a_per_mm: Spectrum::Constant(0.0),
            particle_diameter_nm: 150.0,
            volume_fraction: 0.14,
            interference: Interference::Independent,
        };
        Medium::new(&spec, &grid).unwrap()
    };
    let shared = yarn(of(vec![1.557; 3]), Estimator::Shared);
    assert_eq!(shared.estimator_in_use(), Estimator::Shared);
    let dispersive = of(vec![1.566, 1.557, 1.552]);
    let [shared, independent] = [Estimator::Shared, Estimator::Independent].map(|estimator| {
        let yarn = yarn(dispersive.clone(), estimator);
        assert_eq!(yarn.estimator_in_use(), Estimator::Independent);
        ledgers(&yarn, 37, 50)
    });
    assert!(shared == independent);
    for ledger in shared.iter().flatten() {
        assert!(ledger.residual().abs() <= 1e-12, "{ledger:?}");
    }
}

/// With one wavelength both estimators give the same bits.
#[test]
fn both_estimators_give_the_same_bits_for_one_wavelength() {
    let mut study = Study::default();
    study.spectrum.wavelengths_nm = Some(vec![600.0]);
    let medium = medium(&study).unwrap();
    let [shared, independent] = [Estimator::Shared, Estimator::Independent].map(|estimator| {
        let yarn = yarn(medium.clone(), estimator);
        (ledgers(&yarn, 38, 50), histograms(&yarn, 38, 200))
    });
    assert!(shared == independent);
}

/// The joint test itself, on 200 sets of 40 batches of 35 values that are one value to 1 %, as wavelengths that share
/// paths are: it raises an alarm at the rate it is asked to (5 %: 10 ± 3 sets), and hardly ever misses a mean that is 5
/// standard errors off.
#[test]
fn joint_test_has_its_nominal_false_alarm_rate() {
    let mut alarms = [0; 2];
    for set in 0..200 {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(set);
        // Variance 1/12 · 12 = 1.
        let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
        let batches: Vec<Vec<f64>> = (0..40)
            .map(|_| {
                let common = normal();
                (0..35).map(|_| common + 0.01 * normal()).collect()
            })
            .collect();
        let shift = 5.0 / 40f64.sqrt();
        let shifted: Vec<Vec<f64>> = batches.iter().map(|b| b.iter().map(|x| x + shift).collect()).collect();
        alarms[0] += usize::from(!all_zero(&batches).holds(0.05));
        alarms[1] += usize::from(!all_zero(&shifted).holds(0.05));
    }
    println!("{alarms:?}");
    assert!((1..=19).contains(&alarms[0]) && alarms[1] >= 195, "{alarms:?}");
}
