use super::Study;
use super::fields::Section;
use super::keys::SECTIONS;

const HEADER: &str = "\
# A study of specval: what to simulate and what to compare it with. Every key may be left out; the values here are the
# defaults. Lengths are in mm or nm and angles in degrees, as each key's name says.
";

pub(super) fn default_study() -> String {
    let defaults = toml::Table::try_from(Study::default()).unwrap_or_default();
    let mut out = String::from(HEADER);
    for section in SECTIONS {
        let values = match section.name {
            "" => Some(&defaults),
            name => defaults.get(name).and_then(toml::Value::as_table),
        };
        write_section(&mut out, section, values);
    }
    out
}

fn write_section(out: &mut String, section: &Section, values: Option<&toml::Table>) {
    if !section.name.is_empty() {
        *out += &format!("\n# {}\n[{}]\n", section.meaning, section.name);
    }
    for field in section.fields {
        *out += &format!("\n# {}\n# {}\n", field.meaning, field.expected());
        match (values.and_then(|v| v.get(field.key)), field.example) {
            (Some(value), _) => *out += &format!("{} = {value}\n", field.key),
            (None, Some(example)) => *out += &format!("# {} = {example}\n", field.key),
            (None, None) => {}
        }
    }
}
