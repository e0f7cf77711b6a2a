//! Weave drafts in WIF: interlacement, colours, and what is refused.

use std::path::{Path, PathBuf};

use proptest::prelude::*;
use specval::cloth::Weave;
use specval::run::Plan;
use specval::study::Study;
use specval::weave::{DraftNotice, WeaveDraft};

fn golden(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/formats")
        .join(name)
}

fn text(name: &str) -> String {
    std::fs::read_to_string(golden(name)).unwrap()
}

fn parse(text: &str) -> WeaveDraft {
    WeaveDraft::parse("x.wif", text.as_bytes()).unwrap()
}

fn drawdown(draft: &WeaveDraft) -> Vec<String> {
    let row = |i| {
        (0..draft.warps.len())
            .map(|j| if draft.warp_on_top(i, j) { 'X' } else { '.' })
            .collect()
    };
    (0..draft.wefts.len()).map(row).collect()
}

#[test]
fn two_two_twill() {
    let draft = WeaveDraft::read(&golden("twill22.wif")).unwrap();
    assert_eq!(drawdown(&draft)[..4], ["XX..XX..", ".XX..XX.", "..XX..XX", "X..XX..X"]);
    assert_eq!((draft.title.as_deref(), draft.repeat()), (Some("2/2 twill"), [4, 4]));
    let cloth = draft.draft().unwrap();
    for i in 0..4 {
        for j in 0..4 {
            assert_eq!(cloth.warp_on_top(i, j), draft.warp_on_top(i, j));
        }
    }
    let blue = [20.0 / 255.0, 30.0 / 255.0, 120.0 / 255.0];
    assert_eq!(
        (draft.warps[0].rgb, draft.warps[3].rgb),
        (Some(blue), Some([180.0 / 255.0, 0.0, 0.0]))
    );
    assert_eq!(draft.wefts[5].rgb, Some([240.0 / 255.0, 230.0 / 255.0, 200.0 / 255.0]));
    assert!((draft.warps[1].spacing_mm.unwrap() - 0.5).abs() < 1e-12);
    assert!((draft.wefts[1].thickness_mm.unwrap() - 0.45).abs() < 1e-12);
    assert!(draft.warnings.is_empty(), "{:?}", draft.warnings);
}

/// The same draft on a sinking shed is the complement; the lift plan of the same lifts is the same.
#[test]
fn sinking_sheds_and_lift_plans() {
    let rising = WeaveDraft::read(&golden("twill22.wif")).unwrap();
    let sinking = WeaveDraft::read(&golden("twill22_sinking_range999.wif")).unwrap();
    for (up, down) in drawdown(&rising).iter().zip(drawdown(&sinking)) {
        assert!(up.chars().zip(down.chars()).all(|(a, b)| a != b), "{up} {down}");
    }
    assert_eq!(sinking.warps[0].rgb, Some([78.0 / 999.0, 118.0 / 999.0, 471.0 / 999.0]));
    let whole = text("twill22.wif");
    let tie_up = whole.find("[TIEUP]").unwrap();
    let colours = whole.find("[WARP COLORS]").unwrap();
    let plan = "[LIFTPLAN]\n1=1,2\n2=2,3\n3=3,4\n4=1,4\n5=1,2\n6=2,3\n7=3,4\n8=1,4\n";
    let lifted = parse(&format!("{}{plan}{}", &whole[..tie_up], &whole[colours..]));
    assert_eq!(drawdown(&lifted), drawdown(&rising));
}

