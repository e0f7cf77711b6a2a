use toml::Value;

use super::StudyError;
use super::fields::{self, Field, ValueKind};
use super::keys::{SECTIONS, Study};
use super::parse::closest;
use crate::number::shown;

/// A key of a study that holds a number, such as `medium.particle_index`.
#[derive(Clone, Copy)]
pub struct NumberKey {
    section: &'static str,
    field: &'static Field,
}

/// Keys that hold a number: a whole one, or a table may stand in its place.
fn is_number(kind: ValueKind) -> bool {
    matches!(
        kind,
        ValueKind::Number(_)
            | ValueKind::NumberOrTable(_)
            | ValueKind::Integer(..)
            | ValueKind::Multiple(..)
            | ValueKind::IntegerOr(..)
    )
}

impl NumberKey {
    /// Every key that holds a number, but for those of `[check]` and `[fit]`, which change no result.
    fn all() -> impl Iterator<Item = Self> {
        SECTIONS
            .iter()
            .filter(|section| !["check", "fit"].contains(&section.name))
            .flat_map(|section| {
                section.fields.iter().map(|field| Self {
                    section: section.name,
                    field,
                })
            })
            .filter(|key| is_number(key.field.kind))
    }

    /// The key of this name. `asked_by` is what errors call the place that names it: a key of the study, or an option.
    ///
    /// # Errors
    /// A name that no such key has, with the likeliest one.
    pub fn find(study: &Study, name: &str, asked_by: &str) -> Result<Self, StudyError> {
        if let Some(key) = Self::all().find(|key| key.name() == name) {
            return Ok(key);
        }
        let names: Vec<String> = Self::all().map(|key| key.name()).collect();
        let in_other_section = || {
            names
                .iter()
                .find(|known| known.rsplit('.').next() == name.rsplit('.').next())
        };
        let likely = in_other_section().map(String::as_str);
        let likely = likely.or_else(|| closest(name, names.iter().map(String::as_str)));
        Err(StudyError::Value {
            place: study.origin.place(asked_by),
            key: asked_by.into(),
            expected: "a key of a study that holds a number, as section.key".into(),
            found: format!("`{name}`"),
            remedy: match likely {
                Some(likely) => format!("did you mean `{likely}`?"),
                None => "`specval init --keys` lists them".into(),
            },
        })
    }

    /// Section and key.
    pub fn name(&self) -> String {
        fields::path(self.section, self.field.key)
    }

