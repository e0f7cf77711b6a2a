//! Lines of text, and the words and lists in them.

use std::borrow::Cow;
use std::ops::RangeInclusive;

use crate::formats::error::{FormatError, Location, remedy};
use crate::formats::text::{finite, quoted};

/// The lines of a file that may hold binary data between them.
pub(super) struct Lines<'a> {
    pub(super) path: &'a str,
    pub(super) bytes: &'a [u8],
    /// First byte of the next line.
    pub(super) position: usize,
    /// Number of the line last read, as far as there were lines.
    pub(super) number: usize,
}

impl<'a> Lines<'a> {
    /// The next line that is neither blank nor a comment.
    pub(super) fn next(&mut self) -> Result<Option<Cow<'a, str>>, FormatError> {
        while self.position < self.bytes.len() {
            let rest = &self.bytes[self.position..];
            let end = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
            self.position += (end + 1).min(rest.len());
            self.number += 1;
            let line = &rest[..end];
            if line.contains(&0) {
                return Err(self.error("text", "bytes that are no text", remedy::BINARY_BEHIND));
            }
            // Letters of another encoding are in comments and names alone.
            let line = String::from_utf8_lossy(line);
            let trimmed = line.trim_start_matches('\u{feff}').trim();
            if !trimmed.is_empty() && !trimmed.starts_with('#') {
                return Ok(Some(match &line {
                    Cow::Borrowed(line) => Cow::Borrowed(line.trim_start_matches('\u{feff}').trim()),
                    Cow::Owned(_) => Cow::Owned(trimmed.to_owned()),
                }));
            }
        }
        Ok(None)
    }

    pub(super) fn error(
        &self,
        expected: impl Into<String>,
        found: impl Into<String>,
        remedy: impl Into<String>,
    ) -> FormatError {
        let place = Location::Row {
            line: self.number.max(1),
            column: None,
        };
        FormatError::at(self.path, place, expected, found, remedy)
    }
}

pub(super) fn list_index(name: &str) -> Option<usize> {
    let digit = name.strip_prefix("PARAM")?.strip_suffix("_LIST")?;
    digit
        .parse()
        .ok()
        .filter(|&index: &usize| index < 5 && digit.len() == 1)
}

pub(super) fn word_of<'w>(lines: &Lines, found: &str, words: &[&'w str]) -> Result<&'w str, FormatError> {
    let known = words.iter().find(|&&word| word == found);
    known.copied().ok_or_else(|| {
        lines.error(
            words.join(" or "),
            quoted(found),
            "write one of these words, in lower case",
        )
    })
}

pub(super) fn ascending(
    lines: &Lines,
    list: &str,
    name: &str,
    range: RangeInclusive<f64>,
    any_order: bool,
) -> Result<Vec<f64>, FormatError> {
    let range = if any_order { -90.0..=90.0 } else { range };
    let order = if any_order { "" } else { ", ascending" };
    let mut values: Vec<f64> = Vec::new();
    for word in list.split_whitespace() {
        let value = finite(word, &range).filter(|v| any_order || values.last().is_none_or(|last| v > last));
        let expected = || format!("numbers in {name}, {}..{}{order}", range.start(), range.end());
        let remedy = match name {
            "WAVELENGTH_LIST" => remedy::WAVELENGTHS,
            _ => remedy::SORT,
        };
        values.push(value.ok_or_else(|| lines.error(expected(), quoted(word), remedy))?);
    }
    if values.is_empty() {
        let remedy = "list them on the same line, between blanks";
        return Err(lines.error(format!("numbers in {name}"), "none", remedy));
    }
    Ok(values)
}
