//! Sections and keys of a WIF file.

use crate::formats::{FormatError, Text, quoted};

/// `key=value` and where the key begins.
pub(super) struct Entry<'a> {
    pub(super) key: String,
    pub(super) value: &'a str,
    pub(super) at: usize,
}

pub(super) struct Section<'a> {
    /// Upper case.
    pub(super) name: String,
    pub(super) entries: Vec<Entry<'a>>,
    pub(super) at: usize,
}

pub(super) struct Ini<'a> {
    pub(super) text: Text<'a>,
    sections: Vec<Section<'a>>,
}

impl<'a> Ini<'a> {
    pub(super) fn parse(path: &'a str, bytes: &'a [u8]) -> Result<Self, FormatError> {
        let text = Text::new(path, bytes)?;
        let mut sections: Vec<Section> = Vec::new();
        let start = text.text.as_ptr() as usize;
        for line in text.text.split(['\n', '\r']).map(str::trim) {
            let at = line.as_ptr() as usize - start;
            if line.is_empty() || line.starts_with(';') {
                continue;
            }
            if let Some(name) = line.strip_prefix('[') {
                let name = name
                    .strip_suffix(']')
                    .ok_or_else(|| text.error(at, "[SECTION]", quoted(line)))?;
                let name = name.trim().to_ascii_uppercase();
                if sections.iter().any(|s| s.name == name) {
                    return Err(text.error(at, "each section once", quoted(line)));
                }
                let entries = Vec::new();
                sections.push(Section { name, entries, at });
                continue;
            }
            let (key, value) = line
                .split_once('=')
                .ok_or_else(|| text.error(at, "key=value", quoted(line)))?;
            let section = sections.last_mut();
            let section = section.ok_or_else(|| text.error(at, "a section before the first key", quoted(line)))?;
            section.entries.push(Entry {
                key: key.trim().to_ascii_uppercase(),
                value: value.trim(),
                at,
            });
        }
        Ok(Self { text, sections })
    }

    /// A section by its name in upper case.
    pub(super) fn section(&self, name: &str) -> Option<&Section<'a>> {
        self.sections.iter().find(|s| s.name == name)
    }

    /// A key's value; empty ones count as missing.
    pub(super) fn value(&self, section: &str, key: &str) -> Option<&Entry<'a>> {
        let entry = self.section(section)?.entries.iter().find(|e| e.key == key)?;
        (!entry.value.is_empty()).then_some(entry)
    }

    pub(super) fn number(&self, section: &str, key: &str) -> Result<Option<f64>, FormatError> {
        let Some(entry) = self.value(section, key) else {
            return Ok(None);
        };
        let number = entry.value.parse::<f64>().ok().filter(|v| (0.0..1e9).contains(v));
        let number = number.ok_or_else(|| {
            self.text
                .error(entry.at, format!("{key} and a number, 0 or more"), quoted(entry.value))
        })?;
        Ok(Some(number))
    }

    pub(super) fn count(&self, section: &str, key: &str) -> Result<Option<usize>, FormatError> {
        let Some(entry) = self.value(section, key) else {
            return Ok(None);
        };
        let count = entry.value.parse().ok();
        let count = count.ok_or_else(|| {
            self.text
                .error(entry.at, format!("{key} and a whole number"), quoted(entry.value))
        })?;
        Ok(Some(count))
    }
}
