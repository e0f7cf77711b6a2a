//! Laws of the kernel: every path's energy is accounted for, whatever the body, the angle and the absorption. One
//! wavelength: its ledger closes path by path. (Paths that wavelengths share close in the mean: `estimators.rs`.)

use std::f64::consts::{FRAC_PI_2, TAU};

use specval::geometry::Vec3;
use specval::optics::{HenyeyGreenstein, Phase};
use specval::transport::{
    Coefficients, Cylinder, Entry, Fraction, Interior, Ledger, Purpose, Roulette, Shape, Slab, Stream, Traced, Walk,
};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Rounding of a path's ledger: some hundred terms at most, each below 1.
const ROUNDING: f64 = 1e-12;
const DIRECTIONS: usize = 24;
const BATCHES: usize = 50;
const PATHS: usize = 20;

fn phase() -> Phase {
    Phase::HenyeyGreenstein(HenyeyGreenstein::new(0.3).unwrap())
}

fn interior(phase: &Phase, mu_s: f64, mu_a: f64) -> Interior<'_> {
    Interior::new(1.557, &[Coefficients { mu_s, mu_a, phase }]).unwrap()
}

/// Light at `position` on the top of a body, where the normal is z.
fn entry(position: Vec3, omega_in: Vec3) -> Entry {
    Entry {
        position,
        normal: Vec3::z(),
        omega_in,
    }
}

/// Ledgers of single paths from the directions of a grid over the hemisphere: \[direction\]\[batch\]\[path\].
fn single_paths<S: Shape>(walk: &Walk<'_, S>, position: Vec3, batches: usize) -> Vec<Vec<Vec<Ledger>>> {
    let trace = |direction: usize, batch: usize| -> Vec<Ledger> {
        let zenith = ((direction % 6) as f64 + 0.5) / 6.0 * FRAC_PI_2;
        let azimuth = (direction / 6) as f64 / 4.0 * TAU + 0.1;
        let omega_in = Vec3::new(zenith.sin() * azimuth.cos(), zenith.sin() * azimuth.sin(), zenith.cos());
        (0..PATHS)
            .map(|path| {
                let stream = Stream::open(3, Purpose::Validation, direction, batch, path);
                let mut exits = Ledger::default();
                let Traced { ledgers, .. } = walk.trace(
                    stream,
                    1,
                    |_| entry(position, omega_in),
                    |exit| {
                        let [weight] = exit.weights[..] else {
                            panic!("one wavelength, {} weights", exit.weights.len())
                        };
                        assert!((exit.direction.norm() - 1.0).abs() < ROUNDING);
                        assert!((exit.normal.norm() - 1.0).abs() < ROUNDING);
                        assert!(exit.direction.dot(&exit.normal) >= 0.0 && weight >= 0.0);
                        if exit.scattered {
                            exits[Fraction::Scattered] += weight;
                        } else {
                            exits[Fraction::Ballistic] += weight;
                        }
                    },
                );
                let [ledger] = ledgers[..] else {
                    panic!("one wavelength, {} ledgers", ledgers.len())
                };
                assert!((exits[Fraction::Scattered] - ledger[Fraction::Scattered]).abs() < ROUNDING);
                assert!((exits[Fraction::Ballistic] - ledger[Fraction::Ballistic]).abs() < ROUNDING);
                ledger
            })
            .collect()
    };
    (0..DIRECTIONS)
        .map(|direction| (0..batches).map(|batch| trace(direction, batch)).collect())
        .collect()
}

/// Roulette's net: 48 directions and bodies, Student's t with 49 degrees of freedom, false alarms 0.1 %.
#[test]
fn white_furnace() {
    let phase = phase();
    let interior = &interior(&phase, 6.0, 0.0);
    let roulette = Roulette::default();
    let cylinder = &Cylinder::new(0.15).unwrap();
    let slab = &Slab::new(0.3).unwrap();
    let mut ledgers = single_paths(
        &Walk {
            shape: cylinder,
            interior,
            roulette,
        },
        cylinder.at(0.0),
        BATCHES,
    );
    ledgers.extend(single_paths(
        &Walk {
            shape: slab,
            interior,
            roulette,
        },
        Vec3::zeros(),
        BATCHES,
    ));
    let entries = ledgers.len();
    let limit = StudentsT::new(0.0, 1.0, (BATCHES - 1) as f64)
        .unwrap()
        .inverse_cdf(1.0 - 0.5 * (1.0 - 0.999f64.powf(1.0 / entries as f64)));
    assert_eq!(entries, 48);
    for direction in ledgers {
        let mut batches = Vec::new();
        for paths in direction {
            let mut sum = Ledger::default();
            for ledger in paths {
                let total = ledger[Fraction::Reflected]
                    + ledger[Fraction::Ballistic]
                    + ledger[Fraction::Scattered]
                    + ledger[Fraction::RouletteNet];
                assert!(
                    (total - 1.0).abs() <= ROUNDING && ledger[Fraction::Absorbed] == 0.0,
                    "{ledger:?}"
                );
                sum.add(&ledger);
            }
            batches.push(sum.scaled(1.0 / PATHS as f64));
        }
        let [mean, se] = Ledger::mean_and_se(&batches);
        assert!(mean.residual().abs() <= ROUNDING, "{mean:?}");
        assert!(
            mean[Fraction::RouletteNet].abs() <= limit * se[Fraction::RouletteNet] && se[Fraction::RouletteNet] > 0.0,
            "roulette {} ± {}",
            mean[Fraction::RouletteNet],
            se[Fraction::RouletteNet]
        );
    }
}

