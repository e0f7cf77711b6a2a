//! Lines of a table of readings, put together to one row a geometry.

use std::collections::HashMap;

use super::error::SampleError;
use super::nominal::ANGLE_TOLERANCE_DEG;
use super::notice::SampleNotice;
use super::row::{ReadingAxis, SampleRow};
use crate::number::shown;
use crate::spectrum::plausibility;
use crate::spectrum::{CsvError, CsvTable, WavelengthGrid};

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
pub(super) fn each_once(
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
pub(super) fn wide(
    table: &CsvTable,
    columns: &[(f64, usize)],
    lines: Vec<SampleRow>,
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
fn joined(geometries: &[Gathered], entries: &[SampleRow]) -> (Vec<Gathered>, f64) {
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
pub(super) fn spectral(
    table: &CsvTable,
    column: usize,
    entries: Vec<SampleRow>,
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
