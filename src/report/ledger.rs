use super::tables::rounded;
use super::{EnergyRow, Notice};
use crate::transport::{Column, Fraction};
use serde::Serialize;
use std::fmt::Write;

/// Range of one column of the ledger over all wavelengths and directions, because a mean alone hides the worst row.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LedgerRange {
    pub fraction: &'static str,
    pub lowest: f64,
    pub mean: f64,
    pub highest: f64,
}

/// Every column in the order of `energy.csv`; none without rows.
pub fn ledger_ranges(rows: &[EnergyRow]) -> Vec<LedgerRange> {
    if rows.is_empty() {
        return Vec::new();
    }
    let range = |column: Column| {
        let values = rows.iter().map(|row| row.column(column).value);
        LedgerRange {
            fraction: column.name(),
            lowest: values.clone().fold(f64::INFINITY, f64::min),
            mean: values.clone().sum::<f64>() / rows.len() as f64,
            highest: values.fold(f64::NEG_INFINITY, f64::max),
        }
    };
    Column::ALL.into_iter().map(range).collect()
}

/// A notice if fractions of the ledger lie outside 0 to 1, which noise alone can cause.
pub fn ledger_notice(rows: &[EnergyRow]) -> Option<Notice> {
    // The margin is for rounding.
    let beyond = |value: f64| !(-1e-6..=1.0 + 1e-6).contains(&value);
    let noisy = [Fraction::Ballistic, Fraction::Scattered, Fraction::Absorbed];
    let is_noise = |row: &&EnergyRow| noisy.into_iter().any(|fraction| beyond(row[fraction].value));
    match rows.iter().filter(is_noise).count() {
        0 => None,
        noisy => Some(Notice::LedgerNoise {
            noisy,
            rows: rows.len(),
        }),
    }
}

/// The ranges as a table for the terminal; empty without rows.
pub fn ledger_table(rows: &[EnergyRow]) -> String {
    let ranges = ledger_ranges(rows);
    let mut text = String::new();
    if ranges.is_empty() {
        return text;
    }
    let _ = writeln!(
        text,
        "{:<10} {:>12} {:>12} {:>12}   fraction of the incident flux, {} rows",
        "energy",
        "lowest",
        "mean",
        "highest",
        rows.len()
    );
    for range in ranges {
        let _ = writeln!(
            text,
            "{:<10} {:>12} {:>12} {:>12}",
            range.fraction,
            rounded(range.lowest),
            rounded(range.mean),
            rounded(range.highest)
        );
    }
    text
}
