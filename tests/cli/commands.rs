//! The program as typed: results, exit codes and messages.

use crate::runs::stderr;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output, Stdio};

fn specval(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_specval"))
        .args(arguments)
        .output()
        .unwrap()
}

/// The document of a run that succeeds and says nothing on stderr.
fn json(arguments: &[&str]) -> Value {
    let output = specval(arguments);
    assert!(
        output.status.success() && output.stderr.is_empty(),
        "{}",
        stderr(&output)
    );
    serde_json::from_slice(&output.stdout).unwrap()
}

/// [`crate::runs::refusal`] of a run that needs no folder.
fn refusal(arguments: &[&str]) -> String {
    crate::runs::refusal(Path::new("."), arguments)
}

#[test]
fn mie_prints_the_published_sphere() {
    // Wiscombe's MIEV0 test case 14 in 60-digit arithmetic, tests/data/mie/mie_wiscombe.csv.
    let sphere = json(&[
        "mie", "--m-re", "1.5", "--m-im", "1", "--x", "1", "--angles", "0,180", "--json",
    ]);
    for (field, expected) in [
        ("q_ext", 2.33632098467261),
        ("q_sca", 0.663453761516246),
        ("q_back", 0.573002555238922),
        ("g", 0.192136395891886),
    ] {
        approx::assert_relative_eq!(sphere[field].as_f64().unwrap(), expected, max_relative = 1e-12);
    }
    let amplitude = |name: &str, angle: usize, part: usize| sphere[name][angle][part].as_f64().unwrap();
    assert_eq!(sphere["angles_deg"], serde_json::json!([0.0, 180.0]));
    // Optical theorem, and the symmetry forwards and backwards.
    approx::assert_relative_eq!(
        4.0 * amplitude("s1", 0, 0),
        sphere["q_ext"].as_f64().unwrap(),
        max_relative = 1e-12
    );
    for part in 0..2 {
        approx::assert_relative_eq!(amplitude("s1", 0, part), amplitude("s2", 0, part), max_relative = 1e-12);
        approx::assert_relative_eq!(
            amplitude("s1", 1, part),
            -amplitude("s2", 1, part),
            max_relative = 1e-12
        );
    }
}

#[test]
fn options_may_stand_before_or_after_the_subcommand() {
    let tail = ["mie", "--conducting", "--x", "0.5"];
    let before = json(
        &[
            &["--json", "--threads", "2", "--seed", "7", "--paths", "10", "--quiet"][..],
            &tail,
        ]
        .concat(),
    );
    let after = json(&[&tail[..], &["--json"]].concat());
    assert_eq!(before, after);
}

#[test]
fn bad_flags_name_themselves_and_what_was_expected() {
    for (arguments, expected) in [
        (
            &["mie", "--m-re", "-1.5", "--x", "1"][..],
            &["real part", "> 0", "-1.5"][..],
        ),
        (
            &["mie", "--m-re", "1.5", "--m-im", "-0.1", "--x", "1"],
            &["imaginary part", ">= 0", "-0.1"],
        ),
        (&["mie", "--m-re", "nan", "--x", "1"], &["real part", "NaN"]),
        (
            &["mie", "--m-re", "1.5", "--x", "1e9"],
            &["size parameter", "1e-6", "100000"],
        ),
        (
            &["mie", "--m-re", "1.5", "--x", "1", "--angles", "0,200"],
            &["--angles", "200", "degrees", "0 to 180"],
        ),
        (
            &["mie", "--m-re", "1.5", "--x", "1", "--angles", "-5"],
            &["--angles", "-5", "0 to 180"],
        ),
        (&["mie", "--m-re", "1.5", "--x", "one"], &["--x", "one"]),
        (&["mie", "--x", "1"], &["--m-re"]),
        (&["mie", "--m-re", "1.5", "--x", "1", "--threads", "0"], &["--threads"]),
        (&["color"], &["color", "colour"]),
        (
            &["validate", "--seed", "-1"],
            &["--seed", "from 0 to 9223372036854775807"],
        ),
        (
            &["validate", "--paths", "0"],
            &["--paths", "from 1 to 1000000000000", "2e5"],
        ),
        (&["validate", "--threads", "100000"], &["--threads", "from 1 to 1024"]),
        (
            &["measure", "--out", "none.csv", "--paths", "1"],
            &["--paths", "16 or more"],
        ),
    ] {
        let message = refusal(arguments);
        for part in expected {
            assert!(message.contains(part), "{arguments:?}: {part} is missing in {message}");
        }
    }
}

