use super::curves::SampleCurves;
use super::error::SampleError;
use super::measured::{Data, Sample};
use super::nominal::ANGLE_TOLERANCE_DEG;
use super::row::{ReadingAxis, SampleRow};
use crate::colour::{ColourSystem, Convention, LinearRgb, Xyz};
use crate::spectrum::{Samples, WavelengthGrid};

/// Brightness factors β of a measured geometry in the channels r, g, b (linear RGB) and y (luminance), dimensionless.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    pub beta: [f64; 4],
    /// Covariance of the four: y is a linear function of the other three, and channels of a spectral reading share
    /// its wavelengths.
    pub covariance: [[f64; 4]; 4],
    /// Not measured here but linear between neighbouring geometries. The error of the interpolation itself is not
    /// in the covariance.
    pub interpolated: bool,
}

impl Reading {
    /// Four channels with unrelated standard errors.
    pub fn independent(beta: [f64; 4], se: [f64; 4]) -> Self {
        let mut covariance = [[0.0; 4]; 4];
        for (channel, se) in se.into_iter().enumerate() {
            covariance[channel][channel] = se * se;
        }
        Self {
            beta,
            covariance,
            interpolated: false,
        }
    }

    /// Standard errors of the four channels.
    pub fn se(&self) -> [f64; 4] {
        std::array::from_fn(|channel| self.covariance[channel][channel].sqrt())
    }
}

impl Sample {
    /// β at a geometry: as measured, or linear in theta_v_deg between the nearest views of the same incidence
    /// (flagged), or that of the last view or the nearest incidence within [`ANGLE_TOLERANCE_DEG`], or `None` outside
    /// what was measured and for samples of published ratios. Goniometric files interpolate in their own parameters,
    /// over incidences too.
    ///
    /// Spectral data go through [`ColourSystem`], y being Y of XYZ; wavelengths err independently. RGB data are taken
    /// as they stand, y being the luminance they would have in the convention's RGB space: an assumption wherever they
    /// are camera RGB, and the only use made of the convention for them; channels err independently.
    pub fn reading(
        &self,
        theta_i_deg: f64,
        theta_v_deg: f64,
        convention: &Convention,
    ) -> Result<Option<Reading>, SampleError> {
        let Some((axis, row, interpolated)) = self.at(theta_i_deg, theta_v_deg) else {
            return Ok(None);
        };
        let weights = axis.channel_weights(convention)?;
        let beta = match axis {
            ReadingAxis::Rgb => {
                let rgb = LinearRgb([row.beta[0], row.beta[1], row.beta[2]]);
                [rgb.0[0], rgb.0[1], rgb.0[2], convention.rgb.luminance(rgb)]
            }
            ReadingAxis::Luminance => [row.beta[0]; 4],
            ReadingAxis::Xyz => xyz_channels(convention)?(row.beta[0], row.beta[1], row.beta[2]),
            ReadingAxis::Wavelengths(grid) => {
                let system = ColourSystem::new(grid, convention.clone())?;
                let xyz = system.xyz(&row.beta);
                let [r, g, b] = system.linear_rgb(xyz).0;
                [r, g, b, xyz.y]
            }
        };
        let mut covariance = [[0.0; 4]; 4];
        for (w, se) in weights.iter().zip(&row.se) {
            for (i, line) in covariance.iter_mut().enumerate() {
                for (j, entry) in line.iter_mut().enumerate() {
                    *entry += w[i] * w[j] * se * se;
                }
            }
        }
        Ok(Some(Reading {
            beta,
            covariance,
            interpolated,
        }))
    }

    /// What a unit of each value of [`Sample::raw`] adds to r, g, b and y, as in [`Sample::reading`]; none for published
    /// ratios.
    ///
    /// # Errors
    /// As [`Sample::reading`]: wavelengths that cannot carry a colour, tables that do not cover them.
    pub fn channel_weights(&self, convention: &Convention) -> Result<Vec<[f64; 4]>, SampleError> {
        match self.axis() {
            Some(axis) => axis.channel_weights(convention),
            None => Ok(Vec::new()),
        }
    }

    /// Whether the convention's tables cover the sample's wavelengths, without which there is no [`Sample::reading`].
    pub fn check_convention(&self, convention: &Convention) -> Result<(), SampleError> {
        if let Some(ReadingAxis::Wavelengths(grid)) = self.axis() {
            ColourSystem::new(grid, convention.clone())?;
        }
        Ok(())
    }

    /// Why the colours of these spectral data are doubtful, or missing, under a convention.
    pub fn colour_doubt(&self, convention: &Convention) -> Result<Option<String>, SampleError> {
        match self.axis() {
            Some(ReadingAxis::Wavelengths(grid)) => {
                let system = ColourSystem::new(grid, convention.clone())?;
                Ok(system.doubt().map(str::to_owned))
            }
            Some(ReadingAxis::Rgb | ReadingAxis::Xyz | ReadingAxis::Luminance) | None => Ok(None),
        }
    }