#[test]
fn absorbing_ledgers_close() {
    let phase = phase();
    let shape = &Cylinder::new(0.15).unwrap();
    for mu_a in [1e-6, 0.1, 2.0, 30.0, 1e4] {
        let walk = Walk {
            shape,
            interior: &interior(&phase, 6.0, mu_a),
            roulette: Roulette::default(),
        };
        let mut absorbed = 0.0;
        for ledger in single_paths(&walk, shape.at(0.0), 5).into_iter().flatten().flatten() {
            assert!(ledger.residual().abs() <= ROUNDING, "{ledger:?}");
            absorbed += ledger[Fraction::Absorbed];
        }
        assert!(absorbed > 0.0);
    }
}

/// Almost no light enters at grazing incidence, and it then meets the surface from inside at an angle at which it
/// hardly leaves. Its path must end, without loss of energy.
#[test]
fn grazing_paths_terminate_and_close_the_ledger() {
    let phase = phase();
    let cylinder = Cylinder::new(0.15).unwrap();
    for (k, cosine) in [1e-3, 1e-6, 1e-8, 1e-12, 6.1e-17, 0.0].into_iter().enumerate() {
        for (mu_s, mu_a) in [(0.0, 0.0), (0.0, 2.0), (6.0, 0.0), (6.0, 2.0)] {
            let walk = Walk {
                shape: &cylinder,
                interior: &interior(&phase, mu_s, mu_a),
                roulette: Roulette::default(),
            };
            for path in 0..5 {
                let stream = Stream::open(5, Purpose::Validation, k, path, 0);
                let Traced { ledgers, .. } = walk.trace(
                    stream,
                    1,
                    |[azimuth, ..]| {
                        let azimuth = TAU * azimuth;
                        let omega_in = Vec3::new(azimuth.cos(), azimuth.sin(), cosine).normalize();
                        entry(cylinder.at(0.0), omega_in)
                    },
                    |_| {},
                );
                let [ledger] = ledgers[..] else {
                    panic!("one wavelength, {} ledgers", ledgers.len())
                };
                assert!(ledger.residual().abs() <= ROUNDING, "cos {cosine}: {ledger:?}");
                assert!(
                    ledger[Fraction::Reflected] >= 1.0 - 10.0 * cosine,
                    "cos {cosine}: {ledger:?}"
                );
            }
        }
    }
}

/// The ledger of many paths is the sum of their ledgers, closed to the rounding of the sums.
#[test]
fn ledgers_of_many_paths_close_as_for_one() {
    let phase = phase();
    let shape = &Cylinder::new(0.15).unwrap();
    for (mu_s, mu_a) in [(6.0, 0.0), (6.0, 2.0), (60.0, 0.01), (0.0, 1.0)] {
        let walk = Walk {
            shape,
            interior: &interior(&phase, mu_s, mu_a),
            roulette: Roulette::default(),
        };
        for paths in [1, 15, 16, 17, 1000] {
            let mut exits = 0.0;
            let Traced { ledgers, .. } = walk.trace(
                Stream::open(6, Purpose::Validation, paths, 0, 0),
                paths,
                |_| entry(shape.at(0.0), Vec3::z()),
                |exit| exits += exit.weights[0],
            );
            let mean = ledgers[0].scaled(1.0 / paths as f64);
            assert!(mean.residual().abs() <= ROUNDING, "{paths}: {mean:?}");
            let left = mean[Fraction::Ballistic] + mean[Fraction::Scattered];
            assert!((exits / paths as f64 - left).abs() <= ROUNDING, "{paths}: {mean:?}");
        }
    }
}
