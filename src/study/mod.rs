//! The study file: every parameter of a run, typed, with its unit in its name.
//!
//! A study is TOML. Every key has a default (the preprint's yarn), an unknown key is an error, and so is a value out of
//! its range; the message names the line, what was expected and what was found.

#[macro_use]
mod table;

mod choices;
mod commented;
mod error;
mod fields;
mod free_key;
mod free_key_check;
mod keys;
mod old_keys;
mod origin;
mod parse;
mod paths;
mod sections;
mod validate;
mod vary;

use crate::spectrum::Samples;

pub use choices::{
    BounceLimit, CentreLineChoice, DistributionChoice, DyeChoice, EstimatorChoice, GeometryChoice, InterferenceChoice,
    MethodChoice, NumberOrTable, ShadeWith, SurfaceChoice,
};
pub use error::{FileLine, StudyError};
pub use free_key::{FreeKey, KeyScale};
pub use keys::{
    CheckSection, ClothSection, ColourSection, FitSection, MeasuredSection, MediumSection, RigSection, SpectrumSection,
    SpecularSection, Study, SweepSection, TraceSection, WeftSection, YarnSection,
};
pub use old_keys::{OldKey, OldKeyNow};
pub use origin::Origin;
pub use parse::study_of_any_age;

impl Study {
    /// Reads and validates a study; what the text leaves out keeps its default. `file_name` is what errors call the
    /// text.
    ///
    /// # Errors
    /// The first fault of the text, with its line.
    pub fn from_toml(text: &str, file_name: &str) -> Result<Self, StudyError> {
        parse::study(text, file_name)
    }

    /// Checks every value against its range, and values that must fit each other. A study that [`Study::from_toml`]
    /// returned is valid; one changed since may not be.
    ///
    /// # Errors
    /// The first value that does not fit: key, expected range with unit, found, remedy.
    pub fn validate(&self) -> Result<(), StudyError> {
        validate::study(self).map_err(|error| self.origin.locate(error))
    }

    /// Checks the values of the file at `path`, which a key of `[medium]` or `[weft]` names in place of a number,
    /// against the range of the key.
    ///
    /// # Errors
    /// The first value out of range with its wavelength, key and file.
    pub fn check_medium_table(section: &str, key: &str, path: &str, values: &Samples) -> Result<(), StudyError> {
        validate::table_of(section, key, path, values)
    }

    /// The whole study as TOML, defaults included, without comments.
    ///
    /// # Errors
    /// For an invalid study only.
    pub fn to_toml(&self) -> Result<String, StudyError> {
        self.validate()?;
        toml::to_string(self).map_err(|e| error::unwritable(&e))
    }

    /// The default study as TOML, each key with its meaning, unit and range.
    pub fn commented_toml() -> String {
        commented::default_study()
    }

    /// Every key with default, range, unit and meaning, as tables in Markdown: docs/study.md.
    pub fn page_of_keys() -> String {
        commented::page_of_keys()
    }

    /// Whether a study has such a key or section at its top level, or had in an old spelling.
    pub fn has_at_top(word: &str) -> bool {
        parse::is_section(word) || keys::find("", word).is_some()
    }
}
