//! The result of a study and its report: graphs, tables and documents are pure functions of one [`ReportData`].
//!
//! [`render`] turns a result into named files in memory; a [`crate::output::ReportFolder`] is prepared before a
//! simulation starts and takes those files whole or not at all. Same data, same bytes.

mod approximations;
mod charts;
mod energy_row;
mod error;
mod json;
mod ledger;
mod notice;
mod render;
mod result;
mod result_file;
mod summary;
mod sweep_table;
mod tables;

pub use approximations::{ApproximationRow, Approximations, LocalityRow};
pub use charts::sweep_charts;
pub use charts::{FitCurves, Graph, Outline, chart_font, fit_panels, graphs};
pub use energy_row::EnergyRow;
pub use error::ReportError;
pub use json::report_json;
pub use ledger::{LedgerRange, ledger_notice, ledger_ranges, ledger_table};
pub use notice::{Fallback, GrazingGain, LongPaths, Notice, RatioOf, TableRatio};
pub use render::{file_names, known_names, render};
pub use result::{
    AskedEffort, ConventionRatios, EffortNote, InputDigest, PathsPerBatch, Provenance, ReachedPrecision, ReadingCount,
    ReportData, SampleNote,
};
pub use result_file::{FinishedResult, RESULT, read_result, result_json, result_path};
pub use summary::{effort_line, summary};
pub use sweep_table::{SweepPoint, SweepTable, SweptValue};
pub use tables::{approximations_csv, curves_csv, energy_csv, locality_csv, table1_csv, table1_markdown};
