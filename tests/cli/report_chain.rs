//! The whole chain as a user runs it: report, trace, measure, validate, and what bad input gets.

use serde_json::Value;
use specval::run::YarnArtefact;
use specval::transport::Fraction;
use std::fs;
use std::path::Path;

use crate::command::specval;
use crate::runs::{printed, refusal};

/// A run that refuses its input: exit code 2, a message with every one of `words`, no panic, nothing left behind.
fn refuse(study: &str, arguments: &[&str], words: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("study.toml"), study).unwrap();
    let message = refusal(folder.path(), arguments);
    for word in words {
        assert!(message.contains(word), "{message:?} does not say {word:?}");
    }
    let left: Vec<_> = fs::read_dir(folder.path())
        .unwrap()
        .map(|e| e.unwrap().file_name())
        .collect();
    assert_eq!(left, ["study.toml"], "left behind");
}

/// A study that runs in a second: 5 wavelengths, few cells, few paths.
const SMALL: &str = "
[spectrum]
wavelengths_nm = [450, 500, 550, 600, 650]
[trace]
batches = 4
paths_bssrdf = 40
paths_direct = 2000
exit_azimuth_cells = 12
exit_theta_cells = 4
exit_phi_cells = 8
bssrdf_exit_theta_cells = 2
bssrdf_exit_phi_cells = 4
tilts = 4
[rig]
pixels_per_side = 8
[sweep]
kappa_peak = [0.003]
volume_fraction = []
particle_diameter_nm = []
particle_index = []
";

fn rows(path: &Path) -> Vec<csv::StringRecord> {
    csv::Reader::from_path(path)
        .unwrap()
        .records()
        .map(Result::unwrap)
        .collect()
}

#[test]
fn report_is_whole_and_the_same_bytes_on_any_number_of_threads() {
    for estimator in ["shared", "independent"] {
        let study = SMALL.replace("[trace]", &format!("[trace]\nestimator = \"{estimator}\""));
        let reports = ["1", "3"].map(|threads| report_files(&study, estimator, threads));
        assert!(reports[0] == reports[1], "{estimator}");
    }
}

/// The names and bytes of a report's files, whole and sound.
fn report_files(study: &str, estimator: &str, threads: &str) -> Vec<(String, Vec<u8>)> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("study.toml"), study).unwrap();
    let text = printed(
        folder.path(),
        &["report", "study.toml", "--out", "out", "--threads", threads, "--quiet"],
    );
    assert!(text.contains("published") && text.contains("residual") && text.contains("fit of a measurement"));
    let mut files: Vec<(String, Vec<u8>)> = fs::read_dir(folder.path().join("out"))
        .unwrap()
        .map(|e| e.unwrap())
        .map(|e| (e.file_name().into_string().unwrap(), fs::read(e.path()).unwrap()))
        .collect();
    files.sort();
    let names: Vec<&str> = files.iter().map(|f| f.0.as_str()).collect();
    for name in ["table1.csv", "table1.md", "curves.csv", "energy.csv", "report.json"] {
        assert!(names.contains(&name), "{name}");
    }
    for k in 1..=6 {
        assert!(names.contains(&format!("graph{k}.svg").as_str()) && names.contains(&format!("graph{k}.png").as_str()));
    }
    let energy = rows(&folder.path().join("out/energy.csv"));
    assert_eq!(energy.len(), 5 * 144);
    for wavelength in energy.chunks(144) {
        let column = |k: usize| -> Vec<f64> { wavelength.iter().map(|row| row[k].parse().unwrap()).collect() };
        let (residuals, mis_net) = (column(13), column(15));
        assert!(residuals.iter().all(|r| r.abs() <= 1e-12), "{residuals:?}");
        if estimator == "independent" {
            assert!(mis_net.iter().all(|s| *s == 0.0), "{mis_net:?}");
            continue;
        }
        // What the balance takes is 0 in the mean, here over the 36 directions that are traced, of which the
        // others are copies: |t| with 35 degrees of freedom above 4.1 at one of 5 wavelengths, false alarms 0.1 %.
        let mean = mis_net.iter().sum::<f64>() / 144.0;
        let variance = mis_net.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / 144.0 * 36.0 / 35.0;
        assert!(
            variance > 0.0 && mean.abs() <= 4.1 * (variance / 36.0).sqrt(),
            "{mean} of {mis_net:?}"
        );
    }
    assert_eq!(rows(&folder.path().join("out/curves.csv")).len(), 3 * 27 * 3 * 4);
    let document: Value = serde_json::from_slice(&fs::read(folder.path().join("out/report.json")).unwrap()).unwrap();
    assert_eq!(document["provenance"]["seed"], 1);
    // How many threads worked on it is not told.
    let command = document["provenance"]["command"].as_array().unwrap();
    assert_eq!(command[1..], ["report", "study.toml", "--out", "out"]);
    files
}

