use super::{ArtefactError, Difference};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Everything that must be equal for two files to belong together: program version, seed, study, and every other
/// argument of the command that changes its numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identity(Value);

impl Identity {
    /// `settings` are named fields, such as a study; this program's version and the seed are added as `version` and
    /// `seed`. JSON has no infinities and no NaN: both become null.
    pub fn new(seed: u64, settings: &impl Serialize) -> Result<Self, ArtefactError> {
        const EXPECTED: &str = "settings that JSON can hold, each with a name";
        let wrong = |found| ArtefactError::Identity {
            expected: EXPECTED,
            found,
        };
        let mut fields = match serde_json::to_value(settings) {
            Ok(Value::Object(fields)) => fields,
            Ok(other) => return Err(wrong(other.to_string())),
            Err(cause) => return Err(wrong(cause.to_string())),
        };
        for (name, value) in [("version", env!("CARGO_PKG_VERSION").into()), ("seed", seed.into())] {
            let value: Value = value;
            match fields.get(name) {
                Some(other) if *other != value => {
                    return Err(ArtefactError::Identity {
                        expected: "no second `version` or `seed` among the settings",
                        found: format!("`{name}` {other} beside {value}"),
                    });
                }
                _ => fields.insert(name.into(), value),
            };
        }
        Ok(Self(Value::Object(fields)))
    }

    pub fn value(&self) -> &Value {
        &self.0
    }

    /// Every setting that differs, by key. Empty only where the two are equal.
    pub fn differences(&self, other: &Self) -> Vec<Difference> {
        let mut found = Vec::new();
        compare("", Some(&self.0), Some(&other.0), &mut found);
        found
    }
}

/// Descends only where both sides have the same structure, so that a list of another length is reported as a whole.
fn compare(key: &str, here: Option<&Value>, there: Option<&Value>, found: &mut Vec<Difference>) {
    let below = |name: &str| {
        if key.is_empty() {
            name.to_owned()
        } else {
            format!("{key}.{name}")
        }
    };
    match (here, there) {
        (Some(Value::Object(a)), Some(Value::Object(b))) => {
            for (name, value) in a {
                compare(&below(name), Some(value), b.get(name), found);
            }
            for (name, value) in b.iter().filter(|(name, _)| !a.contains_key(*name)) {
                compare(&below(name), None, Some(value), found);
            }
        }
        (Some(Value::Array(a)), Some(Value::Array(b))) if a.len() == b.len() => {
            for (i, (a, b)) in a.iter().zip(b).enumerate() {
                compare(&below(&i.to_string()), Some(a), Some(b), found);
            }
        }
        _ if here == there => {}
        _ => {
            let text = |value: Option<&Value>| value.map_or("absent".to_owned(), Value::to_string);
            found.push(Difference {
                key: key.to_owned(),
                here: text(here),
                there: text(there),
            });
        }
    }
}
