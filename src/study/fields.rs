//! What is known of a key of a study file: the reader, the validation, the file that `specval init` writes and the page
//! of keys in the docs all take it from here. The keys themselves: [`super::keys`].

use crate::number::shown;

/// A section of the file and its keys. The empty name is the top level.
pub(super) struct Section {
    pub name: &'static str,
    pub meaning: &'static str,
    pub fields: &'static [Field],
}

#[derive(Clone, Copy)]
pub(super) struct Field {
    pub key: &'static str,
    pub meaning: &'static str,
    /// Empty for a number without dimension.
    pub unit: &'static str,
    pub kind: ValueKind,
    /// For a key without a default: an example, as TOML.
    pub example: Option<&'static str>,
}

#[derive(Clone, Copy)]
pub(super) enum ValueKind {
    Number(Range),
    /// A number, or a path to a table of them over wavelength.
    NumberOrTable(Range),
    /// A list of at least so many numbers.
    Numbers(Range, usize),
    Integer(u64, u64),
    /// A whole number that the third divides.
    Multiple(u64, u64, u64),
    /// A whole number, or this word in quotes for any number.
    IntegerOr(u64, u64, &'static str),
    Flag,
    Choice(&'static [&'static str]),
    /// One of these names, or a path, distinguished by [`crate::text::is_path`].
    ChoiceOrPath(&'static [&'static str]),
    /// Any text but the empty one.
    Text,
    /// A list of tables, each a key that a fit varies.
    FreeKeys,
}

/// Which ends belong to the range.
#[derive(Clone, Copy)]
pub(super) struct Range {
    pub low: f64,
    pub low_included: bool,
    pub high: f64,
    pub high_included: bool,
}

/// Both ends belong to it.
pub(super) const fn closed(low: f64, high: f64) -> Range {
    Range {
        low,
        low_included: true,
        high,
        high_included: true,
    }
}

/// The low end does not belong to it.
pub(super) const fn above(low: f64, high: f64) -> Range {
    Range {
        low_included: false,
        ..closed(low, high)
    }
}

/// The high end does not belong to it.
pub(super) const fn below(low: f64, high: f64) -> Range {
    Range {
        high_included: false,
        ..closed(low, high)
    }
}

/// Neither end belongs to it.
pub(super) const fn between(low: f64, high: f64) -> Range {
    Range {
        high_included: false,
        ..above(low, high)
    }
}
impl Range {
    pub fn contains(&self, value: f64) -> bool {
        (value > self.low || (self.low_included && value == self.low))
            && (value < self.high || (self.high_included && value == self.high))
    }
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (low, high) = (shown(self.low), shown(self.high));
        match (self.low_included, self.high_included) {
            (true, true) => write!(f, "{low} to {high}"),
            (true, false) => write!(f, "{low} to below {high}"),
            (false, true) => write!(f, "above {low} to {high}"),
            (false, false) => write!(f, "above {low} to below {high}"),
        }
    }
}

impl Field {
    /// What the key takes, with its unit: for comments and errors alike.
    pub fn expected(&self) -> String {
        let unit = if self.unit.is_empty() {
            String::new()
        } else {
            format!(" {}", self.unit)
        };
        match self.kind {
            ValueKind::Number(range) => format!("a number, {range}{unit}"),
            ValueKind::NumberOrTable(range) => format!(
                "a number, {range}{unit}, or a path in quotes to a CSV of such numbers, columns wavelength_nm,value, \
                 or CGATS text"
            ),
            ValueKind::Numbers(range, at_least) => format!("a list of {at_least} or more numbers, each {range}{unit}"),
            ValueKind::Integer(low, high) => format!("a whole number, {low} to {high}{unit}"),
            ValueKind::Multiple(low, high, of) => {
                format!("a whole number, a multiple of {of} from {low} to {high}{unit}")
            }
            ValueKind::IntegerOr(low, high, word) => format!("a whole number, {low} to {high}, or \"{word}\""),
            ValueKind::Flag => "true or false".into(),
            ValueKind::Choice(choices) => format!("one of {}", quoted(choices)),
            ValueKind::ChoiceOrPath(choices) => {
                format!("one of {}; or a path with a dot or slash in it", quoted(choices))
            }
            ValueKind::Text => "a text in quotes, not empty".into(),
            ValueKind::FreeKeys => {
                "a list of tables { key, min, max, scale, prior_mean, prior_sd, also }, of which the first \
                                    three are needed"
                    .into()
            }
        }
    }
}

pub(super) fn quoted(words: &[&str]) -> String {
    words.iter().map(|w| format!("\"{w}\"")).collect::<Vec<_>>().join(", ")
}

/// `key`, or `section.key`.
pub(super) fn path(section: &str, key: &str) -> String {
    if section.is_empty() {
        key.into()
    } else {
        format!("{section}.{key}")
    }
}

/// The key of this name, for rows that are as one of another section. There must be one, or the program does not
/// compile.
pub(super) const fn same(fields: &[Field], key: &str) -> Field {
    let mut i = 0;
    while !is_same(fields[i].key, key) {
        i += 1;
    }
    fields[i]
}

/// `==` of texts, for constants.
const fn is_same(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    let mut i = 0;
    while i < a.len() && i < b.len() && a[i] == b[i] {
        i += 1;
    }
    i == a.len() && i == b.len()
}

/// The one that there is, if any.
pub(super) const fn first(list: &'static [&'static str]) -> Option<&'static str> {
    match list {
        [one, ..] => Some(*one),
        [] => None,
    }
}
