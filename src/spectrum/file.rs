use std::fs::File;
use std::io::Read;
use std::ops::{Bound, RangeBounds};
use std::path::Path;

use super::tables::ObserverTables;
use super::{CsvTable, Samples, Spectrum, SpectrumError, WavelengthGrid, plausibility};
use crate::text::{Cgats, band_nm, is_cgats, lines_of};

/// Largest file of spectra.
const MOST_BYTES: u64 = 8 << 20;

/// Reads one spectrum, such as a dye or an illuminant, whose values are all `allowed`: a file as of [`read_spectra`] with one
/// spectrum, in CSV the columns `wavelength_nm,value`.
///
/// # Errors
/// The first place where the file departs from that.
pub fn read_spectrum(path: &Path, allowed: impl RangeBounds<f64>) -> Result<Spectrum, SpectrumError> {
    parse_spectrum(&path.display().to_string(), &bytes_of(path)?, allowed)
}

/// [`read_spectrum`] of the bytes of a file; `name` is what errors call them.
///
/// # Errors
/// As [`read_spectrum`].
pub fn parse_spectrum(name: &str, bytes: &[u8], allowed: impl RangeBounds<f64>) -> Result<Spectrum, SpectrumError> {
    let (source, _) = Source::parse(name, bytes)?;
    let refuse = |expected: &str, found: String| {
        let remedy = "keep one column of values, value, beside wavelength_nm, or one set";
        Err(source.table().header_error(expected, &found, remedy).into())
    };
    let mut spectra = source.spectra(&Values::of(&allowed))?;
    if spectra.len() != 1 {
        return refuse("one spectrum", spectra.len().to_string());
    }
    let (_, samples) = spectra.swap_remove(0);
    Ok(Spectrum::Table {
        name: name.into(),
        samples,
    })
}

/// Colour-matching functions from the bytes of a file: three spectra xbar, ybar, zbar, 0 or more, in a layout of
/// [`read_spectra`].
///
/// # Errors
/// The first place where the file departs from that.
pub fn parse_observer(name: &str, bytes: &[u8]) -> Result<ObserverTables, SpectrumError> {
    let (source, _) = Source::parse(name, bytes)?;
    let mut spectra = source.spectra(&Values::of(&(0.0..)))?;
    spectra.sort_by_key(|(title, _)| title.to_ascii_lowercase());
    let titles: Vec<&str> = spectra.iter().map(|(title, _)| title.as_str()).collect();
    let named = titles.iter().map(|title| title.to_ascii_lowercase());
    if !named.eq(["xbar", "ybar", "zbar"]) {
        let expected = "three spectra, xbar, ybar and zbar";
        let remedy = "name the three columns so, beside wavelength_nm";
        return Err(source.table().header_error(expected, &titles.join(", "), remedy).into());
    }
    let mut functions = spectra.into_iter().map(|(title, samples)| Spectrum::Table {
        name: format!("{name} {title}"),
        samples,
    });
    match (functions.next(), functions.next(), functions.next()) {
        (Some(x_bar), Some(y_bar), Some(z_bar)) => Ok(ObserverTables { x_bar, y_bar, z_bar }),
        _ => Err(SpectrumError::Empty),
    }
}

/// Spectra on common wavelengths and what their file says beside them.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectraFile {
    /// By name; one at least.
    pub spectra: Vec<(String, Samples)>,
    /// What was read in another way than its plain meaning.
    pub notices: Vec<String>,
    /// Key words of CGATS text that state an illuminant or an observer, with their values.
    pub stated: Vec<(String, String)>,
}

impl SpectraFile {
    /// Reads any number of named spectra on common wavelengths, values of any sign and size.
    ///
    /// CSV: columns `wavelength_nm,<name>,<name>,…` with a row a wavelength, or columns titled with a wavelength in nm (`390`,
    /// `R390`, `390 nm`) with a row a spectrum; in the second a column `name`, or the only other one, names them, and more columns are notes and skipped.
    /// CGATS-like text: fields such as `SPEC_390`, `SPECTRAL_NM390`, `390_NM` or `nm390` with a set a spectrum, or a field
    /// `WAVELENGTH` or `SPECTRAL_NM` with a set a wavelength; values are over `SPECTRAL_NORM` where that is stated.
    ///
    /// # Errors
    /// The first place where the file departs from its layout; a file over 8 MiB.
    pub fn read(path: &Path) -> Result<Self, SpectrumError> {
        Self::parse(&path.display().to_string(), &bytes_of(path)?)
    }

