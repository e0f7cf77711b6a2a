//! `inspect`, `convert`, `weave` as typed, and goniometric files as samples.

use std::fs;
use std::path::Path;

use crate::runs::{json, refusal, stderr};
use specval::colour::Convention;
use specval::sample::Sample;

fn golden(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/formats")
        .join(name)
        .display()
        .to_string()
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
    let text = crate::command::specval(folder.path(), &["inspect", &golden("spec_rgb.sdr")]);
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
        let output = crate::command::specval(folder.path(), &["convert", "in.csv", out, "--force"]);
        assert_eq!(stderr(&output).contains("standard errors"), told == 1);
    }
}

#[test]
fn weave_prints_the_drawdown() {
    let folder = tempfile::tempdir().unwrap();
    let found = json(folder.path(), &["weave", &golden("twill22.wif")]);
    assert_eq!(found["drawdown"][1], ".XX..XX.");
    assert_eq!(found["repeat"], serde_json::json!([4, 4]));
    let text = crate::command::specval(folder.path(), &["weave", &golden("twill22.wif")]);
    assert!(String::from_utf8(text.stdout).unwrap().contains("X..XX..X\n"));
    assert!(refusal(folder.path(), &["weave", &golden("spec_bw.sdt")]).contains("weave draft"));
    let named = json(folder.path(), &["weave", "twill-2-1"]);
    assert_eq!(named["drawdown"], serde_json::json!([".XX", "X.X", "XX."]));
    fs::copy(golden("twill22.wif"), folder.path().join("mine")).unwrap();
    assert_eq!(json(folder.path(), &["weave", "mine"])["repeat"], found["repeat"]);
    assert!(refusal(folder.path(), &["weave", "satin5"]).contains("did you mean 'satin-5'?"));
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

/// A file in a folder, its path as text.
fn written(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    fs::write(&path, text).unwrap();
    path.display().to_string()
}

#[test]
fn colour_names_what_it_used_and_what_it_doubts() {
    let folder = tempfile::tempdir().unwrap();
    let white = written(folder.path(), "white.csv", "wavelength_nm,white\n450,1\n550,1\n650,1\n");
    let found = &json(folder.path(), &["colour", &white])[0];
    let rgb = |i: usize| found["linear_rgb"][i].as_f64().unwrap();
    assert!(
        (rgb(2) / rgb(0) - 1.0).abs() < 1e-3 && (rgb(1) / rgb(0) - 1.0).abs() < 1e-3,
        "{found}"
    );
    assert_eq!(
        (&found["observer"], &found["illuminant"]),
        (&"cie1931-2deg".into(), &"D65".into())
    );
    assert!(
        (found["white"]["X"].as_f64().unwrap() - 0.95047).abs() < 1e-5,
        "{found}"
    );
    assert!(
        found["method"].as_str().unwrap().contains("linear interpolation"),
        "{found}"
    );
    let doubt = found["notices"][0].as_str().unwrap();
    assert!(doubt.contains("doubtful") && doubt.contains("100 nm apart"), "{doubt}");
    assert!(stderr(&crate::command::specval(folder.path(), &["colour", &white])).contains("100 nm apart"));
    let infrared = written(folder.path(), "nir.csv", "wavelength_nm,a\n850,1\n860,1\n870,1\n");
    assert!(refusal(folder.path(), &["colour", &infrared]).contains("no colour"));
    let bands: Vec<String> = (390..=730).step_by(10).map(|nm| nm.to_string()).collect();
    let set = |value: &str| {
        let fields: String = bands.iter().map(|nm| format!(" {nm}_NM")).collect();
        let values = format!(" {value}").repeat(bands.len());
        format!(
            "CGATS.17\nILLUMINANT \"D50\"\nOBSERVER \"10\"\nBEGIN_DATA_FORMAT\nSAMPLE_ID{fields}\nEND_DATA_FORMAT\n\
             BEGIN_DATA\n1{values}\nEND_DATA\n"
        )
    };
    let stated = written(folder.path(), "d50.txt", &set("0.4"));
    let found = &json(folder.path(), &["colour", &stated])[0];
    assert_eq!(
        (&found["observer"], &found["illuminant"]),
        (&"cie1964-10deg".into(), &"D50".into())
    );
    let found = &json(folder.path(), &["colour", &stated, "--illuminant", "A"])[0];
    assert_eq!(found["illuminant"], "A");
    assert!(
        found["notices"]
            .to_string()
            .contains("states the illuminant 'D50', and A is used"),
        "{found}"
    );
    for (value, says) in [("40", "divide them by 100"), ("-0.4", "0 or more")] {
        let file = written(folder.path(), "odd.txt", &set(value));
        assert!(
            stderr(&crate::command::specval(folder.path(), &["colour", &file])).contains(says),
            "{value}"
        );
    }
}

#[test]
fn colour_reads_what_measure_writes() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = "theta_i_deg,theta_v_deg,wavelength_nm,beta,beta_se\n".to_owned();
    for (view, beta) in [(-30, 0.2), (0, 0.4)] {
        for nm in (390..=730).step_by(10) {
            text += &format!("0,{view},{nm},{beta},0.01\n");
        }
    }
    let curves = written(folder.path(), "curves.csv", &text);
    let found = json(folder.path(), &["colour", &curves]);
    let colours: Vec<(f64, f64)> = found
        .as_array()
        .unwrap()
        .iter()
        .map(|row| (row["theta_v_deg"].as_f64().unwrap(), row["Y"].as_f64().unwrap()))
        .collect();
    assert!(colours.len() == 2 && colours[0].0 == -30.0, "{colours:?}");
    assert!(
        (colours[0].1 - 0.2).abs() < 1e-12 && (colours[1].1 - 0.4).abs() < 1e-12,
        "{colours:?}"
    );
    // The same by incidence, in semicolons, with a column a wavelength and a decimal comma.
    let bands: String = (390..=730).step_by(10).map(|nm| format!(";{nm} nm")).collect();
    let wide = format!(
        "theta_i_deg;phi_i_deg;theta_o_deg;phi_o_deg{bands}\n0;0;0;0{}\n",
        ";0,4".repeat(35)
    );
    let wide = written(folder.path(), "wide.csv", &wide);
    let part = json(folder.path(), &["inspect", &wide])["components"][0].clone();
    assert_eq!(part["wavelength_nm"].as_array().map(Vec::len), Some(35), "{part}");
}

#[test]
fn a_measurement_in_the_infrared_needs_no_colour() {
    let folder = tempfile::tempdir().unwrap();
    let study = "[spectrum]\nwavelengths_nm = [850]\n[medium]\ndye = \"dye.csv\"\n[trace]\nbatches = 2\npaths_direct = \
                 600\npaths_bssrdf = 300\nparticles = 200\n[rig]\npixels_per_side = 4\n";
    written(folder.path(), "dye.csv", "wavelength_nm,value\n800,1\n900,0.5\n");
    let study = written(folder.path(), "nir.toml", study);
    let run = |arguments: &[&str]| crate::command::specval(folder.path(), arguments);
    for arguments in [
        &["measure", &study, "--out", "nir.csv", "--until", "rel 50%"][..],
        &["trace", &study, "--out", "nir.trace"],
        &["medium", &study],
    ] {
        let output = run(arguments);
        assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    }
    for arguments in [
        &["report", &study, "--out", "report"][..],
        &["measure", &study, "--out", "more.csv", "--until", "rel 50% ratios"],
    ] {
        let message = refusal(folder.path(), arguments);
        assert!(message.contains("0 of the wavelengths lie in 360..780 nm"), "{message}");
    }
}
