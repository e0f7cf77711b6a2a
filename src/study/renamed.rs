//! Old spellings of keys: they are still read, and a notice names the new one. Each is a row of [`RENAMED`].

use super::fields::{Field, Kind};
use crate::text::is_path;
use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};

/// An old key and the one that has its value now.
pub(super) struct Renamed {
    pub section: &'static str,
    pub field: Field,
    pub new_section: &'static str,
    pub new_key: &'static str,
    /// The value as the new key has it.
    pub value: fn(&str) -> String,
}

pub(super) const RENAMED: &[Renamed] = &[Renamed {
    section: "weave",
    field: Field {
        key: "draft",
        meaning: "",
        unit: "",
        kind: Kind::Text,
        example: None,
    },
    new_section: "cloth",
    new_key: "weave",
    value: as_path,
}];

/// The old key had paths alone, also those that look like names.
fn as_path(draft: &str) -> String {
    match is_path(draft) || draft.trim().is_empty() {
        true => draft.into(),
        false => format!("./{draft}"),
    }
}

impl Renamed {
    /// The old keys of a section.
    pub fn of(section: &str) -> impl Iterator<Item = &'static Self> {
        RENAMED.iter().filter(move |renamed| renamed.section == section)
    }

    /// Moves the value of the old key in a study's table, if it has one. It replaces a value of the new key, as the old key had
    /// precedence.
    pub fn apply(&self, study: &mut toml::Table) -> Option<OldKey> {
        let section = study.get_mut(self.section)?.as_table_mut()?;
        let old = section.remove(self.field.key);
        if section.is_empty() {
            study.remove(self.section);
        }
        let value = (self.value)(old?.as_str()?);
        let new = study
            .entry(self.new_section)
            .or_insert_with(|| toml::Value::Table(toml::Table::new()));
        let replaced = new.as_table_mut()?.insert(self.new_key.into(), value.as_str().into());
        Some(OldKey {
            place: String::new(),
            old: [self.section.into(), self.field.key.into()],
            new: [self.new_section.into(), self.new_key.into()],
            value,
            replaced: replaced.map(|other| other.to_string()),
        })
    }
}

/// An old key in the file of a study.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct OldKey {
    /// File and line.
    pub place: String,
    /// Section and key.
    pub old: [String; 2],
    pub new: [String; 2],
    /// As the new key has it.
    pub value: String,
    /// Value of the new key in the same file, which this one replaced.
    pub replaced: Option<String>,
}

impl Display for OldKey {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let Self { place, value, .. } = self;
        let [section, key] = &self.new;
        write!(
            f,
            "{place}: `{}` is now `{section}.{key}`: write {key} = {} in [{section}] in its place",
            self.old.join("."),
            toml::Value::from(value.as_str())
        )?;
        match &self.replaced {
            Some(other) => write!(f, ", for {other}, which is passed over"),
            None => Ok(()),
        }
    }
}