    /// [`SpectraFile::read`] of the bytes of a file; `name` is what errors call them.
    ///
    /// # Errors
    /// As [`SpectraFile::read`].
    pub fn parse(name: &str, bytes: &[u8]) -> Result<Self, SpectrumError> {
        let (source, encoding) = Source::parse(name, bytes)?;
        let spectra = source.spectra(&Values::of(&..))?;
        let mut notices = source.table().notices().to_vec();
        notices.extend(encoding);
        let stated = match &source {
            Source::Csv(_) => Vec::new(),
            Source::Cgats(cgats) => cgats.stated(),
        };
        Ok(Self {
            spectra,
            notices,
            stated,
        })
    }
}

/// The spectra of [`SpectraFile::read`] alone.
///
/// # Errors
/// As [`SpectraFile::read`].
pub fn read_spectra(path: &Path) -> Result<Vec<(String, Samples)>, SpectrumError> {
    Ok(SpectraFile::read(path)?.spectra)
}

/// [`read_spectra`] of the bytes of a file; `name` is what errors call them.
///
/// # Errors
/// As [`SpectraFile::read`].
pub fn parse_spectra(name: &str, bytes: &[u8]) -> Result<Vec<(String, Samples)>, SpectrumError> {
    Ok(SpectraFile::parse(name, bytes)?.spectra)
}

/// What values a file may hold, and what they are over.
#[derive(Clone)]
pub(super) struct Values {
    low: Bound<f64>,
    high: Bound<f64>,
    expected: String,
    norm: f64,
}

impl Values {
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

