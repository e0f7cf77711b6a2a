use toml::Value;

use super::choices::{CentreLineChoice, SurfaceChoice};
use super::error::unwritable;
use super::fields::{self, Field, ValueKind};
use super::free_key_check;
use super::keys::{self, RigSection, SECTIONS, SpectrumSection, Study, TraceSection};
use super::{FreeKey, StudyError};
use crate::number::shown;
use crate::spectrum::Samples;
use crate::text::is_path;

/// Most wavelengths or views a study may ask for.
const MOST_STEPS: f64 = 10_000.0;

pub(super) fn study(study: &Study) -> Result<(), StudyError> {
    // TOML has no unsigned 64-bit integers.
    if i64::try_from(study.seed).is_err() {
        let found = study.seed.to_string();
        return Err(value(
            "seed",
            format!("a whole number, 0 to {}", i64::MAX),
            found,
            "take a smaller seed",
        ));
    }
    let written = toml::Table::try_from(study).map_err(|e| unwritable(&e))?;
    for section in SECTIONS {
        let values = match section.name {
            "" => Some(&written),
            name => written.get(name).and_then(Value::as_table),
        };
        for field in section.fields {
            if let Some(found) = values.and_then(|v| v.get(field.key)) {
                in_range(section.name, field, found)?;
            }
        }
    }
    spectrum(&study.spectrum)?;
    trace(&study.trace)?;
    rig(&study.rig)?;
    if study.cloth.centre_line == CentreLineChoice::Peirce
        && let Some(amplitude) = study.cloth.sinusoid_amplitude_mm
    {
        return Err(value(
            "cloth.sinusoid_amplitude_mm",
            "no value while centre_line is \"peirce\"",
            format!("{} mm", shown(amplitude)),
            "leave the amplitude out, or set centre_line = \"sinusoid\"",
        ));
    }
    fit(study)?;
    fibres(study)
}

fn fit(study: &Study) -> Result<(), StudyError> {
    study
        .fit
        .free
        .iter()
        .try_for_each(|free| free_key_check::check(free, study))?;
    let mut keys: Vec<&str> = study.fit.free.iter().flat_map(FreeKey::keys).collect();
    keys.sort_unstable();
    if let Some(twice) = keys.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(value(
            "fit.free",
            "every key once",
            format!("`{}` again", twice[0]),
            "leave one of them out",
        ));
    }
    match study.fit.dye_bounds_per_mm[..] {
        [low, high] if low < high => Ok(()),
        _ => Err(value(
            "fit.dye_bounds_per_mm",
            "two numbers in 1/mm, the lower one first",
            format!("{:?}", study.fit.dye_bounds_per_mm),
            "give the lowest and the highest absorption",
        )),
    }
}

/// Keys of fibres mean nothing on any other surface.
fn fibres(study: &Study) -> Result<(), StudyError> {
    let surface = match study.specular.surface {
        SurfaceChoice::Fibres => return Ok(()),
        SurfaceChoice::Cloth => "cloth",
        SurfaceChoice::Yarn => "yarn",
    };
    for (key, found) in [
        ("yarn.twist_deg", study.yarn.twist_deg),
        ("specular.roughness_across", study.specular.roughness_across),
    ] {
        if let Some(found) = found {
            return Err(value(
                key,
                format!("no value while [specular] surface is \"{surface}\""),
                shown(found),
                "leave it out, or set surface = \"fibres\"",
            ));
        }
    }
    Ok(())
}

fn value(
    key: impl Into<String>,
    expected: impl Into<String>,
    found: impl Into<String>,
    remedy: impl Into<String>,
) -> StudyError {
    StudyError::Value {
        place: None,
        key: key.into(),
        expected: expected.into(),
        found: found.into(),
        remedy: remedy.into(),
    }
}

/// A value of a study for a message.
fn found_text(found: &Value) -> String {
    match found {
        Value::Float(number) => shown(*number),
        Value::Array(list) => format!("[{}]", list.iter().map(found_text).collect::<Vec<_>>().join(", ")),
        other => other.to_string(),
    }
}

fn in_range(section: &str, field: &Field, found: &Value) -> Result<(), StudyError> {
    let number = |v: &Value| v.as_float().unwrap_or(f64::NAN);
    let fits = match field.kind {
        ValueKind::Number(range) => range.contains(number(found)),
        ValueKind::NumberOrTable(range) => match found.as_str() {
            // A number in quotes is a slip, not a file.
            Some(path) => !path.trim().is_empty() && path.trim().parse::<f64>().is_err(),
            None => range.contains(number(found)),
        },
        ValueKind::Numbers(range, at_least) => found
            .as_array()
            .is_some_and(|list| list.len() >= at_least && list.iter().all(|v| range.contains(number(v)))),
        ValueKind::Integer(low, high) => found
            .as_integer()
            .and_then(|i| u64::try_from(i).ok())
            .is_some_and(|i| (low..=high).contains(&i)),
        ValueKind::Multiple(low, high, of) => found
            .as_integer()
            .and_then(|i| u64::try_from(i).ok())
            .is_some_and(|i| (low..=high).contains(&i) && i % of == 0),
        ValueKind::ChoiceOrPath(choices) => found.as_str().is_some_and(|s| choices.contains(&s) || is_path(s)),
        ValueKind::IntegerOr(low, high, word) => match found.as_str() {
            Some(text) => text == word,
            None => found
                .as_integer()
                .and_then(|i| u64::try_from(i).ok())
                .is_some_and(|i| (low..=high).contains(&i)),
        },
        // Their values are checked with the keys that they name.
        ValueKind::FreeKeys => true,
        ValueKind::Text => found.as_str().is_some_and(|s| !s.trim().is_empty()),
        // The types admit nothing else.
        ValueKind::Flag | ValueKind::Choice(_) => true,
    };
    if fits {
        return Ok(());
    }
    let remedy = corrected(field.meaning);
    Err(value(
        fields::path(section, field.key),
        field.expected(),
        found_text(found),
        remedy,
    ))
}

