//! Sections and keys of a WIF file.

use super::notice::DraftNotice;
use crate::formats::{FormatError, Text, quoted, remedy};

/// `key=value` and where the key begins.
pub(super) struct IniEntry<'a> {
    pub(super) key: String,
    pub(super) value: &'a str,
    pub(super) at: usize,
}

pub(super) struct IniSection<'a> {
    /// Upper case.
    pub(super) name: String,
    pub(super) entries: Vec<IniEntry<'a>>,
    pub(super) at: usize,
}

pub(super) struct Ini<'a> {
    pub(super) text: Text<'a>,
    sections: Vec<IniSection<'a>>,
    /// Warnings about ignored content.
    pub(super) warnings: Vec<DraftNotice>,
}

/// Sections whose lines are read; others, private ones among them, may hold anything.
const READ: [&str; 18] = [
    "WIF",
    "CONTENTS",
    "TEXT",
    "WEAVING",
    "WARP",
    "WEFT",
    "COLOR PALETTE",
    "COLOR TABLE",
    "THREADING",
    "TIEUP",
    "TREADLING",
    "LIFTPLAN",
    "WARP COLORS",
    "WEFT COLORS",
    "WARP SPACING",
    "WEFT SPACING",
    "WARP THICKNESS",
    "WEFT THICKNESS",
];

fn is_read(section: &str) -> bool {
    READ.contains(&section)
}

impl<'a> Ini<'a> {
    pub(super) fn parse(path: &'a str, text: &'a str) -> Result<Self, FormatError> {
        let text = Text::new(path, text);
        let mut sections: Vec<IniSection> = Vec::new();
        let mut before = 0usize;
        let start = text.text.as_ptr() as usize;
        for line in text.text.split(['\n', '\r']).map(str::trim) {
            let at = line.as_ptr() as usize - start;
            if line.is_empty() || line.starts_with(';') {
                continue;
            }
            if let Some(name) = line.strip_prefix('[') {
                let name = name.split_once(']').map(|(name, _)| name).ok_or_else(|| {
                    text.error(
                        at,
                        "[SECTION]",
                        quoted(line),
                        "close the bracket, or begin the line with ';'",
                    )
                })?;
                let name = name.trim().to_ascii_uppercase();
                if is_read(&name) && sections.iter().any(|s| s.name == name) {
                    return Err(text.error(at, "each section once", quoted(line), remedy::ONE_OF_TWO));
                }
                let entries = Vec::new();
                sections.push(IniSection { name, entries, at });
                continue;
            }
            let Some(section) = sections.last_mut() else {
                before += 1;
                continue;
            };
            if !is_read(&section.name) {
                continue;
            }
            let (key, value) = line.split_once('=').ok_or_else(|| {
                text.error(
                    at,
                    "key=value",
                    quoted(line),
                    "begin the line with ';' where it is a comment",
                )
            })?;
            // In words of a title a semicolon is one; elsewhere it begins a comment.
            let value = match section.name.as_str() {
                "TEXT" => value,
                _ => value.split(';').next().unwrap_or_default(),
            };
            section.entries.push(IniEntry {
                key: key.trim().to_ascii_uppercase(),
                value: value.trim(),
                at,
            });
        }
        let mut warnings = Vec::new();
        if before > 0 {
            warnings.push(DraftNotice::BeforeSections { lines: before });
        }
        Ok(Self {
            text,
            sections,
            warnings,
        })
    }

    /// A section by its name in upper case.
    pub(super) fn section(&self, name: &str) -> Option<&IniSection<'a>> {
        self.sections.iter().find(|s| s.name == name)
    }

    /// A key's value; empty ones count as missing.
    pub(super) fn value(&self, section: &str, key: &str) -> Option<&IniEntry<'a>> {
        let entry = self.section(section)?.entries.iter().find(|e| e.key == key)?;
        (!entry.value.is_empty()).then_some(entry)
    }

    pub(super) fn number(&self, section: &str, key: &str) -> Result<Option<f64>, FormatError> {
        let Some(entry) = self.value(section, key) else {
            return Ok(None);
        };
        let number = entry.value.parse::<f64>().ok().filter(|v| (0.0..1e9).contains(v));
        let number = number.ok_or_else(|| {
            let expected = format!("{key} and a number, 0 or more");
            let remedy = "write a length with a point as decimal mark, or leave the line out";
            self.text.error(entry.at, expected, quoted(entry.value), remedy)
        })?;
        Ok(Some(number))
    }

    pub(super) fn count(&self, section: &str, key: &str) -> Result<Option<usize>, FormatError> {
        let Some(entry) = self.value(section, key) else {
            return Ok(None);
        };
        let count = entry.value.parse().ok();
        let count = count.ok_or_else(|| {
            let expected = format!("{key} and a whole number");
            let remedy = "write how many there are, or leave the line out";
            self.text.error(entry.at, expected, quoted(entry.value), remedy)
        })?;
        Ok(Some(count))
    }
}
