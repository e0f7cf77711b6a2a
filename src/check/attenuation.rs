//! Beer and Lambert's law along paths of a known length, path by path.

use super::gate::{Gate, Law, Where};
use super::{CheckError, Context};
use crate::geometry::Vec3;
use crate::optics::Medium;
use crate::transport::{Entry, Exit, Purpose, Roulette, Stream, Walk};
use crate::yarn::{Estimator, Yarn};
use std::cell::RefCell;

const INDEPENDENT: Law = Law {
    name: "attenuation",
    words: "independent paths: without a surface light crosses with exp(−(mu_s + mu_a) L), and scattered light keeps \
            exp(−mu_a L)",
};
const SHARED: Law = Law {
    name: "attenuation-shared",
    words: "shared paths: the same, scattered light where all wavelengths scatter alike",
};

/// Of what one shared path carries, which is reckoned in single precision.
const SINGLE: f64 = 1e-5;
/// Rounding of an optical depth in single precision, relative: a weight exp(−depth) is off by this times the deepest
/// depth that it is weighed against.
const ROUNDING: f64 = f32::EPSILON as f64;
/// Of the light that crosses: less of it crosses by rounding. Where as little crosses at all, no path need.
const STRAY: f64 = 1e-6;
const DARK: f64 = 1e-6;
/// Paths through a cross-section of the yarn, for each interior.
const PATHS: usize = 32;
const TILT_SINE: f64 = 0.6;
/// In place of a direction, apart from the other streams of the check.
const STREAM: usize = 1 << 23;

/// The yarn in a host of index 1, which neither reflects nor refracts: light that enters at a height leaves straight
/// on, or where it first meets the surface after scattering. Russian roulette applies to weights below rounding alone.
pub fn gates(context: &Context) -> Result<[Gate; 2], CheckError> {
    let Context { plan, judge, .. } = context;
    let medium = &plan.yarn.medium;
    let own = medium.mu_s_per_mm().to_vec();
    let independent = of(context, &own, |w| w, Estimator::Independent)?;
    let mut shared = of(context, &own, |w| w, Estimator::Shared)?;
    shared.retain(|departure| !departure.scattered);
    // With one μ_s and one phase function no wavelength is told from another but by its absorption.
    let middle = plan.grid.len() / 2;
    shared.extend(of(
        context,
        &vec![own[middle]; own.len()],
        |_| middle,
        Estimator::Shared,
    )?);
    let extinction = own.iter().zip(medium.mu_a_per_mm()).map(|(mu_s, mu_a)| mu_s + mu_a);
    let deepest = 2.0 * plan.yarn.cylinder.radius_mm() * extinction.fold(0.0, f64::max);
    let gate = |law, departures: &[Departure], tolerance| {
        let values: Vec<f64> = departures.iter().map(|departure| departure.value).collect();
        judge.exact(law, &values, tolerance, |i| {
            let kind = if departures[i].scattered {
                "scattered"
            } else {
                "straight on"
            };
            Where::new(departures[i].wavelength_nm, kind)
        })
    };
    Ok([
        gate(INDEPENDENT, &independent, plan.study.check.rounding),
        gate(SHARED, &shared, SINGLE.max(ROUNDING * deepest)),
    ])
}

struct Departure {
    value: f64,
    wavelength_nm: f64,
    scattered: bool,
}

/// `phase` is which wavelength's phase function each has.
fn of(
    context: &Context,
    mu_s: &[f64],
    phase: impl Fn(usize) -> usize,
    estimator: Estimator,
) -> Result<Vec<Departure>, CheckError> {
    let plan = context.plan;
    let medium = &plan.yarn.medium;
    let (nm, mu_a) = (plan.grid.nm(), medium.mu_a_per_mm());
    let phases = (0..nm.len()).map(|w| medium.phase(phase(w)).clone()).collect();
    let clear = vec![1.0; nm.len()];
    let yarn = Yarn {
        medium: Medium::from_coefficients(&plan.grid, clear, mu_s.to_vec(), mu_a.to_vec(), phases)?,
        ..plan.yarn.clone()
    };
    let radius_mm = yarn.cylinder.radius_mm();
    let cosine = (1.0 - TILT_SINE * TILT_SINE).sqrt();
    let mut departures = Vec::new();
    for sharing in yarn.sharing_by(estimator)? {
        let walk = Walk {
            shape: &yarn.cylinder,
            interior: &sharing.interior,
            roulette: Roulette::new(1e-15, 0.5)?,
        };
        let stream = Stream::open(plan.study.seed, Purpose::Check, STREAM, 0, sharing.first);
        let (entered, mut crossed) = (RefCell::new(Vec::new()), 0.0);
        walk.trace(
            stream,
            PATHS,
            |[across, ..]| {
                let h = 2.0 * across - 1.0;
                let depth = (1.0 - h * h).max(0.0).sqrt();
                entered.borrow_mut().push(2.0 * radius_mm * depth / cosine);
                let normal = Vec3::new(h, 0.0, depth);
                Entry {
                    position: normal * radius_mm,
                    normal,
                    omega_in: Vec3::new(0.0, TILT_SINE, cosine),
                }
            },
            |exit: &Exit<'_>| {
                let chord_mm = 2.0 * exit.entry.z / cosine;
                let of = |k: usize| {
                    let w = sharing.first + k;
                    let straight = (-mu_s[w] * chord_mm).exp();
                    match exit.scattered {
                        true => (1.0 - straight) * (-mu_a[w] * exit.length_mm).exp(),
                        false => straight * (-mu_a[w] * chord_mm).exp(),
                    }
                };
                if !exit.scattered {
                    // Of next to no light that is to scatter, the flight may round to the whole chord.
                    if (exit.weights.iter().enumerate()).all(|(k, weight)| *weight < STRAY * of(k)) {
                        return;
                    }
                    crossed += 1.0;
                }
                for (k, weight) in exit.weights.iter().enumerate() {
                    departures.push(Departure {
                        value: weight - of(k),
                        wavelength_nm: nm[sharing.first + k],
                        scattered: exit.scattered,
                    });
                }
            },
        );
        let here = sharing.first..sharing.first + sharing.interior.wavelengths();
        let depths: Vec<f64> = here.map(|w| mu_s[w] + mu_a[w]).collect();
        let crosses = |chord_mm: &&f64| depths.iter().any(|depth| (-depth * **chord_mm).exp() > DARK);
        departures.push(Departure {
            value: (entered.borrow().iter().filter(crosses).count() as f64 - crossed).max(0.0),
            wavelength_nm: nm[sharing.first],
            scattered: false,
        });
    }
    Ok(departures)
}
