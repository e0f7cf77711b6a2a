//! The two ways to judge a law: to rounding, and by means over batches.

use super::gate::{Gate, GateVerdict, Law, Where};
use crate::number::significant;
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::cmp::Ordering;

/// Least standard error that a departure is divided by: the rounding of means over batches in double precision.
const ROUNDING_OF_MEANS: f64 = 1e-12;

/// Fraction of the tolerance below which no departure breaks a law in the mean, however small its standard error. Where
/// departures come from rare events, such as scattering in a nearly empty yarn, batches without any have almost no
/// spread, and Student's t does not apply.
const NEGLIGIBLE: f64 = 1e-2;

/// The two ways to judge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judge {
    /// Probability that a gate whose law holds breaks by chance.
    pub level: f64,
    /// As counted by `--paths`.
    pub paths: u64,
    /// Of the arithmetic behind the batches, in the unit of the tolerances: a smaller departure is rounding.
    pub precision: f64,
}

impl Judge {
    /// A law without chance: every departure is at most the tolerance. One that is no number breaks it.
    pub fn exact(&self, law: Law, departures: &[f64], tolerance: f64, place: impl Fn(usize) -> Where) -> Gate {
        // In this order NaN is the largest.
        let worst = (0..departures.len()).max_by(|&a, &b| departures[a].abs().total_cmp(&departures[b].abs()));
        let value = worst.map_or(0.0, |i| departures[i]);
        Gate {
            cells: departures.len(),
            worst: worst.map(place).unwrap_or_default(),
            value,
            tolerance,
            verdict: if value.abs() <= tolerance {
                GateVerdict::Holds
            } else {
                GateVerdict::Broken
            },
            ..Gate::undecided(law)
        }
    }

    /// The largest departure that is never called a breach of a law in the mean.
    fn floor(&self, tolerance: f64) -> f64 {
        self.precision.max(NEGLIGIBLE * tolerance)
    }

    /// The means of all cells are 0. `batches` are independent, `[batch][cell]`.
    pub fn zero(&self, law: Law, batches: &[Vec<f64>], tolerance: f64, place: impl Fn(usize) -> Where) -> Gate {
        self.means(law, batches, tolerance, |t| t.abs(), 2.0, place)
    }

    /// The means of all cells are 0 or less.
    pub fn at_most_zero(&self, law: Law, batches: &[Vec<f64>], tolerance: f64, place: impl Fn(usize) -> Where) -> Gate {
        self.means(law, batches, tolerance, |t| t, 1.0, place)
    }

    /// Student's t of every cell from the spread of its batches, all cells together after Šidák (1967): with n cells
    /// the joint p is 1 − (1 − p)ⁿ, exact for independent cells and too large, hence safe, for dependent ones. A cell
    /// can break the law only if its departure also exceeds [`Self::floor`].
    fn means(
        &self,
        law: Law,
        batches: &[Vec<f64>],
        tolerance: f64,
        size: fn(f64) -> f64,
        sides: f64,
        place: impl Fn(usize) -> Where,
    ) -> Gate {
        let estimates = estimates(batches);
        let floor = self.floor(tolerance);
        let t = |i: usize| {
            let [value, se]: [f64; 2] = estimates[i];
            let t = size(value / se.hypot(ROUNDING_OF_MEANS));
            if t.is_nan() { f64::INFINITY } else { t }
        };
        let beyond_floor = |i: usize| estimates[i][0].is_nan() || size(estimates[i][0]) > floor;
        let order = |&a: &usize, &b: &usize| (beyond_floor(a), t(a)).partial_cmp(&(beyond_floor(b), t(b)));
        let Some(worst) = (0..estimates.len()).max_by(|a, b| order(a, b).unwrap_or(Ordering::Equal)) else {
            return Gate::undecided(law);
        };
        let [value, se] = estimates[worst];
        let cells = estimates.len() as f64;
        let student = StudentsT::new(0.0, 1.0, (batches.len() - 1) as f64).ok();
        let p = student.map_or(f64::NAN, |student| {
            let one = (sides * student.sf(t(worst))).min(1.0);
            -(cells * (-one).ln_1p()).exp_m1()
        });
        // Beyond this a cell breaks the law.
        let critical = student.map_or(f64::NAN, |student| {
            let one = -((-self.level).ln_1p() / cells).exp_m1();
            -student.inverse_cdf(one / sides)
        });
        let largest_se = estimates.iter().map(|e| e[1]).fold(0.0, f64::max);
        // How many times the paths until no cell could hide a departure of the tolerance; one far below a bound hides
        // none.
        let hidden = |[value, se]: &[f64; 2]| {
            let room = if sides == 1.0 { value.min(0.0) } else { 0.0 };
            (critical * se / (tolerance - room)).powi(2)
        };
        let needed = estimates.iter().map(hidden).fold(0.0, f64::max);
        let resolved = floor < tolerance;
        let verdict = if p.is_nan() || beyond_floor(worst) && p < self.level {
            GateVerdict::Broken
        } else if needed <= 1.0 && resolved {
            GateVerdict::Holds
        } else {
            GateVerdict::Undecided
        };
        Gate {
            cells: estimates.len(),
            worst: place(worst),
            value,
            se,
            tolerance,
            largest_se,
            z: Some(value / se.hypot(ROUNDING_OF_MEANS)),
            p: Some(p),
            verdict,
            // A fifth more, since the error that says so is itself uncertain.
            paths_to_tell: (verdict == GateVerdict::Undecided && resolved)
                .then(|| (1.2 * needed * self.paths as f64).ceil() as u64),
            note: (!resolved).then(|| {
                format!(
                    "the arithmetic is good to {}, and no number of paths shows less; allow a larger tolerance",
                    significant(floor, 1)
                )
            }),
            ..Gate::undecided(law)
        }
    }
}

