use super::error::SpectrumError;

/// Strictly ascending wavelengths in nm (vacuum).
#[derive(Clone, Debug, PartialEq)]
pub struct WavelengthGrid(Vec<f64>);

impl WavelengthGrid {
    /// Any ascending list of positive wavelengths in nm.
    pub fn new(wavelengths_nm: Vec<f64>) -> Result<Self, SpectrumError> {
        if wavelengths_nm.is_empty() {
            return Err(SpectrumError::Empty);
        }
        let mut previous = 0.0;
        for (index, &found) in wavelengths_nm.iter().enumerate() {
            if !found.is_finite() || found <= previous {
                return Err(SpectrumError::NotAscending { index, found });
            }
            previous = found;
        }
        Ok(Self(wavelengths_nm))
    }

    /// The goniophotometer's grid: 390..=730 nm, step 10 nm, 35 wavelengths (Voloboy, Galaktionov, Lobalzo 2008, §4).
    pub fn preprint() -> Self {
        Self((0..35).map(|i| 390.0 + 10.0 * f64::from(i)).collect())
    }

    pub fn nm(&self) -> &[f64] {
        &self.0
    }

    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Never true: construction refuses an empty grid.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn preprint_grid_has_35_wavelengths() {
        let grid = WavelengthGrid::preprint();
        assert_eq!((grid.len(), grid.nm()[0], grid.nm()[34]), (35, 390.0, 730.0));
    }

    #[test]
    fn refuses_what_does_not_ascend() {
        for bad in [
            vec![],
            vec![500.0, 500.0],
            vec![500.0, 400.0],
            vec![f64::NAN],
            vec![-1.0],
        ] {
            assert!(WavelengthGrid::new(bad).is_err());
        }
    }
}
