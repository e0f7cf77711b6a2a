use super::{LitBatch, LitViews};
use crate::yarn::{YarnError, YarnResponse};

/// A way to work out how bright a cloth looks.
pub trait Integrator: Sync {
    /// Brightness factors of batch number `batch`, the same whenever and wherever it is made. `responses` are f* of the batch:
    /// of warp and weft, or one where they are the same yarn; a way that needs none takes none.
    ///
    /// # Errors
    /// f* on another grid, or at other wavelengths, than the scene has.
    fn brightness(
        &self,
        responses: &[YarnResponse],
        lit: &[LitViews],
        batch: usize,
    ) -> Result<Vec<LitBatch>, YarnError>;
}
