use std::collections::HashSet;

/// Where a table (CSV or CGATS text) departs from what was expected, and what to do about it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{name}, line {line}{}: expected {expected}, found {found}{}", .column.as_ref().map(|c| format!(", column {c}")).unwrap_or_default(), .remedy.as_ref().map(|r| format!("; {r}")).unwrap_or_default())]
pub struct CsvError {
    /// File or table.
    pub name: String,
    /// Counted from 1, comment lines included.
    pub line: usize,
    pub column: Option<String>,
    /// With its unit.
    pub expected: String,
    pub found: String,
    pub remedy: Option<String>,
}

/// Named columns and rows of text, each row one line of its file, so that every message can name it. The one reader of all
/// tables: spectra, dyes, measured samples.
#[derive(Debug)]
pub(crate) struct CsvTable {
    pub(super) name: String,
    /// Where the columns are named.
    pub(super) header_line: usize,
    pub(super) columns: Vec<String>,
    pub(super) rows: Vec<Row>,
}

#[derive(Debug)]
pub(super) struct Row {
    pub(super) line: usize,
    pub(super) cells: Vec<String>,
}

impl CsvTable {
    /// CSV with one header line, `#` comment lines and no quoting. At least one row is required; every row has as many
    /// cells as the header.
    pub(crate) fn parse(name: &str, bytes: &[u8]) -> Result<Self, Box<CsvError>> {
        let text = text_of(name, bytes)?;
        // The csv reader counts a record's line from the comments before it; without quoting, the k-th record is the
        // k-th line that is neither empty nor a comment.
        let mut lines = text
            .lines()
            .enumerate()
            .filter(|(_, l)| !l.is_empty() && !l.starts_with('#'))
            .map(|(i, _)| i + 1);
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .quoting(false)
            .flexible(true)
            .has_headers(false)
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let mut table = Self {
            name: name.into(),
            header_line: text.lines().count().max(1),
            columns: Vec::new(),
            rows: Vec::new(),
        };
        for record in reader.records() {
            let line = lines.next().unwrap_or(table.header_line);
            let cells: Vec<String> = match record {
                Ok(record) => record.iter().map(str::to_owned).collect(),
                Err(e) => return Err(table.error(line, None, "a CSV record", &e.to_string(), None)),
            };
            if table.columns.is_empty() {
                table.header_line = line;
                table.columns = cells;
            } else if cells.len() == table.columns.len() {
                table.rows.push(Row { line, cells });
            } else {
                let expected = format!("{} values ({})", table.columns.len(), table.columns.join(","));
                let found = format!("{}", cells.len());
                return Err(table.error(line, None, &expected, &found, Some("separate values by commas")));
            }
        }
        if table.columns.is_empty() {
            return Err(table.error(
                table.header_line,
                None,
                "a header line with column names",
                "nothing",
                None,
            ));
        }
        table.complete()
    }

    /// Refuses a column named twice and a table without rows.
    pub(super) fn complete(self) -> Result<Self, Box<CsvError>> {
        let mut seen = HashSet::new();
        if let Some(twice) = self.columns.iter().find(|c| !seen.insert(c.as_str())) {
            return Err(self.header_error("every column once", &format!("'{}' twice", shortened(twice)), None));
        }
        if self.rows.is_empty() {
            return Err(self.header_error("at least one row of values after the header", "none", None));
        }
        Ok(self)
    }

    pub(crate) fn columns(&self) -> &[String] {
        &self.columns
    }

