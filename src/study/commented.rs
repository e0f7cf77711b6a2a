//! The keys as text: the study file that `specval init` writes, and docs/study.md.

use super::fields::{Section, path};
use super::keys::{FitSection, SECTIONS, Study};
use super::old_keys::{FORMER_KEYS, Now};

const STUDY_HEADER: &str = "\
# A study of specval: what to simulate and what to compare it with. Every key may be left out; the values here are the
# defaults. Lengths are in mm or nm and angles in degrees, as each key's name says.
";

const PAGE_HEADER: &str = "\
# Keys of a study

`specval init --keys` writes this page. A study is TOML; every key may be left out for its default. Paths in a study
belong to the study's folder. A key without a default has an example in its place, marked *e.g.*
";

pub(super) fn default_study() -> String {
    let mut out = String::from(STUDY_HEADER);
    each_section(|section, default| {
        if !section.name.is_empty() {
            out += &format!("\n# {}\n[{}]\n", section.meaning, section.name);
        }
        for field in section.fields {
            out += &format!("\n# {}\n# {}\n", field.meaning, field.expected());
            match (default(field.key), field.example) {
                (Some(value), _) => out += &format!("{} = {value}\n", field.key),
                (None, Some(example)) => out += &format!("# {} = {example}\n", field.key),
                (None, None) => {}
            }
        }
    });
    out
}

pub(super) fn page_of_keys() -> String {
    let mut out = String::from(PAGE_HEADER);
    each_section(|section, default| {
        match section.name {
            "" => out += "\n## Top level\n",
            name => out += &format!("\n## `[{name}]`\n\n{}\n", section.meaning),
        }
        out += "\n| key | default | takes | meaning |\n| --- | --- | --- | --- |\n";
        for field in section.fields {
            let shown = match (default(field.key), field.example) {
                (Some(value), _) => format!("`{value}`"),
                (None, example) => format!("*e.g.* `{}`", example.unwrap_or_default()),
            };
            let (key, expected) = (field.key, field.expected());
            // f* is no emphasis.
            let meaning = field.meaning.replace('*', "\\*");
            out += &format!("| `{key}` | {shown} | {expected} | {meaning} |\n");
        }
    });
    out += "\n## Keys of older studies\n\nThey are still read, with a notice.\n\n| old | now |\n| --- | --- |\n";
    for old in FORMER_KEYS {
        let now = match old.now {
            Now::Renamed { section, key, .. } => format!("`{}`", path(section, key)),
            Now::Dropped(why) => format!("no effect: {why}"),
        };
        out += &format!("| `{}` | {now} |\n", path(old.section, old.field.key));
    }
    out
}

/// Calls with every section and the defaults of its keys.
fn each_section(mut write: impl FnMut(&Section, &dyn Fn(&str) -> Option<toml::Value>)) {
    let mut defaults = toml::Table::try_from(Study::default()).unwrap_or_default();
    // A study leaves this section out where it is the default.
    if let Ok(fit) = toml::Table::try_from(FitSection::default()) {
        defaults.insert("fit".into(), toml::Value::Table(fit));
    }
    for section in SECTIONS {
        let values = match section.name {
            "" => Some(&defaults),
            name => defaults.get(name).and_then(toml::Value::as_table),
        };
        write(section, &|key| values?.get(key).cloned());
    }
}
