//! Spectra in the rows or columns of a table.

use std::ops::{Bound, RangeBounds};

use super::error::SpectrumError;
use super::grid::WavelengthGrid;
use super::plausibility;
use super::samples::Samples;
use crate::text::{CsvTable, TextNotice, band_nm};

/// Spectra by name.
pub(super) type Named = Vec<(String, Samples)>;

/// What values a file may hold, and what they are over.
#[derive(Clone)]
pub(super) struct AllowedValues {
    low: Bound<f64>,
    high: Bound<f64>,
    expected: String,
    norm: f64,
}

impl AllowedValues {
    pub(super) fn of(allowed: &impl RangeBounds<f64>) -> Self {
        let (low, high) = (allowed.start_bound().cloned(), allowed.end_bound().cloned());
        let expected = match (low, high) {
            (Bound::Included(low), Bound::Included(high)) => format!("a value in {low}..{high}, dimensionless"),
            (Bound::Included(low), _) => format!("a value of {low} or more"),
            _ => "a finite value".into(),
        };
        Self {
            low,
            high,
            expected,
            norm: 1.0,
        }
    }

    pub(super) fn over(&self, norm: f64) -> Self {
        let expected = match norm {
            1.0 => self.expected.clone(),
            norm => format!("{} times {norm}", self.expected),
        };
        Self {
            expected,
            norm,
            ..*self
        }
    }

    fn read(&self, table: &CsvTable, row: usize, column: usize) -> Result<f64, SpectrumError> {
        let value = table.number(row, column, &self.expected)? / self.norm;
        if (self.low, self.high).contains(&value) {
            return Ok(value);
        }
        let remedy = plausibility::remedy_outside(value, &(self.low, self.high));
        Err(table.cell_error(row, column, &self.expected, remedy).into())
    }
}

/// Every column of values, on the common grid of the column of wavelengths.
pub(super) fn by_wavelength(
    table: &CsvTable,
    wavelengths: usize,
    values: &AllowedValues,
) -> Result<Named, SpectrumError> {
    let mut nm = Vec::with_capacity(table.len());
    for row in 0..table.len() {
        let found = table.number(row, wavelengths, "a wavelength in nm")?;
        // Infrared of a wide table is none of its first.
        if nm.is_empty()
            && let Some(remedy) = plausibility::wavelength_unit(found)
        {
            return Err(table.cell_error(row, wavelengths, "a wavelength in nm", remedy).into());
        }
        let previous = nm.last().copied().unwrap_or(0.0);
        if found <= previous {
            let expected = format!("a wavelength above {previous} nm");
            let remedy = match found == previous {
                true => {
                    "keep one of the two rows of this wavelength, or their mean; readings over incidence and view need \
                     the columns theta_i_deg and theta_v_deg"
                }
                false => "give wavelengths above 0 nm, in one column",
            };
            return Err(table.cell_error(row, wavelengths, &expected, remedy).into());
        }
        nm.push(found);
    }
    let grid = WavelengthGrid::new(nm)?;
    let mut spectra = Vec::new();
    for (column, title) in table.columns().iter().enumerate() {
        // SAMPLE_ID and its like are notes.
        if column == wavelengths || title.starts_with("SAMPLE_") {
            continue;
        }
        // ISO 28178: per cent.
        let values = match title.as_str() {
            "SPECTRAL_PCT" => &values.over(100.0),
            _ => values,
        };
        let found = (0..table.len()).map(|row| values.read(table, row, column));
        let samples = Samples::new(title, &grid, found.collect::<Result<_, _>>()?)?;
        spectra.push((title.clone(), samples));
    }
    if spectra.is_empty() {
        let expected = "a column of values beside the wavelengths";
        return Err(table
            .header_error(expected, "none", "add a column of values, such as value")
            .into());
    }
    Ok(spectra)
}

/// A table whose rows ascend by wavelength, where they stand in another order in the file; the same row twice is one.
pub(super) fn ascending(table: CsvTable) -> CsvTable {
    let Some(column) = ["wavelength_nm", "SPECTRAL_NM"]
        .iter()
        .find_map(|name| table.column(name))
    else {
        return table;
    };
    // What is no number is told by who reads it.
    let nm: Option<Vec<f64>> = (0..table.len())
        .map(|row| table.number(row, column, "a wavelength in nm").ok())
        .collect();
    let Some(nm) = nm.filter(|nm| !nm.is_sorted_by(|a, b| a < b)) else {
        return table;
    };
    let mut rows: Vec<usize> = (0..table.len()).collect();
    rows.sort_by(|&a, &b| nm[a].total_cmp(&nm[b]));
    let is_sorted = rows.is_sorted();
    let cells = |row: usize| (0..table.columns().len()).map(move |column| (row, column));
    rows.dedup_by(|b, a| {
        cells(*a)
            .zip(cells(*b))
            .all(|(a, b)| table.text(a.0, a.1) == table.text(b.0, b.1))
    });
    let repeated = table.len() - rows.len();
    let repeated = (repeated > 0).then_some(TextNotice::RepeatedLines { lines: repeated });
    let sorted = (!is_sorted).then(|| TextNotice::SortedWavelengths {
        first_nm: nm[0],
        last_nm: nm[nm.len() - 1],
    });
    let notices: Vec<TextNotice> = sorted.into_iter().chain(repeated).collect();
    match notices.is_empty() {
        true => table,
        false => table.reordered(&rows, notices),
    }
}

/// Columns titled with wavelengths in nm, ascending by them; one at least.
pub(super) fn bands(table: &CsvTable) -> Result<Vec<(usize, f64)>, SpectrumError> {
    let titles = table.columns().iter().enumerate();
    let mut bands: Vec<(usize, f64)> = titles.filter_map(|(c, title)| Some((c, band_nm(title)?))).collect();
    bands.sort_by(|a, b| a.1.total_cmp(&b.1));
    if bands.is_empty() || !bands.is_sorted_by(|a, b| a.1 < b.1) {
        let expected = "columns titled with wavelengths in nm, each once, such as R390,R400 or SPEC_390 SPEC_400";
        let remedy = "name each column by its own wavelength";
        return Err(table.header_error(expected, &table.columns().join(","), remedy).into());
    }
    if let Some((column, remedy)) = bands
        .first()
        .and_then(|b| Some((b.0, plausibility::wavelength_unit(b.1)?)))
    {
        let found = &table.columns()[column];
        return Err(table.header_error("wavelengths in nm", found, remedy).into());
    }
    Ok(bands)
}

/// A spectrum a row, named by a column or by its number.
pub(super) fn by_set(
    table: &CsvTable,
    names: Option<usize>,
    bands: &[(usize, f64)],
    values: &AllowedValues,
) -> Result<Named, SpectrumError> {
    let grid = WavelengthGrid::new(bands.iter().map(|&(_, nm)| nm).collect())?;
    let set = |row: usize| {
        let name = names.map_or_else(|| (row + 1).to_string(), |column| table.text(row, column).to_owned());
        let found = bands.iter().map(|&(column, _)| values.read(table, row, column));
        let samples = Samples::new(&name, &grid, found.collect::<Result<_, _>>()?)?;
        Ok((name, samples))
    };
    (0..table.len()).map(set).collect()
}
