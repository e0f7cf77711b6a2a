//! Numbers of a study that another program part varies by the names of their keys.

use super::error::{FileLine, StudyError, unwritable};
use super::fields::{self, Field, ValueKind};
use super::keys::{self, SECTIONS, Study};
use super::parse::closest;
use toml::Value;

impl Study {
    /// The study with another number at a key, as `section.key`; a list of numbers becomes this one number. Ranges are
    /// checked, and values that must fit each other. `option` is what errors call the place of the key.
    ///
    /// # Errors
    /// A key that is unknown or takes no number, with the likeliest one that does; a value out of its range.
    pub fn with_number(&self, key: &str, number: f64, option: &'static str) -> Result<Self, StudyError> {
        let (section, field) = find(key, option)?;
        let whole = || Value::Integer(number as i64);
        let value = match field.kind {
            // A number that is not whole stays one, and is refused with the key's range.
            ValueKind::Integer(..) | ValueKind::Multiple(..) | ValueKind::IntegerOr(..) if number.fract() == 0.0 => {
                whole()
            }
            ValueKind::Integer(..) | ValueKind::Multiple(..) | ValueKind::IntegerOr(..) => {
                return Err(StudyError::Value {
                    place: place(option),
                    key: key.into(),
                    expected: field.expected(),
                    found: number.to_string(),
                    remedy: "take whole numbers".into(),
                });
            }
            ValueKind::Numbers(..) => Value::Array(vec![Value::Float(number)]),
            _ => Value::Float(number),
        };
        let mut table = toml::Table::try_from(self).map_err(|e| unwritable(&e))?;
        let of_section = match section {
            "" => Some(&mut table),
            name => {
                let entry = table.entry(name).or_insert_with(|| Value::Table(toml::Table::new()));
                entry.as_table_mut()
            }
        };
        if let Some(of_section) = of_section {
            of_section.insert(field.key.into(), value);
        }
        let mut study: Self = table.try_into().map_err(|error: toml::de::Error| StudyError::Value {
            place: place(option),
            key: key.into(),
            expected: field.expected(),
            found: number.to_string(),
            remedy: error.message().to_owned(),
        })?;
        study.origin = self.origin.clone();
        study.origin.give(key, option);
        study.validate()?;
        Ok(study)
    }

    /// Unit of a key's number; empty for a number without dimension.
    ///
    /// # Errors
    /// As [`Study::with_number`].
    pub fn unit_of(key: &str, option: &'static str) -> Result<&'static str, StudyError> {
        Ok(find(key, option)?.1.unit)
    }

    /// Whether the values of a key are whole numbers, and multiples of which.
    ///
    /// # Errors
    /// As [`Study::with_number`].
    pub fn whole_steps(key: &str, option: &'static str) -> Result<Option<u64>, StudyError> {
        Ok(match find(key, option)?.1.kind {
            ValueKind::Integer(..) | ValueKind::IntegerOr(..) => Some(1),
            ValueKind::Multiple(_, _, of) => Some(of),
            _ => None,
        })
    }
}

fn place(option: &str) -> Option<Box<FileLine>> {
    Some(Box::new(FileLine {
        file: option.into(),
        line: 0,
    }))
}

fn is_numeric(field: &Field) -> bool {
    use ValueKind::{Integer, IntegerOr, Multiple, Number, NumberOrTable, Numbers};
    matches!(
        field.kind,
        Number(_) | NumberOrTable(_) | Numbers(..) | Integer(..) | Multiple(..) | IntegerOr(..)
    )
}

/// The section and row of a key that takes a number.
pub(super) fn find(key: &str, option: &'static str) -> Result<(&'static str, &'static Field), StudyError> {
    let (section, name) = key.split_once('.').unwrap_or(("", key));
    let all = || {
        SECTIONS
            .iter()
            .flat_map(|of| of.fields.iter().map(move |field| (of.name, field)))
    };
    if let Some(field) = keys::find(section, name) {
        let found = SECTIONS.iter().find(|of| of.name == section).map_or("", |of| of.name);
        return match is_numeric(field) {
            true => Ok((found, field)),
            false => Err(StudyError::Value {
                place: place(option),
                key: key.into(),
                expected: "a key whose value is a number".into(),
                found: format!("one that takes {}", field.expected()),
                remedy: "write one study for each of its values".into(),
            }),
        };
    }
    let names: Vec<String> = all()
        .filter(|(_, field)| is_numeric(field))
        .map(|(section, field)| fields::path(section, field.key))
        .collect();
    // A key without its section is as near as can be.
    let alone = names
        .iter()
        .find(|known| known.split_once('.').is_some_and(|(_, own)| own == key));
    let suggestion = alone
        .map(String::as_str)
        .or_else(|| closest(key, names.iter().map(String::as_str)));
    Err(StudyError::UnknownKey {
        place: Box::new(FileLine {
            file: option.into(),
            line: 0,
        }),
        key: key.into(),
        section: "of the study with a number".into(),
        suggestion: suggestion.map(|known| format!("`{known}`")),
        known: names.join(", "),
    })
}