/// `init --keys` prints the page of keys, as text and in the document.
#[test]
fn init_prints_the_keys() {
    let page = specval::study::Study::page_of_keys();
    assert_eq!(json(&["init", "--keys", "--json"])["markdown"], page);
    assert!(
        page.contains("| `radius_mm` | `0.15` | a number, 1e-6 to 100 mm | Radius of the yarn. |"),
        "{page}"
    );
    let message = refusal(&["init", "--keys", "somewhere"]);
    assert!(message.contains("--keys"), "{message}");
}

#[test]
fn init_writes_the_built_in_study_once() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path().join("new");
    let path = folder.join("study.toml");
    let document = json(&["init", folder.to_str().unwrap(), "--json"]);
    assert_eq!(document["study"], path.to_str().unwrap());
    let text = std::fs::read_to_string(&path).unwrap();
    let study = specval::study::Study::from_toml(&text, "study.toml").unwrap();
    assert_eq!(study, specval::study::Study::default());

    std::fs::write(&path, "seed = 3\n").unwrap();
    let message = refusal(&["init", folder.to_str().unwrap()]);
    assert!(
        message.contains("study.toml") && message.contains("exists already"),
        "{message}"
    );
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "seed = 3\n");
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);

    let message = refusal(&["init", path.to_str().unwrap()]);
    assert!(
        message.contains("study.toml") && message.contains("name another folder"),
        "{message}"
    );
}

#[test]
fn medium_prints_the_reference_coefficients() {
    let scratch = tempfile::tempdir().unwrap();
    let study = scratch.path().join("clear.toml");
    std::fs::write(&study, "[medium]\nkappa_peak = 0.0\n").unwrap();
    let medium = json(&["medium", study.to_str().unwrap(), "--json"]);
    // tests/data/mie/mie_cotton.csv: diameter 150 nm, κ = 0.
    let reference = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/mie/mie_cotton.csv");
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_path(reference)
        .unwrap();
    let mut compared = 0;
    for row in reader.deserialize::<std::collections::HashMap<String, String>>() {
        let row = row.unwrap();
        let number = |column: &str| row[column].parse::<f64>().unwrap();
        if row["size"] != "d150" || number("kappa") != 0.0 {
            continue;
        }
        let wavelengths = medium["wavelength_nm"].as_array().unwrap();
        let at = wavelengths
            .iter()
            .position(|nm| nm.as_f64() == Some(number("lambda_nm")))
            .unwrap();
        for (field, tolerance) in [("mu_s_per_mm", 1e-10), ("mu_a_per_mm", 1e-10), ("g", 1e-6)] {
            let found = medium[field][at].as_f64().unwrap();
            approx::assert_relative_eq!(found, number(field), max_relative = tolerance);
        }
        compared += 1;
    }
    assert!(compared > 0);
}

