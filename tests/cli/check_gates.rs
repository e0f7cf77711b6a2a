//! `specval check` as typed: verdicts, exit codes, outputs, the baseline, and how often chance breaks a gate.

use crate::command::specval;
use serde_json::Value;
use specval::check::{self, CheckEffort, GateVerdict};
use specval::run::Plan;
use specval::study::Study;
use std::fs;
use std::path::Path;
use std::process::Output;

/// Few wavelengths and small tables; everything else as in the built-in study.
const SMALL: &str = "
[spectrum]
wavelengths_nm = [430.0, 530.0, 660.0]
[trace]
bssrdf_azimuth_cells = 4
bssrdf_exit_theta_cells = 2
bssrdf_exit_phi_cells = 4
exit_azimuth_cells = 12
exit_theta_cells = 4
exit_phi_cells = 8
[rig]
pixels_per_side = 8
";
/// Wide enough for the fewest paths.
const WIDE: &str = "
[check]
sharing = 1.0
roulette = 1.0
scattering_angle = 1.0
cylinder = 1.0
two_estimators = 1.0
reciprocity = 1.0
cloth = 1.0
";

fn document(output: &Output) -> Value {
    let text = String::from_utf8_lossy(&output.stderr);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {text}"))
}

fn gate<'d>(document: &'d Value, name: &str) -> &'d Value {
    let gates = document["gates"].as_array().unwrap();
    gates.iter().find(|gate| gate["name"] == name).unwrap()
}

#[test]
fn verdicts_baseline_and_outputs() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    fs::write(here.join("study.toml"), format!("{SMALL}{WIDE}")).unwrap();
    let base = ["check", "study.toml", "--paths", "4096", "--json"];
    let first = specval(here, &base);
    let checked = document(&first);
    assert_eq!(first.status.code(), Some(0), "{checked:#}");
    assert_eq!(checked["verdict"], "holds");
    assert!(checked["gates"].as_array().unwrap().len() >= 20);
    for field in ["name", "value", "se", "tolerance", "verdict"] {
        assert!(!gate(&checked, "sharing")[field].is_null(), "{field}");
    }
    fs::write(here.join("baseline.json"), &first.stdout).unwrap();

    // The same run has the same bits, another seed the same distribution.
    let again = |more: &[&str]| specval(here, &[&base[..], &["--against", "baseline.json"], more].concat());
    let same = document(&again(&[]));
    assert_eq!(
        (&same["drift"]["same_run"], &same["drift"]["same_bits"]),
        (&true.into(), &true.into())
    );
    let other = again(&["--seed", "7"]);
    assert_eq!(other.status.code(), Some(0));
    assert_eq!(document(&other)["drift"]["same_run"], false);

    // A little more dye moves what the dye absorbs.
    fs::write(
        here.join("study.toml"),
        format!("{SMALL}[medium]\nkappa_peak = 0.007\n{WIDE}"),
    )
    .unwrap();
    let outputs = ["--junit", "gates.xml", "--github"];
    let moved = again(&outputs);
    assert_eq!(moved.status.code(), Some(1));
    let drift = &document(&moved)["drift"]["moved"];
    assert!(drift[0]["sigmas"].as_f64().unwrap().abs() > 5.0, "{drift}");
    let annotations = String::from_utf8(moved.stderr).unwrap();
    assert!(
        annotations.starts_with("::error title=specval check baseline::"),
        "{annotations}"
    );
    let xml = fs::read_to_string(here.join("gates.xml")).unwrap();
    assert!(xml.contains("<testcase classname=\"specval.check\" name=\"ledger\">"));
    assert_eq!(xml.matches("<failure ").count(), 1);
    assert!(xml.contains("failures=\"1\" errors=\"0\""), "{xml}");
}

