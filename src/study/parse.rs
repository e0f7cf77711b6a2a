use std::collections::BTreeMap;
use std::ops::Range;

use serde::de::Error;
use serde::{Deserialize, Deserializer};
use toml::de::{DeTable, DeValue};

use super::choices::GeometryChoice;
use super::fields::{self, Field, ValueKind};
use super::keys::{self, RigSection, SECTIONS, Study};
use super::old_keys::{FORMER_KEYS, FormerKey, Now};
use super::{FileLine, Origin, StudyError};
use crate::text::is_path;

type Spanned<T> = toml::Spanned<T>;

/// The text of a study file and what to call it.
struct StudyText<'t> {
    text: &'t str,
    file: &'t str,
}

impl StudyText<'_> {
    fn place(&self, offset: usize) -> Box<FileLine> {
        let before = &self.text.as_bytes()[..offset.min(self.text.len())];
        Box::new(FileLine {
            file: self.file.into(),
            line: 1 + before.iter().filter(|b| **b == b'\n').count(),
        })
    }

    /// The text of a value, cut to a readable length.
    fn quote(&self, span: Range<usize>) -> String {
        let text = self.text.get(span).unwrap_or_default();
        match text.char_indices().nth(40) {
            Some((end, _)) => format!("{}…", &text[..end]),
            None => text.into(),
        }
    }

    fn syntax(&self, error: &toml::de::Error) -> StudyError {
        let at = error.span().map_or(0, |s| s.start);
        let line = self
            .text
            .get(..at)
            .map_or(0, |before| before.rfind('\n').map_or(0, |end| end + 1));
        let line = self
            .text
            .get(line..)
            .and_then(|rest| rest.lines().next())
            .unwrap_or_default();
        StudyError::Syntax {
            place: self.place(at),
            message: match decimal_comma(line) {
                Some([found, point]) => format!("expected a number with a decimal point, found {found}; write {point}"),
                None => match error.message().trim() {
                    "duplicate key" => {
                        let key = error.span().map_or_else(String::new, |span| self.quote(span));
                        format!("expected every key once, found `{key}` again")
                    }
                    message => message.replace('\n', ", "),
                },
            },
        }
    }
}

/// A number with a decimal comma that is the value of a line, and the same with a point.
fn decimal_comma(line: &str) -> Option<[String; 2]> {
    let value = line.split_once('=')?.1.split('#').next()?.trim();
    let (whole, fraction) = value.split_once(',')?;
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    (digits(whole.trim_start_matches(['-', '+'])) && digits(fraction))
        .then(|| [value.to_owned(), format!("{whole}.{fraction}")])
}

pub(super) fn study(text: &str, file: &str) -> Result<Study, StudyError> {
    let source = StudyText { text, file };
    let document = DeTable::parse(text).map_err(|e| source.syntax(&e))?;
    let mut faults = Vec::new();
    check_table(&source, document.get_ref(), &mut faults);
    if let Some((_, first)) = faults.into_iter().min_by_key(|(offset, _)| *offset) {
        return Err(first);
    }
    let mut table: toml::Table = toml::from_str(text).map_err(|e| source.syntax(&e))?;
    let mut origin = origin(&source, document.get_ref());
    for former in FORMER_KEYS {
        if let Some(old_key) = former.apply(&mut table) {
            origin.replace(old_key);
        }
    }
    let mut study: Study = table.try_into().map_err(|e| source.syntax(&e))?;
    study.origin = origin;
    let rig = document.get_ref().get("rig").and_then(|rig| rig.get_ref().as_table());
    if rig.is_some_and(|rig| {
        !rig.contains_key("geometries") && RigSection::ANGLES.iter().any(|key| rig.contains_key(*key))
    }) {
        study.rig.geometries = GeometryChoice::Rig;
    }
    study.validate()?;
    Ok(study)
}

/// A fault and where it is in the text.
type KeyFault = (usize, StudyError);

fn check_table(source: &StudyText, document: &DeTable, faults: &mut Vec<KeyFault>) {
    for (key, value) in document {
        let name = key.get_ref().as_ref();
        let offset = key.span().start;
        if let Some(field) = keys::find("", name) {
            faults.extend(check_value(source, "", field, value));
        } else if is_section(name) {
            match value.get_ref() {
                DeValue::Table(table) => check_section(source, name, table, faults),
                other => faults.push((
                    offset,
                    StudyError::Type {
                        place: source.place(offset),
                        key: name.into(),
                        expected: format!("a section, [{name}]"),
                        found: format!("a value of type {}", other.type_str()),
                    },
                )),
            }
        } else {
            faults.push((offset, unknown(source, "", name, offset)));
        }
    }
}

/// Whether it is a section, now or in an old spelling.
pub(super) fn is_section(name: &str) -> bool {
    SECTIONS.iter().any(|s| !s.name.is_empty() && s.name == name) || FormerKey::of(name).next().is_some()
}

fn check_section(source: &StudyText, section: &str, table: &DeTable, faults: &mut Vec<KeyFault>) {
    for (key, value) in table {
        let name = key.get_ref().as_ref();
        if let Some(field) = keys::find(section, name) {
            faults.extend(check_value(source, section, field, value));
        } else if let Some(old) = FormerKey::of(section).find(|old| old.field.key == name) {
            faults.extend(check_value(source, section, &old.field, value));
        } else {
            let offset = key.span().start;
            faults.push((offset, unknown(source, section, name, offset)));
        }
    }
}