#[test]
fn medium_absorbs_with_the_dye_of_the_study() {
    let scratch = tempfile::tempdir().unwrap();
    let at = |name: &str| scratch.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(at("dye.csv"), "wavelength_nm,value\n380,0.5\n550,1\n740,0\n").unwrap();
    std::fs::write(at("study.toml"), format!("[medium]\ndye = {:?}\n", at("dye.csv"))).unwrap();
    let built_in = json(&["medium", "--json"]);
    let own = json(&["medium", &at("study.toml"), "--json"]);
    assert_eq!(built_in["wavelength_nm"].as_array().unwrap().len(), 35);
    assert_ne!(built_in["mu_a_per_mm"], own["mu_a_per_mm"]);
    let absorption: Vec<f64> = own["mu_a_per_mm"]
        .as_array()
        .unwrap()
        .iter()
        .map(|v| v.as_f64().unwrap())
        .collect();
    assert!(
        absorption[34] < 0.1 * absorption[16],
        "no dye in the red: {absorption:?}"
    );
    let text = String::from_utf8(specval(&["medium"]).stdout).unwrap();
    assert!(
        text.starts_with("wavelength_nm") && text.lines().count() == 36,
        "{text}"
    );
}

#[test]
fn bad_studies_are_refused_with_file_line_and_key() {
    let scratch = tempfile::tempdir().unwrap();
    let at = |name: &str| scratch.path().join(name).to_str().unwrap().to_owned();
    for (text, expected) in [
        (
            "[medium]\nvolume_fractoin = 0.1\n",
            &["line 2", "volume_fractoin", "did you mean", "volume_fraction"][..],
        ),
        (
            "[medium]\nvolume_fraction = 0.8\n",
            &["line 2", "volume_fraction", "0.74", "0.8"],
        ),
        ("[medium]\nkappa_peak = -0.1\n", &["line 2", "kappa_peak", "-0.1"]),
        ("[yarn]\nradius_mm = -1.0\n", &["line 2", "radius_mm", "mm", "-1"]),
        (
            "[medium]\ndye = \"RR196\"\n",
            &["medium.dye", "RR196", "did you mean 'RR195'", "nor is there a file"],
        ),
        (
            "[spectrum]\nwavelengths_nm = [500.0, 500.0]\n",
            &["line 2", "wavelengths_nm", "ascending"],
        ),
        (
            "[spectrum]\nwavelength_max_nm = 3000.0\n",
            &["preprint-red", "380..780 nm"],
        ),
        ("seed = \n", &["line 1"]),
    ] {
        std::fs::write(at("study.toml"), text).unwrap();
        let message = refusal(&["medium", &at("study.toml")]);
        for part in expected {
            assert!(message.contains(part), "{text}: {part} is missing in {message}");
        }
    }
    let message = refusal(&["medium", &at("none.toml")]);
    assert!(
        message.contains("none.toml") && message.contains("specval init"),
        "{message}"
    );
}

#[test]
fn colour_prints_the_reference_colours() {
    // tests/data/colour/spectra_test.csv and colour_expected.csv, spectrum 29 under D65 and the 2 degree observer.
    let spectra = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/colour/spectra_test.csv");
    let expected = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/colour/colour_expected.csv");
    let colours = json(&["colour", spectra, "--json"]);
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_path(expected)
        .unwrap();
    let mut compared = 0;
    for row in reader.deserialize::<std::collections::HashMap<String, String>>() {
        let row = row.unwrap();
        if row["illuminant"] != "D65" || row["observer"] != "2deg" {
            continue;
        }
        let colour = colours
            .as_array()
            .unwrap()
            .iter()
            .find(|colour| colour["name"] == row["name"].as_str())
            .unwrap();
        let number = |column: &str| row[column].parse::<f64>().unwrap();
        for (field, column) in [("X", "X"), ("Y", "Y"), ("Z", "Z")] {
            approx::assert_relative_eq!(
                colour[field].as_f64().unwrap(),
                number(column),
                max_relative = 1e-12,
                epsilon = 1e-15
            );
        }
        for (index, column) in ["srgb_raw_R", "srgb_raw_G", "srgb_raw_B"].into_iter().enumerate() {
            let found = colour["linear_rgb"][index].as_f64().unwrap();
            approx::assert_abs_diff_eq!(found, number(column), epsilon = 1e-12);
        }
        for (index, column) in ["L", "a", "b"].into_iter().enumerate() {
            approx::assert_abs_diff_eq!(colour["lab"][index].as_f64().unwrap(), number(column), epsilon = 1e-10);
        }
        let in_gamut = (0..3).all(|index| colour["linear_rgb"][index].as_f64().unwrap() >= 0.0);
        assert_eq!(colour["in_gamut"], in_gamut);
        compared += 1;
    }
    assert!(compared >= 19, "{compared} spectra compared");
}

