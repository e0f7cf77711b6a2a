//! Laws of the kernel: every path's energy is accounted for, whatever the body, the angle and the absorption.

use std::f64::consts::{FRAC_PI_2, TAU};

use rand::RngExt;
use specval::geometry::Vec3;
use specval::optics::{HenyeyGreenstein, Phase};
use specval::transport::{Cylinder, Interior, Ledger, LedgerEntry, Purpose, Roulette, Shape, Slab, Stream, Walk};

/// Rounding of a ledger: some hundred terms at most, each below 1.
const ROUNDING: f64 = 1e-12;

fn phase() -> Phase {
    Phase::HenyeyGreenstein(HenyeyGreenstein::new(0.3).unwrap())
}

fn interior(phase: &Phase, mu_s: f64, mu_a: f64) -> Interior<'_> {
    Interior {
        index: 1.557,
        mu_s,
        mu_a,
        phase,
    }
}

/// Mean ledger of each of the directions of a grid over the hemisphere, in batches; `each` sees every path's.
fn directions<S: Shape>(walk: &Walk<'_, S>, entry: &Vec3, mut each: impl FnMut(&Ledger)) -> Vec<LedgerEntry> {
    let (batches, paths) = (50, 100);
    let mut entries = Vec::new();
    for direction in 0..24 {
        let zenith = (f64::from(direction % 6) + 0.5) / 6.0 * FRAC_PI_2;
        let azimuth = f64::from(direction / 6) / 4.0 * TAU + 0.1;
        let omega_in = Vec3::new(zenith.sin() * azimuth.cos(), zenith.sin() * azimuth.sin(), zenith.cos());
        let ledgers: Vec<Ledger> = (0..batches)
            .map(|batch| {
                let mut rng = Stream::open(3, Purpose::Validation, direction as usize, batch, 0);
                let mut sum = Ledger::default();
                for _ in 0..paths {
                    let mut exits = Ledger::default();
                    let ledger = walk.run(&mut rng, entry, &Vec3::z(), &omega_in, |exit| {
                        assert!((exit.direction.norm() - 1.0).abs() < ROUNDING);
                        assert!(exit.direction.dot(&exit.normal) >= 0.0 && exit.weight >= 0.0);
                        if exit.scattered {
                            exits.scattered += exit.weight;
                        } else {
                            exits.ballistic += exit.weight;
                        }
                    });
                    assert!((exits.scattered - ledger.scattered).abs() < ROUNDING);
                    assert!((exits.ballistic - ledger.ballistic).abs() < ROUNDING);
                    each(&ledger);
                    sum.add(&ledger);
                }
                sum.scaled(1.0 / f64::from(paths))
            })
            .collect();
        entries.push(LedgerEntry::from_batches(&ledgers));
    }
    entries
}

/// False alarms: 48 directions and bodies, |t| > 4 with 49 degrees of freedom has probability 2.1e-4: 1 %.
#[test]
fn white_furnace() {
    let phase = phase();
    let cylinder = Cylinder::new(0.15).unwrap();
    let slab = Slab::new(0.3).unwrap();
    let closed = |ledger: &Ledger| {
        let sum = ledger.reflected + ledger.ballistic + ledger.scattered + ledger.roulette;
        assert!((sum - 1.0).abs() <= ROUNDING && ledger.absorbed == 0.0, "{ledger:?}");
    };
    let roulette = Roulette::default();
    let interior = interior(&phase, 6.0, 0.0);
    let entry = cylinder.at(0.0);
    let shape = &cylinder;
    let mut entries = directions(
        &Walk {
            shape,
            interior,
            roulette,
        },
        &entry,
        closed,
    );
    let shape = &slab;
    entries.extend(directions(
        &Walk {
            shape,
            interior,
            roulette,
        },
        &Vec3::zeros(),
        closed,
    ));
    assert_eq!(entries.len(), 48);
    for entry in entries {
        assert!(entry.mean.residual().abs() <= ROUNDING, "{entry:?}");
        assert!(
            entry.mean.roulette.abs() <= 4.0 * entry.se[4] && entry.se[4] > 0.0,
            "{entry:?}"
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
            interior: interior(&phase, 6.0, mu_a),
            roulette: Roulette::default(),
        };
        let mut absorbed = 0.0;
        directions(&walk, &shape.at(0.0), |ledger| {
            assert!(ledger.residual().abs() <= ROUNDING, "{ledger:?}");
            absorbed += ledger.absorbed;
        });
        assert!(absorbed > 0.0);
    }
}

/// Light that grazes the surface enters in vanishing parts and then meets the surface from inside at an angle from which
/// it hardly leaves: its path must end, without loss.
#[test]
fn grazing_light_ends_and_is_accounted_for() {
    let phase = phase();
    let cylinder = Cylinder::new(0.15).unwrap();
    let entry = cylinder.at(0.0);
    let mut rng = Stream::open(5, Purpose::Validation, 0, 0, 0);
    for cosine in [1e-3, 1e-6, 1e-8, 1e-12, 6.1e-17, 0.0] {
        for (mu_s, mu_a) in [(0.0, 0.0), (0.0, 2.0), (6.0, 0.0), (6.0, 2.0)] {
            let walk = Walk {
                shape: &cylinder,
                interior: interior(&phase, mu_s, mu_a),
                roulette: Roulette::default(),
            };
            for _ in 0..20 {
                let azimuth = TAU * rng.random::<f64>();
                let omega_in = Vec3::new(azimuth.cos(), azimuth.sin(), cosine).normalize();
                let ledger = walk.run(&mut rng, &entry, &Vec3::z(), &omega_in, |_| {});
                assert!(ledger.residual().abs() <= ROUNDING, "cos {cosine}: {ledger:?}");
                assert!(ledger.reflected >= 1.0 - 10.0 * cosine, "cos {cosine}: {ledger:?}");
            }
        }
    }
}
