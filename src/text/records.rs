//! Records of CSV: rows of cells, without comments and empty lines.

use super::table::shortened;

/// Comments that are kept.
const COMMENTS: usize = 20;

/// One record of CSV.
pub(super) struct Record {
    /// Where it begins.
    pub(super) line: usize,
    /// Without white space around them.
    pub(super) cells: Vec<String>,
    /// Whether its first cell is.
    pub(super) is_quoted: bool,
}

pub(super) struct RecordError {
    pub(super) line: usize,
    pub(super) expected: &'static str,
    pub(super) found: String,
    pub(super) remedy: &'static str,
}

/// Records that are neither comments nor empty.
pub(super) struct Rows<'t> {
    text: &'t str,
    reader: csv::Reader<&'t [u8]>,
    record: csv::StringRecord,
    pub(super) separator: u8,
    /// Byte and line where the next record is looked for.
    at: usize,
    line: usize,
    /// Given out so far.
    pub(super) count: usize,
}

impl<'t> Rows<'t> {
    pub(super) fn new(text: &'t str) -> Self {
        let (mut start, mut line) = (0, 1);
        let mut header = "";
        for content in text.split_inclusive('\n') {
            header = content;
            if !content.trim().is_empty() && !is_comment(content) {
                break;
            }
            start += content.len();
            line += 1;
        }
        // The line that tells a spreadsheet the separator.
        let separator = match stated_separator(header) {
            Some(stated) => {
                (start, line) = (start + header.len(), line + 1);
                match stated {
                    ";" => b';',
                    "|" => b'|',
                    "" | "\\t" | "\t" => b'\t',
                    _ => b',',
                }
            }
            None => {
                (start, line) = (0, 1);
                separator_of(header)
            }
        };
        let reader = csv::ReaderBuilder::new()
            .delimiter(separator)
            .terminator(csv::Terminator::Any(b'\n'))
            .comment(Some(b'#'))
            .flexible(true)
            .has_headers(false)
            .from_reader(&text.as_bytes()[start..]);
        Self {
            text: &text[start..],
            reader,
            record: csv::StringRecord::new(),
            separator,
            at: 0,
            line,
            count: 0,
        }
    }

    pub(super) fn next(&mut self, comments: &mut Vec<String>) -> Option<Result<Record, RecordError>> {
        let mut comment = |text: &str| {
            let words = text.trim_matches(['"', '#', ' ', '\t', '\n', ',', ';']);
            if comments.len() < COMMENTS && !words.is_empty() {
                comments.push(words.to_owned());
            }
        };
        loop {
            let is_there = match self.reader.read_record(&mut self.record) {
                Ok(is_there) => is_there,
                Err(e) => {
                    return Some(Err(RecordError {
                        line: self.line,
                        expected: "a CSV record",
                        found: e.to_string(),
                        remedy: "export the table again",
                    }));
                }
            };
            let end = (self.reader.position().byte() as usize).min(self.text.len());
            let mut raw = &self.text[self.at..end];
            self.at = end;
            // The reader passes over comments and empty lines.
            while let Some((first, rest)) = raw
                .split_once('\n')
                .filter(|(first, _)| first.is_empty() || first.starts_with('#'))
            {
                comment(first);
                self.line += 1;
                raw = rest;
            }
            if !is_there {
                return None;
            }
            let line = self.line;
            self.line += raw.matches('\n').count();
            let is_quoted = raw.starts_with('"');
            if is_unclosed(raw, self.separator, end == self.text.len()) {
                return Some(Err(RecordError {
                    line,
                    expected: "a closing quotation mark",
                    found: shortened(raw.trim_end()),
                    remedy: "close the quotation mark, or double it where it is a character of the text",
                }));
            }
            let cells: Vec<String> = self.record.iter().map(|cell| bare(cell).to_owned()).collect();
            let rest_is_empty = cells[1..].iter().all(String::is_empty);
            // A quoted comment is one of a spreadsheet, which adds empty cells; a quoted name may begin with the mark,
            // too.
            if cells[0].starts_with('#') && (!is_quoted || rest_is_empty || self.count == 0) {
                comment(raw);
                continue;
            }
            if cells[0].is_empty() && rest_is_empty {
                continue;
            }
            self.count += 1;
            return Some(Ok(Record { line, cells, is_quoted }));
        }
    }
}

/// What a line `sep=;` states, in any case and perhaps in quotes.
pub(super) fn stated_separator(line: &str) -> Option<&str> {
    let line = line.trim_matches(['\n', '\r', ' ', '"']);
    let key = line.get(..4)?;
    key.eq_ignore_ascii_case("sep=").then(|| line[4..].trim_matches('"'))
}

pub(super) fn is_comment(line: &str) -> bool {
    line.trim_start_matches([' ', '\t', '"']).starts_with('#')
}

/// The separator that a header has most of outside quotes.
fn separator_of(header: &str) -> u8 {
    let mut counts = [(b',', 0), (b';', 0), (b'\t', 0), (b'|', 0)];
    let mut quoted = false;
    for byte in header.trim_end().bytes() {
        quoted ^= byte == b'"';
        if let Some((_, count)) = counts.iter_mut().find(|(separator, _)| !quoted && *separator == byte) {
            *count += 1;
        }
    }
    // The first of equals.
    counts
        .iter()
        .rev()
        .max_by_key(|(_, count)| *count)
        .map_or(b',', |(separator, _)| *separator)
}

/// Whether quotes of a record stay open to the end of the file.
fn is_unclosed(raw: &str, separator: u8, is_last: bool) -> bool {
    let opens = || raw.starts_with('"') || raw.as_bytes().windows(2).any(|pair| pair == [separator, b'"']);
    is_last && raw.matches('"').count() % 2 == 1 && opens()
}

/// A cell without white space, and without quotes that had white space before them.
fn bare(cell: &str) -> &str {
    let cell = cell.trim();
    let inner = cell.strip_prefix('"').and_then(|inner| inner.strip_suffix('"'));
    inner.map_or(cell, str::trim)
}
