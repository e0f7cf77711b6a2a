//! Binary numbers whose bytes are in the other order.

use super::error::FormatError;

/// Whether most numbers that are not 0 are of no magnitude that scattering has, as those with their bytes reversed are.
pub(super) fn is_implausible(values: impl Iterator<Item = f64>) -> bool {
    let (mut all, mut odd) = (0usize, 0usize);
    for value in values.filter(|v| *v != 0.0) {
        all += 1;
        odd += usize::from(!(1e-12..=1e12).contains(&value.abs()));
    }
    2 * odd > all
}

/// The error of numbers that [`is_implausible`] tells.
pub(super) fn swapped(path: &str, offset: usize) -> FormatError {
    let found = "numbers most of which are beyond 1e-12 to 1e12, as with their bytes in reversed order";
    let remedy = "reverse the bytes of each number, or copy the original file again in binary mode";
    FormatError::byte(path, offset, "little-endian numbers", found, remedy)
}
