//! Graphs, tables and provenance: pure functions of one [`ReportData`], and the folder they are written to.
//!
//! [`render`] turns a result into named files in memory; [`OutputFolder`] is prepared before a simulation starts and
//! takes those files whole or not at all. Same data, same bytes.

mod chart;
mod graphs;
mod json;
mod ledger;
mod output;
mod result;
mod summary;
mod tables;

pub use graphs::{Graph, graphs};
pub use json::report_json;
pub use ledger::{LedgerRange, ledger_ranges, ledger_table};
pub use output::{OutputFolder, check_writable, write_whole};
pub use result::{
    AskedEffort, Convention, EffortNote, EnergyRow, InputDigest, PathsPerBatch, Provenance, ReachedPrecision,
    ReadingCount, ReportData, SampleNote, Table1Name, Table1Row,
};
pub use summary::{effort_line, summary};
pub use tables::{curves_csv, energy_csv, table1_csv, table1_markdown};

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
    #[error("{}: a file stands where a folder should be; name another folder or move the file", path.display())]
    FileInTheWay { path: PathBuf },
    #[error("{}: a folder stands where this file should be written; name another place or move the folder", path.display())]
    FolderInTheWay { path: PathBuf },
    #[error("{}: cannot be written; name a folder you may write to, or mend its permissions and free space", path.display())]
    NotWritable {
        path: PathBuf,
        #[source]
        cause: std::io::Error,
    },
}

/// One file of a report, complete in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedFile {
    pub name: String,
    pub bytes: Vec<u8>,
}

/// Every file of the report, tables first.
pub fn render(data: &ReportData) -> Result<Vec<NamedFile>, ReportError> {
    let file = |name: &str, bytes| NamedFile {
        name: name.to_owned(),
        bytes,
    };
    let mut files = vec![
        file("table1.csv", table1_csv(data)?),
        file("table1.md", table1_markdown(data).into_bytes()),
        file("curves.csv", curves_csv(data)?),
        file("energy.csv", energy_csv(data)?),
        file("report.json", report_json(data)?.into_bytes()),
    ];
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
    Ok(files)
}
