//! Arithmetic on groups of wavelengths.
//!
//! The functions take and return values, so that all reads precede all writes. With references the compiler
//! could not rule out overlapping rows and would not use vector instructions.

use super::interior::{Double, GROUP, Single};
use super::lane_math::{exp_single, loss_single};
use std::ops::{Add, Mul};

/// A length in single precision, clamped to a finite value.
#[inline(always)]
pub(super) fn single(length_mm: f64) -> f32 {
    length_mm.min(f64::from(f32::MAX)) as f32
}

/// 1 − exp(−μ x) of a group.
#[inline(always)]
pub(super) fn losses(mu: Single, x: f32) -> Single {
    let mut result = [0.0; GROUP];
    for i in 0..GROUP {
        result[i] = loss_single(-mu[i] * x);
    }
    result
}

#[inline(always)]
pub(super) fn remainder(lost: Single) -> Single {
    let mut result = [0.0; GROUP];
    for i in 0..GROUP {
        result[i] = 1.0 - lost[i];
    }
    result
}

/// exp((μ_hero − μ) x): factor of the density ratio to the hero for a flight of length x, mm, apart from the μ_s
/// at its end.
#[inline(always)]
pub(super) fn density_ratio(mu_s: Single, hero_mu_s: f32, x: f32) -> Single {
    let mut result = [0.0; GROUP];
    for i in 0..GROUP {
        result[i] = exp_single((hero_mu_s - mu_s[i]) * x);
    }
    result
}

/// Paths per round over P, with P = 1 − T exp(−μ_s c) = (1 − T) + T (1 − exp(−μ_s c)), a form without cancellation; 0
/// where P is 0.
#[inline(always)]
pub(super) fn paths_over_reach(met: Single, paths_per_round: Single, transmittance: f32) -> Single {
    let mut result = [0.0; GROUP];
    for i in 0..GROUP {
        let reach = (1.0 - transmittance) + transmittance * met[i];
        result[i] = if reach > 0.0 { paths_per_round[i] / reach } else { 0.0 };
    }
    result
}

/// Balance-heuristic weights from density ratios. Weights below 1e-30 become 0 for good, before they turn into slow
/// denormal numbers.
#[inline(always)]
pub(super) fn balanced(share: Single, balance: f32) -> Single {
    let mut result = [0.0; GROUP];
    for i in 0..GROUP {
        let share = share[i] * balance;
        result[i] = if share > 1e-30 { share } else { 0.0 };
    }
    result
}

#[inline(always)]
pub(super) fn double(values: Single) -> Double {
    let mut result = [0.0; GROUP];
    for i in 0..GROUP {
        result[i] = f64::from(values[i]);
    }
    result
}

#[inline(always)]
pub(super) fn product<T: Copy + Mul<Output = T>>(a: [T; GROUP], b: [T; GROUP]) -> [T; GROUP] {
    let mut result = a;
    for i in 0..GROUP {
        result[i] = a[i] * b[i];
    }
    result
}

#[inline(always)]
pub(super) fn scaled<T: Copy + Mul<Output = T>>(a: [T; GROUP], factor: T) -> [T; GROUP] {
    let mut result = a;
    for i in 0..GROUP {
        result[i] = a[i] * factor;
    }
    result
}

#[inline(always)]
pub(super) fn plus<T: Copy + Add<Output = T>>(a: [T; GROUP], b: [T; GROUP]) -> [T; GROUP] {
    let mut result = a;
    for i in 0..GROUP {
        result[i] = a[i] + b[i];
    }
    result
}

#[inline(always)]
pub(super) fn minus(a: Double, b: Double) -> Double {
    let mut result = a;
    for i in 0..GROUP {
        result[i] = a[i] - b[i];
    }
    result
}

#[inline(always)]
pub(super) fn larger(a: Single, b: Single) -> Single {
    let mut result = a;
    for i in 0..GROUP {
        result[i] = if b[i] > a[i] { b[i] } else { a[i] };
    }
    result
}

#[inline(always)]
pub(super) fn count(sums: &mut [Double], carried: &[Single], factor: f64) {
    for (sums, carried) in sums.iter_mut().zip(carried) {
        *sums = plus(*sums, scaled(double(*carried), factor));
    }
}

#[inline(always)]
pub(super) fn top(values: Single) -> f32 {
    let mut best = values;
    let mut half = GROUP / 2;
    while half > 0 {
        for i in 0..half {
            best[i] = if best[i + half] > best[i] {
                best[i + half]
            } else {
                best[i]
            };
        }
        half /= 2;
    }
    best[0]
}

/// Pairwise sum in a fixed order, which compiles to vector instructions.
#[inline(always)]
pub(super) fn sum(values: Single) -> f32 {
    let mut part = values;
    let mut half = GROUP / 2;
    while half > 0 {
        for i in 0..half {
            part[i] += part[i + half];
        }
        half /= 2;
    }
    part[0]
}
