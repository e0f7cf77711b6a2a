//! Angles as an instrument's encoder reads them back, and as they were meant.

use serde::Serialize;

use super::row::SampleRow;

/// Incidences in degrees that differ by no more are one incidence, and so far a reading may lie from the geometry it is
/// compared at.
pub const ANGLE_TOLERANCE_DEG: f64 = 0.25;
/// An angle no farther from a whole number of degrees, and no farther than a quarter of the curve's mean step, is that
/// number.
const WHOLE_DEG: f64 = 0.1;

/// What was made of angles that an encoder read back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct AnglesRead {
    /// Readings whose angles were taken as others.
    pub moved: usize,
    /// Largest difference in degrees.
    pub largest_deg: f64,
    /// Readings that were combined with others of the same geometry.
    pub combined: usize,
}

/// A reading at its nominal angles and at those read.
struct Placed {
    row: SampleRow,
    read_deg: [f64; 2],
}

/// Rows at their nominal angles, ascending, every geometry once.
///
/// Incidences within [`ANGLE_TOLERANCE_DEG`] of each other become their mean, and angles within 0.1 degrees of a whole
/// number become that. Readings of one geometry become their mean; its standard error is the larger of what theirs
/// give, as independent, and of what their scatter gives.
pub(super) fn nominal(rows: Vec<SampleRow>) -> (Vec<SampleRow>, AnglesRead) {
    let mut placed: Vec<Placed> = rows
        .into_iter()
        .map(|row| Placed {
            read_deg: [row.theta_i_deg, row.theta_v_deg],
            row,
        })
        .collect();
    sort(&mut placed);
    let near = |a: &Placed, b: &Placed| b.row.theta_i_deg - a.row.theta_i_deg <= ANGLE_TOLERANCE_DEG;
    for curve in placed.chunk_by_mut(near) {
        let span = curve[curve.len() - 1].row.theta_i_deg - curve[0].row.theta_i_deg;
        let mean = curve.iter().map(|placed| placed.row.theta_i_deg).sum::<f64>() / curve.len() as f64;
        for placed in curve {
            let incidence = match span {
                0.0 => placed.row.theta_i_deg,
                _ if span <= 2.0 * ANGLE_TOLERANCE_DEG => (mean * 100.0).round() / 100.0,
                // Incidences in steps finer than the tolerance are meant.
                _ => placed.row.theta_i_deg,
            };
            placed.row.theta_i_deg = whole(incidence, WHOLE_DEG).max(0.0);
        }
    }
    sort(&mut placed);
    for curve in placed.chunk_by_mut(|a, b| a.row.theta_i_deg == b.row.theta_i_deg) {
        let range = curve[curve.len() - 1].row.theta_v_deg - curve[0].row.theta_v_deg;
        let steps = curve.len() - 1;
        // One view, or repeats of one, have no step.
        let within = if range <= 2.0 * WHOLE_DEG {
            WHOLE_DEG
        } else {
            WHOLE_DEG.min(range / steps as f64 / 4.0)
        };
        for placed in curve {
            placed.row.theta_v_deg = whole(placed.row.theta_v_deg, within);
        }
    }
    sort(&mut placed);
    let mut read = AnglesRead::default();
    for Placed { row, read_deg } in &placed {
        let moved = (row.theta_i_deg - read_deg[0])
            .abs()
            .max((row.theta_v_deg - read_deg[1]).abs());
        if moved > 0.0 {
            read.moved += 1;
            read.largest_deg = read.largest_deg.max(moved);
        }
    }
    let same =
        |a: &Placed, b: &Placed| a.row.theta_i_deg == b.row.theta_i_deg && a.row.theta_v_deg == b.row.theta_v_deg;
    let mut rows = Vec::new();
    for repeats in placed.chunk_by(same) {
        if repeats.len() > 1 {
            read.combined += repeats.len();
        }
        rows.push(mean(repeats));
    }
    (rows, read)
}

