use super::SampleError;
use super::data::{Axis, Row};
use crate::formats::{Channels, Component, Goniometric, Placement, Quantity, Scatter, Side, Table, direction};
use crate::spectrum::WavelengthGrid;

/// Common to the observers' and the illuminants' tables.
const COLOUR_NM: std::ops::RangeInclusive<f64> = 360.0..=780.0;

/// The reflection of a goniometric file in the plane of incidence along x, light on the side of −x.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct GoniometricData {
    component: Component,
    axis: Axis,
    /// Channels that the axis takes.
    channels: std::ops::Range<usize>,
    relative_se: f64,
    /// Of the file's own incidences with the views every 5 degrees that it has a value at.
    rows: Vec<Row>,
}

impl GoniometricData {
    pub(super) fn new(path: &str, data: Goniometric, relative_se: f64) -> Result<Self, SampleError> {
        let refuse = |expected: &'static str, found: String| SampleError::NotComparable {
            path: path.into(),
            expected,
            found,
        };
        let Some(component) = data.component(Scatter::Reflection, Side::Front) else {
            return Err(refuse("reflection of light from the front", "none in the file".into()));
        };
        if matches!(component.quantity, Quantity::Unscaled | Quantity::Fraction) {
            return Err(refuse("values of a stated scale", "others".into()));
        }
        let (axis, channels) = match &component.channels {
            Channels::Rgb => (Axis::Rgb, 0..3),
            Channels::Xyz => (Axis::Xyz, 0..3),
            Channels::Monochrome => return Err(refuse("spectra, XYZ or RGB", "one channel".into())),
            Channels::Wavelengths(grid) => {
                let nm = grid.nm();
                let first = nm.partition_point(|w| w < COLOUR_NM.start());
                let end = nm.partition_point(|w| w <= COLOUR_NM.end());
                (
                    Axis::Wavelengths(WavelengthGrid::new(nm[first..end].to_vec())?),
                    first..end,
                )
            }
        };
        let mut this = Self {
            component: component.clone(),
            axis,
            channels,
            relative_se,
            rows: Vec::new(),
        };
        let incidences = component.incidences_deg().into_iter().filter(|theta_i| *theta_i < 90.0);
        let views = || (-17..=17).map(|i| 5.0 * f64::from(i));
        let pairs = incidences.flat_map(|theta_i| views().map(move |theta_v| (theta_i, theta_v)));
        this.rows = pairs
            .filter_map(|(theta_i, theta_v)| Some(this.at(theta_i, theta_v)?.0))
            .collect();
        Ok(this)
    }

    /// Whether the file states standard errors.
    pub(super) fn has_se(&self) -> bool {
        matches!(&self.component.table, Table::Scattered(table) if !table.reading_errors().is_empty())
    }

    pub(super) fn axis(&self) -> &Axis {
        &self.axis
    }

    pub(super) fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// β at a geometry, and whether the file has no value at the very place.
    pub(super) fn at(&self, theta_i_deg: f64, theta_v_deg: f64) -> Option<(Row, bool)> {
        let omega_in = direction(-theta_i_deg.to_radians(), 0.0);
        let omega_out = direction(theta_v_deg.to_radians(), 0.0);
        let evaluation = self.component.eval(&omega_in, &omega_out)?;
        let beta = evaluation.brightness_factor()?[self.channels.clone()].to_vec();
        // Only this program's CSV states errors, and they are of β.
        let stated = self.component.standard_errors(&omega_in, &omega_out);
        let se = match stated {
            Some(errors) => errors[self.channels.clone()].to_vec(),
            None => beta.iter().map(|b| b * self.relative_se).collect(),
        };
        let row = Row {
            theta_i_deg,
            theta_v_deg,
            beta,
            se,
        };
        Some((row, evaluation.placement != Placement::OnNode))
    }
}