    fn over(&self, norm: f64) -> Self {
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

type Named = Vec<(String, Samples)>;

enum Source {
    Csv(CsvTable),
    Cgats(Cgats),
}

impl Source {
    /// And a notice of the file's encoding.
    fn parse(name: &str, bytes: &[u8]) -> Result<(Self, Option<String>), SpectrumError> {
        let (text, encoding) = lines_of(name, bytes)?;
        let source = match is_cgats(&text) {
            true => {
                let mut cgats = Cgats::parse(name, &text)?;
                cgats.table = ascending(cgats.table);
                Self::Cgats(cgats)
            }
            false => Self::Csv(ascending(CsvTable::parse_text(name, &text)?)),
        };
        Ok((source, encoding))
    }

    fn table(&self) -> &CsvTable {
        match self {
            Self::Csv(table) => table,
            Self::Cgats(cgats) => &cgats.table,
        }
    }

    /// One at least.
    fn spectra(&self, values: &Values) -> Result<Named, SpectrumError> {
        let table = match self {
            Self::Csv(table) => table,
            Self::Cgats(cgats) => return of_cgats(cgats, values),
        };
        let is_band = |column: &usize| band_nm(&table.columns()[*column]).is_some();
        let titled = || (0..table.columns().len()).filter(is_band).count();
        // A single column beside those of wavelengths names the rows, whatever its title.
        let mut others = (0..table.columns().len()).filter(|column| !is_band(column));
        let only_other = others.next().filter(|_| others.next().is_none());
        let names = table.column("name").or(only_other.filter(|_| titled() >= 3));
        match table.column("wavelength_nm") {
            Some(wavelengths) => by_wavelength(table, wavelengths, values),
            // Without names, two numbers may as well be the first row of a table that has no header.
            None if names.is_some() || titled() >= 3 => by_set(table, names, &bands(table)?, values),
            None => {
                let expected = "a column wavelength_nm, or columns titled with wavelengths in nm";
                let found = table.columns().join(",");
                let remedy = "name the columns in the first line, as in wavelength_nm,value, with commas, semicolons or tabs \
                              between them, and give wavelengths in nm";
                Err(table.header_error(expected, &found, remedy).into())
            }
        }
    }
}

fn of_cgats(cgats: &Cgats, values: &Values) -> Result<Named, SpectrumError> {
    let table = &cgats.table;
    // The first of the names that is there.
    let field = |names: &[&str]| {
        let at = |name: &&str| {
            table
                .columns()
                .iter()
                .position(|title| title.eq_ignore_ascii_case(name))
        };
        names.iter().find_map(at)
    };
    let values = values.over(cgats.number("SPECTRAL_NORM")?.map_or(1.0, |(norm, _)| norm));
    if let Some(wavelengths) = field(&["WAVELENGTH", "WAVELENGTH_NM", "SPECTRAL_NM"]) {
        return by_wavelength(table, wavelengths, &values);
    }
    let mut bands = bands(table)?;
    // Where bands are no whole nanometres apart, titles are rounded and the key words hold the wavelengths.
    if let (Some((count, line)), Some((start, _)), Some((end, _))) = (
        cgats.number("SPECTRAL_BANDS")?,
        cgats.number("SPECTRAL_START_NM")?,
        cgats.number("SPECTRAL_END_NM")?,
    ) {
        let steps = (bands.len() - 1).max(1) as f64;
        let stated = |k: usize| start + k as f64 * (end - start) / steps;
        let rounded = |(k, (_, nm)): (usize, &(usize, f64))| (stated(k) - nm).abs() <= 0.5 + 1e-9;
        if count != bands.len() as f64 || !bands.iter().enumerate().all(rounded) {
            let expected = format!("{count} bands from {start} to {end} nm, as key words state");
            let (first, last) = (bands[0].1, bands[bands.len() - 1].1);
            let found = format!("{} fields from {first} to {last} nm", bands.len());
            return Err(table
                .error(
                    line,
                    Some("SPECTRAL_BANDS"),
                    &expected,
                    &found,
                    "correct the key words, or remove them",
                )
                .into());
        }
        for (k, band) in bands.iter_mut().enumerate() {
            band.1 = stated(k);
        }
    }
    by_set(table, field(&["SAMPLE_NAME", "NAME", "SAMPLE_ID"]), &bands, &values)
}

/// Every column of values, on the common grid of the column of wavelengths.
pub(super) fn by_wavelength(table: &CsvTable, wavelengths: usize, values: &Values) -> Result<Named, SpectrumError> {
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
                    "keep one of the two rows of this wavelength, or their mean; readings over incidence and view need the columns theta_i_deg \
                         and theta_v_deg"
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
fn ascending(table: CsvTable) -> CsvTable {
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
    let repeated = plausibility::repeated(table.len() - rows.len());
    let sorted = (!is_sorted).then(|| {
        format!(
            "wavelengths stand in another order in the file, from {} to {} nm: sorted with their values",
            nm[0],
            nm[nm.len() - 1]
        )
    });
    let notices: Vec<String> = sorted.into_iter().chain(repeated).collect();
    match notices.is_empty() {
        true => table,
        false => table.reordered(&rows, notices.join("; ")),
    }
}

/// Columns titled with wavelengths in nm, ascending by them; one at least.
fn bands(table: &CsvTable) -> Result<Vec<(usize, f64)>, SpectrumError> {
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
fn by_set(
    table: &CsvTable,
    names: Option<usize>,
    bands: &[(usize, f64)],
    values: &Values,
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

/// The bytes of a file of spectra; its size is looked at before it is read.
pub(crate) fn bytes_of(path: &Path) -> Result<Vec<u8>, SpectrumError> {
    let failed = |reason: String| SpectrumError::Read {
        path: path.display().to_string(),
        reason,
    };
    // Asked before opening: to open a named pipe is to wait for ever.
    let there = std::fs::metadata(path).map_err(|e| failed(e.to_string()))?;
    if !there.is_file() {
        return Err(failed("expected a file, found a folder, device or pipe".into()));
    }
    if there.len() > MOST_BYTES {
        let found = there.len();
        return Err(failed(format!(
            "expected a table of at most {MOST_BYTES} bytes, found {found}"
        )));
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(|e| failed(e.to_string()))?;
    file.take(MOST_BYTES)
        .read_to_end(&mut bytes)
        .map_err(|e| failed(e.to_string()))?;
    Ok(bytes)
}