    /// Empty for a number without dimension.
    pub fn unit(&self) -> &'static str {
        self.field.unit
    }

    /// Whether it holds whole numbers.
    pub fn is_whole(&self) -> bool {
        !matches!(self.field.kind, ValueKind::Number(_) | ValueKind::NumberOrTable(_))
    }

    /// Whether the number lies in the range of the key.
    pub fn allows(&self, value: f64) -> bool {
        match self.field.kind {
            ValueKind::Number(range) | ValueKind::NumberOrTable(range) => range.contains(value),
            ValueKind::Integer(low, high) | ValueKind::IntegerOr(low, high, _) => {
                value.fract() == 0.0 && (low as f64..=high as f64).contains(&value)
            }
            ValueKind::Multiple(low, high, of) => {
                (value / of as f64).fract() == 0.0 && (low as f64..=high as f64).contains(&value)
            }
            _ => false,
        }
    }

    /// The range in words, with the unit.
    pub fn range(&self) -> String {
        let unit = match self.field.unit {
            "" => String::new(),
            unit => format!(" {unit}"),
        };
        match self.field.kind {
            ValueKind::Number(range) | ValueKind::NumberOrTable(range) => format!("{range}{unit}"),
            _ => self.field.expected(),
        }
    }

    /// The number in a study; `None` where a table or a word stands in its place, or the key is left out.
    pub fn of(&self, study: &Study) -> Option<f64> {
        let written = toml::Table::try_from(study).ok()?;
        let value = match self.section {
            "" => written.get(self.field.key),
            section => written.get(section)?.get(self.field.key),
        }?;
        value
            .as_float()
            .or_else(|| value.as_integer().map(|whole| whole as f64))
    }

    /// The study with another value of the key, validated.
    ///
    /// # Errors
    /// A value out of the key's range, or at odds with another key.
    pub fn set(&self, study: &Study, value: f64) -> Result<Study, StudyError> {
        let refuse = |remedy: &str| StudyError::Value {
            place: study.origin.place(&self.name()),
            key: self.name(),
            expected: self.field.expected(),
            found: shown(value),
            remedy: remedy.into(),
        };
        if !self.allows(value) {
            return Err(refuse("take a value of this range"));
        }
        let mut written = toml::Table::try_from(study).map_err(|_| refuse("take another value"))?;
        let number = match self.is_whole() {
            true => Value::Integer(value as i64),
            false => Value::Float(value),
        };
        match self.section {
            "" => {
                written.insert(self.field.key.into(), number);
            }
            section => {
                let section = written
                    .entry(section)
                    .or_insert_with(|| Value::Table(toml::Table::new()));
                if let Value::Table(section) = section {
                    section.insert(self.field.key.into(), number);
                }
            }
        }
        let mut changed: Study = written.try_into().map_err(|_| refuse("take another value"))?;
        changed.origin = study.origin.clone();
        changed.validate()?;
        Ok(changed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_set_by_name() {
        let study = Study::default();
        let key = |name| NumberKey::find(&study, name, "--vary").unwrap();
        let changed = key("medium.particle_index").set(&study, 1.9).unwrap();
        assert_eq!(changed.medium.particle_index.number(), Some(1.9));
        assert_eq!(
            key("weft.radius_mm").set(&study, 0.12).unwrap().weft.radius_mm,
            Some(0.12)
        );
        assert_eq!(key("weft.radius_mm").of(&study), None);
        assert_eq!(key("seed").set(&study, 5.0).unwrap().seed, 5);
        assert!(key("trace.tilts").set(&study, 5.5).is_err());
        assert!(key("specular.weight").set(&study, 1.5).is_err());
        assert_eq!(key("cloth.spacing_diameters").of(&study), Some(1.8));
        let error = NumberKey::find(&study, "medium.particel_index", "--vary")
            .err()
            .unwrap()
            .to_string();
        assert!(error.contains("did you mean `medium.particle_index`?"), "{error}");
        let error = NumberKey::find(&study, "roughness", "--vary")
            .err()
            .unwrap()
            .to_string();
        assert!(error.contains("did you mean `specular.roughness`?"), "{error}");
    }

    #[test]
    fn free_keys_are_checked_with_their_bounds() {
        let read = |line: &str| Study::from_toml(&format!("[fit]\nfree = [{{ {line} }}]\n"), "s.toml");
        assert!(read("key = \"medium.volume_fraction\", min = 0.01, max = 0.5, scale = \"log\"").is_ok());
        for (line, wanted) in [
            (
                "key = \"medium.volume_fractoin\", min = 0.01, max = 0.5",
                "medium.volume_fraction",
            ),
            (
                "key = \"medium.volume_fraction\", min = 0.5, max = 0.1",
                "below its max",
            ),
            (
                "key = \"medium.volume_fraction\", min = 0.5, max = 0.9",
                "within its range",
            ),
            (
                "key = \"medium.volume_fraction\", min = 0.0, max = 0.5, scale = \"log\"",
                "above 0",
            ),
            (
                "key = \"medium.volume_fraction\", min = 0.1, max = 0.5, prior_sd = 0.1",
                "together",
            ),
            ("key = \"medium.volume_fraction\", min = 0.1, max = 0.5, sd = 0.1", "sd"),
        ] {
            let error = read(line).unwrap_err().to_string();
            assert!(error.contains(wanted), "{line}: {error}");
            assert!(error.contains("s.toml"), "{error}");
        }
    }
}
