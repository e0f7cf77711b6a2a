use std::collections::BTreeMap;

use super::old_keys::{OldKey, OldKeyNow};
use super::{FileLine, StudyError};

/// The file that a study was read from and the line of each of its keys, for messages. It says nothing of what the
/// study asks for: studies are equal whatever their origin.
#[derive(Clone, Debug, Default)]
pub struct Origin {
    file: String,
    /// By `section.key`, from 1.
    lines: BTreeMap<String, usize>,
    /// Options of the command line in place of keys, by `section.key`.
    options: BTreeMap<String, &'static str>,
    old_keys: Vec<OldKey>,
}

impl PartialEq for Origin {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Origin {
    pub(super) fn new(file: &str, lines: BTreeMap<String, usize>) -> Self {
        Self {
            file: file.into(),
            lines,
            options: BTreeMap::new(),
            old_keys: Vec::new(),
        }
    }

    /// Where a key, as `section.key`, has its value: an option of the command line, or a line of the file, or the file
    /// as a whole for one that it leaves out; `None` without a file.
    pub fn place(&self, key: &str) -> Option<Box<FileLine>> {
        if let Some(option) = self.options.get(key) {
            return Some(Box::new(FileLine {
                file: (*option).into(),
                line: 0,
            }));
        }
        (!self.file.is_empty()).then(|| {
            Box::new(FileLine {
                file: self.file.clone(),
                line: self.lines.get(key).copied().unwrap_or(0),
            })
        })
    }

    /// Notes that an old key is read, of which another may have the value now.
    pub(super) fn replace(&mut self, old_key: OldKey) {
        let line = self.lines.remove(&old_key.old.join(".")).unwrap_or(0);
        let place = FileLine {
            file: self.file.clone(),
            line,
        };
        if let OldKeyNow::Renamed { new, .. } = &old_key.now {
            self.lines.insert(new.join("."), line);
        }
        self.old_keys.push(OldKey {
            place: place.to_string(),
            ..old_key
        });
    }

    /// Old keys of the file, each with the new one.
    pub fn old_keys(&self) -> &[OldKey] {
        &self.old_keys
    }

    /// That a key has its value from an option of the command line, and no longer from the file.
    pub fn give(&mut self, key: &str, option: &'static str) {
        self.options.insert(key.into(), option);
    }

    /// The error with the place of its key, if it has none yet.
    pub(crate) fn locate(&self, error: StudyError) -> StudyError {
        match error {
            StudyError::Value {
                place: None,
                key,
                expected,
                found,
                remedy,
            } => StudyError::Value {
                place: self.place(&key),
                key,
                expected,
                found,
                remedy,
            },
            located => located,
        }
    }
}
