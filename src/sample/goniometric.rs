use super::description::{Chosen, Description, OneChannel};
use super::error::SampleError;
use super::notice::SampleNotice;
use super::row::{ReadingAxis, SampleRow, unit_doubts};
use crate::goniometric::{ChannelSet, Component, Goniometric, Placement, Quantity, Scatter, Side, Table, direction};
use crate::spectrum::WavelengthGrid;

/// Common to the observers' and the illuminants' tables.
const COLOUR_NM: std::ops::RangeInclusive<f64> = 360.0..=780.0;

/// A component of a goniometric file, reflection unless another is chosen, in the plane of incidence along x, light on
/// the side of −x.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct GoniometricData {
    component: Component,
    /// What the component is in the file.
    scatter: Scatter,
    axis: ReadingAxis,
    /// Channels that the axis takes.
    channels: std::ops::Range<usize>,
    relative_se: f64,
    /// Of the file's own incidences with the views every 5 degrees that it has a value at; of readings that need not
    /// form a grid, those in the plane.
    rows: Vec<SampleRow>,
    outside_plane: usize,
    notices: Vec<SampleNotice>,
}

impl GoniometricData {
    pub(super) fn new(
        path: &str,
        description: &Description,
        data: Goniometric,
        chosen: Chosen,
    ) -> Result<Self, SampleError> {
        let relative_se = description.relative_standard_uncertainty.unwrap_or(0.0);
        let refuse = |expected: &str, found: &str, remedy: &str| SampleError::NotComparable {
            path: path.into(),
            expected: expected.into(),
            found: found.into(),
            remedy: remedy.into(),
        };
        let (scatter, side) = chosen.or_default();
        let Some(component) = data.component(scatter, side) else {
            let there: Vec<String> = data.components.iter().map(Component::words).collect();
            return Err(refuse(&chosen.words(), &there.join(", "), Chosen::REMEDY));
        };
        let others = data.components.iter().filter(|other| *other != component);
        let others: Vec<String> = others.map(Component::words).collect();
        let mut notices: Vec<SampleNotice> = SampleNotice::of_file(&data.warnings).collect();
        if !others.is_empty() {
            notices.push(SampleNotice::OtherComponents {
                path: path.into(),
                component: component.words(),
                others,
            });
        }
        if matches!(component.quantity, Quantity::Unscaled | Quantity::Fraction) {
            return Err(refuse(
                "values of a stated scale",
                "values whose scale the file does not state",
                "export the file with absolute values",
            ));
        }
        let (axis, channels) = match &component.channels {
            ChannelSet::Rgb => (ReadingAxis::Rgb, 0..3),
            ChannelSet::Xyz => (ReadingAxis::Xyz, 0..3),
            ChannelSet::Monochrome if description.channel == Some(OneChannel::Luminance) => {
                notices.push(SampleNotice::LuminanceAlone);
                (ReadingAxis::Luminance, 0..1)
            }
            ChannelSet::Monochrome => {
                return Err(refuse(
                    "spectra, XYZ or RGB",
                    "one channel",
                    "one channel has no colour; if it is luminance, put the file into a folder with a sample.toml that says \
                     channel = \"luminance\" and data = the file's name; `specval inspect` shows it, `specval convert` writes \
                     it in another format",
                ));
            }
            ChannelSet::Wavelengths(grid) => {
                let nm = grid.nm();
                let first = nm.partition_point(|w| w < COLOUR_NM.start());
                let end = nm.partition_point(|w| w <= COLOUR_NM.end());
                (
                    ReadingAxis::Wavelengths(WavelengthGrid::new(nm[first..end].to_vec())?),
                    first..end,
                )
            }
        };
        let mut this = Self {
            // Both directions as tables know them: light from above that is seen from above.
            component: Component {
                scatter: Scatter::Reflection,
                side: Side::Front,
                ..component.clone()
            },
            scatter,
            axis,
            channels,
            relative_se,
            rows: Vec::new(),
            outside_plane: 0,
            notices,
        };
        let incidences = component.incidences_deg().into_iter().filter(|theta_i| *theta_i < 90.0);
        let views = || (-17..=17).map(|i| 5.0 * f64::from(i));
        let pairs: Vec<(f64, f64)> = match &this.component.table {
            Table::Scattered(table) => {
                let readings = table.readings().into_iter();
                let mut pairs: Vec<_> = readings.filter_map(|(angles, _)| in_plane(&angles)).collect();
                pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
                pairs.dedup();
                pairs
            }
            _ => incidences
                .flat_map(|theta_i| views().map(move |theta_v| (theta_i, theta_v)))
                .collect(),
        };
        let mut unseen = 0;
        let mut rows = Vec::with_capacity(pairs.len());
        for (theta_i, theta_v) in pairs {
            match this.evaluate(theta_i, theta_v) {
                Some((_, Placement::FilledIn)) => unseen += 1,
                Some((row, _)) => rows.push(row),
                None => {}
            }
        }
        if unseen > 0 {
            let of = unseen + rows.len();
            this.notices.push(SampleNotice::NotSeen { count: unseen, of });
        }
        if let Table::Klems(matrix) = &this.component.table {
            let patches = [matrix.incident().count(), matrix.exiting().count()];
            this.notices.push(SampleNotice::PatchMeans { patches });
        }
        this.rows = rows;
        if let Table::Scattered(table) = &this.component.table {
            this.outside_plane = table.readings().len().saturating_sub(this.rows.len());
        }
        let doubts = unit_doubts(&this.rows);
        this.notices.extend(doubts.map(SampleNotice::from));
        Ok(this)
    }