/// Whether a value has the type of its key. Ranges are the validation's, but for whole numbers that would not fit at
/// all.
fn check_value(source: &StudyText, section: &str, field: &Field, value: &Spanned<DeValue>) -> Option<KeyFault> {
    let span = value.span();
    let is_number = |v: &DeValue| v.is_float() || v.is_integer();
    let found = value.get_ref();
    let is_whole = |low: u64, high: u64| {
        found.as_integer().is_some_and(|integer| {
            let digits = integer.as_str().replace('_', "");
            i128::from_str_radix(&digits, integer.radix())
                .is_ok_and(|i| (i128::from(low)..=i128::from(high)).contains(&i))
        })
    };
    let fits = match field.kind {
        ValueKind::Number(_) => is_number(found),
        ValueKind::NumberOrTable(_) => is_number(found) || found.is_str(),
        ValueKind::Numbers(..) => found
            .as_array()
            .is_some_and(|list| list.iter().all(|v| is_number(v.get_ref()))),
        ValueKind::Integer(low, high) | ValueKind::Multiple(low, high, _) => is_whole(low, high),
        ValueKind::IntegerOr(low, high, word) => is_whole(low, high) || found.as_str() == Some(word),
        ValueKind::Flag => found.is_bool(),
        ValueKind::Text => found.is_str(),
        ValueKind::Choice(choices) => found.as_str().is_some_and(|s| choices.contains(&s)),
        ValueKind::ChoiceOrPath(choices) => found.as_str().is_some_and(|s| choices.contains(&s) || is_path(s)),
    };
    if fits {
        return None;
    }
    let (place, key, expected) = (
        source.place(span.start),
        fields::path(section, field.key),
        field.expected(),
    );
    let quote = source.quote(span.clone());
    let error = match (field.kind, found) {
        (ValueKind::Choice(choices) | ValueKind::ChoiceOrPath(choices), DeValue::String(text)) => StudyError::Value {
            place: Some(place),
            key,
            expected,
            found: quote,
            remedy: match closest(text, choices.iter().copied()) {
                Some(choice) => format!("did you mean \"{choice}\"?"),
                None => "write one of these".into(),
            },
        },
        _ => StudyError::Type {
            place,
            key,
            expected,
            found: format!("{quote} ({})", found.type_str()),
        },
    };
    Some((span.start, error))
}

fn unknown(source: &StudyText, section: &str, key: &str, offset: usize) -> StudyError {
    let fields = SECTIONS
        .iter()
        .find(|s| s.name == section)
        .map_or(&[][..], |s| s.fields);
    let mut known: Vec<&str> = fields.iter().map(|f| f.key).collect();
    known.extend(FormerKey::of(section).map(|old| old.field.key));
    if section.is_empty() {
        known.extend(SECTIONS.iter().map(|s| s.name).filter(|n| !n.is_empty()));
    }
    let elsewhere = || {
        let home = SECTIONS
            .iter()
            .find(|s| !s.name.is_empty() && keys::find(s.name, key).is_some())?;
        Some(format!("`{key}` in [{}]", home.name))
    };
    StudyError::UnknownKey {
        place: source.place(offset),
        key: key.into(),
        section: if section.is_empty() {
            "at the top level".into()
        } else {
            format!("in [{section}]")
        },
        suggestion: elsewhere().or_else(|| closest(key, known.iter().copied()).map(|k| format!("`{k}`"))),
        known: known.join(", "),
    }
}

/// The likeliest word meant, if one is near: within a third of its letters.
pub(super) fn closest<'w>(typed: &str, words: impl Iterator<Item = &'w str>) -> Option<&'w str> {
    let typed = typed.to_lowercase();
    words
        .map(|w| (strsim::damerau_levenshtein(&typed, &w.to_lowercase()), w))
        .filter(|(distance, w)| *distance <= 1 + w.len() / 3)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, w)| w)
}

/// The lines of all keys that the text has.
fn origin(source: &StudyText, document: &DeTable) -> Origin {
    let mut lines = BTreeMap::new();
    for (name, value) in document {
        let name = name.get_ref().as_ref();
        match value.get_ref() {
            DeValue::Table(section) => lines.extend(section.iter().map(|(key, value)| {
                let path = fields::path(name, key.get_ref().as_ref());
                (path, source.place(value.span().start).line)
            })),
            _ => {
                lines.insert(name.to_owned(), source.place(value.span().start).line);
            }
        }
    }
    Origin::new(source.file, lines)
}

/// The study in a file that an earlier version may have written, with the keys of today.
///
/// # Errors
/// What is no study.
pub fn study_of_any_age<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Study, D::Error> {
    let mut study = serde_json::Value::deserialize(deserializer)?;
    for FormerKey { section, field, now } in FORMER_KEYS {
        let fields = study.get_mut(section).and_then(|of| of.as_object_mut());
        let Some(old) = fields.and_then(|fields| fields.remove(field.key)) else {
            continue;
        };
        if let Now::Renamed { section, key, text } = now {
            let value = old.as_str().map(|old| text(old).into()).unwrap_or(old);
            if let Some(fields) = study.get_mut(section).and_then(|of| of.as_object_mut()) {
                fields.insert((*key).into(), value);
            }
        }
    }
    Study::deserialize(study).map_err(D::Error::custom)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_study_in_an_older_file_is_read_with_the_keys_of_today() {
        let mut written = serde_json::to_value(Study::default()).unwrap();
        written["cloth"]["segments_around"] = 48.into();
        written["cloth"]["segments_along"] = 24.into();
        assert_eq!(study_of_any_age(written.clone()).unwrap(), Study::default());
        let check = written["check"].as_object_mut().unwrap();
        let tolerance = check.remove("two_estimators").unwrap();
        check.insert("two_roads".into(), tolerance);
        assert_eq!(study_of_any_age(written.clone()).unwrap(), Study::default());
        written["cloth"]["no_such_key"] = 1.into();
        assert!(study_of_any_age(written).is_err());
    }
}
