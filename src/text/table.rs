use std::collections::HashSet;

use super::notice::TextNotice;
use super::{bands, titles, units};

/// Where a table (CSV or CGATS text) departs from what was expected, and what to do about it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{name}, line {line}{}: expected {expected}, found {found}; {remedy}", .column.as_ref().map(|c| format!(", \
                                                                                                                 column {c}")).unwrap_or_default())]
pub struct CsvError {
    /// File or table.
    pub name: String,
    /// Counted from 1, comment lines included.
    pub line: usize,
    pub column: Option<String>,
    /// With its unit.
    pub expected: String,
    pub found: String,
    /// What the user can do about it.
    pub remedy: String,
}

/// Named columns and rows of text, each row with its line, so that every message can name it. The one reader of all
/// tables: spectra, dyes, measured samples, goniometric readings.
#[derive(Debug, Default)]
pub(crate) struct CsvTable {
    pub(super) name: String,
    /// Where the columns are named.
    pub(super) header_line: usize,
    pub(super) columns: Vec<String>,
    /// Cells of all rows, one after the other; of a large file they are many.
    cells: String,
    /// Where each cell ends.
    ends: Vec<usize>,
    /// Of each row.
    lines: Vec<usize>,
    /// What was read in another way than its plain meaning.
    pub(super) notices: Vec<TextNotice>,
    /// Columns known by another name than the documented one: what they were taken for.
    renamed: Vec<String>,
    /// The first comments, without their mark.
    pub(super) comments: Vec<String>,
}

impl CsvTable {
    pub(super) fn new(name: &str) -> Self {
        Self {
            name: name.into(),
            header_line: 1,
            ..Self::default()
        }
    }