    pub(crate) fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|c| c == name)
    }

    /// Number of rows, at least 1.
    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }

    pub(crate) fn text(&self, row: usize, column: usize) -> &str {
        &self.rows[row].cells[column]
    }

    pub(crate) fn line(&self, row: usize) -> usize {
        self.rows[row].line
    }

    /// A finite number; `expected` names the quantity and its unit.
    pub(crate) fn number(&self, row: usize, column: usize, expected: &str) -> Result<f64, Box<CsvError>> {
        match self.text(row, column).parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(self.cell_error(row, column, expected, None)),
        }
    }

    pub(crate) fn cell_error(&self, row: usize, column: usize, expected: &str, remedy: Option<&str>) -> Box<CsvError> {
        let found = match self.text(row, column) {
            "" => "nothing".to_owned(),
            cell => shortened(cell),
        };
        self.error(self.line(row), Some(&self.columns[column]), expected, &found, remedy)
    }

    pub(crate) fn row_error(&self, row: usize, expected: &str, found: &str, remedy: Option<&str>) -> Box<CsvError> {
        self.error(self.line(row), None, expected, found, remedy)
    }

    pub(crate) fn header_error(&self, expected: &str, found: &str, remedy: Option<&str>) -> Box<CsvError> {
        self.error(self.header_line, None, expected, found, remedy)
    }

    pub(super) fn error(
        &self,
        line: usize,
        column: Option<&str>,
        expected: &str,
        found: &str,
        remedy: Option<&str>,
    ) -> Box<CsvError> {
        Box::new(CsvError {
            name: self.name.clone(),
            line,
            column: column.map(shortened),
            expected: expected.into(),
            found: found.into(),
            remedy: remedy.map(str::to_owned),
        })
    }
}

/// UTF-8 text without byte order mark, lines ended by `\n` alone.
pub(super) fn text_of(name: &str, bytes: &[u8]) -> Result<String, Box<CsvError>> {
    let valid = std::str::from_utf8(bytes)
        .map_err(|e| e.valid_up_to())
        .and_then(|text| text.find('\0').map_or(Ok(text), Err));
    match valid {
        Ok(text) => Ok(text
            .trim_start_matches('\u{feff}')
            .replace("\r\n", "\n")
            .replace('\r', "\n")),
        Err(at) => Err(Box::new(CsvError {
            name: name.into(),
            line: 1 + bytes[..at].iter().filter(|&&b| b == b'\n').count(),
            column: None,
            expected: "CSV text in UTF-8".into(),
            found: format!("byte 0x{:02x}", bytes[at]),
            remedy: Some("this is not a text file: export the table as CSV".into()),
        })),
    }
}

/// What a message quotes of a cell: no control characters, no page of text.
pub(super) fn shortened(cell: &str) -> String {
    const LONGEST: usize = 40;
    let mut quoted: String = cell.escape_debug().take(LONGEST).collect();
    if cell.escape_debug().count() > LONGEST {
        quoted.push('…');
    }
    quoted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_the_line_whatever_comes_before_it() {
        for end in ["\n", "\r\n", "\r"] {
            let text = ["\u{feff}# one", "", "# two", "a,b", "1,2", "# three", "3,x"].join(end);
            let table = CsvTable::parse("t.csv", text.as_bytes()).unwrap();
            assert_eq!(
                (table.columns(), table.len()),
                (&["a".to_owned(), "b".to_owned()][..], 2)
            );
            assert_eq!(table.number(0, 1, "b in mm"), Ok(2.0));
            let error = table.number(1, 1, "b in mm").unwrap_err();
            assert_eq!(error.to_string(), "t.csv, line 7, column b: expected b in mm, found x");
        }
    }

    #[test]
    fn refuses_junk() {
        let cases: [(&[u8], usize); 8] = [
            (b"", 1),
            (b"# only a comment\n", 1),
            (b"a,b\n", 1),
            (b"a,a\n1,2\n", 1),
            (b"a,b\n1,2\n1\n", 3),
            (b"a,b\n1,2,3\n", 2),
            (b"a,b\n\xff\xfe\n", 2),
            (b"a,b\n1,\0\n", 2),
        ];
        for (bytes, line) in cases {
            assert_eq!(CsvTable::parse("t", bytes).unwrap_err().line, line, "{bytes:?}");
        }
    }
}
