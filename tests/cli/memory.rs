//! The memory that a run really takes, against the estimate that decides whether it begins. Linux alone tells the peak
//! of a process while it runs.
#![cfg(target_os = "linux")]

use specval::run::{Stage, memory_bytes};
use specval::study::Study;
use std::fs;
use std::process::{Command, Stdio};
use std::time::Duration;

const THREADS: usize = 2;

/// Largest resident memory of a run, bytes, and its exit code.
fn peak(study: &str, arguments: &[&str]) -> f64 {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("study.toml"), study).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_specval"));
    command
        .current_dir(folder.path())
        .args(arguments)
        .args(["--quiet", "--threads", &THREADS.to_string()]);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let status = format!("/proc/{}/status", child.id());
    let mut largest = 0.0_f64;
    let code = loop {
        if let Some(code) = child.try_wait().unwrap() {
            break code;
        }
        let text = fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find(|line| line.starts_with("VmHWM:"));
        let kilobytes = line.and_then(|line| line.split_whitespace().nth(1)?.parse::<f64>().ok());
        largest = largest.max(1024.0 * kilobytes.unwrap_or(0.0));
        std::thread::sleep(Duration::from_millis(2));
    };
    assert!(code.success(), "{study}: {code}");
    largest
}

/// Within a factor 1.5, over grids of f*, geometries, wavelengths, camera rays, batches, yarns and methods. Tables that
/// few paths leave empty in part take less than is estimated, so the BSSRDF has more paths.
#[test]
fn estimates_are_within_a_factor_of_the_peak() {
    const REPORT: [&str; 6] = ["report", "study.toml", "--paths", "64", "--out", "out"];
    const MEASURE: [&str; 6] = ["measure", "study.toml", "--paths", "64", "--out", "curves.csv"];
    let bssrdf = ["measure", "study.toml", "--paths", "40000", "--out", "curves.csv"];
    let trace = ["trace", "study.toml", "--paths", "64", "--out", "yarn.trace"];
    let studies = [
        ("[rig]\npixels_per_side = 8", Stage::Views, &REPORT),
        (
            "[trace]\nexit_theta_cells = 60\n[rig]\npixels_per_side = 8",
            Stage::Views,
            &REPORT,
        ),
        (
            "[trace]\ntilts = 40\n[rig]\npixels_per_side = 8",
            Stage::Views,
            &MEASURE,
        ),
        (
            "[trace]\nexit_phi_cells = 96\n[rig]\npixels_per_side = 8",
            Stage::Views,
            &MEASURE,
        ),
        (
            "[spectrum]\nwavelength_step_nm = 2\n[rig]\npixels_per_side = 8",
            Stage::Views,
            &MEASURE,
        ),
        (
            "[rig]\nincidences_deg = [0, 10, 20, 30, 40, 50, 60, 70]\nview_step_deg = 1\npixels_per_side = 12",
            Stage::Views,
            &MEASURE,
        ),
        (
            "[rig]\npixels_per_side = 700\nincidences_deg = [0]\nview_min_deg = 0\nview_max_deg = 0",
            Stage::Views,
            &MEASURE,
        ),
        (
            "[weft]\nkappa_peak = 0\n[trace]\nexit_theta_cells = 30\n[rig]\npixels_per_side = 8",
            Stage::Views,
            &MEASURE,
        ),
        (
            "[cloth]\nbounces = \"all\"\n[trace]\nexit_theta_cells = 30\n[rig]\npixels_per_side = 8",
            Stage::Views,
            &MEASURE,
        ),
        (
            "[cloth]\nmethod = \"volumetric\"\n[rig]\npixels_per_side = 8",
            Stage::Views,
            &REPORT,
        ),
        (
            "[trace]\nshade_with = \"bssrdf\"\n[rig]\npixels_per_side = 8",
            Stage::Views,
            &bssrdf,
        ),
        ("", Stage::Yarn, &trace),
    ];
    let mut beyond = Vec::new();
    for (text, stage, arguments) in studies {
        let estimate = memory_bytes(&Study::from_toml(text, "study.toml").unwrap(), stage, THREADS);
        let peak = peak(text, arguments);
        let ratio = estimate / peak;
        println!(
            "{ratio:.2}: {:.0} MB estimated, {:.0} MB taken: {text}",
            1e-6 * estimate,
            1e-6 * peak
        );
        if !(1.0 / 1.5..1.5).contains(&ratio) {
            beyond.push(text);
        }
    }
    assert!(beyond.is_empty(), "{beyond:#?}");
}
