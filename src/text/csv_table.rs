//! CSV as RFC 4180 has it and as spreadsheets, R and instruments write it.

use super::decimals::Decimals;
use super::encoding::decode;
use super::foreign::foreign;
use super::notice::TextNotice;
use super::records::{Record, Rows, is_comment, stated_separator};
use super::table::{CsvError, CsvTable, shortened};
use super::{titles, units};

impl CsvTable {
    /// Reads CSV with one header line: fields perhaps in double quotes, separated by commas, semicolons or tabs,
    /// whichever the header has most of, by white space where it has none of them, or by the one that a first line
    /// `sep=;` names.
    ///
    /// Passed over: comments (`#`), empty rows, empty cells behind the last column, a row of units below the header, a
    /// column of row numbers without a title. Decimal commas are read where a comma separates nothing, and the notices
    /// say so.
    ///
    /// # Errors
    /// Bytes that are no text; no header or no row; a row with more or fewer cells than the header; commas that can be
    /// decimal or of thousands.
    pub(crate) fn parse(name: &str, bytes: &[u8]) -> Result<Self, Box<CsvError>> {
        let (text, notice) = lines_of(name, bytes)?;
        let mut table = Self::parse_text(name, &text)?;
        table.notices.extend(notice);
        Ok(table)
    }

    /// [`CsvTable::parse`] of text whose lines end with `\n`.
    pub(crate) fn parse_text(name: &str, text: &str) -> Result<Self, Box<CsvError>> {
        let mut table = Self::new(name);
        table.header_line = text.lines().count().max(1);
        // DOS ends a text with it.
        let text = text.strip_suffix('\u{1a}').unwrap_or(text);
        let commented = without_preamble(text);
        if let Some((count, _)) = &commented {
            table.notices.push(TextNotice::Preamble { lines: *count });
        }
        let text = commented.as_ref().map_or(text, |(_, text)| text);
        let spaced = tabbed(text);
        let mut rows = Rows::new(spaced.as_deref().unwrap_or(text));
        let mut decimals = Decimals::default();
        while let Some(row) = rows.next(&mut table.comments) {
            let row = row.map_err(|e| table.error(e.line, None, e.expected, &e.found, e.remedy))?;
            if table.columns.is_empty() {
                table.header_line = row.line;
                table.columns = row.cells;
            } else if rows.count == 2
                && row.cells.iter().all(|cell| units::is_unit(cell))
                && row.cells.iter().any(|cell| cell.parse::<f64>().is_err())
            {
                table.check_units(&row)?;
            } else {
                let cells = table.fitted(row.cells, row.line, rows.separator, row.is_quoted)?;
                let cells = cells.into_iter().map(|cell| decimals.cell(cell, row.line));
                let cells: Vec<String> = cells.collect();
                table.push(row.line, cells.iter().map(String::as_str));
            }
        }
        if table.columns.is_empty() {
            return Err(table.error(
                table.header_line,
                None,
                "a header line with column names",
                "nothing",
                "name the columns in the first line, such as wavelength_nm,value",
            ));
        }
        if let Some(ambiguous) = decimals.ambiguous() {
            let (line, expected, found, remedy) = ambiguous;
            return Err(table.error(line, None, expected, &found, remedy));
        }
        table.notices.extend(decimals.notice());
        table.titled()?.complete()
    }

    /// The cells of a row, as many as there are columns.
    fn fitted(
        &self,
        mut cells: Vec<String>,
        line: usize,
        separator: u8,
        is_quoted: bool,
    ) -> Result<Vec<String>, Box<CsvError>> {
        let columns = self.columns.len();
        let titled = columns - self.columns.iter().rev().take_while(|title| title.is_empty()).count();
        while cells.len() > columns && cells.last().is_some_and(String::is_empty) {
            cells.pop();
        }
        if cells.len() >= titled && cells.len() < columns {
            cells.resize(columns, String::new());
        }
        // R's write.table gives row names, in quotes, no title.
        if cells.len() == columns + 1 && is_quoted && cells[0] == (self.len() + 1).to_string() {
            cells.remove(0);
        }
        if cells.len() == columns {
            return Ok(cells);
        }
        let expected = format!("{titled} values ({})", self.columns[..titled].join(","));
        let found = format!("{}", cells.len());
        let remedy = match separator {
            b',' if cells.len() > columns => {
                "separate values by commas, one for each title; numbers with a decimal comma need semicolons between \
                 them"
            }
            b',' => "separate values by commas",
            b';' => "separate values by semicolons, as the titles are",
            b'|' => "separate values by '|', as the titles are",
            _ => "separate values by tabs, as the titles are",
        };
        Err(self.error(line, None, &expected, &found, remedy))
    }

