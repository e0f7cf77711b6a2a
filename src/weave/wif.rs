//! WIF 1.1, the weaving information file: threading with tie-up and treadling, or with a lift plan.

use std::collections::{BTreeMap, BTreeSet};

use super::ini::{Ini, IniSection};
use super::{Thread, WeaveDraft};
use crate::formats::{FormatError, quoted, remedy};
use crate::number::count;

/// Crossings of warp and weft a draft may have.
const CROSSINGS: usize = 4_000_000;

/// Numbers by number, such as the shafts of each thread; all counted from 1.
type Lists = BTreeMap<usize, BTreeSet<usize>>;

pub(super) fn parse(path: &str, text: &str) -> Result<WeaveDraft, FormatError> {
    let ini = Ini::parse(path, text)?;
    let mut warnings = ini.warnings.clone();
    if ini.section("WIF").is_none() {
        warnings.push("the file has no section [WIF], which the format requires".to_owned());
    }
    missing_contents(&ini, &mut warnings);
    let threading = required(&ini, "THREADING")?;
    let lift_plan = ini.section("LIFTPLAN");
    let treadled = ini.section("TIEUP").zip(ini.section("TREADLING"));
    let picks = match (&treadled, lift_plan) {
        (Some((_, treadling)), plan) => {
            if plan.is_some() {
                warnings.push("both a lift plan and a tie-up are given: the tie-up is used".into());
            }
            treadling
        }
        (None, Some(plan)) => plan,
        (None, None) => {
            let expected = "sections [TIEUP] and [TREADLING], or [LIFTPLAN]";
            let remedy = "export the draft with its tie-up and treadling, or with its lift plan";
            return Err(FormatError::file(path, expected, "neither", remedy));
        }
    };
    let mut from_zero = |section: &IniSection, what: &str| -> bool {
        let zero = section.entries.iter().any(|entry| entry.key == "0");
        if zero {
            warnings.push(format!(
                "{what} are numbered from 0 in [{}], not from 1 as the format has it",
                section.name
            ));
        }
        zero
    };
    let threads_from_zero = from_zero(threading, "warp threads");
    let picks_from_zero = from_zero(picks, "picks");
    let treadles_from_zero = treadled.is_some_and(|(tie_up, _)| from_zero(tie_up, "treadles"));
    let shaft_count = ini.count("WEAVING", "SHAFTS")?;
    let treadle_count = ini.count("WEAVING", "TREADLES")?;
    // In a file that counts other things from 0, a shaft 0 is a shaft; else 0 means none.
    let counts_from_zero = threads_from_zero || picks_from_zero || treadles_from_zero;
    let shafts = |section| numbers(&ini, section, counts_from_zero, "shaft", shaft_count);
    let by_warp = renumbered(shafts(threading)?, threads_from_zero);
    let by_pick = match treadled {
        Some((tie_up, treadling)) => {
            let tied = renumbered(shafts(tie_up)?, treadles_from_zero);
            let treadles = numbers(&ini, treadling, treadles_from_zero, "treadle", treadle_count)?;
            let lifted =
                |treadles: BTreeSet<usize>| treadles.iter().filter_map(|t| tied.get(t)).flatten().copied().collect();
            renumbered(treadles, picks_from_zero)
                .into_iter()
                .map(|(pick, t)| (pick, lifted(t)))
                .collect()
        }
        None => renumbered(shafts(picks)?, picks_from_zero),
    };
    let warps = thread_count(&ini, "WARP", &by_warp, threading.at)?;
    for section in ["WARP", "WEFT"] {
        if ini.count(section, "THREADS")? == Some(0) {
            warnings.push(format!("[{section}] states Threads=0: as many as are listed are taken"));
        }
    }
    let wefts = thread_count(&ini, "WEFT", &by_pick, picks.at)?;
    if warps.checked_mul(wefts).is_none_or(|crossings| crossings > CROSSINGS) {
        let found = format!("{warps} warps and {wefts} wefts");
        let remedy = "export one repeat of the draft, or correct Threads";
        return Err(FormatError::file(
            path,
            format!("at most {CROSSINGS} crossings"),
            found,
            remedy,
        ));
    }
    let idle = |lists: &Lists, count: usize| -> Vec<usize> {
        (1..=count)
            .filter(|number| lists.get(number).is_none_or(BTreeSet::is_empty))
            .collect()
    };
    let idle_picks = idle(&by_pick, wefts);
    if idle_picks.len() == wefts {
        let remedy = "fill in the treadling, the tie-up or the lift plan: the draft may be unfinished";
        return Err(ini
            .text
            .error(picks.at, "picks that lift shafts", "none that does", remedy));
    }
    let idle_warps = idle(&by_warp, warps);
    if idle_warps.len() == warps {
        let remedy = "fill in the threading: the draft may be unfinished";
        return Err(ini
            .text
            .error(threading.at, "warp threads on shafts", "none that is", remedy));
    }
    for (numbers, noun, [one, several]) in [
        (
            idle_picks,
            "pick",
            [
                "lifts no shaft, so that nothing binds it: check treadling and tie-up, or the lift plan",
                "lift no shaft, so that nothing binds them: check treadling and tie-up, or the lift plan",
            ],
        ),
        (
            idle_warps,
            "warp thread",
            [
                "is on no shaft, so that nothing binds it: check the threading",
                "are on no shaft, so that nothing binds them: check the threading",
            ],
        ),
    ] {
        let words = if numbers.len() == 1 { one } else { several };
        if !numbers.is_empty() {
            let counted = count(numbers.len(), noun);
            warnings.push(format!("{counted} ({}) {words}", listed(&numbers)));
        }
    }
    let rising = rising(&ini, &mut warnings)?;
    let none = BTreeSet::new();
    let mut warp_on_top = Vec::with_capacity(warps * wefts);
    for pick in 1..=wefts {
        let lifted = by_pick.get(&pick).unwrap_or(&none);
        for warp in 1..=warps {
            let up = by_warp
                .get(&warp)
                .unwrap_or(&none)
                .iter()
                .any(|shaft| lifted.contains(shaft));
            warp_on_top.push(up == rising);
        }
    }
    let palette = palette(&ini)?;
    let title = ini.value("TEXT", "TITLE").map(|entry| entry.value.to_owned());
    Ok(WeaveDraft {
        title,
        warp_on_top,
        warps: threads(&ini, "WARP", warps, threads_from_zero, &palette, &mut warnings)?,
        wefts: threads(&ini, "WEFT", wefts, picks_from_zero, &palette, &mut warnings)?,
        warnings,
    })
}