#[test]
fn colour_flags_change_the_convention() {
    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("white.csv");
    let rows: String = (0..35).map(|k| format!("{},1\n", 390 + 10 * k)).collect();
    std::fs::write(&file, format!("wavelength_nm,white\n{rows}")).unwrap();
    let file = file.to_str().unwrap();
    let flags = [
        "--illuminant",
        "A",
        "--observer",
        "cie1964-10deg",
        "--rgb",
        "ntsc",
        "--adaptation",
        "bradford",
    ];
    let colours = json(&[&["colour", file, "--json"][..], &flags].concat());
    // After adaptation the perfect diffuser is white in any space.
    for index in 0..3 {
        approx::assert_relative_eq!(
            colours[0]["linear_rgb"][index].as_f64().unwrap(),
            1.0,
            max_relative = 1e-9
        );
    }
    let text = String::from_utf8(specval(&[&["colour", file][..], &flags].concat()).stdout).unwrap();
    assert!(
        text.contains("cie1964-10deg, A, ntsc, adaptation bradford") && text.contains("white"),
        "{text}"
    );
    let message = refusal(&["colour", file, "--illuminant", "D56"]);
    assert!(
        message.contains("--illuminant") && message.contains("did you mean"),
        "{message}"
    );
}

#[test]
fn bad_spectra_are_refused_with_file_line_and_column() {
    let scratch = tempfile::tempdir().unwrap();
    let at = |name: &str| scratch.path().join(name).to_str().unwrap().to_owned();
    for (name, text, expected) in [
        (
            "twice.csv",
            "wavelength_nm,a\n500,1\n500,0.9\n",
            &["twice.csv", "line 3", "wavelength_nm", "above 500 nm", "or their mean"][..],
        ),
        (
            "nan.csv",
            "# note\nwavelength_nm,a\n500,1\n510,nan\n",
            &["nan.csv", "line 4", "column a", "nan"],
        ),
        (
            "short.csv",
            "wavelength_nm,a\n500\n",
            &["short.csv", "line 2", "2 values"],
        ),
        (
            "infrared.csv",
            "wavelength_nm,a\n500,1\n1500,1\n",
            &["infrared.csv", "no colour", "1 of the wavelengths lie in 360..780 nm"],
        ),
        ("bare.csv", "500,1\n510,1\n", &["bare.csv", "line 1", "wavelength_nm"]),
        ("empty.csv", "", &["empty.csv", "header"]),
    ] {
        std::fs::write(at(name), text).unwrap();
        let message = refusal(&["colour", &at(name)]);
        for part in expected {
            assert!(message.contains(part), "{name}: {part} is missing in {message}");
        }
    }
    for (missing, words) in [(at("missing.csv"), "cannot be read"), (at(""), "found a folder")] {
        let message = refusal(&["colour", &missing]);
        assert!(message.contains(&missing) && message.contains(words), "{message}");
    }
}

#[test]
fn a_reader_that_leaves_early_is_no_error() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_specval"))
        .args(["mie", "--m-re", "1.5", "--x", "10", "--angles"])
        .arg(
            (0..5_000)
                .map(|k| format!("{}", f64::from(k) * 0.03))
                .collect::<Vec<_>>()
                .join(","),
        )
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(
        output.status.success() && output.stderr.is_empty(),
        "{}",
        stderr(&output)
    );
}

