//! The classical models. One more is its own file and a row here.

mod facets;
mod lambert_charlie;
mod lambert_cook_torrance;
mod lambert_ggx;
mod oren_nayar;

pub use lambert_cook_torrance::LambertCookTorrance;

use super::{ClassicalModel, ShadingError};
use crate::spectrum::UnknownName;

static MODELS: &[&ClassicalModel] = &[
    &lambert_cook_torrance::MODEL,
    &oren_nayar::MODEL,
    &lambert_ggx::MODEL,
    &lambert_charlie::MODEL,
];

/// Ids of the models that a report compares by default: the preprint's.
pub const DEFAULT_MODELS: &[&str] = &["lambert-cook-torrance"];

/// Every classical model.
pub fn classical_models() -> &'static [&'static ClassicalModel] {
    MODELS
}

/// The classical model of this id.
///
/// # Errors
/// An id that no model has.
pub fn classical_model(id: &str) -> Result<&'static ClassicalModel, ShadingError> {
    let found = MODELS.iter().find(|model| model.id == id);
    let known = MODELS.iter().map(|model| model.id);
    Ok(found.ok_or_else(|| UnknownName::new("classical model", id, known))?)
}