    fn check_units(&self, row: &Record) -> Result<(), Box<CsvError>> {
        let (names, _) = titles::names(&self.columns);
        for ((title, name), unit) in self.columns.iter().zip(names).zip(&row.cells) {
            let name = name.unwrap_or(title);
            if let Some((expected, remedy)) = units::contradicts(name, unit) {
                return Err(self.error(row.line, Some(title), expected, &shortened(unit), remedy));
            }
        }
        Ok(())
    }

    /// Sees to columns without a title: empty ones and row numbers are dropped, names of rows are titled, others
    /// refused.
    fn titled(mut self) -> Result<Self, Box<CsvError>> {
        let untitled: Vec<usize> = (0..self.columns.len())
            .filter(|&c| self.columns[c].is_empty())
            .collect();
        let mut dropped = Vec::new();
        for column in untitled {
            let counts_from =
                |first: usize| (0..self.len()).all(|row| self.text(row, column) == (row + first).to_string());
            if (0..self.len()).all(|row| self.text(row, column).is_empty()) {
                dropped.push(column);
            } else if column == 0 && self.len() > 0 && (counts_from(0) || counts_from(1)) {
                dropped.push(column);
                self.notices.push(TextNotice::RowNumbers);
            } else if column == 0 && (0..self.len()).all(|row| self.text(row, 0).parse::<f64>().is_err()) {
                self.columns[0] = "name".into();
            } else {
                let expected = format!("a title for column {}", column + 1);
                return Err(self.header_error(&expected, "none", "name it or remove it"));
            }
        }
        Ok(self.without(&dropped))
    }
}

/// Text of a file with lines that end with `\n`, and a notice of its encoding.
pub(crate) fn lines_of(name: &str, bytes: &[u8]) -> Result<(String, Option<TextNotice>), Box<CsvError>> {
    if let Some(found) = foreign(bytes) {
        return Err(Box::new(CsvError {
            name: name.into(),
            line: 1,
            column: None,
            expected: "a table as text".into(),
            found: found.what.into(),
            remedy: found.remedy.into(),
        }));
    }
    match decode(bytes) {
        Ok(decoded) => {
            let text = match decoded.text.contains('\r') {
                true => decoded.text.replace("\r\n", "\n").replace('\r', "\n"),
                false => decoded.text.into_owned(),
            };
            Ok((text, decoded.notice))
        }
        Err(not_text) => Err(Box::new(CsvError {
            name: name.into(),
            line: not_text.line,
            column: None,
            expected: "text in UTF-8, UTF-16 or Latin-1".into(),
            found: format!("byte 0x{:02x}", not_text.byte),
            remedy: "this is a binary file: export the table as CSV text".into(),
        })),
    }
}

/// A text with what instruments write before the titles made comments, and the number of such lines; `None` where the
/// first line is no preamble, or nothing below it looks like titles.
fn without_preamble(text: &str) -> Option<(usize, String)> {
    /// Lines that a preamble has at most.
    const LINES: usize = 200;
    let is_content = |line: &&str| !line.trim().is_empty() && !is_comment(line) && stated_separator(line).is_none();
    let first = text.lines().find(is_content)?;
    if titles::heading(first).is_some() {
        return None;
    }
    let at = text
        .lines()
        .take(LINES)
        .position(|line| is_content(&line) && titles::heading(line).is_some())?;
    let mut count = 0;
    let mut commented = String::with_capacity(text.len() + LINES);
    for (index, line) in text.lines().enumerate() {
        if index < at && is_content(&line) {
            count += 1;
            commented += "# ";
        }
        commented += line;
        commented.push('\n');
    }
    Some((count, commented))
}