    /// As many cells as there are columns.
    pub(super) fn push<'c>(&mut self, line: usize, cells: impl IntoIterator<Item = &'c str>) {
        for cell in cells {
            self.cells += cell;
            self.ends.push(self.cells.len());
        }
        self.lines.push(line);
    }

    /// Refuses a column named twice and a table without rows; gives known columns the names they have in this program.
    pub(super) fn complete(mut self) -> Result<Self, Box<CsvError>> {
        if let Some((title, (expected, remedy))) = self
            .columns
            .iter()
            .find_map(|title| Some((title, units::misstated(title)?)))
        {
            return Err(self.header_error(expected, &format!("'{}'", shortened(title)), remedy));
        }
        let (names, renamed) = titles::names(&self.columns);
        for (title, name) in self.columns.iter_mut().zip(names) {
            if let Some(name) = name {
                *title = name.into();
            }
        }
        self.renamed = renamed;
        let mut seen = HashSet::new();
        if let Some(twice) = self.columns.iter().find(|c| !seen.insert(c.as_str())) {
            return Err(self.header_error(
                "every column once",
                &format!("'{}' twice", shortened(twice)),
                "rename or remove one of them",
            ));
        }
        if self.lines.is_empty() {
            return Err(self.header_error(
                "at least one row of values after the header",
                "none",
                "export the table with its values: the file may be cut short",
            ));
        }
        Ok(self)
    }

    /// The table without some of its columns.
    pub(super) fn without(self, dropped: &[usize]) -> Self {
        if dropped.is_empty() {
            return self;
        }
        let kept: Vec<usize> = (0..self.columns.len()).filter(|c| !dropped.contains(c)).collect();
        let mut table = Self {
            columns: kept.iter().map(|&c| self.columns[c].clone()).collect(),
            ..Self::new(&self.name)
        };
        for row in 0..self.len() {
            table.push(self.line(row), kept.iter().map(|&c| self.text(row, c)));
        }
        Self {
            header_line: self.header_line,
            notices: self.notices,
            comments: self.comments,
            ..table
        }
    }

    /// Readings with a column a wavelength (`390`, `R390`, `390 nm`, perhaps each with one of `_se`) as readings with
    /// the columns `wavelength_nm`, `beta` and perhaps `beta_se`, a row a wavelength; other tables as they are.
    ///
    /// # Errors
    /// Errors of other wavelengths than the values.
    pub(crate) fn long(self) -> Result<Self, Box<CsvError>> {
        let of = |title: &String| match title.to_lowercase().strip_suffix("_se") {
            Some(stem) => (None, bands::band_nm(stem)),
            None => (bands::band_nm(title), None),
        };
        let (bands, errors): (Vec<Option<f64>>, Vec<Option<f64>>) = self.columns.iter().map(of).unzip();
        let taken = ["wavelength_nm", "beta"].iter().any(|name| self.column(name).is_some());
        if taken || bands.iter().flatten().count() < 2 {
            return Ok(self);
        }
        let error_of = |nm: f64| errors.iter().position(|at| *at == Some(nm));
        let pairs: Vec<(f64, usize, Option<usize>)> = (bands.iter().enumerate())
            .filter_map(|(column, nm)| nm.map(|nm| (nm, column, error_of(nm))))
            .collect();
        let stated = pairs.iter().filter(|(_, _, error)| error.is_some()).count();
        let columns_of_errors = errors.iter().flatten().count();
        if columns_of_errors > 0 && (stated != pairs.len() || columns_of_errors != stated) {
            let found = format!("{columns_of_errors} such columns for {} wavelengths", pairs.len());
            let expected = "a column with _se for every wavelength, or none";
            return Err(self.header_error(expected, &found, "add those that are missing, or remove the others"));
        }
        let others: Vec<usize> = (0..bands.len()).filter(|&c| bands[c].or(errors[c]).is_none()).collect();
        let mut table = Self {
            columns: others.iter().map(|&c| self.columns[c].clone()).collect(),
            ..Self::new(&self.name)
        };
        table.columns.extend(["wavelength_nm".into(), "beta".into()]);
        table.columns.extend((stated > 0).then(|| "beta_se".into()));
        for row in 0..self.len() {
            for (nm, value, error) in &pairs {
                let fixed = others.iter().map(|&c| self.text(row, c));
                let error = error.map(|column| self.text(row, column));
                let nm = nm.to_string();
                table.push(
                    self.line(row),
                    fixed.chain([nm.as_str(), self.text(row, *value)]).chain(error),
                );
            }
        }
        Ok(Self {
            header_line: self.header_line,
            notices: self.notices,
            renamed: self.renamed,
            comments: self.comments,
            ..table
        })
    }

    /// The rows in another order, or some of them; `why` tells the user.
    pub(crate) fn reordered(self, rows: &[usize], why: Vec<TextNotice>) -> Self {
        let mut table = Self {
            columns: self.columns.clone(),
            ..Self::new(&self.name)
        };
        for &row in rows {
            table.push(
                self.line(row),
                (0..self.columns.len()).map(|column| self.text(row, column)),
            );
        }
        let mut notices = self.notices;
        notices.extend(why);
        Self {
            header_line: self.header_line,
            notices,
            renamed: self.renamed,
            comments: self.comments,
            ..table
        }
    }

    /// Columns known by another name than the documented one: what they were taken for.
    pub(crate) fn renamed(&self) -> &[String] {
        &self.renamed
    }

    pub(crate) fn columns(&self) -> &[String] {
        &self.columns
    }

    pub(crate) fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|c| c == name)
    }

    /// Number of rows, at least 1.
    pub(crate) fn len(&self) -> usize {
        self.lines.len()
    }

    pub(crate) fn text(&self, row: usize, column: usize) -> &str {
        let cell = row * self.columns.len() + column;
        let start = cell.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.cells[start..self.ends[cell]]
    }

    pub(crate) fn line(&self, row: usize) -> usize {
        self.lines[row]
    }

    /// What was read in another way than its plain meaning, for the user.
    pub(crate) fn notices(&self) -> &[TextNotice] {
        &self.notices
    }

    /// The first comments of the file.
    pub(crate) fn comments(&self) -> &[String] {
        &self.comments
    }

    /// A finite number; `expected` names the quantity and its unit.
    pub(crate) fn number(&self, row: usize, column: usize, expected: &str) -> Result<f64, Box<CsvError>> {
        let text = self.text(row, column);
        // Typeset tables have a minus sign in place of the hyphen.
        let value = match text.strip_prefix('\u{2212}') {
            Some(size) => size.parse().map(|size: f64| -size),
            None => text.parse(),
        };
        match value {
            Ok(value) if value.is_finite() => Ok(value),
            _ => {
                let remedy = match text {
                    "" => "fill in the value, or leave the line out",
                    _ if text.contains(',') => "write numbers with a decimal point and nothing between thousands",
                    _ if value.is_ok() => {
                        "replace it by a reading, or leave the line out: no value may be infinite or undefined"
                    }
                    _ => "write a number there, or leave the line out; a comment begins with '#'",
                };
                Err(self.cell_error(row, column, expected, remedy))
            }
        }
    }

    pub(crate) fn cell_error(&self, row: usize, column: usize, expected: &str, remedy: &str) -> Box<CsvError> {
        let found = match self.text(row, column) {
            "" => "nothing".to_owned(),
            cell => shortened(cell),
        };
        self.error(self.line(row), Some(&self.columns[column]), expected, &found, remedy)
    }

    pub(crate) fn row_error(&self, row: usize, expected: &str, found: &str, remedy: &str) -> Box<CsvError> {
        self.error(self.line(row), None, expected, found, remedy)
    }

    pub(crate) fn header_error(&self, expected: &str, found: &str, remedy: &str) -> Box<CsvError> {
        self.error(self.header_line, None, expected, found, remedy)
    }

    pub(crate) fn error(
        &self,
        line: usize,
        column: Option<&str>,
        expected: &str,
        found: &str,
        remedy: &str,
    ) -> Box<CsvError> {
        Box::new(CsvError {
            name: self.name.clone(),
            line,
            column: column.map(shortened),
            expected: expected.into(),
            found: found.into(),
            remedy: remedy.into(),
        })
    }
}

/// What a message quotes of a cell: no control characters, no page of text.
pub(crate) fn shortened(cell: &str) -> String {
    const LONGEST: usize = 40;
    let mut quoted: String = cell.escape_debug().take(LONGEST).collect();
    if cell.escape_debug().count() > LONGEST {
        quoted.push('…');
    }
    quoted
}
