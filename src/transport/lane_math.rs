//! Elementary functions without a branch or a table, so that a loop over lanes compiles to vector instructions. Only
//! operations that IEEE 754 rounds exactly (+, −, ×, ÷, fused multiply-add) and selections are used, in a fixed order:
//! every instruction set gives the same bits, those without fused multiply-add slowly.
//!
//! Polynomial coefficients are our own: interpolation of the function in 40 digits at Chebyshev nodes (exp) or Remez
//! exchange (ln).

use std::f64::consts::{LN_2, LOG2_E, SQRT_2, TAU};

/// Number of paths traced together in vector instructions.
pub(super) const LANES: usize = 16;

/// 1.5 · 2⁵²: adding and subtracting it rounds to the nearest integer; after the addition the low bits hold that
/// integer.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// ln 2 in two parts, the first with 21 trailing zero bits: k · LN_2_HIGH is exact for |k| < 2²¹.
const LN_2_HIGH: f64 = f64::from_bits(LN_2.to_bits() & !0x1F_FFFF);
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
const EXP: [f64; 10] = [
    0.5000000000000001,
    0.16666666666666669,
    0.04166666666662413,
    0.008333333333330062,
    0.0013888888917213717,
    0.00019841269863053618,
    2.4801521295954376e-05,
    2.7557268459997064e-06,
    2.7620088445409746e-07,
    2.510038549551032e-08,
];
const LN: [f64; 7] = [
    0.666666666666667,
    0.3999999999989789,
    0.28571428626651707,
    0.22222211031710895,
    0.18182896208630672,
    0.1533149778859185,
    0.14619096121623418,
];
/// The same for single precision: 1.5 · 2²³, ln 2 in two parts (12 bits in the first), and (eʳ − 1 − r)/r².
const ROUND_SINGLE: f32 = 12_582_912.0;
const LN_2_HIGH_SINGLE: f32 = 0.693_359_4;
const LN_2_LOW_SINGLE: f32 = -2.121_944_4e-4;
const EXP_SINGLE: [f32; 5] = [0.5, 0.166_665_76, 0.041_666_556, 0.008_363_179, 0.001_392_618_4];
const SINGLE_RANGE: f32 = 80.0;
/// exp returns 0 below this argument; the smallest normal number is e^−708.4.
const LEAST_EXPONENT: f64 = -708.0;

/// eˣ for x ≤ 0 (up to 700), relative error below 4e-16; 0 below −708.
#[inline(always)]
pub(super) fn exp(x: f64) -> f64 {
    let clamped = if x > LEAST_EXPONENT { x } else { LEAST_EXPONENT };
    let shifted = clamped.mul_add(LOG2_E, ROUND);
    let k = shifted - ROUND;
    let r = k.mul_add(-LN_2_LOW, k.mul_add(-LN_2_HIGH, clamped));
    // (eʳ − 1 − r)/r², |r| ≤ 0.3466.
    let mut p = EXP[9];
    p = p.mul_add(r, EXP[8]);
    p = p.mul_add(r, EXP[7]);
    p = p.mul_add(r, EXP[6]);
    p = p.mul_add(r, EXP[5]);
    p = p.mul_add(r, EXP[4]);
    p = p.mul_add(r, EXP[3]);
    p = p.mul_add(r, EXP[2]);
    p = p.mul_add(r, EXP[1]);
    p = p.mul_add(r, EXP[0]);
    let e = (p * r).mul_add(r, r) + 1.0;
    // The low bits of `shifted` are k in two's complement: moved to the exponent they multiply by 2ᵏ.
    let scaled = f64::from_bits(e.to_bits().wrapping_add(shifted.to_bits() << 52));
    if x > LEAST_EXPONENT { scaled } else { 0.0 }
}

/// 2ᵏ and eʳ − 1 with eˣ = 2ᵏ eʳ, |r| ≤ ln 2 / 2, in single precision; x is clamped to |x| ≤ 80.
#[inline(always)]
fn exp_parts(x: f32) -> (f32, f32) {
    let x = x.clamp(-SINGLE_RANGE, SINGLE_RANGE);
    let shifted = x.mul_add(LOG2_E as f32, ROUND_SINGLE);
    let k = shifted - ROUND_SINGLE;
    let r = k.mul_add(-LN_2_LOW_SINGLE, k.mul_add(-LN_2_HIGH_SINGLE, x));
    let mut p = EXP_SINGLE[4];
    p = p.mul_add(r, EXP_SINGLE[3]);
    p = p.mul_add(r, EXP_SINGLE[2]);
    p = p.mul_add(r, EXP_SINGLE[1]);
    p = p.mul_add(r, EXP_SINGLE[0]);
    let scale = f32::from_bits(1f32.to_bits().wrapping_add(shifted.to_bits() << 23));
    (scale, (p * r).mul_add(r, r))
}

/// eˣ, relative error below 2e-7.
#[inline(always)]
pub(super) fn exp_single(x: f32) -> f32 {
    let (scale, rest) = exp_parts(x);
    scale.mul_add(rest, scale)
}

/// 1 − eˣ, relative error below 4e-7.
#[inline(always)]
pub(super) fn loss_single(x: f32) -> f32 {
    let (scale, rest) = exp_parts(x);
    scale.mul_add(-rest, 1.0 - scale)
}

