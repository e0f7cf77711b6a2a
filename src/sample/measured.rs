//! A sample, whatever layout its file has.

use super::curves::SampleCurves;
use super::description::Description;
use super::goniometric::GoniometricData;
use super::nominal::AnglesRead;
use super::notice::SampleNotice;
use super::ratios::PublishedRatios;
use super::row::{ReadingAxis, SampleRow, unit_doubts};
use crate::goniometric::Scatter;

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Data {
    SampleCurves(SampleCurves),
    Goniometric(Box<GoniometricData>),
    Ratios(PublishedRatios),
}

/// A measured sample, checked as a whole when loaded.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    pub(super) description: Description,
    pub(super) data: Data,
    pub(super) digest: String,
}

impl Sample {
    pub fn description(&self) -> &Description {
        &self.description
    }

    pub fn name(&self) -> &str {
        &self.description.name
    }

    /// SHA-256 of the data file's bytes, hexadecimal.
    pub fn digest(&self) -> &str {
        &self.digest
    }

    /// Colour ratios published without curves; none for a sample with readings.
    pub fn published_ratios(&self) -> Option<&PublishedRatios> {
        match &self.data {
            Data::Ratios(ratios) => Some(ratios),
            Data::SampleCurves(_) | Data::Goniometric(_) => None,
        }
    }

    /// Measured geometries (theta_i_deg, theta_v_deg), ascending.
    ///
    /// Of a goniometric file they are its own incidences with those of the views every 5 degrees that it has a value
    /// at.
    pub fn geometries(&self) -> impl Iterator<Item = (f64, f64)> {
        self.rows().iter().map(|row| (row.theta_i_deg, row.theta_v_deg))
    }

    fn rows(&self) -> &[SampleRow] {
        match &self.data {
            Data::SampleCurves(curves) => curves.rows(),
            Data::Goniometric(data) => data.rows(),
            Data::Ratios(_) => &[],
        }
    }

    /// Readings as the data have them at [`Sample::geometries`]; none for published ratios.
    pub fn raw(&self) -> impl Iterator<Item = RawReading<'_>> {
        self.rows().iter().map(|row| RawReading {
            theta_i_deg: row.theta_i_deg,
            theta_v_deg: row.theta_v_deg,
            beta: &row.beta,
            se: &row.se,
        })
    }

    /// What the reader assumed, left out or found implausible: units, signs, columns by other names. For a report to
    /// show.
    pub fn notices(&self) -> &[SampleNotice] {
        match &self.data {
            Data::SampleCurves(curves) => curves.notices(),
            Data::Goniometric(data) => data.notices(),
            Data::Ratios(_) => &[],
        }
    }

    /// Whether it is light that went through, which has no reciprocity of its own: light and viewer exchanged are on
    /// the other sides.
    pub fn is_transmission(&self) -> bool {
        matches!(&self.data, Data::Goniometric(data) if data.scatter() == Scatter::Transmission)
    }

    /// Whether values or angles look like those of another unit, of which [`Sample::notices`] tell.
    pub fn implausible(&self) -> bool {
        unit_doubts(self.rows()).next().is_some()
    }

    /// What was made of angles that an encoder read back.
    pub fn angles_read(&self) -> AnglesRead {
        match &self.data {
            Data::SampleCurves(curves) => curves.angles(),
            Data::Goniometric(_) | Data::Ratios(_) => AnglesRead::default(),
        }
    }

    /// Readings of the file that a comparison in the plane of incidence along x cannot use, lying outside it.
    pub fn readings_outside_plane(&self) -> usize {
        match &self.data {
            Data::Goniometric(data) => data.outside_plane(),
            Data::SampleCurves(_) | Data::Ratios(_) => 0,
        }
    }

    /// Whether the file is a table over the hemisphere, which has values between its nodes by its format.
    pub fn is_table(&self) -> bool {
        matches!(&self.data, Data::Goniometric(data) if !data.is_scattered())
    }

    /// Whether there is a value at a geometry, read or interpolated.
    pub fn covers(&self, theta_i_deg: f64, theta_v_deg: f64) -> bool {
        self.at(theta_i_deg, theta_v_deg).is_some()
    }

    /// Directional-hemispherical reflectance at an incidence in degrees, a value a channel of [`Sample::raw`], and the
    /// share of the projected hemisphere that the file has values on. `None` of files of the plane of incidence alone.
    pub fn hemispherical(&self, theta_i_deg: f64) -> Option<(Vec<f64>, f64)> {
        match &self.data {
            Data::Goniometric(data) => data.hemispherical(theta_i_deg),
            Data::SampleCurves(_) | Data::Ratios(_) => None,
        }
    }

    /// Whether the sample scatters alike at every azimuth: as `sample.toml` says, else `None` where that is not known.
    pub fn is_isotropic(&self) -> Option<bool> {
        self.description.isotropic
    }

    /// Whether the readings are of luminance alone, without colour.
    pub fn is_luminance(&self) -> bool {
        matches!(&self.data, Data::Goniometric(data) if *data.axis() == ReadingAxis::Luminance)
    }

    /// Wavelengths in nm that the values of [`Sample::raw`] stand at; `None` for RGB and XYZ.
    pub fn wavelengths_nm(&self) -> Option<&[f64]> {
        match self.axis()? {
            ReadingAxis::Wavelengths(grid) => Some(grid.nm()),
            ReadingAxis::Rgb | ReadingAxis::Xyz | ReadingAxis::Luminance => None,
        }
    }
}

/// One measured geometry: β and its standard error, a value a wavelength or one each of red, green and blue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawReading<'a> {
    pub theta_i_deg: f64,
    pub theta_v_deg: f64,
    pub beta: &'a [f64],
    pub se: &'a [f64],
}
