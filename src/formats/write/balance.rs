//! What resampling does to hemispherical values, and how it is undone: each incidence is scaled back to the source's
//! value.

use super::sampling::ChannelMap;
use crate::goniometric::{Component, Hemispherical};
use crate::number::{count, shown};

/// Factors beyond these would bend values more than they mend them: the table cannot hold what the source does.
const FACTORS: std::ops::RangeInclusive<f64> = 0.5..=2.0;
/// Changes that a notice reports.
const TOLD: f64 = 5e-4;

/// A value before and after, at an incidence.
#[derive(Clone, Copy)]
struct Change {
    theta_i_deg: f64,
    source: f64,
    table: f64,
    /// Of both integrals together, estimated.
    error: f64,
}

impl Change {
    /// The error in words, two digits of it.
    fn integrated(&self) -> String {
        let rounded = format!("{:.1e}", self.error).parse().unwrap_or(self.error);
        format!("integrated to within {}", shown(rounded))
    }

    fn size(&self) -> f64 {
        (self.source / self.table - 1.0).abs()
    }
}

/// The largest change of a hemispherical value that was undone, and the largest one that was not.
#[derive(Default)]
pub(super) struct Balance {
    undone: Option<Change>,
    left: Option<Change>,
    /// Incidences whose hemisphere the source or the table does not cover.
    uncovered: usize,
}

fn keep_larger(kept: &mut Option<Change>, change: Change) {
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
            let change = Change {
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
                let change = Change {
                    theta_i_deg,
                    source,
                    table,
                    error,
                };
                keep_larger(&mut self.left, change);
            }
        }
    }

    pub(super) fn notice(&self, notices: &mut Vec<String>) {
        if let Some(c) = self.undone.filter(|c| c.size() > TOLD) {
            notices.push(format!(
                "hemispherical values are kept: values are scaled at each incidence and channel, by {:+.2} % at most, at \
                 incidence {} degrees, where the table alone has {:.5} for {:.5}, {}",
                100.0 * (c.source / c.table - 1.0),
                shown(c.theta_i_deg),
                c.table,
                c.source,
                c.integrated()
            ));
        }
        if let Some(c) = self.left.filter(|c| c.size() > TOLD) {
            notices.push(format!(
                "hemispherical values change by up to {:+.2} %: {:.5} becomes {:.5} at incidence {} degrees, {}",
                100.0 * (c.table / c.source - 1.0),
                c.source,
                c.table,
                shown(c.theta_i_deg),
                c.integrated()
            ));
        }
        if self.uncovered > 0 {
            notices.push(format!(
                "at {} of incidence the source does not cover the hemisphere: its hemispherical value is not kept there",
                count(self.uncovered, "direction")
            ));
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
