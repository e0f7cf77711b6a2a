//! `specval check --sample`: a measurement by itself, good and spoiled.

use crate::command::specval;
use serde_json::Value;
use std::fs;
use std::path::Path;

const VIEWS: [f64; 7] = [-60.0, -40.0, -20.0, 0.0, 20.0, 40.0, 60.0];

/// β = 0.5 − (θ_i² + θ_v²)/20 000: reciprocal, smooth, with an error of 1 %.
fn table(beta: impl Fn(f64, f64) -> f64, errors: bool) -> String {
    let mut text = String::from("theta_i_deg,theta_v_deg,wavelength_nm,beta");
    text += if errors { ",beta_se\n" } else { "\n" };
    for theta_i in [0.0, 20.0, 40.0] {
        for theta_v in VIEWS {
            for nm in [450, 650] {
                let value = beta(theta_i, theta_v);
                text += &format!("{theta_i},{theta_v},{nm},{value}");
                text += &if errors {
                    format!(",{}\n", 0.01 * value)
                } else {
                    "\n".into()
                };
            }
        }
    }
    text
}

fn smooth(i: f64, v: f64) -> f64 {
    0.5 - (i * i + v * v) / 20_000.0
}

/// Exit code and (gate, verdict) of all.
fn verdicts(folder: &Path, text: &str) -> (i32, Vec<(String, String)>) {
    fs::write(folder.join("sample.csv"), text).unwrap();
    let output = specval(folder, &["check", "--sample", "sample.csv", "--json"]);
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    let word = |value: &Value| value.as_str().unwrap().to_owned();
    let gates = document["gates"].as_array().unwrap().iter();
    let gates = gates
        .map(|gate| (word(&gate["name"]), word(&gate["verdict"])))
        .collect();
    (output.status.code().unwrap(), gates)
}

#[test]
fn each_spoiled_measurement_breaks_its_own_law() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let (code, gates) = verdicts(folder, &table(smooth, true));
    assert_eq!(code, 0, "{gates:?}");
    assert_eq!(gates.len(), 7);
    let good = table(smooth, true);
    let first = good.lines().nth(1).unwrap();
    let cases = [
        ("sample-readings", "broken", good.replace(",0.5,", ",-0.5,")),
        (
            "sample-readings",
            "broken",
            format!("{good}{}\n", first.replacen("0.32", "0.33", 1)),
        ),
        ("sample-uncertainty", "undecided", table(smooth, false)),
        (
            "sample-reciprocity",
            "broken",
            table(|i, v| smooth(i, v) * (1.0 + 0.01 * i), true),
        ),
        ("sample-energy", "undecided", table(|i, v| 3.0 * smooth(i, v), true)),
        ("sample-units", "undecided", table(|i, v| 100.0 * smooth(i, v), true)),
        (
            "sample-jumps",
            "undecided",
            table(|i, v| if v == 20.0 { 1.5 } else { 1.0 } * smooth(i, v), true),
        ),
        (
            "sample-coverage",
            "undecided",
            good.lines()
                .filter(|line| !line.starts_with("0,0,"))
                .map(|line| format!("{line}\n"))
                .collect(),
        ),
    ];
    for (name, verdict, text) in cases {
        let (code, gates) = verdicts(folder, &text);
        let found = gates.iter().find(|(gate, _)| gate == name).unwrap();
        assert_eq!(found.1, verdict, "{name}: {gates:?}");
        // The outlier breaks reciprocity too; a plausibility alone never ends in 1.
        let breaks = gates.iter().any(|(_, verdict)| verdict == "broken");
        assert_eq!(
            breaks,
            verdict == "broken" || name == "sample-jumps",
            "{name}: {gates:?}"
        );
        assert_eq!(code, if breaks { 1 } else { 2 }, "{name}: {gates:?}");
    }
    let missing = specval(folder, &["check", "--sample", "none"]);
    assert_eq!(missing.status.code(), Some(2));
}