/// Rows at the angles that were read, ascending: of angles that are none in degrees.
pub(super) fn as_read(mut rows: Vec<SampleRow>) -> (Vec<SampleRow>, AnglesRead) {
    rows.sort_by(|a, b| (a.theta_i_deg.total_cmp(&b.theta_i_deg)).then(a.theta_v_deg.total_cmp(&b.theta_v_deg)));
    (rows, AnglesRead::default())
}

fn sort(placed: &mut [Placed]) {
    placed.sort_by(|a, b| {
        (a.row.theta_i_deg.total_cmp(&b.row.theta_i_deg)).then(a.row.theta_v_deg.total_cmp(&b.row.theta_v_deg))
    });
}

/// The whole number within reach, else the angle itself; never −0.
fn whole(angle_deg: f64, within_deg: f64) -> f64 {
    let whole = angle_deg.round();
    if (angle_deg - whole).abs() <= within_deg {
        whole + 0.0
    } else {
        angle_deg
    }
}

fn mean(repeats: &[Placed]) -> SampleRow {
    let first = &repeats[0].row;
    let count = repeats.len() as f64;
    if repeats.len() == 1 {
        return first.clone();
    }
    let (mut beta, mut se) = (Vec::new(), Vec::new());
    for k in 0..first.beta.len() {
        let values = || repeats.iter().map(|placed| placed.row.beta[k]);
        let mean = values().sum::<f64>() / count;
        let scatter = values().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0) / count;
        let stated = repeats.iter().map(|placed| placed.row.se[k].powi(2)).sum::<f64>() / (count * count);
        beta.push(mean);
        se.push(scatter.max(stated).sqrt());
    }
    SampleRow {
        beta,
        se,
        ..first.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(theta_i_deg: f64, theta_v_deg: f64, beta: f64, se: f64) -> SampleRow {
        SampleRow {
            theta_i_deg,
            theta_v_deg,
            beta: vec![beta],
            se: vec![se],
        }
    }

    fn angles(rows: &[SampleRow]) -> Vec<(f64, f64)> {
        rows.iter().map(|row| (row.theta_i_deg, row.theta_v_deg)).collect()
    }

    #[test]
    fn encoder_noise_is_removed_and_repeats_are_combined() {
        let rows = vec![
            row(30.02, -59.98, 0.1, 0.003),
            row(29.9, 0.03, 0.2, 0.003),
            row(30.06, -0.04, 0.4, 0.003),
            row(-0.01, 44.7, 0.3, 0.003),
        ];
        let (rows, read) = nominal(rows);
        assert_eq!(angles(&rows), [(0.0, 44.7), (30.0, -60.0), (30.0, 0.0)]);
        assert_eq!((read.moved, read.combined), (4, 2));
        assert!((read.largest_deg - 0.1).abs() < 1e-9);
        // Mean of 0.2 and 0.4; their scatter, 0.2/sqrt(2)/sqrt(2), exceeds 0.003/sqrt(2).
        assert!((rows[2].beta[0] - 0.3).abs() < 1e-15 && (rows[2].se[0] - 0.1).abs() < 1e-15);
        assert_eq!(rows[1].se, [0.003]);
    }

    #[test]
    fn fine_steps_are_kept() {
        let views: Vec<SampleRow> = (-10..=10).map(|k| row(45.0, 0.1 * f64::from(k), 0.3, 0.0)).collect();
        let (rows, read) = nominal(views.clone());
        assert_eq!(rows.len(), 21);
        assert_eq!((read.moved, read.combined), (0, 0));
        let incidences: Vec<SampleRow> = (0..9).map(|k| row(30.0 + 0.2 * f64::from(k), 0.0, 0.3, 0.0)).collect();
        assert_eq!(nominal(incidences).0.len(), 9);
        // Angles written with a decimal that is no noise.
        assert_eq!(angles(&nominal(vec![row(22.5, 36.87, 0.3, 0.0)]).0), [(22.5, 36.87)]);
    }
}