/// ln x for normal x > 0, error below 3e-16 relative to max(|ln x|, 1 − x).
#[inline(always)]
pub(super) fn ln(x: f64) -> f64 {
    let bits = x.to_bits();
    let mantissa = f64::from_bits((bits & 0x000F_FFFF_FFFF_FFFF) | 0x3FF0_0000_0000_0000);
    // The biased exponent as a number, without an integer conversion: it fills the low bits of 2⁵².
    let exponent = f64::from_bits((bits >> 52) | 0x4330_0000_0000_0000) - 4_503_599_627_370_496.0;
    let high = mantissa > SQRT_2;
    let m = if high { 0.5 * mantissa } else { mantissa };
    let k = if high { exponent - 1022.0 } else { exponent - 1023.0 };
    // ln m = 2 artanh s, |s| ≤ 0.1716.
    let s = (m - 1.0) / (m + 1.0);
    let z = s * s;
    // (2 artanh s − 2s)/s³ in z ≤ 0.0295.
    let mut p = LN[6];
    p = p.mul_add(z, LN[5]);
    p = p.mul_add(z, LN[4]);
    p = p.mul_add(z, LN[3]);
    p = p.mul_add(z, LN[2]);
    p = p.mul_add(z, LN[1]);
    p = p.mul_add(z, LN[0]);
    k.mul_add(LN_2_HIGH, k.mul_add(LN_2_LOW, (s * z).mul_add(p, 2.0 * s)))
}

/// (sin 2πu, cos 2πu) for 0 ≤ u ≤ 1, error below 3e-16.
#[inline(always)]
pub(super) fn sin_cos_turns(u: f64) -> (f64, f64) {
    let shifted = 4.0 * u + ROUND;
    let quarter = shifted - ROUND;
    let a = (u - 0.25 * quarter) * TAU;
    let z = a * a;
    // Taylor; |a| ≤ π/4.
    let mut s: f64 = -1.0 / 1_307_674_368_000.0;
    s = s.mul_add(z, 1.0 / 6_227_020_800.0);
    s = s.mul_add(z, -1.0 / 39_916_800.0);
    s = s.mul_add(z, 1.0 / 362_880.0);
    s = s.mul_add(z, -1.0 / 5_040.0);
    s = s.mul_add(z, 1.0 / 120.0);
    s = s.mul_add(z, -1.0 / 6.0);
    let sin = (s * z).mul_add(a, a);
    let mut c: f64 = 1.0 / 20_922_789_888_000.0;
    c = c.mul_add(z, -1.0 / 87_178_291_200.0);
    c = c.mul_add(z, 1.0 / 479_001_600.0);
    c = c.mul_add(z, -1.0 / 3_628_800.0);
    c = c.mul_add(z, 1.0 / 40_320.0);
    c = c.mul_add(z, -1.0 / 720.0);
    c = c.mul_add(z, 1.0 / 24.0);
    c = c.mul_add(z, -0.5);
    let cos = c.mul_add(z, 1.0);
    let turned = shifted.to_bits() & 1 != 0;
    let opposite = shifted.to_bits() & 2 != 0;
    let (s, c) = if turned { (cos, -sin) } else { (sin, cos) };
    if opposite { (-s, -c) } else { (s, c) }
}

/// Uniform random number in [0, 1) with 52 bits.
#[inline(always)]
pub(super) fn unit(bits: u64) -> f64 {
    f64::from_bits((bits >> 12) | 0x3FF0_0000_0000_0000) - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agree_with_the_standard_library() {
        let mut worst = [0.0f64; 6];
        for i in 0..200_000 {
            let u = (i as f64 + 0.5) / 200_000.0;
            for x in [-708.0 * u, -40.0 * u, -u, -1e-6 * u, 700.0 * u] {
                worst[0] = worst[0].max((exp(x) / x.exp() - 1.0).abs());
            }
            for x in [u, 1e-8 * u, 1.0 - 1e-6 * u, 1e-300 * u] {
                worst[1] = worst[1].max((ln(x) - x.ln()).abs() / x.ln().abs().max(1.0 - x));
            }
            for x in [-80.0 * u, 80.0 * u, -u, -1e-6 * u] {
                let x = x as f32;
                worst[4] = worst[4].max((f64::from(exp_single(x)) / f64::from(x).exp() - 1.0).abs());
                worst[5] = worst[5].max((f64::from(loss_single(x)) / -f64::from(x).exp_m1() - 1.0).abs());
            }
            let (s, c) = sin_cos_turns(u);
            let (s0, c0) = (TAU * u).sin_cos();
            worst[2] = worst[2].max((s - s0).abs()).max((c - c0).abs());
            worst[3] = worst[3].max((s * s + c * c - 1.0).abs());
        }
        assert!(worst[0] < 5e-16, "exp {:e}", worst[0]);
        assert!(worst[1] < 4e-16, "ln {:e}", worst[1]);
        assert!(
            worst[4] < 2e-7 && worst[5] < 4e-7,
            "exp, loss in single precision {:e} {:e}",
            worst[4],
            worst[5]
        );
        // The reference's own argument 2πu is rounded to 4e-16.
        assert!(
            worst[2] < 9e-16 && worst[3] < 6e-16,
            "sin, cos {:e} {:e}",
            worst[2],
            worst[3]
        );
        assert_eq!((exp(-709.0), exp(f64::NEG_INFINITY), exp(0.0)), (0.0, 0.0, 1.0));
        assert_eq!((ln(1.0), unit(0)), (0.0, 0.0));
        assert!(unit(u64::MAX) < 1.0);
    }
}
