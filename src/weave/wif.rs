//! WIF 1.1, the weaving information file: threading with tie-up and treadling, or with a lift plan.

use std::collections::{BTreeMap, BTreeSet};

use super::WeaveDraft;
use super::ini::{Ini, IniSection};
use super::notice::DraftNotice;
use super::threads::{palette, threads};
use crate::cloth::System;
use crate::formats::{FormatError, quoted, remedy};

/// Crossings of warp and weft a draft may have.
const CROSSINGS: usize = 4_000_000;

/// Numbers by number, such as the shafts of each thread; all counted from 1.
type Lists = BTreeMap<usize, BTreeSet<usize>>;

pub(super) fn parse(path: &str, text: &str) -> Result<WeaveDraft, FormatError> {
    let ini = Ini::parse(path, text)?;
    let mut warnings = ini.warnings.clone();
    if ini.section("WIF").is_none() {
        warnings.push(DraftNotice::NoWifSection);
    }
    missing_contents(&ini, &mut warnings);
    let threading = required(&ini, "THREADING")?;
    let lift_plan = ini.section("LIFTPLAN");
    let treadled = ini.section("TIEUP").zip(ini.section("TREADLING"));
    let picks = match (&treadled, lift_plan) {
        (Some((_, treadling)), plan) => {
            if plan.is_some() {
                warnings.push(DraftNotice::TieUpBeforeLiftPlan);
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
    let mut from_zero = |section: &IniSection, what: &'static str| -> bool {
        let zero = section.entries.iter().any(|entry| entry.key == "0");
        if zero {
            warnings.push(DraftNotice::NumberedFromZero {
                what,
                section: section.name.clone(),
            });
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
            warnings.push(DraftNotice::NoThreadCount { section });
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
    if !idle_picks.is_empty() {
        warnings.push(DraftNotice::IdlePicks { picks: idle_picks });
    }
    if !idle_warps.is_empty() {
        warnings.push(DraftNotice::IdleWarps { warps: idle_warps });
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
        warps: threads(&ini, System::Warp, warps, threads_from_zero, &palette, &mut warnings)?,
        wefts: threads(&ini, System::Weft, wefts, picks_from_zero, &palette, &mut warnings)?,
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
fn missing_contents(ini: &Ini, warnings: &mut Vec<DraftNotice>) {
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
        warnings.push(DraftNotice::MissingSections { sections: missing });
    }
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

fn rising(ini: &Ini, warnings: &mut Vec<DraftNotice>) -> Result<bool, FormatError> {
    let Some(entry) = ini.value("WEAVING", "RISING SHED") else {
        warnings.push(DraftNotice::RisingShedAssumed);
        return Ok(true);
    };
    is_true(entry.value).ok_or_else(|| {
        let remedy = "write true where a lifted shaft brings its warp threads to the top";
        ini.text
            .error(entry.at, "Rising Shed true or false", quoted(entry.value), remedy)
    })
}