fn corrected(meaning: &str) -> String {
    format!(
        "correct it, or leave it out for its default; it is: {}",
        meaning.trim_end_matches('.')
    )
}

/// [`Study::check_medium_table`], for any section.
pub(super) fn table_of(section: &str, key: &str, path: &str, values: &Samples) -> Result<(), StudyError> {
    let fault = |expected: String, found: String, remedy: String| {
        Err(value(
            fields::path(section, key),
            expected,
            format!("{found} in {path}"),
            remedy,
        ))
    };
    let Some(Field {
        kind: ValueKind::NumberOrTable(range),
        unit,
        meaning,
        ..
    }) = keys::find(section, key)
    else {
        return fault(
            "a key that takes a table".into(),
            "a table".into(),
            "write a number".into(),
        );
    };
    let mut points = values.grid().nm().iter().zip(values.values());
    match points.find(|(_, found)| !range.contains(**found)) {
        None => Ok(()),
        Some((nm, found)) => fault(
            format!("each value {range} {unit}").trim_end().to_owned(),
            format!("{} at {} nm", shown(*found), shown(*nm)),
            corrected(meaning),
        ),
    }
}

fn spectrum(spectrum: &SpectrumSection) -> Result<(), StudyError> {
    if let Some(list) = &spectrum.wavelengths_nm {
        if let Some(pair) = list.windows(2).find(|pair| pair[0] >= pair[1]) {
            return Err(value(
                "spectrum.wavelengths_nm",
                "strictly ascending wavelengths in nm",
                format!("{} after {}", shown(pair[1]), shown(pair[0])),
                "sort the list and take out duplicates",
            ));
        }
        return Ok(());
    }
    whole_steps(
        "spectrum.wavelength",
        "nm",
        spectrum.wavelength_min_nm,
        spectrum.wavelength_max_nm,
        spectrum.wavelength_step_nm,
    )
}

fn rig(rig: &RigSection) -> Result<(), StudyError> {
    let list = &rig.incidences_deg;
    if let Some((i, twice)) = list.iter().enumerate().find(|(i, angle)| list[..*i].contains(angle)) {
        return Err(value(
            "rig.incidences_deg",
            "different angles in degrees",
            format!("{} again as entry {}", shown(*twice), i + 1),
            "take out the duplicate",
        ));
    }
    whole_steps("rig.view", "deg", rig.view_min_deg, rig.view_max_deg, rig.view_step_deg)
}

/// That `max` lies above `min` by a whole number of steps.
fn whole_steps(name: &str, unit: &str, min: f64, max: f64, step: f64) -> Result<(), StudyError> {
    let key = |which: &str| format!("{name}_{which}_{unit}");
    if max < min {
        let remedy = format!("exchange it with {}", key("min"));
        return Err(value(
            key("max"),
            format!("at least {} {unit}", shown(min)),
            format!("{} {unit}", shown(max)),
            remedy,
        ));
    }
    let count = (max - min) / step;
    if count > MOST_STEPS {
        let expected = format!("at least {} {unit}", shown((max - min) / MOST_STEPS));
        return Err(value(
            key("step"),
            expected,
            format!("{} {unit}", shown(step)),
            "take a larger step",
        ));
    }
    if (count - count.round()).abs() > 1e-6 {
        return Err(value(
            key("step"),
            format!(
                "a step that divides {} {unit}, from {} to {}",
                shown(max - min),
                shown(min),
                shown(max)
            ),
            format!("{} {unit}", shown(step)),
            format!("change the step, or {}", key("max")),
        ));
    }
    Ok(())
}

fn trace(trace: &TraceSection) -> Result<(), StudyError> {
    for (key, paths) in [
        ("paths_bssrdf", trace.paths_bssrdf),
        ("paths_direct", trace.paths_direct),
        ("particles", trace.particles),
        ("particles_volumetric", trace.particles_volumetric),
    ] {
        if paths < u64::from(trace.batches) {
            return Err(value(
                fields::path("trace", key),
                format!("at least one path a batch, {}", trace.batches),
                paths.to_string(),
                "trace more paths, or take fewer batches",
            ));
        }
    }
    Ok(())
}
