//! What resampling does to hemispherical values, and how it is undone: each incidence is scaled back to the source's
//! value.

use super::notice::{HemisphericalChange, WriteNotice};
use super::sampling::ChannelMap;
use crate::goniometric::{Component, Hemispherical};

/// Factors beyond these would bend values more than they mend them: the table cannot hold what the source does.
const FACTORS: std::ops::RangeInclusive<f64> = 0.5..=2.0;
/// Changes that a notice reports.
const TOLD: f64 = 5e-4;

/// The largest change of a hemispherical value that was undone, and the largest one that was not.
#[derive(Default)]
pub(super) struct Balance {
    undone: Option<HemisphericalChange>,
    left: Option<HemisphericalChange>,
    /// Incidences whose hemisphere the source or the table does not cover.
    uncovered: usize,
}

fn keep_larger(kept: &mut Option<HemisphericalChange>, change: HemisphericalChange) {
    if kept.is_none_or(|kept| kept.size() < change.size()) {
        *kept = Some(change);
    }
}

impl Balance {
    /// What each channel of a table is to be multiplied by at an incidence for the source's hemispherical values; 1
    /// where that cannot be known.
    pub(super) fn factors(
        &mut self,
        theta_i_deg: f64,
        source: Option<&Hemispherical>,
        table: Option<&Hemispherical>,
        channels: usize,
    ) -> Vec<f64> {
        let (Some(source), Some(table)) = (source, table) else {
            self.uncovered += 1;
            return vec![1.0; channels];
        };
        if source.measured < 1.0 || table.measured < 1.0 {
            self.uncovered += 1;
            return vec![1.0; channels];
        }
        let most = source.values.iter().copied().fold(0.0, f64::max);
        let factor = |channel: usize| {
            let (value, known) = (source.values[channel], table.values[channel]);
            let errors = source.errors[channel] + table.errors[channel];
            // A channel that is black but for rounding, and a difference that the integration may have made.
            if value <= 1e-6 * most || known <= 0.0 || (value - known).abs() <= errors {
                return 1.0;
            }
            let (source, table) = (value, known);
            let change = HemisphericalChange {
                theta_i_deg,
                source,
                table,
                error: errors,
            };
            if FACTORS.contains(&(source / table)) {
                keep_larger(&mut self.undone, change);
                source / table
            } else {
                keep_larger(&mut self.left, change);
                1.0
            }
        };
        (0..channels).map(factor).collect()
    }

    pub(super) fn merge(&mut self, other: Self) {
        for (kept, change) in [(&mut self.undone, other.undone), (&mut self.left, other.left)] {
            change.into_iter().for_each(|change| keep_larger(kept, change));
        }
        self.uncovered += other.uncovered;
    }

    /// A hemispherical value that the format itself changes.
    pub(super) fn leave(&mut self, theta_i_deg: f64, source: &Hemispherical, table: &Hemispherical) {
        let errors = source.errors.iter().zip(&table.errors).map(|(a, b)| a + b);
        for ((&source, &table), error) in source.values.iter().zip(&table.values).zip(errors) {
            if source > 0.0 && table > 0.0 {
                let change = HemisphericalChange {
                    theta_i_deg,
                    source,
                    table,
                    error,
                };
                keep_larger(&mut self.left, change);
            }
        }
    }

    pub(super) fn notice(&self, notices: &mut Vec<WriteNotice>) {
        if let Some(c) = self.undone.filter(|c| c.size() > TOLD) {
            notices.push(WriteNotice::BalanceKept(c));
        }
        if let Some(c) = self.left.filter(|c| c.size() > TOLD) {
            notices.push(WriteNotice::BalanceChanged(c));
        }
        if self.uncovered > 0 {
            notices.push(WriteNotice::NotCovered {
                directions: self.uncovered,
            });
        }
    }
}

/// A hemispherical value in the channels of a format; any error may go into each of them.
pub(super) fn mapped(of: &Hemispherical, map: &ChannelMap) -> Hemispherical {
    let values = map.apply(&of.values);
    Hemispherical {
        errors: vec![of.errors.iter().sum(); values.len()],
        values,
        measured: of.measured,
    }
}

/// The source's hemispherical value at a direction of incidence in degrees.
pub(super) fn hemispherical(of: &Component, theta_i_deg: f64, phi_i_deg: f64) -> Option<Hemispherical> {
    of.directional_hemispherical(theta_i_deg.to_radians(), phi_i_deg.to_radians())
}
