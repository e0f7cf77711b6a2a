//! Readings over incidence and view from this program's CSV and its usual variants.

use std::collections::HashMap;

use super::columns::{SampleColumns, ValueColumns};
use super::error::SampleError;
use super::nominal::{ANGLE_TOLERANCE_DEG, AnglesRead, as_read, nominal};
use super::notice::SampleNotice;
use super::row::{ReadingAxis, SampleRow, unit_doubts};
use crate::number::shown;
use crate::spectrum::plausibility;
use crate::spectrum::{CsvError, CsvTable, Doubt, WavelengthGrid};

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
            .map(|(k, (&beta, se))| match -beta <= (plausibility::NOISE * largest).max(SIGMAS * se) {
                true => Ok(beta),
                false => Err(table.cell_error(
                    row,
                    columns.places().0[k],
                    BETA,
                    "noise about 0 is read to 5 % of the largest value or three standard errors; a colour outside the RGB \
                     space has to be given as spectral data",
                )),
            })
            .collect()
    }
}

const BETA: &str = "a brightness factor, dimensionless, 0 or more";

/// Bits of the two angles; adding 0 makes one zero of the two.
fn key(row: &SampleRow) -> [u64; 2] {
    [(row.theta_i_deg + 0.0).to_bits(), (row.theta_v_deg + 0.0).to_bits()]
}

fn geometry_text(row: &SampleRow) -> String {
    format!(
        "theta_i_deg {}, theta_v_deg {}",
        shown(row.theta_i_deg),
        shown(row.theta_v_deg)
    )
}

/// Rows of different geometries; the same reading written twice is one, and `notices` tell how many.
fn each_once(
    table: &CsvTable,
    entries: Vec<SampleRow>,
    notices: &mut Vec<SampleNotice>,
) -> Result<Vec<SampleRow>, Box<CsvError>> {
    let mut seen: HashMap<[u64; 2], usize> = HashMap::new();
    let mut repeated = 0;
    let mut first_lines = Vec::new();
    let mut rows: Vec<SampleRow> = Vec::with_capacity(entries.len());
    for (index, entry) in entries.into_iter().enumerate() {
        match seen.get(&key(&entry)) {
            Some(&first) if rows[first] == entry => repeated += 1,
            Some(&first) => return Err(twice(table, index, first_lines[first], &geometry_text(&entry))),
            None => {
                seen.insert(key(&entry), rows.len());
                rows.push(entry);
                first_lines.push(index);
            }
        }
    }
    notices.extend(plausibility::repeated(repeated).map(SampleNotice::from));
    Ok(rows)
}

fn twice(table: &CsvTable, row: usize, first: usize, what: &str) -> Box<CsvError> {
    let found = format!("{what} again with another value, first on line {}", table.line(first));
    table.row_error(row, "every geometry once", &found, "keep one, or their mean")
}

/// Common to the observers' and the illuminants' tables.
const COLOUR_NM: std::ops::RangeInclusive<f64> = 360.0..=780.0;

/// Tells how many wavelengths lie beyond the CIE's tables.
fn beyond_colour(count: usize, notices: &mut Vec<SampleNotice>) {
    if count > 0 {
        notices.push(SampleNotice::OutsideColour { count });
    }
}

/// Readings with all their wavelengths on one line.
fn wide(
    table: &CsvTable,
    columns: &[(f64, usize)],
    lines: Vec<Line>,
    notices: &mut Vec<SampleNotice>,
) -> Result<(ReadingAxis, Vec<SampleRow>), SampleError> {
    let kept = |k: &usize| COLOUR_NM.contains(&columns[*k].0);
    let places: Vec<usize> = (0..columns.len()).filter(kept).collect();
    if places.len() < 2 {
        let found = format!("{} nm to {} nm", columns[0].0, columns[columns.len() - 1].0);
        let expected = "two or more columns named by wavelengths from 360 to 780 nm";
        let remedy = "measure in the visible, or name the columns by wavelengths in nm";
        return Err(table.header_error(expected, &found, remedy).into());
    }
    beyond_colour((columns.len() - places.len()) * lines.len(), notices);
    let nm = places.iter().map(|&k| columns[k].0).collect();
    let take = |values: &[f64]| places.iter().map(|&k| values[k]).collect();
    let rows = lines
        .into_iter()
        .map(|line| SampleRow {
            beta: take(&line.beta),
            se: take(&line.se),
            ..line
        })
        .collect();
    let rows = each_once(table, rows, notices)?;
    Ok((ReadingAxis::Wavelengths(WavelengthGrid::new(nm)?), rows))
}

/// One geometry of a spectral table while its lines are gathered.
struct Gathered {
    first_row: usize,
    /// (wavelength in nm, row of the table)
    points: Vec<(f64, usize)>,
}