    pub(super) fn scatter(&self) -> Scatter {
        self.scatter
    }

    /// Whether readings need not form a grid.
    pub(super) fn is_scattered(&self) -> bool {
        matches!(self.component.table, Table::Scattered(_))
    }

    pub(super) fn notices(&self) -> &[SampleNotice] {
        &self.notices
    }

    pub(super) fn outside_plane(&self) -> usize {
        self.outside_plane
    }

    /// Directional-hemispherical reflectance at an incidence in degrees, a value a channel of the axis, and the share
    /// of the projected hemisphere that the file has values on.
    pub(super) fn hemispherical(&self, theta_i_deg: f64) -> Option<(Vec<f64>, f64)> {
        let azimuth_rad = std::f64::consts::PI;
        let integrated = self
            .component
            .directional_hemispherical(theta_i_deg.to_radians(), azimuth_rad)?;
        Some((integrated.values[self.channels.clone()].to_vec(), integrated.measured))
    }

    /// Whether the file states standard errors.
    pub(super) fn has_se(&self) -> bool {
        matches!(&self.component.table, Table::Scattered(table) if !table.reading_errors().is_empty())
    }

    pub(super) fn axis(&self) -> &ReadingAxis {
        &self.axis
    }

    pub(super) fn rows(&self) -> &[SampleRow] {
        &self.rows
    }

    /// β at a geometry, and whether the file has no value at the very place. `None` too where the instrument did not
    /// read what the file has.
    pub(super) fn at(&self, theta_i_deg: f64, theta_v_deg: f64) -> Option<(SampleRow, bool)> {
        match self.evaluate(theta_i_deg, theta_v_deg)? {
            (_, Placement::FilledIn) => None,
            (row, placement) => Some((row, placement != Placement::OnNode)),
        }
    }

    /// Whether the table has no azimuths of incidence.
    pub(super) fn is_isotropic(&self) -> bool {
        self.component.is_isotropic()
    }

    fn evaluate(&self, theta_i_deg: f64, theta_v_deg: f64) -> Option<(SampleRow, Placement)> {
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
        let row = SampleRow {
            theta_i_deg,
            theta_v_deg,
            beta,
            se,
        };
        Some((row, evaluation.placement))
    }
}

/// Incidence and signed view in degrees of a reading's angles in radians, if it lies in the plane of incidence along x;
/// light and view below 90 degrees.
fn in_plane(angles: &[f64]) -> Option<(f64, f64)> {
    let degrees = |angle: f64| (angle.to_degrees() * 1e9).round() / 1e9;
    let near = |turn: f64| turn.sin().abs() < 1e-9;
    let (theta_i, theta_v) = match *angles {
        [theta_i, theta_v] => (degrees(theta_i), degrees(theta_v)),
        [theta_i, phi_i, theta_o, phi_o] => {
            // Seen from the normal, or lit from it, any azimuth is in some plane of incidence; the table's own is along
            // x.
            if theta_o > 1e-9 && !near(phi_o - if theta_i > 1e-9 { phi_i } else { 0.0 }) {
                return None;
            }
            let towards_light = (phi_o - phi_i).cos() > 0.0;
            let sign = if towards_light { -1.0 } else { 1.0 };
            (degrees(theta_i), sign * degrees(theta_o) + 0.0)
        }
        _ => return None,
    };
    (theta_i < 90.0 && theta_v.abs() < 90.0).then_some((theta_i, theta_v))
}
