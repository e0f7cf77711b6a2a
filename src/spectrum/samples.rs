use super::error::SpectrumError;
use super::grid::WavelengthGrid;

/// Finite values at exactly the wavelengths of one grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    grid: WavelengthGrid,
    values: Vec<f64>,
}

impl Samples {
    /// `name` is what an error calls these values.
    pub fn new(name: &str, grid: &WavelengthGrid, values: Vec<f64>) -> Result<Self, SpectrumError> {
        if values.len() != grid.len() {
            return Err(SpectrumError::Length {
                name: name.into(),
                expected: grid.len(),
                found: values.len(),
            });
        }
        if let Some(i) = values.iter().position(|v| !v.is_finite()) {
            return Err(SpectrumError::NotFinite {
                name: name.into(),
                wavelength_nm: grid.nm()[i],
                found: values[i],
            });
        }
        Ok(Self {
            grid: grid.clone(),
            values,
        })
    }

    pub fn grid(&self) -> &WavelengthGrid {
        &self.grid
    }

    pub fn values(&self) -> &[f64] {
        &self.values
    }
}