/// A text whose fields are separated by white space alone, with tabs in its place; `None` for other texts.
fn tabbed(text: &str) -> Option<String> {
    let header = text.lines().find(|line| !line.trim().is_empty() && !is_comment(line))?;
    let mut quoted = false;
    let mut bare = header.trim().chars().filter(|&c| {
        quoted ^= c == '"';
        !quoted
    });
    if header.contains([',', ';', '\t', '|']) || !bare.any(|c| c == ' ') {
        return None;
    }
    let mut tabbed = String::with_capacity(text.len());
    for line in text.lines() {
        if is_comment(line) {
            tabbed += line;
        } else {
            let mut quoted = false;
            for c in line.trim().chars() {
                quoted ^= c == '"';
                match c {
                    ' ' | '\t' if quoted => tabbed.push(c),
                    ' ' | '\t' if tabbed.ends_with('\t') => {}
                    ' ' | '\t' => tabbed.push('\t'),
                    c => tabbed.push(c),
                }
            }
        }
        tabbed.push('\n');
    }
    Some(tabbed)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(text: &str) -> Vec<Vec<String>> {
        let table = CsvTable::parse("t.csv", text.as_bytes()).unwrap_or_else(|e| panic!("{text:?}: {e}"));
        let row = |row| {
            (0..table.columns().len())
                .map(|c| table.text(row, c).to_owned())
                .collect()
        };
        std::iter::once(table.columns().to_vec())
            .chain((0..table.len()).map(row))
            .collect()
    }

    #[test]
    fn names_the_line_whatever_comes_before_it() {
        for end in ["\n", "\r\n", "\r"] {
            let text = [
                "\u{feff}# one",
                "",
                "# it's 5\" wide",
                "a,b",
                "",
                "1,2",
                " # three",
                "\"1\",\"x",
                "y\"",
                "\"#\",",
                "3,x",
            ];
            let table = CsvTable::parse("t.csv", text.join(end).as_bytes()).unwrap();
            assert_eq!(
                (table.columns(), table.len()),
                (&["a".to_owned(), "b".to_owned()][..], 3)
            );
            assert_eq!(table.number(0, 1, "b in mm"), Ok(2.0));
            assert_eq!((table.text(1, 1), table.line(1)), ("x\ny", 8));
            let error = table.number(2, 1, "b in mm").unwrap_err();
            let found = "t.csv, line 11, column b: expected b in mm, found x; write a number there";
            assert!(error.to_string().starts_with(found), "{error}");
            assert_eq!(table.comments(), ["one", "it's 5\" wide", "three"]);
        }
    }

    /// One table as spreadsheets, R and instruments write it.
    #[test]
    fn usual_ways_of_writing_one_table() {
        let expected = cells("wavelength_nm,red\n390,0.25\n400,0.5\n");
        for text in [
            "\"wavelength_nm\",\"red\"\n390,0.25\n400,0.5\n",
            "\"\",\"wavelength_nm\",\"red\"\n\"1\",390,0.25\n\"2\",400,0.5\n",
            "\"wavelength_nm\",\"red\"\n\"1\",390,0.25\n\"2\",400,0.5\n",
            ",wavelength_nm,red\n0,390,0.25\n1,400,0.5\n",
            "wavelength_nm;red\n390;0.25\n400;0.5\n",
            "wavelength_nm\tred\n390\t0.25\n400\t0.5\n",
            "wavelength_nm;red\n390;0,25\n400;0,5\n",
            "wavelength_nm,red\n390,\"0,25\"\n400,\"0,5\"\n",
            "sep=;\nwavelength_nm;red\n390;0,25\n400;0,5\n",
            "sep=,\nwavelength_nm,red\n390,0.25\n400,0.5\n",
            "\"sep=,\"\nwavelength_nm,red\n390,0.25\n400,0.5\n",
            "wavelength_nm,red,,\n390,0.25,,\n400,0.5,,\n,,,\n",
            "wavelength_nm,red\n390,0.25,\n400,0.5,,\n",
            "wavelength_nm,,red\n390,,0.25\n400,,0.5\n",
            "Wavelength (nm), red\n390, 0.25\n400, \"0.5\"\n",
            "lambda,red\nnm,1\n390,0.25\n400,0.5\n",
            "# by R\n\"wavelength_nm\" \"red\"\n\"1\" 390 0.25\n\"2\" 400 0.5\n",
            "wavelength_nm   red\n  390      0.25\n  400      0.5\n",
            "wl,red\n(nm),\n390,0.25\n400,0.5\n",
            "\"# study, seed 1\",\n# more,\nwavelength_nm,red\n390,0.25\n400,0.5\n",
        ] {
            assert_eq!(cells(text), expected, "{text:?}");
        }
        assert_eq!(cells("a,b\n\"x \"\"y\"\", z\",1\n")[1], ["x \"y\", z", "1"]);
        assert_eq!(cells("\"name\",\"390\"\n\"#1\",0.5\n")[1], ["#1", "0.5"]);
        assert_eq!(cells("\"\",\"390\"\n\"red\",0.5\n")[0], ["name", "390"]);
        let notices = CsvTable::parse("t", b"a;b\n1;0,25\n").unwrap().notices().to_vec();
        let words = notices.iter().map(ToString::to_string).collect::<Vec<_>>();
        assert!(words.join(" ").contains("0,25 on line 2: read as 0.25"), "{words:?}");
    }

    #[test]
    fn utf_16_and_latin_1() {
        let text = "\u{feff}# \u{b5}m\nwavelength_nm,r\u{e9}d\n390,1\n";
        let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
        let latin: Vec<u8> = text.chars().skip(1).map(|c| c as u8).collect();
        for (bytes, notices) in [(little, 0), (big, 0), (latin, 1)] {
            let table = CsvTable::parse("t", &bytes).unwrap();
            assert_eq!(
                (table.columns()[1].as_str(), table.line(0), table.notices().len()),
                ("r\u{e9}d", 3, notices)
            );
        }
    }

    #[test]
    fn columns_of_wavelengths_become_rows() {
        let table = CsvTable::parse("t", b"theta_i_deg,R450,550 nm\n0,0.1,0.2\n10,0.3,0.4\n")
            .unwrap()
            .long()
            .unwrap();
        assert_eq!(table.columns(), ["theta_i_deg", "wavelength_nm", "beta"]);
        let row = |row: usize| [0, 1, 2].map(|column| table.number(row, column, "").unwrap());
        assert_eq!([row(0), row(3)], [[0.0, 450.0, 0.1], [10.0, 550.0, 0.4]]);
        assert_eq!((table.len(), table.line(2), table.line(3)), (4, 3, 3));
    }

    #[test]
    fn refuses_what_has_no_one_meaning() {
        for (text, line, says) in [
            ("", 1, "header line"),
            ("# only a comment\n", 1, "header line"),
            ("a,b\n", 1, "at least one row"),
            ("a,a\n1,2\n", 1, "'a' twice"),
            ("wl,lambda\n1,2\n", 1, "'wavelength_nm' twice"),
            ("a,b\n1,2\n1\n", 3, "2 values (a,b), found 1"),
            ("a,b\n1,2,3\n", 2, "found 3"),
            ("wavelength_nm,red\n390,0,2\n", 2, "decimal comma need semicolons"),
            (
                "a;b\n1;0,2\n2;0.3\n",
                2,
                "a comma in 0,2 and, on line 3, a point in 0.3",
            ),
            (
                "a;b\n1;1,234\n",
                2,
                "1,234, whose comma can be a decimal mark or one of thousands",
            ),
            ("a,b\n1,\"2\n3,4\n", 2, "a closing quotation mark"),
            ("a,,b\n1,2,3\n", 1, "a title for column 2"),
            (",a\n5,2\n", 1, "a title for column 1"),
            (
                "theta_i_deg,b\nrad,1\n1,2\n",
                2,
                "expected deg, found rad; multiply radians by 57.29578",
            ),
            ("wl,b\n\u{b5}m,1\n1,2\n", 2, "multiply micrometres by 1000"),
            ("wl,b\nnm,%\n1,2\n", 2, "divide values in per cent by 100"),
        ] {
            let error = CsvTable::parse("t", text.as_bytes()).unwrap_err();
            assert!(
                error.line == line && error.to_string().contains(says),
                "{text:?}: {error}"
            );
        }
        for bytes in [&b"a,b\n1,\0\n"[..], &[0xff; 64]] {
            let error = CsvTable::parse("t", bytes).unwrap_err();
            assert!(error.expected.contains("text in UTF-8"), "{error}");
        }
        let error = CsvTable::parse("t", b"\x89PNG\r\n\x1a\n").unwrap_err();
        assert!(error.to_string().contains("found an image"), "{error}");
    }
}