/// Mean of each cell and its standard error.
pub(super) fn estimates(batches: &[Vec<f64>]) -> Vec<[f64; 2]> {
    let Some(first) = batches.first() else {
        return Vec::new();
    };
    let n = batches.len() as f64;
    let mut means = vec![0.0; first.len()];
    for batch in batches {
        means.iter_mut().zip(batch).for_each(|(mean, x)| *mean += x / n);
    }
    let mut squares = vec![0.0; first.len()];
    for batch in batches {
        for ((square, x), mean) in squares.iter_mut().zip(batch).zip(&means) {
            *square += (x - mean) * (x - mean);
        }
    }
    means
        .into_iter()
        .zip(squares)
        .map(|(mean, square)| [mean, (square / (n * (n - 1.0))).sqrt()])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: Law = Law { name: "law", words: "" };
    const JUDGE: Judge = Judge {
        level: 1e-3,
        paths: 1000,
        precision: 1e-12,
    };

    fn batches(values: &[f64]) -> Vec<Vec<f64>> {
        values.iter().map(|&x| vec![x]).collect()
    }

    /// t = 3.0 with 9 degrees of freedom has p 0.01496 on both sides together (tables of Student's t).
    #[test]
    fn one_cell_has_students_p() {
        let spread = [-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0];
        let se = (10.0f64 / 90.0).sqrt();
        let shifted: Vec<f64> = spread.iter().map(|x| x + 3.0 * se).collect();
        let gate = JUDGE.zero(LAW, &batches(&shifted), 10.0, |_| Where::default());
        assert!((gate.p.unwrap() - 0.014956).abs() < 1e-5, "{gate:?}");
        assert_eq!(gate.verdict, GateVerdict::Holds);
        let one_sided = JUDGE.at_most_zero(LAW, &batches(&shifted), 10.0, |_| Where::default());
        assert!((one_sided.p.unwrap() - 0.007478).abs() < 1e-5);
        let below: Vec<f64> = shifted.iter().map(|x| -x - 100.0).collect();
        assert_eq!(
            JUDGE
                .at_most_zero(LAW, &batches(&below), 1e9, |_| Where::default())
                .verdict,
            GateVerdict::Holds
        );
    }

    #[test]
    fn too_few_paths_cannot_tell_and_say_how_many_would() {
        let values = [-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0];
        let gate = JUDGE.zero(LAW, &batches(&values), 0.1, |_| Where::default());
        assert_eq!(gate.verdict, GateVerdict::Undecided);
        // t of 1e-3 on both sides with 9 degrees of freedom is 4.781.
        let expected = 1.2 * (4.781 * (10.0f64 / 90.0).sqrt() / 0.1).powi(2) * 1000.0;
        assert!(
            (gate.paths_to_tell.unwrap() as f64 / expected - 1.0).abs() < 1e-3,
            "{gate:?}"
        );
    }

    /// A departure below the precision of the arithmetic or a hundredth of the tolerance is no breach, though every
    /// batch has it; one above either is. A tolerance below the precision leaves the law undecided.
    #[test]
    fn the_judge_knows_its_precision() {
        let verdict = |departure: f64, precision, tolerance| {
            let judge = Judge { precision, ..JUDGE };
            let gate = judge.zero(LAW, &batches(&[departure; 8]), tolerance, |_| Where::default());
            (gate.verdict, gate.paths_to_tell)
        };
        assert_eq!(verdict(1.86e-9, 1e-6, 2e-3), (GateVerdict::Holds, None));
        assert_eq!(verdict(1.9e-5, 1e-12, 2e-3), (GateVerdict::Holds, None));
        assert_eq!(verdict(-2.1e-5, 1e-6, 2e-3), (GateVerdict::Broken, None));
        // Scattering so rare that 64 batches of 187 paths have next to no spread: host and particles of index 1, seed
        // 1.
        assert_eq!(verdict(1.54e-4, 1e-6, 0.14), (GateVerdict::Holds, None));
        assert_eq!(verdict(1.1e-6, 1e-6, 1e-5), (GateVerdict::Broken, None));
        assert_eq!(verdict(0.0, 1e-6, 1e-7), (GateVerdict::Undecided, None));
        // The cell beyond the floor is shown, not the one with the larger t below it.
        let mut two = vec![vec![1e-7, 0.01], vec![1e-7, 0.011]];
        two.extend(two.clone());
        let gate = JUDGE.zero(LAW, &two, 1.0, |i| Where::named(i.to_string()));
        assert_eq!(gate.worst.at, "1", "{gate:?}");
    }

    /// A cell that no batch changes is known to rounding; what is no number breaks a law.
    #[test]
    fn no_spread_and_no_number() {
        assert_eq!(
            JUDGE.zero(LAW, &batches(&[0.0; 8]), 0.1, |_| Where::default()).verdict,
            GateVerdict::Holds
        );
        assert_eq!(
            JUDGE.zero(LAW, &batches(&[2e-3; 8]), 0.1, |_| Where::default()).verdict,
            GateVerdict::Broken
        );
        assert_eq!(
            JUDGE
                .zero(LAW, &batches(&[f64::NAN; 8]), 0.1, |_| Where::default())
                .verdict,
            GateVerdict::Broken
        );
        assert_eq!(
            JUDGE.exact(LAW, &[0.0, f64::NAN], 1.0, |_| Where::default()).verdict,
            GateVerdict::Broken
        );
        assert_eq!(
            JUDGE.exact(LAW, &[0.0, -1e-13], 1e-12, |_| Where::default()).verdict,
            GateVerdict::Holds
        );
    }
}
