//! Old spellings of keys: they are still read, and a notice names the new one. Each is a row of [`RENAMED`].

use super::fields::{Field, Kind};
use crate::text::is_path;

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

    /// Moves the value of the old key in a study's table, if it has one, and says so. A value that the new key has
    /// gives way, as the old key took its place.
    pub fn apply(&self, study: &mut toml::Table) -> Option<String> {
        let section = study.get_mut(self.section)?.as_table_mut()?;
        let old = section.remove(self.field.key);
        if section.is_empty() {
            study.remove(self.section);
        }
        let value = (self.value)(old?.as_str()?);
        let Self {
            section: old_section,
            field: Field { key, .. },
            new_section,
            new_key,
            ..
        } = self;
        let mut notice = format!(
            "`{old_section}.{key}` is now `{new_section}.{new_key}`: write {new_key} = {} in [{new_section}] in its \
             place",
            toml::Value::from(value.as_str())
        );
        let new = study
            .entry(*new_section)
            .or_insert_with(|| toml::Value::Table(toml::Table::new()));
        if let Some(other) = new.as_table_mut()?.insert((*new_key).into(), value.into()) {
            notice += &format!(", for {other}, which is passed over");
        }
        Some(notice)
    }
}
