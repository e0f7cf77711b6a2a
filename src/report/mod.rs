//! Graphs, tables and provenance: pure functions of one [`ReportData`].
//!
//! [`render`] turns a result into named files in memory; a [`crate::output::ReportFolder`] is prepared before a simulation starts
//! and takes those files whole or not at all. Same data, same bytes.

mod approximations;
mod chart;
mod energy_row;
mod graphs;
mod json;
mod ledger;
mod notice;
mod result;
mod result_file;
mod summary;
mod tables;

pub use approximations::{ApproximationRow, Approximations, LocalityRow};
pub use chart::chart_font;
pub use energy_row::EnergyRow;
pub use graphs::{Graph, graphs};
pub use json::report_json;
pub use ledger::{LedgerRange, ledger_notice, ledger_ranges, ledger_table};
pub use notice::{Fallback, GrazingGain, LongPaths, Notice, RatioOf, TableRatio};
pub use result::{
    AskedEffort, Convention, EffortNote, InputDigest, PathsPerBatch, Provenance, ReachedPrecision, ReadingCount,
    ReportData, SampleNote, Table1Name, Table1Row,
};
pub use result_file::{RESULT, read_result, result_json};
pub use summary::{effort_line, summary};
pub use tables::{approximations_csv, curves_csv, energy_csv, locality_csv, table1_csv, table1_markdown};

use crate::output::NamedFile;
use rayon::prelude::*;
use std::path::PathBuf;

/// What can go wrong when a result is drawn or written.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    #[error("graph {graph} could not be drawn: {reason}")]
    Drawing { graph: usize, reason: String },
    #[error("the table could not be written")]
    Csv(#[from] csv::Error),
    #[error("report.json could not be written")]
    Json(#[from] serde_json::Error),
    #[error("the result names no sample: expected one or more; run its study again")]
    NoSample,
    #[error("{}: expected the result of a report, format version 2, found {found}; {remedy}", path.display())]
    NoResult {
        path: PathBuf,
        found: String,
        remedy: &'static str,
    },
}

/// Names of the tables of [`render`], and of its document.
const TABLES: [&str; 6] = [
    "table1.csv",
    "table1.md",
    "curves.csv",
    "energy.csv",
    "report.json",
    RESULT,
];
/// Those of a result with [`Approximations`].
const APPROXIMATIONS: [&str; 2] = ["approximations.csv", "locality.csv"];

/// Names of the files that [`render`] makes of a result with so many incidences, with approximations or without.
pub fn file_names(incidences: usize, approximations: bool) -> Vec<String> {
    let graphs = (1..=2 * incidences).flat_map(|n| [format!("graph{n}.svg"), format!("graph{n}.png")]);
    let tables = TABLES.iter().chain(APPROXIMATIONS.iter().filter(|_| approximations));
    tables.map(|name| (*name).to_owned()).chain(graphs).collect()
}

/// Every file of the report, tables first.
pub fn render(data: &ReportData) -> Result<Vec<NamedFile>, ReportError> {
    let file = |name: &str, bytes| NamedFile {
        name: name.to_owned(),
        bytes,
    };
    let contents = [
        table1_csv(data)?,
        table1_markdown(data).into_bytes(),
        curves_csv(data)?,
        energy_csv(data)?,
        report_json(data)?.into_bytes(),
        result_json(data)?,
    ];
    let tables = TABLES.into_iter().zip(contents);
    let mut files: Vec<NamedFile> = tables.map(|(name, bytes)| file(name, bytes)).collect();
    let pictures: Result<Vec<[NamedFile; 2]>, ReportError> = graphs(data)
        .par_iter()
        .map(|graph| {
            Ok([
                file(&format!("graph{}.svg", graph.number()), graph.svg()?.into_bytes()),
                file(&format!("graph{}.png", graph.number()), graph.png()?),
            ])
        })
        .collect();
    files.extend(pictures?.into_iter().flatten());
    if let Some(approximations) = &data.approximations {
        files.push(file(APPROXIMATIONS[0], approximations_csv(approximations)?));
        files.push(file(APPROXIMATIONS[1], locality_csv(approximations)?));
    }
    Ok(files)
}