#[test]
fn dialects() {
    let whole = text("twill22.wif");
    let rising = drawdown(&parse(&whole));
    // Names in any case, lines ended otherwise, empty values for none.
    assert_eq!(drawdown(&parse(&whole.to_uppercase().replace('\n', "\r\n"))), rising);
    // No colours, no palette, no weaving section.
    let bare: String = [
        "[WIF]\nVersion=1.1\n",
        &whole[whole.find("[THREADING]").unwrap()..whole.find("[WARP COLORS]").unwrap()],
    ]
    .concat();
    let bare = parse(&bare);
    assert_eq!(
        (drawdown(&bare), bare.warps[0].rgb, bare.warps[0].spacing_mm),
        (rising.clone(), None, None)
    );
    assert!(
        bare.warnings.contains(&DraftNotice::RisingShedAssumed),
        "{:?}",
        bare.warnings
    );
    // Everything counted from 0.
    let zero = "[WEAVING]\nRising Shed=1\n[THREADING]\n0=0\n1=1\n2=2\n3=3\n[TIEUP]\n0=0,1\n1=1,2\n2=2,3\n3=0,3\n\
                [TREADLING]\n0=0\n1=1\n2=2\n3=3\n";
    let zero = parse(&format!("[WIF]\n{zero}"));
    assert_eq!(drawdown(&zero), ["XX..", ".XX.", "..XX", "X..X"]);
    assert!(
        zero.warnings.iter().any(|w| w.to_string().contains("from 0")),
        "{:?}",
        zero.warnings
    );
    // In a file counted from 1 a 0 means none.
    let none = whole.replacen("3=3\n4=4\n5=1", "3=0\n4=4\n5=1", 1);
    assert_eq!(drawdown(&parse(&none))[1], ".X...XX.");
}

/// What other programs write, and other readers take.
#[test]
fn usual_files_are_read() {
    let whole = text("twill22.wif");
    let rising = drawdown(&parse(&whole));
    for (from, to, told) in [
        ("8=4\n\n[TIEUP]", "8=4   ; the last thread\n\n[TIEUP]", None),
        ("Rising Shed=true", "Rising Shed=true ;optional", None),
        ("[WIF]", "exported by a loom\n\n[WIF]", Some("(1 line)")),
        (
            "[THREADING]",
            "[PRIVATE LOOM]\nno equals sign\n1=x\n[PRIVATE LOOM]\n[THREADING]",
            None,
        ),
        ("8=2", "8=7", Some("[COLOR TABLE] does not have (7)")),
        (
            "[WEFT COLORS]\n",
            "[WEFT COLORS]\n99=1\n",
            Some("threads that the draft does not have (99)"),
        ),
        ("Threads=8", "Threads=0", Some("as many as are listed")),
        (
            "[CONTENTS]\n",
            "[CONTENTS]\nWEFT SYMBOLS=1\nNOTES=no\n",
            Some("promises [WEFT SYMBOLS]"),
        ),
    ] {
        assert!(whole.contains(from), "{from}");
        let draft = parse(&whole.replacen(from, to, 1));
        assert_eq!(drawdown(&draft), rising, "{to}");
        match told {
            Some(words) => assert!(
                draft.warnings.iter().any(|w| w.to_string().contains(words)),
                "{:?}",
                draft.warnings
            ),
            None => assert!(draft.warnings.is_empty(), "{to}: {:?}", draft.warnings),
        }
    }
    for bytes_of in [u16::to_le_bytes, u16::to_be_bytes] {
        let utf16: Vec<u8> = whole.encode_utf16().flat_map(bytes_of).collect();
        assert_eq!(drawdown(&WeaveDraft::parse("x.wif", &utf16).unwrap()), rising);
    }
    let latin: Vec<u8> = [b"; M\xfcller\n", whole.as_bytes()].concat();
    assert_eq!(drawdown(&WeaveDraft::parse("x.wif", &latin).unwrap()), rising);
}

/// Picks that lift nothing are told, and a draft of such picks alone is none.
#[test]
fn picks_without_shafts_are_told() {
    let whole = text("twill22.wif");
    let treadling = whole.find("[TREADLING]").unwrap();
    let (before, behind) = whole.split_at(treadling);
    let some = parse(&format!("{before}{}", behind.replacen("3=3\n4=4\n", "3=\n", 1)));
    assert!(
        some.warnings
            .iter()
            .any(|w| w.to_string().starts_with("2 picks (3, 4) lift no shaft")),
        "{:?}",
        some.warnings
    );
    let colours = whole.find("[WARP COLORS]").unwrap();
    let none = format!("{before}[TREADLING]\n1=\n2=\n8=\n{}", &whole[colours..]);
    let error = WeaveDraft::parse("x.wif", none.as_bytes()).unwrap_err();
    assert!(error.to_string().contains("none that does"), "{error}");
}

