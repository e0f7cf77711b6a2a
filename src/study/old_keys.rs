//! Keys of older studies: they are still read, and a notice says what to write in their place. Each is a row of [`OLD_KEYS`].

use super::fields::{Field, Kind};
use crate::text::is_path;

/// A key that studies no longer have.
pub(super) struct OldKey {
    pub section: &'static str,
    pub field: Field,
    pub now: Now,
}

/// What became of an old key.
pub(super) enum Now {
    /// Another key has its value.
    Renamed {
        section: &'static str,
        key: &'static str,
        /// The value as the new key has it.
        value: fn(&str) -> String,
    },
    /// Nothing depends on it any more; the reason in words.
    Dropped(&'static str),
}

pub(super) const OLD_KEYS: &[OldKey] = &[
    OldKey {
        section: "weave",
        field: field("draft", Kind::Text),
        now: Now::Renamed {
            section: "cloth",
            key: "weave",
            value: as_path,
        },
    },
    OldKey {
        section: "cloth",
        field: field("segments_around", Kind::Multiple(8, 1024, 4)),
        now: Now::Dropped(SMOOTH),
    },
    OldKey {
        section: "cloth",
        field: field("segments_along", Kind::Integer(8, 1024)),
        now: Now::Dropped(SMOOTH),
    },
];

const SMOOTH: &str = "the camera sees yarns as smooth tubes, without facets";

const fn field(key: &'static str, kind: Kind) -> Field {
    Field {
        key,
        meaning: "",
        unit: "",
        kind,
        example: None,
    }
}

/// The old key had paths alone, also those that look like names.
fn as_path(draft: &str) -> String {
    match is_path(draft) || draft.trim().is_empty() {
        true => draft.into(),
        false => format!("./{draft}"),
    }
}

impl OldKey {
    /// The old keys of a section.
    pub fn of(section: &str) -> impl Iterator<Item = &'static Self> {
        OLD_KEYS.iter().filter(move |old| old.section == section)
    }

    /// Takes the old key out of a study's table, if it has one, and says so; a new key that has its value now takes it. A
    /// value that the new key has gives way, as the old key took its place.
    pub fn apply(&self, study: &mut toml::Table) -> Option<String> {
        let (old_section, key) = (self.section, self.field.key);
        let section = study.get_mut(old_section)?.as_table_mut()?;
        let old = section.remove(key)?;
        if section.is_empty() {
            study.remove(old_section);
        }
        let (new_section, new_key, value) = match &self.now {
            Now::Renamed { section, key, value } => (*section, *key, value(old.as_str()?)),
            Now::Dropped(why) => {
                return Some(format!(
                    "`{old_section}.{key}` has no effect any more: {why}; remove it"
                ));
            }
        };
        let mut notice = format!(
            "`{old_section}.{key}` is now `{new_section}.{new_key}`: write {new_key} = {} in [{new_section}] in its \
             place",
            toml::Value::from(value.as_str())
        );
        let new = study
            .entry(new_section)
            .or_insert_with(|| toml::Value::Table(toml::Table::new()));
        if let Some(other) = new.as_table_mut()?.insert(new_key.into(), value.into()) {
            notice += &format!(", for {other}, which is passed over");
        }
        Some(notice)
    }
}