#[test]
fn too_few_paths_cannot_tell_and_bad_input_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    fs::write(here.join("study.toml"), format!("{SMALL}[check]\nsharing = 1e-4\n")).unwrap();
    let output = specval(here, &["check", "study.toml", "--paths", "4096", "--json"]);
    assert_eq!(output.status.code(), Some(2));
    let checked = document(&output);
    assert_eq!(checked["verdict"], "undecided");
    assert!(gate(&checked, "sharing")["paths_to_tell"].as_u64().unwrap() > 100_000);

    let refused = |arguments: &[&str], words: &str| {
        let output = specval(here, arguments);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(words) && output.stdout.is_empty(), "{message}");
    };
    refused(&["check", "study.toml", "--paths", "100"], "expected at least 4096");
    refused(&["check", "--against", "none.json"], "check --json");
    fs::write(here.join("other.json"), "{}").unwrap();
    refused(&["check", "--against", "other.json"], "expected the document");
    refused(&["check", "--junit", "no/such/folder.xml"], "cannot be written");
    fs::write(here.join("wrong.toml"), "[check]\nsharing = 2.0\n").unwrap();
    refused(&["check", "wrong.toml"], "check.sharing");
}

/// Runs of a clean study, each with its own seed, of which some gate breaks.
fn false_alarms(runs: u64) -> Vec<(u64, Vec<&'static str>)> {
    (0..runs)
        .filter_map(|seed| {
            let mut study = Study::from_toml(&format!("{SMALL}{WIDE}"), "study").unwrap();
            study.seed = 1000 + seed;
            let plan = Plan::new(study).unwrap();
            let checked = check::study(&plan, CheckEffort::of_paths(4096).unwrap(), &|_| ()).unwrap();
            let broken = checked.gates.iter().filter(|gate| gate.verdict == GateVerdict::Broken);
            let broken: Vec<&str> = broken.map(|gate| gate.name).collect();
            (!broken.is_empty()).then_some((seed, broken))
        })
        .collect()
}

/// Studies at the ends of their keys' ranges, where laws hold and light is rare, all but absorbed, or turned by next to
/// nothing.
const VALID: [&str; 9] = [
    "[medium]\nkappa_peak = 0.1",
    "[medium]\nvolume_fraction = 0.0",
    "[medium]\nvolume_fraction = 1e-6",
    "[medium]\nhost_index = 1.0\nparticle_index = 1.05",
    "[medium]\nparticle_index = 1.557",
    "[medium]\nparticle_diameter_nm = 1.0",
    "[medium]\nhost_mu_a_per_mm = 50.0",
    "[yarn]\nradius_mm = 1e-6",
    "[medium]\ninterference = \"percus-yevick\"\nparticle_diameter_nm = 1000.0\nvolume_fraction = 0.6",
];

#[test]
fn valid_studies_at_the_ends_of_the_ranges_break_no_law() {
    let alarms: Vec<(&str, Vec<String>)> = VALID
        .iter()
        .filter_map(|keys| {
            let study = Study::from_toml(&format!("{SMALL}{WIDE}{keys}\n"), "study").unwrap();
            let plan = Plan::new(study).unwrap();
            let checked = check::study(&plan, CheckEffort::of_paths(4096).unwrap(), &|_| ()).unwrap();
            let broken = checked.gates.iter().filter(|gate| gate.verdict == GateVerdict::Broken);
            let broken: Vec<String> = broken
                .map(|gate| format!("{}: {}", gate.name, gate.message()))
                .collect();
            (!broken.is_empty()).then_some((*keys, broken))
        })
        .collect();
    assert!(alarms.is_empty(), "{alarms:#?}");
}