/// All bytes of a folder's files, by name.
fn files_of(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<(String, Vec<u8>)> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap())
        .map(|entry| {
            (
                entry.file_name().into_string().unwrap(),
                fs::read(entry.path()).unwrap(),
            )
        })
        .collect();
    files.sort();
    files
}

#[test]
fn a_result_is_drawn_again_to_the_same_bytes() {
    let unlit = format!("{SMALL}[medium]\nvolume_fraction = 0\n");
    for study in [SMALL, &unlit] {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("study.toml"), study).unwrap();
        // Few paths leave errors unknown and withhold verdicts: null in the file.
        for paths in ["8", "2000"] {
            let traced = ["report", "study.toml", "--paths", paths, "--out", "traced", "--force"];
            printed(folder.path(), &traced);
            let traced = files_of(&folder.path().join("traced"));
            printed(
                folder.path(),
                &["report", "--from", "traced/result.json", "--out", "drawn", "--force"],
            );
            assert!(traced == files_of(&folder.path().join("drawn")), "{paths}");
            // Also into its own folder, where only files that it wrote stand.
            printed(folder.path(), &["report", "--from", "traced", "--out", "traced"]);
            assert!(traced == files_of(&folder.path().join("traced")), "{paths}");
        }
    }
}

#[test]
fn file_that_is_no_result_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let of_version = |version: u32| format!("{{\"format\":\"specval result\",\"format_version\":{version}}}");
    for (content, arguments, word) in [
        ("{}", &[][..], "another document"),
        ("wavelength_nm,a\n", &[], "found"),
        (&of_version(1), &[], "version 1; read it with the program that wrote it"),
        (&of_version(2), &[], "missing field"),
        (&of_version(2), &["--seed", "3"], "leave --seed out"),
        (&of_version(2), &["--quick"], "cannot be used"),
    ] {
        fs::write(folder.path().join("result.json"), content).unwrap();
        let output = specval(
            folder.path(),
            &[&["report", "--from", "result.json"], arguments].concat(),
        );
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(word), "{message}");
        assert!(!folder.path().join("report").exists(), "left behind");
    }
}

/// The quick report of the built-in study: Table 1 within four of its own standard errors of the committed reference
/// report (false alarms 0.01 %), the reference inside the ranges the preprint's cotton asks for, in seconds.
#[test]
fn quick_report_agrees_with_the_reference_report() {
    let folder = tempfile::tempdir().unwrap();
    let start = std::time::Instant::now();
    printed(folder.path(), &["report", "--quick", "--out", "out", "--quiet"]);
    let seconds = start.elapsed().as_secs_f64();
    // 15 s on two idle cores; the tests beside this one may have a core of them.
    assert!(seconds < 45.0, "{seconds} s");
    let model = |path: &Path| -> [f64; 4] {
        let row = rows(path).into_iter().find(|r| &r[0] == "model").unwrap();
        std::array::from_fn(|i| row[i + 1].parse().unwrap())
    };
    let quick = model(&folder.path().join("out/table1.csv"));
    let reference = model(Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/reports/preprint/table1.csv"
    )));
    for i in [0, 2] {
        let z = (quick[i] - reference[i]) / quick[i + 1].hypot(reference[i + 1]);
        assert!(z.abs() < 4.0, "{quick:?} {reference:?}");
    }
    assert!(
        (0.06..=0.10).contains(&reference[0]) && (0.006..=0.016).contains(&reference[2]),
        "{reference:?}"
    );
}