#[test]
fn faults_are_named() {
    let whole = text("twill22.wif");
    for (from, to, says) in [
        ("8=4\n\n[TIEUP]", "8=5\n\n[TIEUP]", "at most the number"),
        ("8=4\n\n[TIEUP]", "9=4\n\n[TIEUP]", "8 threads"),
        ("8=4\n\n[TIEUP]", "x=4\n\n[TIEUP]", "whole number"),
        ("8=4\n\n[TIEUP]", "7=4\n\n[TIEUP]", "once"),
        ("8=4\n\n[WARP COLORS]", "8=9\n\n[WARP COLORS]", "treadle"),
        ("[TREADLING]", "[TRAMPLING]", "[LIFTPLAN]"),
        ("[WEFT COLORS]", "[WARP COLORS]", "once"),
        ("Rising Shed=true", "Rising Shed=maybe", "true or false"),
        ("Threads=8", "Threads=many", "whole number"),
        ("Threads=8", "Threads=1000000000", "crossings"),
        ("Range=0,255", "Range=255,0", "low,high"),
        ("centimeters", "cubits", "Centimeters"),
        ("Spacing=0.050", "Spacing=nan", "0 or more"),
        ("1=20,30,120", "1=20,30", "red,green,blue"),
        ("[THREADING]", "no key\n[THREADING]", "key=value"),
    ] {
        assert!(whole.contains(from), "{from}");
        let error = WeaveDraft::parse("x.wif", whole.replacen(from, to, 1).as_bytes()).unwrap_err();
        assert!(error.to_string().contains(says), "{from} → {to}: {error}");
    }
    assert!(
        WeaveDraft::read(&golden("dir_iso_bw.ddr"))
            .unwrap_err()
            .to_string()
            .contains("format ddr")
    );
    // A thread on no shaft never changes sides: a drawdown, but no cloth.
    let loose = parse(&whole.replacen("3=3\n4=4\n5=1", "3=0\n4=4\n5=1", 1));
    assert!(loose.draft().is_err());
}

/// Every weave with a name survives being written as a lift plan.
#[test]
fn known_weaves_as_lift_plans() {
    for weave in Weave::BUILT_IN {
        let draft = weave.draft();
        let n = draft.yarns(specval::cloth::System::Warp);
        let mut wif = "[WIF]\n[WEAVING]\nRising Shed=yes\n[THREADING]\n".to_owned();
        (1..=n).for_each(|j| wif += &format!("{j}={j}\n"));
        wif += "[LIFTPLAN]\n";
        for i in 0..n {
            let up = (0..n).filter(|&j| draft.warp_on_top(i, j)).map(|j| (j + 1).to_string());
            wif += &format!("{}={}\n", i + 1, up.collect::<Vec<_>>().join(","));
        }
        assert_eq!(parse(&wif).draft().unwrap(), draft, "{weave:?}");
    }
}

/// The text of a drawdown, as `specval weave` prints it.
fn rows(draft: &WeaveDraft) -> String {
    drawdown(draft).join(" ")
}

/// Built-in weaves by name, files by path; what is neither is refused with the names, the nearest and the way to a
/// file.
#[test]
fn weaves_are_loaded_by_name_or_path() {
    assert_eq!(
        rows(&WeaveDraft::load("satin-5").unwrap()),
        ".XXXX XX.XX XXXX. X.XXX XXX.X"
    );
    for (weave, name) in Weave::BUILT_IN.iter().zip(Weave::NAMES) {
        let draft = WeaveDraft::load(name).unwrap();
        assert_eq!(draft.draft().unwrap(), weave.draft(), "{name}");
        assert_eq!(draft.title.as_deref(), Some(*name));
    }
    let path = golden("twill22.wif");
    assert_eq!(
        WeaveDraft::load(path.to_str().unwrap()).unwrap(),
        WeaveDraft::read(&path).unwrap()
    );
    assert_eq!(
        WeaveDraft::load("twil-2-1").unwrap_err().to_string(),
        format!(
            "expected a built-in weave, or a WIF file by a path with a dot or slash in it: weave 'twil-2-1' is not \
             known; known: {}; did you mean 'twill-2-1'?",
            Weave::NAMES.join(", ")
        )
    );
    let missing = WeaveDraft::load("missing.wif").unwrap_err().to_string();
    assert!(missing.starts_with("missing.wif"), "{missing}");
}

