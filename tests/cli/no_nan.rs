//! What is not known is left out, and never a NaN, an infinity or a negative zero: in no file and on no stream.

use serde_json::Value;
use std::fs;
use std::path::Path;

use crate::command::specval;

/// Words that stand for no number, and zeros with a sign, with their surroundings.
fn unfit(text: &str) -> Vec<String> {
    let part_of_word = |c: char| c.is_alphanumeric() || "._-+".contains(c);
    text.split(|c: char| !part_of_word(c))
        .filter(|word| {
            let bare = word.trim_start_matches(['-', '+']).to_lowercase();
            let number = word.parse::<f64>();
            matches!(bare.as_str(), "nan" | "inf" | "infinity")
                || number.is_ok_and(|number| !number.is_finite() || (number == 0.0 && number.is_sign_negative()))
        })
        .map(str::to_owned)
        .collect()
}

#[test]
fn what_is_unfit_is_found() {
    let found = |text: &str| unfit(text).len();
    assert_eq!(found("a,NaN,0\n-0.0;1,-0 -0e0 inf:-inf 0,\"-0.000\""), 7);
    assert_eq!(found("0.0 -1e-5 10-0 information a-0 nano <td>0</td> 1e-300 2-0.5"), 0);
}

/// Every text of a folder; what is drawn in pictures is of the same numbers.
fn texts(folder: &Path) -> Vec<(String, String)> {
    let mut texts = Vec::new();
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let path = entry.path();
        if path.is_dir() {
            texts.extend(self::texts(&path));
        } else if path.extension().is_none_or(|e| e != "png" && e != "trace") {
            texts.push((path.display().to_string(), fs::read_to_string(&path).unwrap()));
        }
    }
    texts
}

/// Runs in a folder with a study of that text and looks at all that comes out.
fn run(study: &str, arguments: &[&str]) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("study.toml"), study).unwrap();
    let output = specval(folder.path(), arguments);
    let [stdout, stderr] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    assert!(output.status.success(), "{arguments:?}: {stderr}");
    let mut all = texts(folder.path());
    all.push(("stdout".into(), stdout.clone()));
    all.push(("stderr".into(), stderr));
    for (name, text) in all {
        let unfit = unfit(&text);
        assert!(unfit.is_empty(), "{arguments:?} of {study:?}, {name}: {unfit:?}");
    }
    (folder, stdout)
}

/// Yarns of a nanometre, at which hardly any path meets a particle; no particles at all; and few paths.
const STUDIES: [&str; 3] = [
    include_str!("../data/no_hits.toml"),
    "[medium]\nvolume_fraction = 0\n[rig]\npixels_per_side = 8\n",
    "[rig]\npixels_per_side = 8\n",
];

#[test]
fn no_report_holds_what_is_no_number_and_verdicts_are_withheld() {
    for study in STUDIES {
        let (folder, _) = run(study, &["report", "study.toml", "--paths", "64", "--out", "out"]);
        let document: Value =
            serde_json::from_slice(&fs::read(folder.path().join("out/report.json")).unwrap()).unwrap();
        let verdicts: Vec<&Value> = document["rmse_ratios"]
            .as_array()
            .unwrap()
            .iter()
            .map(|row| &row["verdict"])
            .collect();
        assert!(!verdicts.is_empty(), "{document}");
        // Of clear yarns the gloss is all there is, and that is known.
        let known = study == STUDIES[1];
        for verdict in verdicts {
            assert!(known || verdict == "cannot tell", "{study}: {verdict}");
        }
        let (_, json) = run(
            study,
            &["report", "study.toml", "--paths", "64", "--out", "out", "--json"],
        );
        let _: Value = serde_json::from_str(&json).unwrap();
    }
}

#[test]
fn no_other_command_writes_what_is_no_number() {
    for study in STUDIES {
        for arguments in [
            &["measure", "study.toml", "--paths", "64", "--out", "curves.csv"][..],
            &[
                "measure",
                "study.toml",
                "--paths",
                "64",
                "--out",
                "curves.csv",
                "--json",
            ],
            &[
                "measure",
                "study.toml",
                "--paths",
                "64",
                "--method",
                "volumetric",
                "--out",
                "curves.csv",
            ],
            &["trace", "study.toml", "--paths", "64", "--out", "yarn.trace", "--json"],
            &["medium", "study.toml"],
            &["medium", "study.toml", "--json"],
        ] {
            run(study, arguments);
        }
    }
}

/// The ledger of a yarn's light, of fractions of what falls on it, has no row of nothing.
#[test]
fn a_clear_yarn_absorbs_and_scatters_nothing() {
    let (folder, _) = run(STUDIES[1], &["report", "study.toml", "--paths", "64", "--out", "out"]);
    let energy = fs::read_to_string(folder.path().join("out/energy.csv")).unwrap();
    let mut reader = csv::Reader::from_reader(energy.as_bytes());
    let header = reader.headers().unwrap().clone();
    let column = |name: &str| header.iter().position(|column| column == name).unwrap();
    let mut rows = 0;
    for row in reader.records().map(Result::unwrap) {
        let number = |name: &str| row[column(name)].parse::<f64>().unwrap();
        assert_eq!((number("scattered"), number("absorbed")), (0.0, 0.0));
        let left = 1.0 - number("reflected") - number("ballistic") - number("roulette");
        assert!(left.abs() < 1e-12, "{row:?}");
        rows += 1;
    }
    assert!(rows > 1000, "{rows}");
}

/// Readings whose errors are 0 have no z.
#[test]
fn a_check_of_readings_without_error_writes_numbers_alone() {
    let folder = tempfile::tempdir().unwrap();
    let mut csv = "theta_i_deg,theta_v_deg,beta_r,beta_g,beta_b,beta_r_se,beta_g_se,beta_b_se\n".to_owned();
    for theta_i in [0, 30] {
        for theta_v in (-60..=60).step_by(20) {
            csv += &format!("{theta_i},{theta_v},0.3,0.2,0.1,0,0,0\n");
        }
    }
    fs::write(folder.path().join("s.csv"), csv).unwrap();
    for arguments in [
        &["check", "--sample", "s.csv", "--junit", "j.xml"][..],
        &["check", "--sample", "s.csv", "--json", "--github"],
    ] {
        let output = specval(folder.path(), arguments);
        let [stdout, stderr] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        assert!(stdout.contains("sample-energy"), "{stdout}{stderr}");
        for (name, text) in [("stdout".into(), stdout), ("stderr".into(), stderr)]
            .into_iter()
            .chain(texts(folder.path()))
        {
            assert_eq!(unfit(&text), Vec::<String>::new(), "{arguments:?}: {name}: {text}");
        }
    }
}