/// A simulated measurement is a sample like any other: against itself the model's coefficient is 1 within its errors.
#[test]
fn measured_curves_are_a_sample() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("study.toml"), SMALL).unwrap();
    let text = printed(
        folder.path(),
        &["measure", "study.toml", "--out", "cloth.csv", "--seed", "2", "--quiet"],
    );
    assert!(text.contains("405 brightness factors"), "{text}");
    let report: Value = serde_json::from_str(&printed(
        folder.path(),
        &[
            "report",
            "study.toml",
            "--measured",
            "cloth.csv",
            "--out",
            "out",
            "--json",
            "--quiet",
        ],
    ))
    .unwrap();
    let model = &report["normalisation"]["model"];
    let (value, se) = (model["value"].as_f64().unwrap(), model["se"].as_f64().unwrap());
    // One number, limit 4.5 for 4 batches on either side: false alarms about 1 %.
    assert!((value - 1.0).abs() < 4.5 * se && se < 0.2, "{value} ± {se}");
}

#[test]
fn trace_keeps_what_it_says() {
    const BINS: usize = specval::yarn::LengthBins::DEFAULT;
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("study.toml"), SMALL).unwrap();
    let text = printed(
        folder.path(),
        &["trace", "study.toml", "--out", "yarn.trace", "--quiet"],
    );
    assert!(text.contains("scattered") && text.contains("residual"));
    let yarn = YarnArtefact::read(&folder.path().join("yarn.trace")).unwrap();
    assert_eq!((yarn.batches, yarn.layout.wavelengths()), (4, 5));
    assert_eq!(yarn.energy.len(), 5 * 144);
    // Tilt, azimuth to 180°, exit cell, wavelength; direction, azimuth, z with overflow, exit cell, wavelength.
    assert_eq!(yarn.tables.direct.mean.len(), 4 * 6 * 32 * 5);
    assert_eq!(yarn.layout.bssrdf_shape, [36, 20, 10, 8, 5]);
    // The bins of path length add to f*, in single precision.
    for (cell, bins) in yarn.tables.by_length.mean.chunks(BINS * 5).enumerate() {
        for (wavelength, f) in yarn.tables.direct.mean[cell * 5..][..5].iter().enumerate() {
            let sum: f32 = bins.iter().skip(wavelength).step_by(5).sum();
            approx::assert_relative_eq!(f64::from(sum), *f, max_relative = 1e-5);
        }
    }
    // Of all incident light as much leaves by path length as the ledger says.
    let row = yarn.energy.iter().find(|row| row.wavelength_nm == 600.0).unwrap();
    let first = &yarn.tables.energy_by_length.mean[3 * BINS * 4..][..BINS * 4];
    for (part, expected) in [(0, row[Fraction::Ballistic].value), (1, row[Fraction::Scattered].value)] {
        let sum: f64 = first.iter().skip(part).step_by(4).sum();
        approx::assert_relative_eq!(sum, expected, max_relative = 1e-12);
    }
    // What is written again is the same file.
    yarn.write(&folder.path().join("again.trace")).unwrap();
    let [first, again] = ["yarn.trace", "again.trace"].map(|name| fs::read(folder.path().join(name)).unwrap());
    assert!(first == again && first.starts_with(b"specval-artefact 1\n"));
}

#[test]
fn validate_prints_its_checks() {
    let folder = tempfile::tempdir().unwrap();
    let checks: Value =
        serde_json::from_str(&printed(folder.path(), &["validate", "--paths", "10000", "--json"])).unwrap();
    let checks = checks.as_array().unwrap();
    assert!(checks.len() > 200);
    for field in ["problem", "quantity", "value", "se", "reference", "z"] {
        assert!(!checks[0][field].is_null(), "{field}");
    }
    refuse("", &["validate", "--paths", "10"], &["paths", "10"]);
}