fn required<'i, 'a>(ini: &'i Ini<'a>, name: &str) -> Result<&'i IniSection<'a>, FormatError> {
    let section = ini.section(name);
    section.ok_or_else(|| {
        let remedy = "export the draft with it, or copy the file again: it may be cut short";
        FormatError::file(ini.text.path, format!("a section [{name}]"), "none", remedy)
    })
}

/// Warns of sections that [CONTENTS] lists and the file lacks.
fn missing_contents(ini: &Ini, warnings: &mut Vec<String>) {
    let contents = ini
        .section("CONTENTS")
        .map(|s| s.entries.as_slice())
        .unwrap_or_default();
    let promised = contents.iter().filter(|entry| is_true(entry.value) == Some(true));
    let missing: Vec<String> = promised
        .filter(|entry| ini.section(&entry.key).is_none())
        .map(|entry| format!("[{}]", entry.key))
        .collect();
    if !missing.is_empty() {
        warnings.push(format!(
            "[CONTENTS] promises {}, and the file has none: it may be cut short; export it again",
            missing.join(", ")
        ));
    }
}

/// The first numbers of a list, formatted for a message.
fn listed(numbers: &[usize]) -> String {
    const SHOWN: usize = 8;
    let mut words: Vec<String> = numbers.iter().take(SHOWN).map(usize::to_string).collect();
    if numbers.len() > SHOWN {
        words.push("…".into());
    }
    words.join(", ")
}

fn is_true(word: &str) -> Option<bool> {
    match word.to_ascii_lowercase().as_str() {
        "true" | "on" | "yes" | "1" => Some(true),
        "false" | "off" | "no" | "0" => Some(false),
        _ => None,
    }
}

