use std::ops::RangeBounds;
use std::path::Path;

use super::error::SpectrumError;
use super::function::Spectrum;
use super::layout::{AllowedValues, Named, ascending, bands, by_set, by_wavelength};
use super::observer::ObserverTables;
use super::samples::Samples;
use crate::input::read_file;
use crate::text::{Cgats, CsvTable, TextNotice, band_nm, is_cgats, lines_of};

/// Largest file of spectra.
const MOST_BYTES: u64 = 8 << 20;

/// Reads one spectrum, such as a dye or an illuminant, whose values are all `allowed`: a file as of [`read_spectra`]
/// with one spectrum, in CSV the columns `wavelength_nm,value`.
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
    let (source, _) = SpectrumText::parse(name, bytes)?;
    let refuse = |expected: &str, found: String| {
        let remedy = "keep one column of values, value, beside wavelength_nm, or one set";
        Err(source.table().header_error(expected, &found, remedy).into())
    };
    let mut spectra = source.spectra(&AllowedValues::of(&allowed))?;
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
    let (source, _) = SpectrumText::parse(name, bytes)?;
    let mut spectra = source.spectra(&AllowedValues::of(&(0.0..)))?;
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
    pub notices: Vec<TextNotice>,
    /// Key words of CGATS text that state an illuminant or an observer, with their values.
    pub stated: Vec<(String, String)>,
}

impl SpectraFile {
    /// Reads any number of named spectra on common wavelengths, values of any sign and size.
    ///
    /// CSV: columns `wavelength_nm,<name>,<name>,…` with a row a wavelength, or columns titled with a wavelength in nm
    /// (`390`, `R390`, `390 nm`) with a row a spectrum; in the second a column `name`, or the only other one, names
    /// them, and more columns are notes and skipped. CGATS-like text: fields such as `SPEC_390`, `SPECTRAL_NM390`,
    /// `390_NM` or `nm390` with a set a spectrum, or a field `WAVELENGTH` or `SPECTRAL_NM` with a set a wavelength;
    /// values are over `SPECTRAL_NORM` where that is stated.
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
        let (source, encoding) = SpectrumText::parse(name, bytes)?;
        let spectra = source.spectra(&AllowedValues::of(&..))?;
        let mut notices = source.table().notices().to_vec();
        notices.extend(encoding);
        let stated = match &source {
            SpectrumText::Csv(_) => Vec::new(),
            SpectrumText::Cgats(cgats) => cgats.stated(),
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

enum SpectrumText {
    Csv(CsvTable),
    Cgats(Cgats),
}

impl SpectrumText {
    /// And a notice of the file's encoding.
    fn parse(name: &str, bytes: &[u8]) -> Result<(Self, Option<TextNotice>), SpectrumError> {
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
    fn spectra(&self, values: &AllowedValues) -> Result<Named, SpectrumError> {
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
                let remedy = "name the columns in the first line, as in wavelength_nm,value, with commas, semicolons \
                              or tabs between them, and give wavelengths in nm";
                Err(table.header_error(expected, &found, remedy).into())
            }
        }
    }
}

fn of_cgats(cgats: &Cgats, values: &AllowedValues) -> Result<Named, SpectrumError> {
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
    read_file(path, MOST_BYTES).map_err(|e| failed(e.to_string()))
}