/// Geometries whose angles differ by no more than an encoder's, put together: each reading goes to the nearest one that
/// has not its wavelength yet. And the largest difference of an angle from that of the first reading, degrees.
fn joined(geometries: &[Gathered], entries: &[Line]) -> (Vec<Gathered>, f64) {
    let mut all: Vec<(f64, usize)> = geometries.iter().flat_map(|gathered| gathered.points.clone()).collect();
    all.sort_by_key(|point| point.1);
    let mut joined: Vec<Gathered> = Vec::new();
    let mut largest_deg = 0.0f64;
    for point in all {
        let entry = &entries[point.1];
        let distance = |gathered: &Gathered| {
            let first = &entries[gathered.first_row];
            let [i, v] = [
                entry.theta_i_deg - first.theta_i_deg,
                entry.theta_v_deg - first.theta_v_deg,
            ];
            i.abs().max(v.abs())
        };
        let free = |(_, gathered): &(usize, &Gathered)| {
            distance(gathered) <= ANGLE_TOLERANCE_DEG && gathered.points.iter().all(|known| known.0 != point.0)
        };
        let nearest = joined
            .iter()
            .enumerate()
            .filter(free)
            .min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
        match nearest.map(|(at, gathered)| (at, distance(gathered))) {
            Some((at, distance)) => {
                largest_deg = largest_deg.max(distance);
                joined[at].points.push(point);
            }
            None => joined.push(Gathered {
                first_row: point.1,
                points: vec![point],
            }),
        }
    }
    for gathered in &mut joined {
        gathered.points.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    (joined, largest_deg)
}

/// Readings with one wavelength a line.
fn spectral(
    table: &CsvTable,
    column: usize,
    entries: Vec<Line>,
    notices: &mut Vec<SampleNotice>,
) -> Result<(ReadingAxis, Vec<SampleRow>), SampleError> {
    const NM: std::ops::RangeInclusive<f64> = 100.0..=3000.0;
    let mut found: HashMap<[u64; 2], usize> = HashMap::new();
    let mut geometries: Vec<Gathered> = Vec::new();
    let mut beyond = 0;
    for (row, entry) in entries.iter().enumerate() {
        let expected = "a wavelength in nm, 360..780, where the CIE tables are";
        let nm = table.number(row, column, expected)?;
        if !NM.contains(&nm) {
            let remedy = plausibility::wavelength_unit(nm).unwrap_or("leave the row out");
            return Err(table.cell_error(row, column, expected, remedy).into());
        }
        if !COLOUR_NM.contains(&nm) {
            beyond += 1;
            continue;
        }
        let index = *found.entry(key(entry)).or_insert_with(|| {
            geometries.push(Gathered {
                first_row: row,
                points: Vec::new(),
            });
            geometries.len() - 1
        });
        geometries[index].points.push((nm, row));
    }
    if geometries.is_empty() {
        let expected = "wavelengths in nm within 360..780, where the CIE tables are";
        return Err(table
            .row_error(0, expected, "none", "measure in the visible, or give wavelengths in nm")
            .into());
    }
    beyond_colour(beyond, notices);
    let mut repeated = 0;
    for geometry in &mut geometries {
        geometry.points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let all = geometry.points.len();
        geometry
            .points
            .dedup_by(|b, a| a.0 == b.0 && entries[a.1] == entries[b.1]);
        repeated += all - geometry.points.len();
        if let Some(pair) = geometry.points.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            let what = format!("{}, {} nm", geometry_text(&entries[pair[1].1]), pair[1].0);
            return Err(twice(table, pair[1].1, pair[0].1, &what).into());
        }
    }
    notices.extend(plausibility::repeated(repeated).map(SampleNotice::from));
    let unlike = |geometries: &[Gathered]| {
        let nm = |gathered: &Gathered| -> Vec<f64> { gathered.points.iter().map(|point| point.0).collect() };
        let first = nm(&geometries[0]);
        geometries.iter().position(|gathered| nm(gathered) != first)
    };
    let mut joined_deg = 0.0;
    if unlike(&geometries).is_some() {
        // An encoder may have been read anew at each wavelength.
        let (joined, largest_deg) = joined(&geometries, &entries);
        if unlike(&joined).is_none() {
            (geometries, joined_deg) = (joined, largest_deg);
            notices.push(SampleNotice::AnglesOfWavelengths { largest_deg });
        }
    }
    let nm: Vec<f64> = geometries[0].points.iter().map(|point| point.0).collect();
    if let Some(other) = unlike(&geometries).map(|at| &geometries[at]) {
        let first = &entries[geometries[0].first_row];
        let expected = format!("the {} wavelengths of {}", nm.len(), geometry_text(first));
        let text = format!(
            "{} others at {}",
            other.points.len(),
            geometry_text(&entries[other.first_row])
        );
        let remedy = "measure every geometry at the same wavelengths, or resample first";
        return Err(table.row_error(other.first_row, &expected, &text, remedy).into());
    }
    let rows = geometries
        .iter()
        .map(|geometry| {
            let values =
                |of: fn(&SampleRow) -> f64| geometry.points.iter().map(|point| of(&entries[point.1])).collect();
            let angle = |of: fn(&SampleRow) -> f64| match joined_deg > 0.0 {
                true => geometry.points.iter().map(|point| of(&entries[point.1])).sum::<f64>() / nm.len() as f64,
                false => of(&entries[geometry.first_row]),
            };
            SampleRow {
                theta_i_deg: angle(|entry| entry.theta_i_deg),
                theta_v_deg: angle(|entry| entry.theta_v_deg),
                beta: values(|entry| entry.beta[0]),
                se: values(|entry| entry.se[0]),
            }
        })
        .collect();
    Ok((ReadingAxis::Wavelengths(WavelengthGrid::new(nm)?), rows))
}