/// `[cloth] weave` weaves a built-in weave, or the repeat of a draft, which enters the inputs.
#[test]
fn studies_weave_names_and_paths() {
    let study =
        |weave: &str| Study::from_toml(&format!("[cloth]\nweave = \"{weave}\"\nspacing_diameters = 2.5"), "s").unwrap();
    let is_draft = |plan: &Plan| plan.inputs.iter().any(|input| input.name.starts_with("draft "));
    let named = Plan::new(study("satin-5")).unwrap();
    assert!(named.cloth_spec.weave == Weave::Satin5 && !is_draft(&named));
    let path = golden("twill22.wif").display().to_string();
    let plan = Plan::new(study(&path)).unwrap();
    assert!(plan.inputs.iter().any(|input| input.name == format!("draft {path}")));
    assert!(plan.study.to_toml().unwrap().contains(&path));
    let twill = WeaveDraft::read(&golden("twill22.wif")).unwrap().draft().unwrap();
    assert_eq!(plan.cloth_spec.weave, Weave::Custom(twill));
    let Err(error) = Plan::new(study("missing.wif")) else {
        panic!("no draft, and yet a plan")
    };
    assert!(
        error.to_string().starts_with("s, line 2: `cloth.weave`: missing.wif"),
        "{error}"
    );
}

/// A draft with a yarn that never changes sides is refused by its key.
#[test]
fn a_draft_that_is_no_weave_is_refused_by_its_key() {
    let folder = tempfile::tempdir().unwrap();
    let loose = text("twill22.wif").replacen("3=3\n4=4\n5=1", "3=0\n4=4\n5=1", 1);
    std::fs::write(folder.path().join("loose.wif"), loose).unwrap();
    let study = Study::from_toml("\n[cloth]\nweave = \"loose.wif\"\n", "s").unwrap();
    let error = Plan::new(study.at_folder(folder.path())).err().unwrap().to_string();
    assert!(
        error.starts_with("s, line 3: `cloth.weave`: expected a weave"),
        "{error}"
    );
    assert!(
        error.contains("loose.wif") && error.contains("`specval weave`"),
        "{error}"
    );
}

/// The old key reads as it did, over the new one too, and its notice names the new one.
#[test]
fn the_old_key_of_drafts_is_read_with_a_notice() {
    let path = golden("twill22.wif").display().to_string();
    let old = Study::from_toml(&format!("[weave]\ndraft = \"{path}\"\n"), "s").unwrap();
    let new = Study::from_toml(&format!("[cloth]\nweave = \"{path}\"\n"), "s").unwrap();
    assert_eq!(old, new);
    assert!(new.origin.old_keys().is_empty());
    let notice =
        format!("s, line 2: `weave.draft` is now `cloth.weave`: write weave = \"{path}\" in [cloth] in its place");
    assert_eq!(old.origin.old_keys()[0].to_string(), notice);
    assert!(
        Plan::new(old)
            .unwrap()
            .notices()
            .iter()
            .any(|told| told.to_string() == notice)
    );
    // Both: the draft was woven.
    let both = Study::from_toml("[cloth]\nweave = \"plain\"\n[weave]\ndraft = \"twill\"\n", "s").unwrap();
    assert_eq!(both.cloth.weave, "./twill");
    let notices = both.origin.old_keys()[0].to_string();
    assert!(
        notices.starts_with("s, line 4: ") && notices.ends_with(", for \"plain\", which is passed over"),
        "{notices}"
    );
    for (text, words) in [
        ("[weave]\ndraft = 3\n", "s, line 2: `weave.draft`: expected a text"),
        (
            "[weave]\ndraft = \"\"\n",
            "s, line 2: `cloth.weave`: expected one of \"plain\"",
        ),
        ("[weave]\ndrft = \"a.wif\"\n", "did you mean `draft`? Known keys: draft"),
        ("weave = \"plain\"\n", "s, line 1: "),
    ] {
        let message = Study::from_toml(text, "s").unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
    assert_eq!(Study::from_toml("[weave]\n", "s"), Ok(Study::default()));
}

proptest! {
    #[test]
    fn changed_drafts_are_survived(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0usize..3), 1..8),
    ) {
        let mut bytes = text("twill22.wif").into_bytes();
        for (place, byte, kind) in changes {
            let at = place.index(bytes.len());
            match kind {
                0 => bytes[at] = byte,
                1 => { bytes.remove(at); }
                _ => bytes.insert(at, byte),
            }
        }
        let _ = WeaveDraft::parse("x.wif", &bytes).map(|draft| (draft.repeat(), draft.draft()));
    }
}
