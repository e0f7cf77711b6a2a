use std::ops::RangeInclusive;
use std::path::Path;

use super::{CsvTable, Samples, Spectrum, SpectrumError, WavelengthGrid};

/// Reads a user's dye or reflectance: CSV with the columns `wavelength_nm,value`, `#` comments allowed.
///
/// Wavelengths ascend strictly, in nm; values are dimensionless, 0..1 (1 at a dye's peak).
pub fn read_csv_spectrum(path: &Path) -> Result<Spectrum, SpectrumError> {
    let table = CsvTable::parse(&path.display().to_string(), &bytes_of(path)?)?;
    let expected = ["wavelength_nm", "value"];
    if table.columns() != expected {
        return Err(table
            .header_error(
                "the columns wavelength_nm,value",
                &table.columns().join(","),
                Some("name the columns in the first line that is not a comment"),
            )
            .into());
    }
    let mut columns = spectra_by_column(&table, 0, Some(0.0..=1.0))?;
    let (_, samples) = columns.remove(0);
    Ok(Spectrum::Table {
        name: path.display().to_string(),
        samples,
    })
}

/// Reads any number of named spectra, values of any sign and size, from a CSV file in one of two layouts:
/// columns `wavelength_nm,<name>,<name>,…` with a row a wavelength, or a column `name` and columns titled with a
/// wavelength in nm (`390` or `R390`) with a row a spectrum; in the second, other columns are notes and skipped.
pub fn read_csv_spectra(path: &Path) -> Result<Vec<(String, Samples)>, SpectrumError> {
    let table = CsvTable::parse(&path.display().to_string(), &bytes_of(path)?)?;
    match (table.column("wavelength_nm"), table.column("name")) {
        (Some(wavelengths), _) => spectra_by_column(&table, wavelengths, None),
        (None, Some(names)) => spectra_by_row(&table, names),
        (None, None) => Err(table
            .header_error(
                "a column wavelength_nm, or a column name and columns titled with wavelengths in nm",
                &table.columns().join(","),
                None,
            )
            .into()),
    }
}

/// Every column but the one with the wavelengths, on their common grid.
pub(super) fn spectra_by_column(
    table: &CsvTable,
    wavelengths: usize,
    allowed: Option<RangeInclusive<f64>>,
) -> Result<Vec<(String, Samples)>, SpectrumError> {
    let mut nm = Vec::with_capacity(table.len());
    for row in 0..table.len() {
        let found = table.number(row, wavelengths, "a wavelength in nm")?;
        let previous = nm.last().copied().unwrap_or(0.0);
        if found <= previous {
            let expected = format!("a wavelength above {previous} nm");
            return Err(table
                .cell_error(
                    row,
                    wavelengths,
                    &expected,
                    Some("sort the rows by wavelength, each once"),
                )
                .into());
        }
        nm.push(found);
    }
    let grid = WavelengthGrid::new(nm)?;
    let expected = match &allowed {
        Some(range) => format!("a value in {}..{}, dimensionless", range.start(), range.end()),
        None => "a finite value".into(),
    };
    let mut spectra = Vec::new();
    for (column, title) in table.columns().iter().enumerate().filter(|(c, _)| *c != wavelengths) {
        let mut values = Vec::with_capacity(table.len());
        for row in 0..table.len() {
            let value = table.number(row, column, &expected)?;
            if allowed.as_ref().is_some_and(|range| !range.contains(&value)) {
                return Err(table.cell_error(row, column, &expected, None).into());
            }
            values.push(value);
        }
        spectra.push((title.clone(), Samples::new(title, &grid, values)?));
    }
    if spectra.is_empty() {
        return Err(table
            .header_error("a column of values beside wavelength_nm", "none", None)
            .into());
    }
    Ok(spectra)
}

fn spectra_by_row(table: &CsvTable, names: usize) -> Result<Vec<(String, Samples)>, SpectrumError> {
    let (columns, nm): (Vec<usize>, Vec<f64>) = table
        .columns()
        .iter()
        .enumerate()
        .filter_map(|(c, title)| Some((c, title.strip_prefix('R').unwrap_or(title).parse::<f64>().ok()?)))
        .unzip();
    if !nm.is_sorted_by(|a, b| a < b) || nm.first().is_none_or(|&w| w <= 0.0) {
        return Err(table
            .header_error(
                "columns titled with ascending wavelengths in nm, such as R390,R400",
                &table.columns().join(","),
                None,
            )
            .into());
    }
    let grid = WavelengthGrid::new(nm)?;
    (0..table.len())
        .map(|row| {
            let values = columns
                .iter()
                .map(|&c| table.number(row, c, "a finite value"))
                .collect::<Result<Vec<_>, _>>()?;
            let name = table.text(row, names);
            Ok((name.to_owned(), Samples::new(name, &grid, values)?))
        })
        .collect()
}

fn bytes_of(path: &Path) -> Result<Vec<u8>, SpectrumError> {
    std::fs::read(path).map_err(|e| SpectrumError::Read {
        path: path.display().to_string(),
        reason: e.to_string(),
    })
}