#[test]
fn help_and_version_name_the_program() {
    let help = String::from_utf8(specval(&["--help"]).stdout).unwrap();
    for word in [
        "init",
        "mie",
        "colour",
        "--json",
        "--seed",
        "--threads",
        "--paths",
        "--quiet",
    ] {
        assert!(help.contains(word), "{word} is missing in {help}");
    }
    let version = String::from_utf8(specval(&["--version"]).stdout).unwrap();
    let begins = format!("specval {} (", env!("CARGO_PKG_VERSION"));
    assert!(
        version.starts_with(&begins) && version.contains("sources "),
        "{version}"
    );
    let of_command = |arguments: &[&str]| String::from_utf8(specval(arguments).stdout).unwrap();
    assert_eq!(of_command(&["help"]), help);
    assert_eq!(of_command(&["help", "reabsorb"]), of_command(&["reabsorb", "--help"]));
    for (arguments, words) in [
        (["reabsorb", "--help"], &["preprint-red", "RR195", "Examples:"][..]),
        (
            ["init", "--help"],
            &["satin-5", "cie1964-10deg", "D50", "merl-red-fabric2"],
        ),
        (["convert", "--help"], &["ssdd-binary", "klems"]),
        // What a command's own words say beside the line of the list.
        (["help", "mie"], &["q_back = 4 |S(180°)|²/x²"]),
        (["help", "check"], &["Exit code 0: all hold"]),
        (["help", "reabsorb"], &["the BSSRDF is left out"]),
        (["bsdf", "--help"], &["ssdd-binary", "reflection or transmission"]),
    ] {
        let help = of_command(&arguments);
        assert!(words.iter().all(|word| help.contains(word)), "{words:?} in {help}");
    }
}

/// Infrared alone: without a dye that absorbs, no table of one is needed, and spectra need no colour.
#[test]
fn wavelengths_without_dye_or_colour_are_simulated_where_they_can_be() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let rest = "[rig]\npixels_per_side = 8\n[spectrum]\nwavelengths_nm = [850]\n";
    let (clear, dyed) = (path("clear.toml"), path("dyed.toml"));
    std::fs::write(&clear, format!("{rest}[medium]\nkappa_peak = 0\n")).unwrap();
    std::fs::write(&dyed, rest).unwrap();
    for arguments in [
        ["measure", &clear, "--out", &path("a.csv"), "--paths", "64"],
        ["bsdf", &clear, "--out", &path("a.ssdd"), "--paths", "64"],
        ["trace", &clear, "--out", &path("a.trace"), "--paths", "64"],
    ] {
        let output = specval(&arguments);
        assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    }
    let message = refusal(&["measure", &dyed, "--out", &path("b.csv")]);
    assert!(
        message.contains("`medium.dye`") && message.contains("set `medium.kappa_peak` to 0"),
        "{message}"
    );
    for arguments in [
        &["report", &clear, "--out", &path("c"), "--paths", "64"][..],
        &["bsdf", &clear, "--out", &path("c.xml"), "--paths", "64"],
    ] {
        let message = refusal(arguments);
        assert!(
            message.contains("clear.toml, line 4: `spectrum.wavelengths_nm`"),
            "{message}"
        );
        assert!(message.contains("write spectra and need no colour"), "{message}");
    }
}