    /// β(λ) at a geometry, on the wavelengths of the sample, interpolated as [`Sample::reading`] does; `None` for RGB
    /// data.
    pub fn spectrum(&self, theta_i_deg: f64, theta_v_deg: f64) -> Result<Option<Samples>, SampleError> {
        match self.at(theta_i_deg, theta_v_deg) {
            Some((ReadingAxis::Wavelengths(grid), row, _)) => Ok(Some(Samples::new(self.name(), grid, row.beta)?)),
            _ => Ok(None),
        }
    }

    /// Whether the readings are linear RGB of some space, not spectra or XYZ.
    pub fn is_rgb(&self) -> bool {
        self.axis() == Some(&ReadingAxis::Rgb)
    }

    /// What the values of a reading stand for; none for published ratios.
    pub(super) fn axis(&self) -> Option<&ReadingAxis> {
        match &self.data {
            Data::SampleCurves(curves) => Some(curves.axis()),
            Data::Goniometric(data) => Some(data.axis()),
            Data::Ratios(_) => None,
        }
    }

    /// Values at a geometry, what they stand for, and whether they are interpolated.
    pub(super) fn at(&self, theta_i_deg: f64, theta_v_deg: f64) -> Option<(&ReadingAxis, SampleRow, bool)> {
        match &self.data {
            Data::SampleCurves(curves) => {
                let (row, interpolated) = curves.at(theta_i_deg, theta_v_deg)?;
                Some((curves.axis(), row, interpolated))
            }
            Data::Goniometric(data) => {
                let (row, interpolated) = data.at(theta_i_deg, theta_v_deg)?;
                Some((data.axis(), row, interpolated))
            }
            Data::Ratios(_) => None,
        }
    }
}

impl ReadingAxis {
    /// What a unit of each value adds to r, g, b and y.
    fn channel_weights(&self, convention: &Convention) -> Result<Vec<[f64; 4]>, SampleError> {
        match self {
            Self::Rgb => {
                let [r, g, b] = convention.rgb.luminance_row();
                Ok(vec![[1.0, 0.0, 0.0, r], [0.0, 1.0, 0.0, g], [0.0, 0.0, 1.0, b]])
            }
            Self::Xyz => {
                let channels = xyz_channels(convention)?;
                Ok(vec![
                    channels(1.0, 0.0, 0.0),
                    channels(0.0, 1.0, 0.0),
                    channels(0.0, 0.0, 1.0),
                ])
            }
            Self::Luminance => Ok(vec![[1.0; 4]]),
            Self::Wavelengths(grid) => {
                let system = ColourSystem::new(grid, convention.clone())?;
                system.require()?;
                Ok(system.channel_weights())
            }
        }
    }
}

/// r, g, b and y of X, Y, Z.
fn xyz_channels(convention: &Convention) -> Result<impl Fn(f64, f64, f64) -> [f64; 4], SampleError> {
    // Without adaptation the matrix is the same for every grid.
    let system = ColourSystem::new(&WavelengthGrid::preprint(), convention.clone())?;
    Ok(move |x, y, z| {
        let [r, g, b] = system.linear_rgb(Xyz { x, y, z }).0;
        [r, g, b, y]
    })
}

impl SampleCurves {
    /// Values at a geometry, and whether they are interpolated.
    fn at(&self, theta_i_deg: f64, theta_v_deg: f64) -> Option<(SampleRow, bool)> {
        /// Angles in degrees that differ by less are the same angle, written differently.
        const SAME_DEG: f64 = 1e-9;
        let off = |row: &&SampleRow| (row.theta_i_deg - theta_i_deg).abs();
        let nearest = self.rows().iter().min_by(|a, b| off(a).total_cmp(&off(b)))?;
        if off(&nearest) > ANGLE_TOLERANCE_DEG {
            return None;
        }
        let rows = || self.rows().iter().filter(|row| row.theta_i_deg == nearest.theta_i_deg);
        if let Some(row) = rows().find(|row| (row.theta_v_deg - theta_v_deg).abs() < SAME_DEG) {
            return Some((row.clone(), false));
        }
        let below = rows().rfind(|row| row.theta_v_deg < theta_v_deg);
        let above = rows().find(|row| row.theta_v_deg > theta_v_deg);
        let (Some(below), Some(above)) = (below, above) else {
            // Beyond the last view there is nothing to interpolate with.
            let end = below.or(above)?;
            let within = (end.theta_v_deg - theta_v_deg).abs() <= ANGLE_TOLERANCE_DEG;
            return within.then(|| (end.clone(), false));
        };
        let t = (theta_v_deg - below.theta_v_deg) / (above.theta_v_deg - below.theta_v_deg);
        let pairs = |a: &[f64], b: &[f64], f: fn(f64, f64, f64) -> f64| {
            a.iter().zip(b).map(|(a, b)| f(*a, *b, t)).collect::<Vec<_>>()
        };
        let row = SampleRow {
            theta_i_deg,
            theta_v_deg,
            beta: pairs(&below.beta, &above.beta, |a, b, t| a + t * (b - a)),
            se: pairs(&below.se, &above.se, |a, b, t| ((1.0 - t) * a).hypot(t * b)),
        };
        Some((row, true))
    }
}
