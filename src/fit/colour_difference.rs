use super::error::FitError;
use super::readings::FitReadings;
use crate::colour::{ColourSystem, Convention, Lab, LinearRgb, delta_e_2000, delta_e_cmc};
use crate::rig::Geometry;
use crate::sample::SampleError;
use crate::spectrum::WavelengthGrid;
use ndarray::{Array2, ArrayView1};
use serde::Serialize;

/// Colour difference of a model from the sample at one geometry, against the perfect diffuser as white.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ColourDifference {
    pub theta_i_deg: f64,
    pub theta_v_deg: f64,
    pub delta_e_2000: f64,
    /// CMC 2:1, the sample being the standard.
    pub delta_e_cmc: f64,
}

/// Colour differences at the geometries of readings; none where the wavelengths cannot carry a colour, or the RGB space
/// has no inverse. RGB of a camera are taken as linear RGB of the convention's space.
///
/// # Errors
/// Tables that do not cover the wavelengths.
pub fn colour_differences(
    readings: &FitReadings,
    model: &Array2<f64>,
    convention: &Convention,
) -> Result<Option<Vec<ColourDifference>>, FitError> {
    let nm: Vec<f64> = readings
        .channels
        .iter()
        .filter_map(|channel| channel.wavelength_nm())
        .collect();
    let grid = match nm.is_empty() {
        true => WavelengthGrid::preprint(),
        false => WavelengthGrid::new(nm).map_err(SampleError::from)?,
    };
    let system = ColourSystem::new(&grid, convention.clone()).map_err(SampleError::from)?;
    let lab = |channels: ArrayView1<f64>| -> Option<Lab> {
        let [r, g, b, _] = readings.rgby_of(&channels.to_vec())?;
        system.lab_of_rgb(LinearRgb([r, g, b]))
    };
    let of = |place: usize, geometry: &Geometry| -> Option<ColourDifference> {
        let (sample, model) = (lab(readings.beta.row(place))?, lab(model.row(place))?);
        Some(ColourDifference {
            theta_i_deg: geometry.theta_i_deg,
            theta_v_deg: geometry.theta_v_deg,
            delta_e_2000: delta_e_2000(sample, model),
            delta_e_cmc: delta_e_cmc(sample, model, 2.0, 1.0),
        })
    };
    Ok(readings
        .geometries
        .iter()
        .enumerate()
        .map(|(place, geometry)| of(place, geometry))
        .collect())
}
