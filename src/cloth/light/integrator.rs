use super::{LitBatch, LitViews};
use crate::yarn::{YarnError, YarnResponse};

/// A method to compute the brightness factor of a cloth.
pub trait Integrator: Sync {
    /// Brightness factors of batch `batch`, a function of its arguments alone. `responses` are f* of the batch, of warp
    /// and weft, or one if they are the same yarn; integrators that do not use f* ignore them.
    ///
    /// # Errors
    /// [`YarnError`] if f* has another grid or other wavelengths than the scene.
    fn brightness(
        &self,
        responses: &[YarnResponse],
        lit: &[LitViews],
        batch: usize,
    ) -> Result<Vec<LitBatch>, YarnError>;
}
