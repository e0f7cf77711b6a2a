use super::tables::BetaTables;
use super::{FitError, FreeParameter};
use crate::rig::Geometry;
use ndarray::Array2;

/// A physical model as a function of parameters: what a study's cloth, media and gloss give at the geometries of a
/// sample. Implemented where studies are known.
pub trait ForwardModel: Sync {
    fn geometries(&self) -> &[Geometry];

    /// Wavelengths in nm at which the model is evaluated.
    fn wavelengths_nm(&self) -> &[f64];

    /// What β at each wavelength adds to each channel of the sample: `[channel][wavelength]`.
    fn to_channels(&self) -> &Array2<f64>;

    /// Wavelengths in nm at which scattering is traced, ascending, among which the model interpolates.
    fn nodes_nm(&self) -> &[f64];

    /// Parameters that change how light is scattered, so that it must be traced anew. A point has a coordinate from 0
    /// to 1 for each, from its lower to its upper bound on its scale.
    fn traced(&self) -> &[FreeParameter];

    /// Parameters of the gloss, which is added in closed form.
    fn gloss_parameters(&self) -> &[FreeParameter];

    /// β of the gloss at each geometry for values of its parameters, of a white light's colour.
    ///
    /// # Errors
    /// [`FitError`] for values that the gloss cannot have.
    fn gloss(&self, values: &[f64]) -> Result<Vec<f64>, FitError>;

    /// Traces the light at a point. `added_mu_a_per_mm`: absorption of each node to trace with, near that of interest.
    /// `share`: of the particles of the study. Common random numbers: the same streams at every point.
    ///
    /// # Errors
    /// [`FitError`] for a cloth that cannot be woven or a medium that cannot be traced.
    fn trace(&self, point: &[f64], added_mu_a_per_mm: &[f64], share: f64) -> Result<ForwardRun, FitError>;
}

/// One evaluation of a [`ForwardModel`].
#[derive(Clone, Debug, PartialEq)]
pub struct ForwardRun {
    pub point: Vec<f64>,
    /// Values of the traced parameters, in their units.
    pub values: Vec<f64>,
    pub tables: BetaTables,
    /// Share of the study's particles that were traced.
    pub share: f64,
    /// Absorption of the study at each wavelength, 1/mm; 0 where it is free.
    pub mu_a_per_mm: Vec<f64>,
}

/// Lagrange weights of the nodes at a wavelength, in the logarithm of wavelength: scattering is a smooth function of
/// it. Beyond the nodes the nearest node's value holds.
pub fn node_weights(nodes_nm: &[f64], nm: f64) -> Vec<f64> {
    let [first, last] = [nodes_nm[0], nodes_nm[nodes_nm.len() - 1]].map(f64::ln);
    let x = nm.ln().clamp(first, last);
    (0..nodes_nm.len())
        .map(|k| {
            let at = nodes_nm[k].ln();
            let others = nodes_nm.iter().enumerate().filter(|(j, _)| *j != k);
            others.map(|(_, node)| (x - node.ln()) / (at - node.ln())).product()
        })
        .collect()
}
