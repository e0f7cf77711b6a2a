use super::tables::rounded;
use super::{EnergyRow, Notice};
use serde::Serialize;
use std::fmt::Write;

/// Range of one fraction of the ledger over all wavelengths and directions: the mean of a ledger says nothing, its worst
/// row does.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LedgerRange {
    pub fraction: &'static str,
    pub lowest: f64,
    pub mean: f64,
    pub highest: f64,
}

/// A fraction's name and where it stands.
type Column = (&'static str, fn(&EnergyRow) -> f64);

/// Every fraction in the order of `energy.csv`; none without rows.
pub fn ledger_ranges(rows: &[EnergyRow]) -> Vec<LedgerRange> {
    let columns: [Column; 7] = [
        ("reflected", |row| row.reflected),
        ("ballistic", |row| row.ballistic),
        ("scattered", |row| row.scattered),
        ("absorbed", |row| row.absorbed),
        ("roulette", |row| row.roulette),
        ("residual", |row| row.residual),
        ("sharing", |row| row.sharing),
    ];
    if rows.is_empty() {
        return Vec::new();
    }
    columns
        .into_iter()
        .map(|(fraction, of)| LedgerRange {
            fraction,
            lowest: rows.iter().map(of).fold(f64::INFINITY, f64::min),
            mean: rows.iter().map(of).sum::<f64>() / rows.len() as f64,
            highest: rows.iter().map(of).fold(f64::NEG_INFINITY, f64::max),
        })
        .collect()
}

/// The notice of a ledger with fractions beyond 0 to 1, which noise alone can do.
pub fn ledger_notice(rows: &[EnergyRow]) -> Option<Notice> {
    // Beyond rounding.
    let beyond = |value: f64| !(-1e-6..=1.0 + 1e-6).contains(&value);
    let is_noise = |row: &&EnergyRow| [row.ballistic, row.scattered, row.absorbed].into_iter().any(beyond);
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
