use super::function::Spectrum;

/// Colour-matching functions of an observer, dimensionless; of the standard ones at 360..830 nm.
#[derive(Clone, Debug, PartialEq)]
pub struct ObserverTables {
    pub x_bar: Spectrum,
    pub y_bar: Spectrum,
    pub z_bar: Spectrum,
}
