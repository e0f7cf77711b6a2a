use crate::spectrum::WavelengthGrid;

/// What the values of a row stand for.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Axis {
    Rgb,
    Xyz,
    Wavelengths(WavelengthGrid),
}

/// β and its standard error, one value a channel or wavelength.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Row {
    pub(super) theta_i_deg: f64,
    pub(super) theta_v_deg: f64,
    pub(super) beta: Vec<f64>,
    pub(super) se: Vec<f64>,
}
