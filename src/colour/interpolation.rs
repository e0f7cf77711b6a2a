//! Values between the wavelengths of a grid as a linear function of the values on it.

use crate::spectrum::WavelengthGrid;

/// Steps this close, relative, are one step written in decimals.
const EQUAL: f64 = 1e-9;
/// Least number of values that Sprague's polynomial extends beyond the ends from.
const SPRAGUE_LEAST: usize = 6;

/// The common step in nm of a grid of two wavelengths or more, if it has one.
pub(super) fn uniform_step(grid: &WavelengthGrid) -> Option<f64> {
    let nm = grid.nm();
    let step = nm.get(1)? - nm[0];
    let equal = |pair: &[f64]| ((pair[1] - pair[0]) / step - 1.0).abs() < EQUAL;
    nm.windows(2).all(equal).then_some(step)
}

/// How values are interpolated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SpectralInterpolation {
    /// Fifth-order polynomial through six neighbours with their slopes (T. B. Sprague 1880; CIE 167:2005), on equal
    /// steps.
    Sprague,
    Linear,
}

impl SpectralInterpolation {
    /// Sprague's where steps are equal and there are six values or more.
    pub(super) fn of(grid: &WavelengthGrid) -> Self {
        match uniform_step(grid) {
            Some(_) if grid.len() >= SPRAGUE_LEAST => Self::Sprague,
            _ => Self::Linear,
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Sprague => "Sprague's",
            Self::Linear => "linear",
        }
    }

    /// Calls `add` with index and weight of the values whose weighted sum is the value at a wavelength: that of the
    /// nearest end outside the grid. Weights sum to 1.
    pub(super) fn weights(self, grid: &WavelengthGrid, at_nm: f64, mut add: impl FnMut(usize, f64)) {
        let nm = grid.nm();
        let last = nm.len() - 1;
        if at_nm <= nm[0] {
            return add(0, 1.0);
        }
        if at_nm >= nm[last] {
            return add(last, 1.0);
        }
        let below = nm.partition_point(|&x| x <= at_nm) - 1;
        let t = (at_nm - nm[below]) / (nm[below + 1] - nm[below]);
        match self {
            Self::Linear => {
                add(below, 1.0 - t);
                add(below + 1, t);
            }
            Self::Sprague => {
                for (k, weight) in sprague(t).into_iter().enumerate() {
                    match (below + k).checked_sub(2) {
                        Some(index) if index <= last => add(index, weight),
                        Some(index) => extended(index - last, |i, w| add(last - i, weight * w)),
                        None => extended(2 - below - k, |i, w| add(i, weight * w)),
                    }
                }
            }
        }
    }
}

/// Weights of the values at steps −2 to 3 for the value at t steps, 0..1 (CIE 167:2005, eq. 3).
fn sprague(t: f64) -> [f64; 6] {
    /// Of t⁰ to t⁵, in 24ths.
    const POWERS: [[f64; 6]; 6] = [
        [0.0, 0.0, 24.0, 0.0, 0.0, 0.0],
        [2.0, -16.0, 0.0, 16.0, -2.0, 0.0],
        [-1.0, 16.0, -30.0, 16.0, -1.0, 0.0],
        [-9.0, 39.0, -70.0, 66.0, -33.0, 7.0],
        [13.0, -64.0, 126.0, -124.0, 61.0, -12.0],
        [-5.0, 25.0, -50.0, 50.0, -25.0, 5.0],
    ];
    std::array::from_fn(|node| POWERS.iter().rev().fold(0.0, |sum, power| sum * t + power[node] / 24.0))
}

/// Weights of the six values at an end, the outermost first, for the value 1 or 2 steps beyond it.
fn extended(steps: usize, mut add: impl FnMut(usize, f64)) {
    const ONE: [f64; 6] = [508.0, -540.0, 488.0, -367.0, 144.0, -24.0];
    const TWO: [f64; 6] = [884.0, -1960.0, 3033.0, -2648.0, 1080.0, -180.0];
    let weights = if steps == 1 { ONE } else { TWO };
    weights.iter().enumerate().for_each(|(i, w)| add(i, w / 209.0));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(grid: &WavelengthGrid, values: &[f64], nm: f64) -> f64 {
        let mut sum = 0.0;
        SpectralInterpolation::of(grid).weights(grid, nm, |i, w| sum += w * values[i]);
        sum
    }

    /// The values beyond the ends that the CIE gives follow straight lines, not more.
    #[test]
    fn cubics_are_exact_between_inner_values_and_straight_lines_everywhere() {
        let cubic = |nm: f64| 0.2 + 0.3 * ((nm - 500.0) / 100.0) - 0.1 * ((nm - 500.0) / 100.0).powi(3);
        let line = |nm: f64| 0.001 * nm;
        let equal = WavelengthGrid::new((0..7).map(|i| 400.0 + 20.0 * f64::from(i)).collect()).unwrap();
        let on = |of: &dyn Fn(f64) -> f64| equal.nm().iter().map(|&nm| of(nm)).collect::<Vec<f64>>();
        for nm in [440.0, 441.0, 455.5, 460.0, 479.9] {
            assert!((at(&equal, &on(&cubic), nm) - cubic(nm)).abs() < 1e-13, "{nm}");
        }
        for nm in [400.0, 401.0, 413.7, 455.5, 501.0, 519.0, 520.0] {
            assert!((at(&equal, &on(&line), nm) - line(nm)).abs() < 1e-13, "{nm}");
        }
        let values = on(&cubic);
        assert_eq!(
            (at(&equal, &values, 300.0), at(&equal, &values, 900.0)),
            (values[0], values[6])
        );
        let uneven = WavelengthGrid::new(vec![400.0, 410.0, 500.0]).unwrap();
        assert!((at(&uneven, &[0.0, 0.1, 1.0], 455.0) - 0.55).abs() < 1e-15);
    }
}