/// Messages name options and keys that exist, and what to do.
#[test]
fn messages_name_what_was_typed_and_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("s.toml").to_str().unwrap().to_owned();
    let curves = folder.path().join("curves.csv").to_str().unwrap().to_owned();
    std::fs::write(
        &curves,
        "theta_i_deg,theta_v_deg,source,channel,beta,se\n0,0,model,r,0.2,0.01\n",
    )
    .unwrap();
    let brdf = folder.path().join("brdf.csv").to_str().unwrap().to_owned();
    std::fs::write(&brdf, "theta_i_deg,theta_v_deg,wavelength_nm,BRDF\n0,0,500,0.1\n").unwrap();
    std::fs::write(&study, "[trace]\ntilts = 3\n").unwrap();
    for (arguments, words) in [
        (
            ["report", &study, "--measured", "nosuch"],
            "--measured: `measured.sample`: sample 'nosuch' is not known",
        ),
        (
            ["report", &study, "--measured", &curves],
            "the curves of a report (curves.csv); give the sample's own readings",
        ),
        (
            ["report", &study, "--measured", &brdf],
            "beta = pi f: multiply it by pi",
        ),
    ] {
        let message = refusal(&arguments);
        assert!(message.contains(words), "{message}");
    }
    for (text, words) in [
        (
            "[trace]\ntilts = 3\ntilts = 4\n",
            "line 3: expected every key once, found `tilts` again; mend the line",
        ),
        (
            "[yarn]\nradius_mm = -1\n",
            "found -1; correct it, or leave it out for its default; it is: Radius",
        ),
        (
            "[medium]\ndye = \"rde\"\n",
            "take one of these names, or the path of a table",
        ),
        (
            "[cloth]\ncentre_line = \"sinusoid\"\nspacing_diameters = 1.1\n",
            "its own radius 0.15 mm; increase it",
        ),
    ] {
        std::fs::write(&study, text).unwrap();
        let message = refusal(&["report", &study]);
        assert!(message.contains(words) && !message.contains("_spacing_mm"), "{message}");
    }
}

/// Per cent and radians are told by `inspect` whatever the layout.
#[test]
fn inspect_tells_of_units() {
    let folder = tempfile::tempdir().unwrap();
    let red = |nm: u32| if nm < 600 { 0.9 } else { 45.0 };
    let bands: Vec<u32> = (390..=730).step_by(10).collect();
    let mut readings = "theta_i_deg,theta_v_deg,wavelength_nm,beta\n".to_owned();
    let mut spectra = "wavelength_nm,red\n".to_owned();
    for &nm in &bands {
        spectra += &format!("{nm},{}\n", red(nm));
        readings += &[-60, -30, 0, 45]
            .map(|view| format!("0,{view},{nm},{}\n", red(nm)))
            .concat();
    }
    let fields: Vec<String> = bands.iter().map(|nm| format!("SPEC_{nm}")).collect();
    let values: Vec<String> = bands.iter().map(|&nm| red(nm).to_string()).collect();
    let cgats = format!(
        "BEGIN_DATA_FORMAT\nSAMPLE_ID {}\nEND_DATA_FORMAT\nBEGIN_DATA\n1 {}\nEND_DATA\n",
        fields.join(" "),
        values.join(" ")
    );
    let mut sphere = "theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,beta\n".to_owned();
    for theta_o in [0.0, 0.52, 1.05] {
        sphere += &[0.0, 1.05, 2.09, 4.71]
            .map(|phi| format!("0,0,{theta_o},{phi},0.3\n"))
            .concat();
    }
    for (name, text, words) in [
        (
            "readings.csv",
            readings,
            "up to 45, where 1 is a perfect diffuser: these look like per cent",
        ),
        ("spectra.csv", spectra, "if these are per cent, divide them by 100"),
        ("spectra.txt", cgats, "if these are per cent, divide them by 100"),
        ("sphere.csv", sphere, "no angle is beyond 4.71: these look like radians"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        let output = specval(&["inspect", path.to_str().unwrap()]);
        let shown = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(shown.contains(words), "{name}: {shown}{}", stderr(&output));
    }
    let study = folder.path().join("s.toml");
    std::fs::write(&study, "[rig]\nincidences_deg = [0, 0.52, 1.05]\npixels_per_side = 8\n").unwrap();
    let out = folder.path().join("o.csv");
    let output = specval(&[
        "measure",
        study.to_str().unwrap(),
        "--paths",
        "64",
        "--out",
        out.to_str().unwrap(),
    ]);
    assert!(stderr(&output).contains("notice: `rig.incidences_deg`: no angle is beyond 1.05: these look like radians"));
}