/// Lists of numbers by a whole number; 0 and nothing stand for none, unless numbers count from 0.
fn numbers(
    ini: &Ini,
    section: &IniSection,
    from_zero: bool,
    what: &str,
    most: Option<usize>,
) -> Result<Lists, FormatError> {
    let mut lists = Lists::new();
    for entry in &section.entries {
        let refuse = |expected: String, found: &str| {
            let remedy = "write number=number, with commas between several";
            ini.text.error(entry.at, expected, quoted(found), remedy)
        };
        let key: usize = entry
            .key
            .parse()
            .map_err(|_| refuse("a whole number before '='".into(), &entry.key))?;
        let mut list = BTreeSet::new();
        for word in entry.value.split(',').map(str::trim).filter(|word| !word.is_empty()) {
            let number: usize = word
                .parse()
                .map_err(|_| refuse(format!("the number of a {what}"), word))?;
            let number = number.saturating_add(usize::from(from_zero));
            if most.is_some_and(|most| number > most) {
                let expected = format!("a {what} of at most the number in [WEAVING]");
                let remedy = format!("correct the line, or the number of {what}s in [WEAVING]");
                return Err(ini.text.error(entry.at, expected, quoted(word), remedy));
            }
            if number > 0 {
                list.insert(number);
            }
        }
        if lists.insert(key, list).is_some() {
            return Err(ini
                .text
                .error(entry.at, "each number once", quoted(&entry.key), remedy::ONE_OF_TWO));
        }
    }
    Ok(lists)
}

fn renumbered(lists: Lists, from_zero: bool) -> Lists {
    let add = usize::from(from_zero);
    lists
        .into_iter()
        .map(|(key, list)| (key.saturating_add(add), list))
        .filter(|(key, _)| *key > 0)
        .collect()
}

/// As stated, or as many as are listed.
fn thread_count(ini: &Ini, section: &str, listed: &Lists, at: usize) -> Result<usize, FormatError> {
    let highest = listed.keys().next_back().copied().unwrap_or(0);
    match ini.count(section, "THREADS")? {
        Some(stated) if 0 < stated && stated < highest => {
            let found = format!("thread {highest}");
            let expected = format!("the {stated} threads of [{section}] and no more");
            let remedy = format!("correct Threads in [{section}], or remove what is too many");
            Err(ini.text.error(at, expected, found, remedy))
        }
        Some(stated) if stated > 0 => Ok(stated),
        _ if highest > 0 => Ok(highest),
        _ => {
            let expected = format!("threads of the {}", section.to_lowercase());
            Err(ini.text.error(at, expected, "none", "list them as number=number"))
        }
    }
}

fn rising(ini: &Ini, warnings: &mut Vec<String>) -> Result<bool, FormatError> {
    let Some(entry) = ini.value("WEAVING", "RISING SHED") else {
        warnings.push("the file does not say whether the shed rises: taken as rising".into());
        return Ok(true);
    };
    is_true(entry.value).ok_or_else(|| {
        let remedy = "write true where a lifted shaft brings its warp threads to the top";
        ini.text
            .error(entry.at, "Rising Shed true or false", quoted(entry.value), remedy)
    })
}

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

struct Palette {
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

fn palette(ini: &Ini) -> Result<Palette, FormatError> {
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

fn threads(
    ini: &Ini,
    section: &str,
    count: usize,
    from_zero: bool,
    palette: &Palette,
    warnings: &mut Vec<String>,
) -> Result<Vec<Thread>, FormatError> {
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
    let what = section.to_lowercase();
    if !unknown_colours.is_empty() {
        let uses = unknown_colours.len();
        unknown_colours.sort();
        unknown_colours.dedup();
        unknown_colours.truncate(8);
        warnings.push(format!(
            "{uses} entries of the {what} name colours that [COLOR TABLE] does not have ({}): taken as not stated",
            unknown_colours.join(", ")
        ));
    }
    if !unknown_threads.is_empty() {
        warnings.push(format!(
            "{} entries are of {what} threads that the draft does not have ({}): left out",
            unknown_threads.len(),
            listed(&unknown_threads)
        ));
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
