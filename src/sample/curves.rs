//! Readings over incidence and view from this program's CSV and its usual variants.

use super::columns::{SampleColumns, ValueColumns};
use super::error::SampleError;
use super::geometries::{each_once, spectral, wide};
use super::nominal::{AnglesRead, as_read, nominal};
use super::notice::SampleNotice;
use super::row::{ReadingAxis, SampleRow, unit_doubts};
use crate::spectrum::plausibility;
use crate::spectrum::{CsvError, CsvTable, Doubt};

/// Readings over incidence and view, all of them on the same channels or wavelengths.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SampleCurves {
    axis: ReadingAxis,
    has_se: bool,
    /// Ascending by incidence, then by view; a geometry occurs once.
    rows: Vec<SampleRow>,
    angles: AnglesRead,
    /// What the reader assumed, left out or found implausible.
    notices: Vec<SampleNotice>,
}

impl SampleCurves {
    pub(super) fn axis(&self) -> &ReadingAxis {
        &self.axis
    }

    pub(super) fn rows(&self) -> &[SampleRow] {
        &self.rows
    }

    pub(super) fn has_se(&self) -> bool {
        self.has_se
    }

    pub(super) fn angles(&self) -> AnglesRead {
        self.angles
    }

    pub(super) fn notices(&self) -> &[SampleNotice] {
        &self.notices
    }
}

/// Reads readings of any layout; the header says which.
pub(super) fn curves(table: CsvTable, relative_se: Option<f64>) -> Result<SampleCurves, SampleError> {
    let columns = SampleColumns::of(&table)?;
    let relative_se = relative_se.unwrap_or(0.0);
    let mut notices: Vec<SampleNotice> = SampleNotice::of_file(table.notices()).collect();
    if !table.renamed().is_empty() {
        notices.push(renamed(&columns, &table));
    }
    let mut lines = Vec::with_capacity(table.len());
    for row in 0..table.len() {
        lines.push(Line::read(&table, &columns, row, relative_se)?);
    }
    let largest = lines
        .iter()
        .flat_map(|line| &line.beta)
        .fold(0.0, |a: f64, b| a.max(*b));
    let mut negative = Vec::new();
    for (row, line) in lines.iter().enumerate() {
        negative.extend(line.negative(&table, &columns, row, largest)?);
    }
    if let Some(lowest) = negative.iter().copied().reduce(f64::min) {
        notices.push(SampleNotice::NegativeValues {
            count: negative.len(),
            lowest,
        });
    }
    let has_se = columns.has_se();
    let (axis, rows) = match &columns.values {
        ValueColumns::Rgb { .. } => (ReadingAxis::Rgb, each_once(&table, lines, &mut notices)?),
        ValueColumns::Wide { beta, .. } => wide(&table, beta, lines, &mut notices)?,
        ValueColumns::Long { wavelength, .. } => spectral(&table, *wavelength, lines, &mut notices)?,
    };
    let doubts: Vec<Doubt> = unit_doubts(&rows).collect();
    // 1.05 is no reading at 1 degree where it is one at 60.
    let (rows, angles) = match doubts.iter().any(|doubt| matches!(doubt, Doubt::Radians { .. })) {
        true => as_read(rows),
        false => nominal(rows),
    };
    notices.extend(doubts.into_iter().map(SampleNotice::from));
    Ok(SampleCurves {
        axis,
        has_se,
        rows,
        angles,
        notices,
    })
}

/// What columns of other names were taken for, and what that means for the sign of a view.
fn renamed(columns: &SampleColumns, table: &CsvTable) -> SampleNotice {
    SampleNotice::RenamedColumns {
        columns: table.renamed().to_vec(),
        unsigned: (0..table.len()).all(|row| !table.text(row, columns.theta_v).starts_with('-')),
    }
}

/// Views and incidences that an encoder may read back below 0 where 0 was meant.
const BELOW_NORMAL_DEG: f64 = -super::nominal::ANGLE_TOLERANCE_DEG;

/// One line of readings: a whole reading, or one wavelength of the long layout.
type Line = SampleRow;

impl Line {
    fn read(table: &CsvTable, columns: &SampleColumns, row: usize, relative_se: f64) -> Result<Self, Box<CsvError>> {
        let checked = |column: usize, expected: &str, remedy: &str, allowed: &dyn Fn(f64) -> bool| {
            let value = table.number(row, column, expected)?;
            if allowed(value) {
                Ok(value)
            } else {
                Err(table.cell_error(row, column, expected, remedy))
            }
        };
        let theta_i_deg = checked(
            columns.theta_i,
            "an incidence in degrees from the normal, 0 or more and below 90",
            "check the unit and the column; the light's side is given by the sign of theta_v_deg",
            &|v| (BELOW_NORMAL_DEG..90.0).contains(&v),
        )?;
        let theta_v_deg = checked(
            columns.theta_v,
            "a signed view angle in degrees, above -90 and below 90",
            "check the unit and the column; readings are of reflection alone, with the view above the cloth",
            &|v| v.abs() < 90.0,
        )?;
        let (beta, se) = columns.places();
        let beta = beta
            .into_iter()
            .map(|column| table.number(row, column, BETA))
            .collect::<Result<Vec<_>, _>>()?;
        let se = if se.is_empty() {
            beta.iter().map(|b| b.abs() * relative_se).collect()
        } else {
            let expected = "a standard error in the unit of beta, dimensionless, 0 or more";
            se.into_iter()
                .map(|column| {
                    checked(
                        column,
                        expected,
                        "give its size without a sign, or leave the column out",
                        &|v| v >= 0.0,
                    )
                })
                .collect::<Result<Vec<_>, _>>()?
        };
        Ok(Self {
            theta_i_deg,
            theta_v_deg,
            beta,
            se,
        })
    }

    /// Values below 0 as a dark reading's noise leaves them: no farther than three of their standard errors, or than 2
    /// % of the table's largest value.
    fn negative(
        &self,
        table: &CsvTable,
        columns: &SampleColumns,
        row: usize,
        largest: f64,
    ) -> Result<Vec<f64>, Box<CsvError>> {
        const SIGMAS: f64 = 3.0;
        let values = std::iter::zip(&self.beta, &self.se).enumerate();
        let below = values.filter(|(_, (beta, _))| **beta < 0.0);
        below
            .map(
                |(k, (&beta, se))| {
                    match -beta <= (plausibility::NOISE * largest).max(SIGMAS * se) {
                true => Ok(beta),
                false => Err(table.cell_error(
                    row,
                    columns.places().0[k],
                    BETA,
                    "noise about 0 is read to 5 % of the largest value or three standard errors; a colour outside the \
                     RGB space has to be given as spectral data",
                )),
            }
                },
            )
            .collect()
    }
}

const BETA: &str = "a brightness factor, dimensionless, 0 or more";
