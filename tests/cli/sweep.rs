//! `specval sweep`: designs, resumption, and what it refuses.

use std::fs;
use std::path::Path;
use std::process::Output;

use crate::command::specval;
use serde_json::Value;

const VARY: [&str; 4] = [
    "--vary",
    "medium.kappa_peak=0.002:0.0065:2",
    "--vary",
    "medium.volume_fraction=0.1,0.14",
];

fn sweep(folder: &Path, more: &[&str]) -> Output {
    let words = ["sweep", "--quick", "--paths", "3000"];
    specval(folder, &[&words[..], more].concat())
}

fn rows(folder: &Path, out: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let text = fs::read_to_string(folder.join(out).join("sweep.csv")).unwrap();
    let mut lines = text.lines().skip(1).map(|line| line.split(','));
    let names = lines.next().unwrap().map(String::from).collect();
    let number = |cell: &str| cell.parse().unwrap_or(f64::NAN);
    (names, lines.map(|line| line.map(number).collect()).collect())
}

#[test]
fn a_point_is_what_a_report_of_its_study_says() {
    let folder = tempfile::tempdir().unwrap();
    let done = sweep(folder.path(), &VARY);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let (names, rows) = rows(folder.path(), "sweep");
    assert_eq!(rows.len(), 4);
    let points: Vec<[f64; 2]> = rows.iter().map(|row| [row[1], row[2]]).collect();
    assert_eq!(points, [[0.002, 0.1], [0.002, 0.14], [0.0065, 0.1], [0.0065, 0.14]]);
    let out = ["report", "--quick", "--paths", "3000", "--json"];
    let report: Value = serde_json::from_slice(&specval(folder.path(), &out).stdout).unwrap();
    // The last point is the built-in study.
    let of = |name: &str| rows[3][names.iter().position(|known| known == name).unwrap()];
    let list = |key: &str| report[key].as_array().unwrap().clone();
    let model = |row: &&Value| row["source"] == "model";
    let coefficient = report["normalisation"]["model"]["value"].as_f64().unwrap();
    assert_eq!(of("coefficient"), coefficient);
    let table1 = list("table1");
    let ratios = table1.iter().find(|row| row["row"] == "model").unwrap();
    for name in [
        "blue_over_red",
        "blue_over_red_se",
        "green_over_red",
        "green_over_red_se",
    ] {
        assert_eq!(of(name), ratios[name].as_f64().unwrap(), "{name}");
    }
    for theta in [0, 30, 60] {
        let rmse = list("rmse");
        let rmse = rmse
            .iter()
            .find(|of| model(of) && of["channel"] == "y" && of["theta_i_deg"].as_f64() == Some(f64::from(theta)));
        assert_eq!(
            of(&format!("rmse_y_{theta}deg")),
            rmse.unwrap()["value"].as_f64().unwrap()
        );
    }
    for name in ["sweep1.svg", "sweep1.png", "sweep2.svg", "sweep2.png", "sweep.json"] {
        assert!(folder.path().join("sweep").join(name).exists(), "{name}");
    }
}

#[test]
fn a_sweep_that_was_cut_short_goes_on_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let first = sweep(folder.path(), &[&VARY[..], &["--max-time", "0s"]].concat());
    let words = String::from_utf8_lossy(&first.stderr).into_owned();
    assert!(first.status.success() && words.contains("1 of 4 points"), "{words}");
    assert_eq!(rows(folder.path(), "sweep").1.len(), 1);
    let resumed = sweep(folder.path(), &[&VARY[..], &["--resume"]].concat());
    assert!(resumed.status.success(), "{}", String::from_utf8_lossy(&resumed.stderr));
    assert!(String::from_utf8_lossy(&resumed.stderr).contains("goes on after 1 points"));
    let whole = sweep(folder.path(), &[&VARY[..], &["--out", "whole"]].concat());
    assert!(whole.status.success());
    for name in ["sweep.csv", "sweep1.svg", "sweep2.png"] {
        let of = |out: &str| fs::read(folder.path().join(out).join(name)).unwrap();
        assert!(of("sweep") == of("whole"), "{name}");
    }
    // Rows of another seed are those of another sweep.
    let other = sweep(folder.path(), &[&VARY[..], &["--resume", "--seed", "2"]].concat());
    assert_eq!(other.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&other.stderr).contains("another study, sample, seed or design"));
}

#[test]
fn what_cannot_be_varied_is_refused_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, words) in [
        (
            &["--vary", "medium.kapa_peak=1:2:3"][..],
            "did you mean `medium.kappa_peak`",
        ),
        (&["--vary", "kappa_peak=0.1,0.2"], "did you mean `medium.kappa_peak`"),
        (&["--vary", "medium.dye=1"], "a key whose value is a number"),
        (
            &["--vary", "medium.volume_fraction=0.1:2:3"],
            "0 to below 0.74, found 1.05",
        ),
        (&["--vary", "trace.tilts=1.5"], "whole number"),
        (&["--vary", "medium.kappa_peak=0.1:0.2"], "KEY=FROM:TO:COUNT"),
        (&["--vary", "medium.kappa_peak=x"], "no finite number"),
        (&["--vary", "medium.kappa_peak=0:1:3:log"], "not above 0"),
        (&["--vary", "rig.view_step_deg=5,10"], "no point depends on"),
        (
            &["--vary", "medium.kappa_peak=0.1:0.2", "--design", "sobol"],
            "--points N",
        ),
        (
            &["--vary", "medium.kappa_peak=0.1,0.2", "--design", "hexagon"],
            "grid, lhs or sobol",
        ),
        (
            &["--vary", "medium.kappa_peak=0.1,0.2", "--points", "3"],
            "without --points",
        ),
        (&["--vary", "seed=1", "--vary", "seed=2"], "every key once"),
        (&["--vary", "seed=1", "--measured", "no-such"], "no-such"),
    ] {
        let refused = sweep(folder.path(), arguments);
        let message = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert_eq!(refused.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains(words), "{arguments:?}: {message}");
    }
    assert!(!folder.path().join("sweep").exists());
}
