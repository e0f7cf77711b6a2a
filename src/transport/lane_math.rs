//! Elementary functions without a branch or a table, so that a loop over lanes compiles to vector instructions. Only +, −,
//! ×, ÷ and selections are used, in a fixed order: every instruction set gives the same bits.

use std::f64::consts::{LN_2, LOG2_E, SQRT_2, TAU};

/// 1.5 · 2⁵²: added and taken away again it rounds to the nearest whole number, which then stands in the low bits.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// ln 2 in two parts, the first with 21 trailing zero bits: k · LN_2_HIGH is exact for |k| < 2²¹.
const LN_2_HIGH: f64 = f64::from_bits(LN_2.to_bits() & !0x1F_FFFF);
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
/// Below it exp is taken as 0; the smallest normal number is e^−708.4.
const LEAST_EXPONENT: f64 = -708.0;

/// eˣ for x ≤ 0 (up to 700), relative error below 4e-16; 0 below −708.
#[inline(always)]
pub(super) fn exp(x: f64) -> f64 {
    let clamped = if x > LEAST_EXPONENT { x } else { LEAST_EXPONENT };
    let shifted = clamped * LOG2_E + ROUND;
    let k = shifted - ROUND;
    let r = (clamped - k * LN_2_HIGH) - k * LN_2_LOW;
    // Taylor to r¹³/13!; |r| ≤ 0.3466.
    let mut p = 1.0 / 6_227_020_800.0;
    p = p * r + 1.0 / 479_001_600.0;
    p = p * r + 1.0 / 39_916_800.0;
    p = p * r + 1.0 / 3_628_800.0;
    p = p * r + 1.0 / 362_880.0;
    p = p * r + 1.0 / 40_320.0;
    p = p * r + 1.0 / 5_040.0;
    p = p * r + 1.0 / 720.0;
    p = p * r + 1.0 / 120.0;
    p = p * r + 1.0 / 24.0;
    p = p * r + 1.0 / 6.0;
    p = p * r + 0.5;
    let e = (p * r * r + r) + 1.0;
    // The low bits of `shifted` are k in two's complement: moved to the exponent they multiply by 2ᵏ.
    let scaled = f64::from_bits(e.to_bits().wrapping_add(shifted.to_bits() << 52));
    if x > LEAST_EXPONENT { scaled } else { 0.0 }
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
    let mut p = 2.0 / 21.0;
    p = p * z + 2.0 / 19.0;
    p = p * z + 2.0 / 17.0;
    p = p * z + 2.0 / 15.0;
    p = p * z + 2.0 / 13.0;
    p = p * z + 2.0 / 11.0;
    p = p * z + 2.0 / 9.0;
    p = p * z + 2.0 / 7.0;
    p = p * z + 2.0 / 5.0;
    p = p * z + 2.0 / 3.0;
    k * LN_2_HIGH + (2.0 * s + (s * z * p + k * LN_2_LOW))
}

/// (sin, cos) of u turns, 0 ≤ u ≤ 1, error below 3e-16.
#[inline(always)]
pub(super) fn sin_cos_turns(u: f64) -> (f64, f64) {
    let shifted = 4.0 * u + ROUND;
    let quarter = shifted - ROUND;
    let a = (u - 0.25 * quarter) * TAU;
    let z = a * a;
    let mut s = -1.0 / 1_307_674_368_000.0;
    s = s * z + 1.0 / 6_227_020_800.0;
    s = s * z - 1.0 / 39_916_800.0;
    s = s * z + 1.0 / 362_880.0;
    s = s * z - 1.0 / 5_040.0;
    s = s * z + 1.0 / 120.0;
    s = s * z - 1.0 / 6.0;
    let sin = s * z * a + a;
    let mut c = 1.0 / 20_922_789_888_000.0;
    c = c * z - 1.0 / 87_178_291_200.0;
    c = c * z + 1.0 / 479_001_600.0;
    c = c * z - 1.0 / 3_628_800.0;
    c = c * z + 1.0 / 40_320.0;
    c = c * z - 1.0 / 720.0;
    c = c * z + 1.0 / 24.0;
    c = c * z - 0.5;
    let cos = c * z + 1.0;
    let turned = shifted.to_bits() & 1 != 0;
    let opposite = shifted.to_bits() & 2 != 0;
    let (s, c) = if turned { (cos, -sin) } else { (sin, cos) };
    if opposite { (-s, -c) } else { (s, c) }
}

/// Even in [0, 1) with 52 bits.
#[inline(always)]
pub(super) fn unit(bits: u64) -> f64 {
    f64::from_bits((bits >> 12) | 0x3FF0_0000_0000_0000) - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agree_with_the_standard_library() {
        let mut worst = [0.0f64; 4];
        for i in 0..200_000 {
            let u = (i as f64 + 0.5) / 200_000.0;
            for x in [-708.0 * u, -40.0 * u, -u, -1e-6 * u, 700.0 * u] {
                worst[0] = worst[0].max((exp(x) / x.exp() - 1.0).abs());
            }
            for x in [u, 1e-8 * u, 1.0 - 1e-6 * u, 1e-300 * u] {
                worst[1] = worst[1].max((ln(x) - x.ln()).abs() / x.ln().abs().max(1.0 - x));
            }
            let (s, c) = sin_cos_turns(u);
            let (s0, c0) = (TAU * u).sin_cos();
            worst[2] = worst[2].max((s - s0).abs()).max((c - c0).abs());
            worst[3] = worst[3].max((s * s + c * c - 1.0).abs());
        }
        assert!(worst[0] < 5e-16, "exp {:e}", worst[0]);
        assert!(worst[1] < 4e-16, "ln {:e}", worst[1]);
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
