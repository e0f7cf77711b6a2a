use super::error::SpectrumError;
use super::grid::WavelengthGrid;
use super::samples::Samples;

/// A quantity as a function of wavelength.
#[derive(Clone, Debug, PartialEq)]
pub enum Spectrum {
    /// The same value at every wavelength.
    Constant(f64),
    /// Linear between tabulated samples; undefined outside them.
    Table { name: String, samples: Samples },
}

impl Spectrum {
    /// Value at a wavelength in nm. Outside a table's range: an error, never an extrapolation.
    pub fn at(&self, wavelength_nm: f64) -> Result<f64, SpectrumError> {
        match self {
            Self::Constant(value) => Ok(*value),
            Self::Table { name, samples } => {
                let nm = samples.grid().nm();
                let values = samples.values();
                let (low, high) = (nm[0], nm[nm.len() - 1]);
                if !(low..=high).contains(&wavelength_nm) {
                    return Err(SpectrumError::OutsideTable {
                        name: name.clone(),
                        low,
                        high,
                        found: wavelength_nm,
                    });
                }
                let above = nm.partition_point(|&x| x < wavelength_nm);
                if nm[above] == wavelength_nm {
                    return Ok(values[above]);
                }
                let t = (wavelength_nm - nm[above - 1]) / (nm[above] - nm[above - 1]);
                Ok(values[above - 1] + t * (values[above] - values[above - 1]))
            }
        }
    }

    /// First and last wavelength in nm that it is defined at; `None` where that is everywhere.
    pub fn range_nm(&self) -> Option<[f64; 2]> {
        match self {
            Self::Constant(_) => None,
            Self::Table { samples, .. } => {
                let nm = samples.grid().nm();
                Some([nm[0], nm[nm.len() - 1]])
            }
        }
    }

    /// Values on a grid. Exact at a table's own wavelengths.
    pub fn on(&self, grid: &WavelengthGrid) -> Result<Samples, SpectrumError> {
        let values = grid.nm().iter().map(|&w| self.at(w)).collect::<Result<Vec<_>, _>>()?;
        let name = match self {
            Self::Constant(_) => "constant",
            Self::Table { name, .. } => name,
        };
        Samples::new(name, grid, values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_is_exact_at_nodes_linear_between_and_refuses_outside() {
        let grid = WavelengthGrid::new(vec![400.0, 500.0]).unwrap();
        let table = Spectrum::Table {
            name: "t".into(),
            samples: Samples::new("t", &grid, vec![1.0, 3.0]).unwrap(),
        };
        assert_eq!(table.at(400.0), Ok(1.0));
        assert_eq!(table.at(500.0), Ok(3.0));
        assert_eq!(table.at(450.0), Ok(2.0));
        assert!(table.at(399.9).is_err());
        assert!(table.at(f64::NAN).is_err());
    }
}