/// White yarns that send light out all around would reflect and transmit more than all light at grazing incidence;
/// `measure` says so on stderr and in its file, which stays one that is read.
#[test]
fn grazing_incidence_is_told_of() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let small = "[trace]\nbatches = 2\npaths_direct = 200\npaths_bssrdf = 20\n[spectrum]\nwavelengths_nm = [550.0]\n";
    let of = |rig: &str| {
        fs::write(
            here.join("study.toml"),
            format!("{small}[rig]\npixels_per_side = 4\n{rig}\n"),
        )
        .unwrap();
        let output = specval(here, &["measure", "study.toml", "--out", "curves.csv", "--force"]);
        assert_eq!(output.status.code(), Some(0));
        let text = fs::read_to_string(here.join("curves.csv")).unwrap();
        (String::from_utf8(output.stderr).unwrap(), text)
    };
    let (told, text) = of("incidences_deg = [0.0, 60.0, 89.0, 89.9]");
    assert!(
        told.contains("gains energy") && told.contains("89 deg (") && told.contains("89.9 deg ("),
        "{told}"
    );
    assert!(
        !told.contains("60 deg (") && text.starts_with("# shading with f* gains energy"),
        "{text}"
    );
    let (told, text) = of("incidences_deg = [0.0, 60.0]");
    assert!(
        !told.contains("energy") && text.starts_with("theta_i_deg"),
        "{told} {text}"
    );
    let (told, _) = of("incidences_deg = [0.0, 89.9]\n[cloth]\nmethod = \"volumetric\"");
    assert!(!told.contains("energy"), "{told}");
    // As typed values in JSON.
    let json = |rig: &str| {
        fs::write(
            here.join("study.toml"),
            format!("{small}[rig]\npixels_per_side = 4\n{rig}\n"),
        )
        .unwrap();
        document(&specval(
            here,
            &["measure", "study.toml", "--out", "curves.csv", "--force", "--json"],
        ))
    };
    let gaining = json("incidences_deg = [0.0, 60.0, 89.9]");
    let gains = gaining["grazing_gains"].as_array().unwrap();
    assert_eq!(gains.len(), 1, "{gains:?}");
    assert_eq!(gains[0]["theta_i_deg"], 89.9);
    assert!(gains[0]["white_albedo"].as_f64().unwrap() > 1.5, "{gains:?}");
    assert!(gaining["notices"].to_string().contains("gains energy"));
    assert!(!gaining["brightness_factors"].as_array().unwrap().is_empty());
    assert_eq!(json("incidences_deg = [0.0]")["grazing_gains"], serde_json::json!([]));
}

/// A full measurement by f* follows light from yarn to yarn from the first yarn on, and gains no energy at grazing
/// incidence, where shading in the sun would nearly double it: white yarns send out all light, to a tenth for the noise
/// of few particles.
#[test]
fn full_measurements_by_factors_gain_nothing_at_grazing_incidence() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let study = "[trace]\nbatches = 2\npaths_direct = 40000\n[spectrum]\nwavelengths_nm = \
                 [550.0]\n[medium]\nkappa_peak = 0.0\n";
    fs::write(here.join("study.toml"), study).unwrap();
    let output = specval(
        here,
        &[
            "bsdf",
            "study.toml",
            "--method",
            "radiance-factor",
            "--theta-step",
            "2",
            "--phi-step",
            "90",
            "--paths",
            "2000",
            "--out",
            "full.csv",
            "--json",
        ],
    );
    let rows = document(&output)["hemispherical"].clone();
    let mut grazing = 0;
    for row in rows.as_array().unwrap() {
        let of = |name: &str| row[name].as_f64().unwrap();
        let out = of("reflectance") + of("transmittance");
        assert!((out - 1.0).abs() < 0.1, "{row}");
        grazing += usize::from(of("theta_i_deg") >= 88.0);
    }
    assert!(grazing > 0, "{rows}");
}

/// A run has a false alarm with probability 1e-3, five of them with 5e-3.
#[test]
fn clean_runs_raise_no_alarm() {
    assert_eq!(false_alarms(5), []);
}

#[test]
#[ignore = "minutes"]
fn at_most_two_of_200_clean_runs_raise_an_alarm() {
    let alarms = false_alarms(200);
    assert!(alarms.len() <= 2, "{alarms:?}");
}

#[test]
fn documented_commands_are_of_the_program() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let docs = fs::read_to_string(root.join("docs/checks.md")).unwrap();
    let commands: Vec<&str> = docs
        .lines()
        .filter_map(|line| line.strip_prefix("    specval check"))
        .collect();
    assert_eq!(commands.len(), 4);
    // The default study is minutes of work on a busy machine; its command is that of --quick but for the paths.
    for command in &commands[1..] {
        let command = command.split("    ").next().unwrap_or_default();
        let arguments: Vec<&str> = std::iter::once("check").chain(command.split_whitespace()).collect();
        let output = specval(root, &arguments);
        let text = String::from_utf8_lossy(&output.stdout);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {text}");
        assert!(text.trim_end().ends_with("0 broken, 0 undecided"), "{text}");
    }
}
