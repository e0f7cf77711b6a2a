use super::interpolation::Interpolation;
use super::{YarnError, YarnResponseGrid};
use crate::geometry::Vec3;
use ndarray::{Array4, Array5};
use std::iter::zip;

/// Yarn response f* at each wavelength, and the yarn transfer, as estimated by one batch of paths.
///
/// f*(ω_in, ω_out) at a point of the surface is the radiance towards ω_out per irradiance normal to a parallel beam
/// from ω_in on the whole yarn, 1/sr (preprint 63, section 3). It is defined for ω_in on the whole sphere and already
/// includes self-shadowing and the foreshortening of the light: do not multiply it by the cosine of incidence.
/// Ballistic light is not included.
#[derive(Clone, Debug, PartialEq)]
pub struct YarnResponse {
    grid: YarnResponseGrid,
    /// Axes: tilt, azimuth, exit cell, wavelength.
    factor: Array4<f64>,
    /// Axes: tilt, entry cell, side, azimuth, wavelength.
    transfer: Array5<f64>,
}

impl YarnResponse {
    /// f* and transfer from their values in the order of the axes, wavelength fastest.
    ///
    /// # Errors
    /// [`YarnError::Values`] if the number of values does not match the grid.
    pub fn new(
        grid: YarnResponseGrid,
        wavelengths: usize,
        factor: Vec<f64>,
        transfer: Vec<f64>,
    ) -> Result<Self, YarnError> {
        let count = |quantity, expected: usize, found: usize| YarnError::Values {
            quantity,
            expected,
            found,
        };
        let found = [factor.len(), transfer.len()];
        Ok(Self {
            grid,
            factor: Array4::from_shape_vec(factor_shape(&grid, wavelengths), factor)
                .map_err(|_| count("f*", grid.cells() * wavelengths, found[0]))?,
            transfer: Array5::from_shape_vec(transfer_shape(&grid, wavelengths), transfer)
                .map_err(|_| count("transfer", grid.transfer_cells() * wavelengths, found[1]))?,
        })
    }

    /// Response of a yarn that scatters nothing.
    pub fn zeros(grid: YarnResponseGrid, wavelengths: usize) -> Self {
        // Zeros that are written. Of memory that the system gives as zero pages, the first addition reads one before it
        // writes, a second page fault that halts the other threads.
        Self {
            grid,
            factor: Array4::from_shape_simple_fn(factor_shape(&grid, wavelengths), || 0.0),
            transfer: Array5::from_shape_simple_fn(transfer_shape(&grid, wavelengths), || 0.0),
        }
    }

    /// f* from a function of (tilt, azimuth, exit cell, wavelength), with zero transfer; for problems with a known f*.
    pub fn from_fn(grid: YarnResponseGrid, wavelengths: usize, mut factor: impl FnMut([usize; 4]) -> f64) -> Self {
        Self {
            factor: Array4::from_shape_fn(factor_shape(&grid, wavelengths), |(tilt, azimuth, exit, w)| {
                factor([tilt, azimuth, exit, w])
            }),
            ..Self::zeros(grid, wavelengths)
        }
    }

    /// Axes of the tables.
    pub fn grid(&self) -> &YarnResponseGrid {
        &self.grid
    }

    /// Number of wavelengths.
    pub fn wavelengths(&self) -> usize {
        self.factor.dim().3
    }

    /// f*, 1/sr, means over cells. Axes: tilt of the light, azimuth of the surface point from the light, exit cell,
    /// wavelength.
    pub fn factor(&self) -> &Array4<f64> {
        &self.factor
    }

    /// Yarn transfer: fraction of all light of a tilt that enters at an entry cell of the section or its mirror image,
    /// scatters, and leaves at an azimuth on the same (0) or the opposite side (1) of the light's meridian. Axes: tilt,
    /// entry, side, azimuth, wavelength.
    pub fn transfer(&self) -> &Array5<f64> {
        &self.transfer
    }

    /// All of f* with wavelength fastest; [`YarnResponseGrid::cell`] numbers the rows.
    pub fn values(&self) -> &[f64] {
        self.factor.as_slice().expect(STANDARD_LAYOUT)
    }

    /// All of the transfer with wavelength fastest; [`YarnResponseGrid::transfer_cell`] numbers the rows.
    pub fn transfer_values(&self) -> &[f64] {
        self.transfer.as_slice().expect(STANDARD_LAYOUT)
    }

    /// The same as [`Self::values`], by value.
    pub fn into_values(self) -> Vec<f64> {
        self.factor.into_raw_vec_and_offset().0
    }

    /// Values of f* and of the transfer, for tallying.
    pub(super) fn values_mut(&mut self) -> [&mut [f64]; 2] {
        [
            self.factor.as_slice_mut().expect(STANDARD_LAYOUT),
            self.transfer.as_slice_mut().expect(STANDARD_LAYOUT),
        ]
    }

    /// f* of a cell at each wavelength, 1/sr.
    pub fn row(&self, cell: usize) -> &[f64] {
        &self.values()[cell * self.wavelengths()..][..self.wavelengths()]
    }

    /// f* at each wavelength, 1/sr, interpolated between the nodes of the table. Unit vectors are in the local frame of
    /// the surface point: x tangent, y axis, z outward normal. `omega_in` may be anywhere on the sphere; `omega_out`
    /// must be above the surface.
    pub fn eval(&self, omega_in: &Vec3, omega_out: &Vec3) -> Vec<f64> {
        let seen = self.grid.surface().exit().bilinear(omega_out);
        let mut sum = vec![0.0; self.wavelengths()];
        Interpolation::new(self.grid).spread(omega_in, &seen, |cell, weight| {
            zip(&mut sum, self.row(cell)).for_each(|(sum, f)| *sum += weight * f);
        });
        sum
    }

    /// Fraction of the light meeting the yarn that leaves it scattered, for a tilt cell, at each wavelength.
    pub fn albedo(&self, tilt: usize) -> Vec<f64> {
        let exits = self.grid.surface().exit().cells();
        let mut sum = vec![0.0; self.wavelengths()];
        for azimuth in 0..self.grid.azimuths() {
            for exit in 0..exits {
                let share = 1.0 / self.grid.response_per_fraction(tilt, exit);
                let row = self.row(self.grid.cell(tilt, azimuth, exit));
                zip(&mut sum, row).for_each(|(sum, f)| *sum += share * f);
            }
        }
        sum
    }
}

const STANDARD_LAYOUT: &str = "both arrays own their values in standard order since they were made";

fn factor_shape(grid: &YarnResponseGrid, wavelengths: usize) -> [usize; 4] {
    [
        grid.tilts(),
        grid.azimuths(),
        grid.surface().exit().cells(),
        wavelengths,
    ]
}

fn transfer_shape(grid: &YarnResponseGrid, wavelengths: usize) -> [usize; 5] {
    [grid.tilts(), grid.entries(), 2, grid.azimuths(), wavelengths]
}