#[test]
fn bad_studies_are_refused_before_anything_is_written() {
    let run = ["report", "study.toml", "--out", "out"];
    refuse(
        "[yarn]\nradius_mm = -0.1",
        &run,
        &["study.toml", "radius_mm", "-0.1", "mm"],
    );
    refuse("[medium]\nvolume_fraction = 0.74", &run, &["volume_fraction", "0.74"]);
    refuse("[medium]\nkappa_peak = -0.001", &run, &["kappa_peak", "-0.001"]);
    refuse(
        "[medium]\nkapa_peak = 0.001",
        &run,
        &["kapa_peak", "did you mean", "kappa_peak"],
    );
    refuse("[spectrum]\nwavelengths_nm = [500, 400]", &run, &["wavelengths_nm"]);
    refuse("[spectrum]\nwavelength_max_nm = 900", &run, &["nm"]);
    refuse("[cloth]\nspacing_diameters = 1.7", &run, &["spacing"]);
    refuse(
        "[cloth]\ncentre_line = \"sinusoid\"\nsinusoid_amplitude_mm = 0.05",
        &run,
        &["overlap"],
    );
    refuse("[medium]\ndye = \"no-such-dye\"", &run, &["no-such-dye"]);
    refuse("[measured]\nsample = \"no-such-sample\"", &run, &["no-such-sample"]);
    refuse("", &["report", "study.toml", "--out", "study.toml"], &["study.toml"]);
    refuse(
        "",
        &["report", "missing.toml", "--out", "out"],
        &["missing.toml", "init"],
    );
    refuse(
        "",
        &["trace", "study.toml", "--out", "no/such/folder/file"],
        &["no/such/folder"],
    );
}

#[test]
fn bad_samples_are_refused_by_row_and_column() {
    for (csv, words) in [
        (
            "theta_i_deg,theta_v_deg,beta_r,beta_g,beta_b\n0,0,nan,0.1,0.1\n",
            ["line 2", "beta_r"],
        ),
        (
            "theta_i_deg,theta_v_deg,beta_r,beta_g\n0,0,0.1,0.1\n",
            ["beta_b", "bad.csv"],
        ),
        (
            "theta_i_deg,theta_v_deg,wavelength_nm,beta\n0,0,500,-0.1\n",
            ["line 2", "beta"],
        ),
        ("", ["bad.csv", "error"]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("bad.csv"), csv).unwrap();
        let output = specval(folder.path(), &["report", "--measured", "bad.csv", "--out", "out"]);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{csv}: {message}");
        for word in words {
            assert!(message.contains(word), "{message:?} does not say {word:?}");
        }
        assert!(!folder.path().join("out").exists());
    }
}

