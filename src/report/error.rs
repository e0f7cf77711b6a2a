use std::path::PathBuf;

/// What can go wrong when a result is drawn or written.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    #[error("{picture} could not be drawn: {reason}")]
    Drawing { picture: String, reason: String },
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
