//! Keys of older studies: they are still read, and a notice says what to write in their place. Each is a row of
//! [`FORMER_KEYS`].

use super::fields::{Field, ValueKind, closed};
use crate::text::is_path;
use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};

/// A key that studies no longer have.
pub(super) struct FormerKey {
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
        /// A text as the new key has it; other values stay as they are.
        text: fn(&str) -> String,
    },
    /// Nothing depends on it any more; the reason in words.
    Dropped(&'static str),
}

pub(super) const FORMER_KEYS: &[FormerKey] = &[
    FormerKey {
        section: "weave",
        field: field("draft", ValueKind::Text),
        now: Now::Renamed {
            section: "cloth",
            key: "weave",
            text: as_path,
        },
    },
    FormerKey {
        section: "check",
        field: field("two_roads", ValueKind::Number(closed(0.0, 1.0))),
        now: Now::Renamed {
            section: "check",
            key: "two_estimators",
            text: str::to_owned,
        },
    },
    FormerKey {
        section: "cloth",
        field: field("segments_around", ValueKind::Multiple(8, 1024, 4)),
        now: Now::Dropped(SMOOTH),
    },
    FormerKey {
        section: "cloth",
        field: field("segments_along", ValueKind::Integer(8, 1024)),
        now: Now::Dropped(SMOOTH),
    },
];

const SMOOTH: &str = "the camera sees yarns as smooth tubes, without facets";

const fn field(key: &'static str, kind: ValueKind) -> Field {
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

impl FormerKey {
    /// The old keys of a section.
    pub fn of(section: &str) -> impl Iterator<Item = &'static Self> {
        FORMER_KEYS.iter().filter(move |old| old.section == section)
    }

    /// Takes the old key out of a study's table, if it has one; a key that has its value now takes it, in place of a
    /// value of its own, as the old key had precedence.
    pub fn apply(&self, study: &mut toml::Table) -> Option<OldKey> {
        let (old_section, key) = (self.section, self.field.key);
        let section = study.get_mut(old_section)?.as_table_mut()?;
        let old = section.remove(key);
        if section.is_empty() {
            study.remove(old_section);
        }
        let old = old?;
        let now = match &self.now {
            Now::Renamed { section, key, text } => {
                let value = old.as_str().map(|old| toml::Value::from(text(old))).unwrap_or(old);
                let new = study
                    .entry(*section)
                    .or_insert_with(|| toml::Value::Table(toml::Table::new()));
                let replaced = new.as_table_mut()?.insert((*key).into(), value.clone());
                OldKeyNow::Renamed {
                    new: [(*section).into(), (*key).into()],
                    value: value.to_string(),
                    replaced: replaced.map(|other| other.to_string()),
                }
            }
            Now::Dropped(why) => OldKeyNow::Dropped { why: (*why).into() },
        };
        Some(OldKey {
            place: String::new(),
            old: [old_section.into(), key.into()],
            now,
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
    pub now: OldKeyNow,
}

/// What became of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OldKeyNow {
    Renamed {
        /// Section and key.
        new: [String; 2],
        /// As the new key has it, in TOML.
        value: String,
        /// Value of the new key in the same file, which this one replaced.
        replaced: Option<String>,
    },
    Dropped {
        why: String,
    },
}

impl Display for OldKey {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        write!(f, "{}: `{}` ", self.place, self.old.join("."))?;
        match &self.now {
            OldKeyNow::Renamed { new, value, replaced } => {
                let [section, key] = new;
                write!(
                    f,
                    "is now `{section}.{key}`: write {key} = {value} in [{section}] in its place"
                )?;
                match replaced {
                    Some(other) => write!(f, ", for {other}, which is passed over"),
                    None => Ok(()),
                }
            }
            OldKeyNow::Dropped { why } => write!(f, "has no effect any more: {why}; remove it"),
        }
    }
}
