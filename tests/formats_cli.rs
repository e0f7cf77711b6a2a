//! `inspect`, `convert`, `weave` as typed, and goniometric files as samples.

mod command;

use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::Value;
use specval::colour::Convention;
use specval::sample::Sample;

fn golden(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/formats")
        .join(name)
        .display()
        .to_string()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn json(folder: &Path, arguments: &[&str]) -> Value {
    let output = command::specval(folder, &[arguments, &["--json"]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn refusal(folder: &Path, arguments: &[&str]) -> String {
    let output = command::specval(folder, arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", stderr(&output));
    assert!(output.stdout.is_empty() && !stderr(&output).contains("panicked"));
    stderr(&output)
}

#[test]
fn inspect_says_what_a_file_holds() {
    let folder = tempfile::tempdir().unwrap();
    let found = json(folder.path(), &["inspect", &golden("libbsdf_iso_spectral7.ddr")]);
    assert_eq!(found["format"], "ddr");
    assert_eq!(found["provenance"]["source"], "Measured");
    let part = &found["components"][0];
    assert_eq!(part["quantity"], "brightness_factor");
    assert_eq!(part["scatter"], "reflection");
    assert_eq!(
        part["wavelength_nm"],
        serde_json::json!([400.0, 450.0, 500.0, 550.0, 600.0, 650.0, 700.0])
    );
    assert_eq!(part["axes"][0]["nodes_deg"], serde_json::json!([0.0, 20.0, 40.0, 60.0]));
    let lambert = json(folder.path(), &["inspect", &golden("lbgen_lambert_mono.ddr")]);
    for row in lambert["components"][0]["reflectance"].as_array().unwrap() {
        assert!((row["values"][0].as_f64().unwrap() - 1.0).abs() < 1e-6, "{row}");
    }
    let text = command::specval(folder.path(), &["inspect", &golden("spec_rgb.sdr")]);
    let text = String::from_utf8(text.stdout).unwrap();
    assert!(text.contains("fraction of the flux") && text.contains("45"), "{text}");
}

#[test]
fn convert_writes_whole_files_and_replaces_none() {
    let folder = tempfile::tempdir().unwrap();
    let source = golden("dir_iso_rgb.ddr");
    let done = json(folder.path(), &["convert", &source, "out.ssdd"]);
    assert_eq!(done["format"], "ssdd");
    assert!(refusal(folder.path(), &["convert", &source, "out.ssdd"]).contains("--force"));
    json(
        folder.path(),
        &["convert", &source, "out.ssdd", "--to", "astm", "--force"],
    );
    assert_eq!(json(folder.path(), &["inspect", "out.ssdd"])["format"], "astm");
    assert!(refusal(folder.path(), &["convert", "out.ssdd", "out.ssdd", "--force"]).contains("input"));
    json(
        folder.path(),
        &["convert", &source, "out.ssdd", "--to", "ssdd-binary", "--force"],
    );
    let bytes = fs::read(folder.path().join("out.ssdd")).unwrap();
    assert!(bytes.windows(12).any(|window| window == b"DATA binary\n"));
    assert_eq!(json(folder.path(), &["inspect", "out.ssdd"])["format"], "ssdd");
    assert!(refusal(folder.path(), &["convert", &source, "out.dat"]).contains("--to"));
    assert!(refusal(folder.path(), &["convert", &source, "out.zmx", "--to", "zemax"]).contains("not written"));
    assert!(refusal(folder.path(), &["convert", &source, "out.sdr"]).contains("specular"));
    assert!(refusal(folder.path(), &["convert", &source, "out.ddt"]).contains("ddr"));
    assert!(refusal(folder.path(), &["convert", "missing.ddr", "new.ssdd"]).contains("missing.ddr"));
    // Nothing but what was asked for.
    let names: Vec<_> = fs::read_dir(folder.path())
        .unwrap()
        .map(|e| e.unwrap().file_name())
        .collect();
    assert_eq!(names, ["out.ssdd"]);
}

/// What a format cannot hold is recorded, not dropped in silence.
#[test]
fn standard_errors_left_out_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let text = "theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,beta,beta_se\n0,0,0,0,0.4,0.03\n0,0,90,0,0.6,0.04\n0,0,90,180,0.6,0.04\n";
    fs::write(folder.path().join("in.csv"), text).unwrap();
    for (out, told) in [("out.csv", 0), ("out.ssdd", 1), ("out.xml", 1)] {
        let done = json(folder.path(), &["convert", "in.csv", out]);
        let notices = done["notices"].as_array().unwrap().iter();
        let found = notices.filter(|notice| notice.as_str().unwrap().contains("standard errors"));
        assert_eq!(found.count(), told, "{done}");
        let output = command::specval(folder.path(), &["convert", "in.csv", out, "--force"]);
        assert_eq!(stderr(&output).contains("standard errors"), told == 1);
    }
}

#[test]
fn weave_prints_the_drawdown() {
    let folder = tempfile::tempdir().unwrap();
    let found = json(folder.path(), &["weave", &golden("twill22.wif")]);
    assert_eq!(found["drawdown"][1], ".XX..XX.");
    assert_eq!(found["repeat"], serde_json::json!([4, 4]));
    let text = command::specval(folder.path(), &["weave", &golden("twill22.wif")]);
    assert!(String::from_utf8(text.stdout).unwrap().contains("X..XX..X\n"));
    assert!(refusal(folder.path(), &["weave", &golden("spec_bw.sdt")]).contains("weave draft"));
}

/// β = π f at nodes as libbsdf read them; interpolated elsewhere, and said so.
#[test]
fn goniometric_files_are_samples() {
    let sample = Sample::load(&golden("libbsdf_iso_spectral7.ddr")).unwrap();
    let beta = sample.spectrum(20.0, 20.0).unwrap().unwrap();
    assert!((beta.values()[0] / std::f64::consts::PI - 0.376869).abs() < 1e-6);
    let reading = |theta_i, theta_v| sample.reading(theta_i, theta_v, &Convention::default()).unwrap();
    assert!(!reading(20.0, 20.0).unwrap().interpolated);
    assert!(reading(30.0, 20.0).unwrap().interpolated);
    assert_eq!(reading(70.0, 20.0), None);
    assert!(sample.geometries().any(|g| g == (40.0, -30.0)));
    let rgb = Sample::load(&golden("dir_iso_rgb.ddr")).unwrap();
    let reading = rgb.reading(40.0, 40.0, &Convention::default()).unwrap().unwrap();
    for (beta, f) in reading.beta.iter().zip([0.344465, 0.172233, 0.0861163]) {
        assert!((beta / std::f64::consts::PI - f).abs() < 1e-6);
    }
    let xyz = Sample::load(&golden("dir_specular_bilateral_xyz.ssdd")).unwrap();
    let y = xyz.reading(20.0, 20.0, &Convention::default()).unwrap().unwrap().beta[3];
    assert!((y / std::f64::consts::PI - 0.19406).abs() < 1e-6);
    let refused = Sample::load(&golden("dir_iso_bw.ddr")).unwrap_err().to_string();
    assert!(refused.contains("one channel"), "{refused}");
    assert!(
        Sample::load(&golden("dir_btdf_sigmat_bw.ddt"))
            .unwrap_err()
            .to_string()
            .contains("reflection")
    );
}
