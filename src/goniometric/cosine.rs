//! f of tables that hold f cos θ_out at the nodes of a grid.

use super::grid::Grid;

/// Divides values f cos θ_out by the cosine at their nodes, so that f is interpolated: the cosine is not linear between
/// nodes and vanishes at the horizon. Nodes at and below the horizon get f of the next node above it on their arc of
/// the third angle, or else on the previous or next arc. Returns the number of these nodes.
pub(crate) fn divide_by_cosine(grid: &mut Grid) -> usize {
    /// Smallest cosine at which a value of few digits still determines f.
    const HORIZON: f64 = 1e-4;
    let [n0, n1, n2, n3] = grid.shape();
    let mut held = 0;
    for (i0, i1) in (0..n0).flat_map(|i0| (0..n1).map(move |i1| (i0, i1))) {
        let cosines: Vec<Vec<Option<f64>>> = (0..n3)
            .map(|i3| {
                let cosine = |i2| grid.directions([i0, i1, i2, i3]).map(|(_, out)| out.z);
                (0..n2).map(|i2| cosine(i2).filter(|z| *z > HORIZON)).collect()
            })
            .collect();
        held += cosines.iter().flatten().filter(|z| z.is_none()).count();
        for channel in 0..grid.channels() {
            let mut arcs: Vec<Vec<f64>> = Vec::with_capacity(n3);
            for (i3, cosines) in cosines.iter().enumerate() {
                let f = |(i2, z): (usize, &Option<f64>)| z.map_or(f64::NAN, |z| grid.at([i0, i1, i2, i3], channel) / z);
                let mut arc: Vec<f64> = cosines.iter().enumerate().map(f).collect();
                hold(&mut arc);
                arcs.push(arc);
            }
            for i2 in 0..n2 {
                let mut around: Vec<f64> = arcs.iter().map(|arc| arc[i2]).collect();
                hold(&mut around);
                for (i3, value) in around.into_iter().enumerate() {
                    grid.set([i0, i1, i2, i3], channel, if value.is_nan() { 0.0 } else { value });
                }
            }
        }
    }
    held
}

/// Fills missing values with the last value before them, or else with the first after them.
fn hold(values: &mut [f64]) {
    let first = values.iter().copied().find(|v| !v.is_nan()).unwrap_or(f64::NAN);
    values.iter_mut().fold(first, |last, value| {
        if value.is_nan() {
            *value = last;
        }
        *value
    });
}
