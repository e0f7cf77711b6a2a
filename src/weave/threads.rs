//! Colours, spacings and thicknesses of the threads of a WIF file.

use std::collections::BTreeMap;

use super::Thread;
use super::ini::Ini;
use super::notice::DraftNotice;
use crate::cloth::System;
use crate::formats::{FormatError, quoted};

/// Whole numbers between commas.
fn whole(ini: &Ini, at: usize, list: &str) -> Result<Vec<i64>, FormatError> {
    let words = list.split(',').map(str::trim);
    let numbers = words.map(|w| {
        w.parse().map_err(|_| {
            let remedy = "write whole numbers, or remove the line: colours are not needed";
            ini.text.error(at, "whole numbers between commas", quoted(w), remedy)
        })
    });
    numbers.collect()
}

pub(super) struct Palette {
    range: [f64; 2],
    colours: BTreeMap<i64, [f64; 3]>,
    is_there: bool,
}

impl Palette {
    /// Components outside the range are clamped, because some writers exceed it.
    fn scaled(&self, rgb: [i64; 3]) -> [f64; 3] {
        let [low, high] = self.range;
        rgb.map(|c| ((c as f64 - low) / (high - low)).clamp(0.0, 1.0))
    }
}

pub(super) fn palette(ini: &Ini) -> Result<Palette, FormatError> {
    let range = match ini.value("COLOR PALETTE", "RANGE") {
        None => [0.0, 255.0],
        Some(entry) => match whole(ini, entry.at, entry.value)?[..] {
            [low, high] if low < high => [low as f64, high as f64],
            _ => {
                let remedy = "write the least and the greatest number of a colour, such as 0,255";
                return Err(ini.text.error(entry.at, "Range=low,high", quoted(entry.value), remedy));
            }
        },
    };
    let table = ini.section("COLOR TABLE");
    let mut palette = Palette {
        range,
        colours: BTreeMap::new(),
        is_there: table.is_some(),
    };
    for entry in table.map(|t| t.entries.as_slice()).unwrap_or_default() {
        let key = entry.key.parse::<i64>();
        let key = key.map_err(|_| {
            let remedy = "number the colours, from 1 on";
            ini.text
                .error(entry.at, "a whole number before '='", quoted(&entry.key), remedy)
        })?;
        let [r, g, b] = whole(ini, entry.at, entry.value)?[..] else {
            let remedy = "write the three numbers, or remove the line: colours are not needed";
            return Err(ini.text.error(entry.at, "red,green,blue", quoted(entry.value), remedy));
        };
        let colour = palette.scaled([r, g, b]);
        palette.colours.insert(key, colour);
    }
    Ok(palette)
}

pub(super) fn threads(
    ini: &Ini,
    system: System,
    count: usize,
    from_zero: bool,
    palette: &Palette,
    warnings: &mut Vec<DraftNotice>,
) -> Result<Vec<Thread>, FormatError> {
    let section = match system {
        System::Warp => "WARP",
        System::Weft => "WEFT",
    };
    let unit_mm = match ini.value(section, "UNITS") {
        None => None,
        Some(entry) => Some(match entry.value.to_ascii_lowercase().as_str() {
            "decipoints" => 25.4 / 720.0,
            "inches" => 25.4,
            "centimeters" => 10.0,
            _ => {
                let expected = "Units Decipoints, Inches or Centimeters";
                let remedy = "write one of these, or remove the line: lengths are then not known";
                return Err(ini.text.error(entry.at, expected, quoted(entry.value), remedy));
            }
        }),
    };
    let length = |key: &str| -> Result<Option<f64>, FormatError> {
        Ok(ini
            .number(section, key)?
            .zip(unit_mm)
            .map(|(length, unit)| length * unit))
    };
    // Colours and lengths are optional information: invalid values are ignored with one warning.
    let mut unknown_colours = Vec::new();
    let mut unknown_threads = Vec::new();
    let mut colour_at = |at: usize, value: &str| -> Result<Option<[f64; 3]>, FormatError> {
        let known = colour_of(ini, at, value, palette)?;
        if known.is_none() {
            unknown_colours.push(value.to_owned());
        }
        Ok(known.flatten())
    };
    let colour = match ini.value(section, "COLOR") {
        None => None,
        Some(entry) => colour_at(entry.at, entry.value)?,
    };
    let general = Thread {
        rgb: colour,
        spacing_mm: length("SPACING")?,
        thickness_mm: length("THICKNESS")?,
    };
    let mut threads = vec![general; count];
    let each = |list: &str| {
        ini.section(&format!("{section} {list}"))
            .map(|s| s.entries.as_slice())
            .unwrap_or_default()
    };
    let mut index = |key: &str, at: usize| -> Result<Option<usize>, FormatError> {
        let number: usize = key.parse().map_err(|_| {
            let remedy = "write number=value for each thread";
            ini.text
                .error(at, "the number of a thread before '='", quoted(key), remedy)
        })?;
        let index = number.checked_sub(usize::from(!from_zero)).filter(|&i| i < count);
        if index.is_none() {
            unknown_threads.push(number);
        }
        Ok(index)
    };
    for entry in each("COLORS").iter().filter(|e| !e.value.is_empty()) {
        let colour = colour_at(entry.at, entry.value)?;
        if let Some(index) = index(&entry.key, entry.at)? {
            threads[index].rgb = colour;
        }
    }
    for (list, is_spacing) in [("SPACING", true), ("THICKNESS", false)] {
        for entry in each(list).iter().filter(|e| !e.value.is_empty()) {
            let number = entry.value.parse::<f64>().ok().filter(|v| (0.0..1e9).contains(v));
            let number = number.ok_or_else(|| {
                let remedy = "write it with a point as decimal mark, or remove the line: lengths are not needed";
                ini.text
                    .error(entry.at, "a length, 0 or more", quoted(entry.value), remedy)
            })?;
            let Some(index) = index(&entry.key, entry.at)? else {
                continue;
            };
            let length_mm = unit_mm.map(|unit| unit * number);
            *(if is_spacing {
                &mut threads[index].spacing_mm
            } else {
                &mut threads[index].thickness_mm
            }) = length_mm;
        }
    }
    if !unknown_colours.is_empty() {
        let uses = unknown_colours.len();
        unknown_colours.sort();
        unknown_colours.dedup();
        unknown_colours.truncate(8);
        warnings.push(DraftNotice::UnknownColours {
            system,
            uses,
            colours: unknown_colours,
        });
    }
    if !unknown_threads.is_empty() {
        warnings.push(DraftNotice::UnknownThreads {
            system,
            threads: unknown_threads,
        });
    }
    Ok(threads)
}

/// An index of the colour table, perhaps with the colour itself behind it; 0 stands for none. `None` of an index that
/// the table does not have.
fn colour_of(ini: &Ini, at: usize, value: &str, palette: &Palette) -> Result<Option<Option<[f64; 3]>>, FormatError> {
    match whole(ini, at, value)?[..] {
        [index] => match palette.colours.get(&index) {
            Some(colour) => Ok(Some(Some(*colour))),
            None if index == 0 || !palette.is_there => Ok(Some(None)),
            None => Ok(None),
        },
        [_, r, g, b] => Ok(Some(Some(palette.scaled([r, g, b])))),
        _ => {
            let remedy = "write the number of a colour, or remove the line: colours are not needed";
            Err(ini
                .text
                .error(at, "index, or index,red,green,blue", quoted(value), remedy))
        }
    }
}