/// A sample of 45° alone is compared where it was measured; angles typed in `[rig]` win, and what they leave out is
/// named.
#[test]
fn every_reading_of_a_sample_without_the_normal_is_accounted_for() {
    let folder = tempfile::tempdir().unwrap();
    let header = "theta_i_deg,theta_v_deg,beta_r,beta_g,beta_b\n";
    let views = [-30, -15, 0, 15, 30, 60];
    let rows: String = views.iter().map(|v| format!("45.01,{v}.02,0.3,0.02,0.04\n")).collect();
    fs::write(
        folder.path().join("s45.csv"),
        format!("{header}{rows}").replace("-30.02", "-29.98"),
    )
    .unwrap();
    let report = |study: &str, out: &str| -> Value {
        fs::write(folder.path().join("study.toml"), study).unwrap();
        let words = [
            "report",
            "study.toml",
            "--measured",
            "s45.csv",
            "--out",
            out,
            "--json",
            "--quiet",
        ];
        serde_json::from_str(&printed(folder.path(), &words)).unwrap()
    };
    let own = report(SMALL, "own");
    let count = &own["readings"];
    assert_eq!(
        (&count["total"], &count["used"], &count["moved"]),
        (&6.into(), &6.into(), &6.into())
    );
    assert_eq!(
        count["normalised_at"],
        serde_json::json!({ "theta_i_deg": 45.0, "theta_v_deg": 0.0 })
    );
    let rmse = own["rmse"].as_array().unwrap();
    assert!(!rmse.is_empty() && rmse.iter().all(|row| row["theta_i_deg"] == 45.0 && row["views"] == 6));
    assert!(
        own["provenance"]["fallbacks"]
            .to_string()
            .contains("incidence 45 and view 0")
    );
    let graph = fs::read_to_string(folder.path().join("own/graph1.svg")).unwrap();
    assert!(graph.contains("Light at 45°") && graph.contains("measured"));
    assert!(!folder.path().join("own/graph3.svg").exists());
    // No error is stated, so none is written.
    let measured = rows_of(&folder.path().join("own/curves.csv"), "measured");
    assert!(measured.len() == 24 && measured.iter().all(|row| row[5].is_empty()));

    let typed = report(&SMALL.replace("[rig]", "[rig]\nincidences_deg = [0, 30]"), "typed");
    let count = &typed["readings"];
    assert_eq!((&count["used"], &count["outside_rig"]), (&0.into(), &6.into()));
    assert_eq!(count["examples_outside_rig"][0]["theta_i_deg"], 45.0);
    let graph = fs::read_to_string(folder.path().join("typed/graph1.svg")).unwrap();
    assert!(graph.contains("the sample has no reading at this incidence"));
}

fn rows_of(path: &Path, source: &str) -> Vec<csv::StringRecord> {
    rows(path).into_iter().filter(|row| &row[2] == source).collect()
}

/// Two samples and one without readings: the first normalises the curves, each has its own errors, and none changes the
/// others.
#[test]
fn samples_are_compared_side_by_side() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("study.toml"), SMALL).unwrap();
    fs::write(
        folder.path().join("empty.csv"),
        "theta_i_deg,theta_v_deg,beta_r,beta_g,beta_b\n77,3,0.1,0.1,0.1\n",
    )
    .unwrap();
    let first = ["report", "study.toml", "--measured", "merl-red-fabric"];
    let others = ["--measured", "merl-red-fabric2", "--measured", "empty.csv"];
    printed(folder.path(), &[&first[..], &["--out", "one"]].concat());
    let summary = printed(folder.path(), &[&first[..], &others[..], &["--out", "all"]].concat());
    for words in [
        "model and classical against measured:",
        "model and classical against measured-2:",
        "fallback: sample empty has no reading at any geometry",
    ] {
        assert!(summary.contains(words), "{words}: {summary}");
    }
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    let (one, all) = (read("one/curves.csv"), read("all/curves.csv"));
    let without: Vec<&str> = all.lines().filter(|line| !line.contains(",measured-2,")).collect();
    assert_eq!(without, one.lines().collect::<Vec<_>>());
    assert!(all.lines().count() > one.lines().count());
    let document: Value = serde_json::from_str(&read("all/report.json")).unwrap();
    assert_eq!(document["table1"][2]["row"], "measured-2");
    assert_eq!(document["more_samples"].as_array().unwrap().len(), 2);
    let alone: Value = serde_json::from_str(&read("one/report.json")).unwrap();
    assert_eq!(document["normalisation"], alone["normalisation"]);
    let other = &document["normalisation_to_others"]["measured-2"]["model"]["value"];
    assert!(other.is_f64() && *other != alone["normalisation"]["model"]["value"]);
    assert!(
        read("all/graph1.svg").contains("merl-red-fabric2"),
        "the legend names the second sample"
    );
    printed(folder.path(), &["report", "--from", "all", "--out", "again"]);
    assert_eq!(read("again/graph4.svg"), read("all/graph4.svg"));
    assert_eq!(read("again/report.json"), read("all/report.json"));
}
