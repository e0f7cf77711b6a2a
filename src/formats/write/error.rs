use crate::colour::ColourError;
use crate::goniometric::Format;

/// Why data were not written.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WriteError {
    #[error("expected a format that is written, found {format}, which is read but not written; take {written}")]
    NotWritten {
        format: Format,
        /// Those that are.
        written: String,
    },
    #[error("expected {holds}, which {format} holds, found {found}; {remedy}")]
    CannotHold {
        format: Format,
        holds: String,
        found: String,
        remedy: String,
    },
    #[error("the source's values are of a scale it does not state; give the factor to 1/sr (--scale)")]
    Unscaled,
    #[error(
        "{format} needs f at incidence {theta_i_deg:.4} degrees towards {theta_o_deg:.4} degrees, azimuth \
         {phi_o_deg:.4}, and the source has nothing near it at that azimuth; take a format that holds single readings \
         (csv, astm)"
    )]
    NotMeasured {
        format: Format,
        theta_i_deg: f64,
        theta_o_deg: f64,
        phi_o_deg: f64,
    },
    #[error(transparent)]
    Colour(#[from] ColourError),
}
