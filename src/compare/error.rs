use super::SourceId;

/// Why there is nothing to compare.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CompareError {
    #[error("a standard error needs 2 or more Monte Carlo batches, found {found}; trace in more batches")]
    TooFewBatches { found: usize },
    #[error("{what}: expected {expected} geometries, found {found}")]
    Length {
        what: String,
        expected: usize,
        found: usize,
    },
    #[error("{what}, geometry {index}: expected finite values, found {found:?}")]
    NotFinite {
        what: String,
        index: usize,
        found: Vec<f64>,
    },
    #[error("nothing of the sample was measured at the rig's geometries: expected one reading or more")]
    NoReading,
    #[error("sources: expected a different id for each, found {id} twice; rename one of them")]
    SameId { id: SourceId },
}
