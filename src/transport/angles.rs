use crate::optics::{Phase, PhaseTable};
use std::hint::select_unpredictable;

/// An angle drawn from a phase function.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Angle {
    pub cos_theta: f64,
    /// Interval between the table's nodes it lies in, and where in it from the first node (0) to the second (1).
    pub interval: usize,
    pub place: f64,
}

/// Phase functions of several wavelengths, made ready for drawing from any of them without a branch or a search.
#[derive(Clone, Debug)]
pub(super) enum Angles<'a> {
    /// Tables on the same nodes: Walker's alias method chooses the interval, whose linear density is then inverted.
    Tables {
        intervals: usize,
        columns: Vec<Column>,
    },
    Functions(Vec<&'a Phase>),
}

/// One interval of one table.
#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    /// Share of the column that is the interval's own; the rest belongs to the interval `alias`.
    own: f64,
    alias: usize,
    /// Densities at the interval's nodes.
    low: f64,
    high: f64,
}

impl<'a> Angles<'a> {
    pub fn new(phases: &[&'a Phase]) -> Self {
        match common_tables(phases) {
            Some((nodes, tables)) => Self::Tables {
                intervals: nodes - 1,
                columns: tables.iter().flat_map(|table| columns(table)).collect(),
            },
            None => Self::Functions(phases.to_vec()),
        }
    }

    /// Draws from the phase function of one wavelength with an even number.
    #[inline(always)]
    pub fn draw(&self, wavelength: usize, u: f64) -> Angle {
        match self {
            Self::Tables { intervals, columns } => {
                let intervals = *intervals;
                let of_wavelength = &columns[wavelength * intervals..(wavelength + 1) * intervals];
                let at = u * intervals as f64;
                let k = (at as usize).min(intervals - 1);
                let rest = at - k as f64;
                let column = &of_wavelength[k];
                // The choice is a matter of chance: a branch on it would be mispredicted as often.
                let own = rest < column.own;
                let v = select_unpredictable(own, rest, rest - column.own)
                    / select_unpredictable(own, column.own, 1.0 - column.own);
                let k = select_unpredictable(own, k, column.alias);
                let Column { low, high, .. } = of_wavelength[k];
                let place = v * (low + high) / (low + (low * low + (high - low) * (high + low) * v).max(0.0).sqrt());
                let step = 1.0 / intervals as f64;
                let t = k as f64 * step;
                Angle {
                    cos_theta: 1.0 - 2.0 * (t * t + place * step * (2.0 * t + step)),
                    interval: k,
                    place,
                }
            }
            Self::Functions(phases) => Angle {
                cos_theta: phases[wavelength].sample(u),
                interval: 0,
                place: 0.0,
            },
        }
    }
}

/// The tables behind the phase functions and the number of their nodes, if all are tables on the same nodes.
pub(super) fn common_tables<'a>(phases: &[&'a Phase]) -> Option<(usize, Vec<&'a PhaseTable>)> {
    let tables: Vec<&PhaseTable> = phases
        .iter()
        .filter_map(|phase| match phase {
            Phase::Table(table) => Some(table),
            Phase::HenyeyGreenstein(_) => None,
        })
        .collect();
    let nodes = tables.first()?.density().len();
    let alike = tables.len() == phases.len() && tables.iter().all(|table| table.density().len() == nodes);
    alike.then_some((nodes, tables))
}

/// Walker's columns (Vose 1991) of the intervals' probabilities.
fn columns(table: &PhaseTable) -> Vec<Column> {
    let density = table.density();
    let intervals = density.len() - 1;
    // Interval k is 2(2k + 1)/n² wide in cos θ.
    let mut share: Vec<f64> = (0..intervals)
        .map(|k| (density[k] + density[k + 1]) * (2 * k + 1) as f64)
        .collect();
    let total: f64 = share.iter().sum();
    share.iter_mut().for_each(|s| *s *= intervals as f64 / total);
    let mut columns: Vec<Column> = (0..intervals)
        .map(|k| Column {
            own: 1.0,
            alias: k,
            low: density[k],
            high: density[k + 1],
        })
        .collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..intervals).partition(|&k| share[k] < 1.0);
    while let (Some(poor), Some(&rich)) = (small.pop(), large.last()) {
        columns[poor].own = share[poor];
        columns[poor].alias = rich;
        share[rich] -= 1.0 - share[poor];
        if share[rich] < 1.0 {
            large.pop();
            small.push(rich);
        }
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stratified draws reproduce the distribution: mean cosine is g, and the share of each interval is its integral.
    #[test]
    fn draws_follow_the_table() {
        let table = PhaseTable::from_density(181, |c| 0.1 + (1.0 + c).powi(4)).unwrap();
        let (g, density) = (table.g(), table.density().to_vec());
        let phase = Phase::Table(table);
        let angles = Angles::new(&[&phase, &phase]);
        let n = 2_000_000;
        let mut mean = 0.0;
        let mut shares = vec![0.0; 180];
        for i in 0..n {
            let angle = angles.draw(1, (f64::from(i) + 0.5) / f64::from(n));
            mean += angle.cos_theta / f64::from(n);
            shares[angle.interval] += 1.0 / f64::from(n);
            assert!((0.0..=1.0).contains(&angle.place));
        }
        assert!((mean - g).abs() < 1e-6, "{mean} {g}");
        for (k, share) in shares.iter().enumerate() {
            let expected =
                std::f64::consts::PI * (density[k] + density[k + 1]) * 2.0 * (2 * k + 1) as f64 / (180.0 * 180.0);
            assert!((share - expected).abs() < 2e-6, "interval {k}: {share} {expected}");
        }
    }
}
