//! Azimuths of a grid all around: a circle that is closed, and the seam between its ends.

use std::f64::consts::TAU;

use super::Grid;

impl Grid {
    /// The same table with azimuths that close the circle ([`Axis::closed`]); nothing else changes.
    pub(crate) fn closed(&self) -> Self {
        let mut grid = self.clone();
        for axis in [1, 3] {
            grid = grid.closed_along(axis).unwrap_or(grid);
        }
        grid
    }

    fn closed_along(&self, axis: usize) -> Option<Self> {
        let (closed, shares) = self.axes[axis].closed()?;
        let mut axes = self.axes.clone();
        axes[axis] = closed;
        let [n0, n1, n2, n3] = std::array::from_fn(|axis| axes[axis].nodes_rad().len());
        let mut values = Vec::with_capacity(n0 * n1 * n2 * n3 * self.channels);
        for i in 0..n0 * n1 * n2 * n3 {
            let node = [i / (n3 * n2 * n1), i / (n3 * n2) % n1, i / n3 % n2, i % n3];
            for channel in 0..self.channels {
                let part = |(own, share): (usize, f64)| {
                    let mut at = node;
                    at[axis] = own;
                    if share > 0.0 { share * self.at(at, channel) } else { 0.0 }
                };
                values.push(shares[node[axis]].into_iter().map(part).sum());
            }
        }
        let order = [0, 1, 2, 3, 4];
        Some(Self::new(
            self.parameters.clone(),
            axes,
            self.fold,
            self.channels,
            order,
            values,
        ))
    }

    /// Largest difference between values at azimuths 360° apart (the same direction), relative to the larger value; 0
    /// if the table has no such pair.
    pub(crate) fn seam(&self) -> f64 {
        let shape = self.shape();
        let mut largest = 0.0f64;
        for axis in [1, 3] {
            let nodes = self.axes[axis].nodes_rad();
            let last = nodes.len() - 1;
            if last == 0 || (nodes[last] - nodes[0] - TAU).abs() > 1e-6 {
                continue;
            }
            let [a, b, c] = match axis {
                1 => [0, 2, 3],
                _ => [0, 1, 2],
            };
            for place in 0..shape[a] * shape[b] * shape[c] {
                let mut node = [0; 4];
                node[a] = place / (shape[b] * shape[c]);
                node[b] = place / shape[c] % shape[b];
                node[c] = place % shape[c];
                let mut end = node;
                end[axis] = last;
                for channel in 0..self.channels {
                    let (first, end) = (self.at(node, channel), self.at(end, channel));
                    let most = first.abs().max(end.abs());
                    if most > 0.0 {
                        largest = largest.max((first - end).abs() / most);
                    }
                }
            }
        }
        largest
    }
}
