//! Light between yarns as typed: methods, bounces, backing, and where the light went.

use crate::command::specval;
use std::fs;
use std::path::Path;
use std::process::Output;

const SMALL: &str = "
[spectrum]
wavelengths_nm = [450.0, 540.0, 640.0]
[trace]
batches = 4
exit_azimuth_cells = 12
exit_theta_cells = 4
exit_phi_cells = 8
tilts = 4
paths_direct = 20000
particles = 800
particles_volumetric = 4000
[rig]
incidences_deg = [0.0, 40.0]
view_min_deg = -40.0
view_max_deg = 40.0
view_step_deg = 40.0
pixels_per_side = 8
";

const FIBRES: &str = "[yarn]\ntwist_deg = 20\n[specular]\nsurface = \"fibres\"\nroughness = 0.2\n";

fn measure(folder: &Path, name: &str, more: &str, arguments: &[&str]) -> Output {
    fs::write(folder.join(format!("{name}.toml")), format!("{SMALL}{more}")).unwrap();
    let (study, out) = (format!("{name}.toml"), format!("{name}.csv"));
    let mut words = vec!["measure", study.as_str(), "--out", out.as_str(), "--quiet"];
    words.extend(arguments);
    specval(folder, &words)
}

fn rows(path: &Path) -> Vec<Vec<f64>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let number = |text: &str| text.parse().unwrap();
    reader
        .records()
        .map(|record| record.unwrap().iter().map(number).collect())
        .collect()
}

/// β at 640 nm, normal light and view.
fn red(folder: &Path, name: &str) -> f64 {
    let all = rows(&folder.join(format!("{name}.csv")));
    all.iter()
        .find(|r| r[0] == 0.0 && r[1] == 0.0 && r[2] == 640.0)
        .unwrap()[3]
}

#[test]
fn methods_bounces_and_backings() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let studies = [
        ("direct", "", &[][..]),
        ("all", "[cloth]\nbounces = \"all\"\n", &[]),
        ("one", "[cloth]\nbounces = 1\n", &[]),
        ("volumetric", "", &["--method", "volumetric"]),
        ("white", "[cloth]\nbacking = \"white\"\nbounces = \"all\"\n", &[]),
        (
            "yarn",
            "[cloth]\nmethod = \"volumetric\"\n[specular]\nsurface = \"yarn\"\n",
            &["--threads", "1"],
        ),
        ("fibres", FIBRES, &[]),
    ];
    for (name, more, arguments) in studies {
        let output = measure(here, name, more, arguments);
        assert!(
            output.status.success(),
            "{name}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
        let energy = here.join(format!("{name}.csv.energy.csv"));
        assert_eq!(energy.exists(), name != "direct", "{name}");
        if name != "direct" {
            let rows = rows(&energy);
            assert_eq!(rows.len(), 2 * 3, "{name}");
            assert!(rows.iter().all(|r| r[16].abs() < 1e-9), "{name}: {rows:?}");
        }
    }
    // Each adds light: other yarns to the direct, a white plane to those. Noise is far smaller.
    let [direct, all, white] = ["direct", "all", "white"].map(|name| red(here, name));
    assert!(direct < all && all < white, "{direct} {all} {white}");
    // And so do fibres, with no light from other yarns.
    assert!(direct < red(here, "fibres"));
    let before = fs::read(here.join("yarn.csv")).unwrap();
    measure(
        here,
        "yarn",
        "[cloth]\nmethod = \"volumetric\"\n[specular]\nsurface = \"yarn\"\n",
        &["--threads", "2", "--force"],
    );
    assert!(
        before == fs::read(here.join("yarn.csv")).unwrap(),
        "threads change bytes"
    );
}

/// Yarns and backing that absorb nothing: what is left out of the light stands in columns of its own, and `absorbed` is
/// 0.
#[test]
fn absorbed_is_absorption_alone() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    // Whether the yarns' reflection is left out, and whether light is cut off.
    for (name, cloth, dropped, cut) in [
        ("all", "bounces = \"all\"", true, false),
        ("one", "bounces = 1", true, true),
        ("white", "bounces = 0\nbacking = \"white\"", true, true),
        ("volumetric", "method = \"volumetric\"", true, false),
    ] {
        let output = measure(
            here,
            name,
            &format!("[medium]\nkappa_peak = 0\n[cloth]\n{cloth}\n"),
            &[],
        );
        assert!(output.status.success(), "{name}");
        let file = here.join(format!("{name}.csv.energy.csv"));
        let text = fs::read_to_string(&file).unwrap();
        let columns: Vec<&str> = text.lines().next().unwrap().split(',').collect();
        let of = |row: &[f64], column: &str| row[columns.iter().position(|c| *c == column).unwrap()];
        for row in rows(&file) {
            assert_eq!(of(&row, "absorbed"), 0.0, "{name}: {row:?}");
            assert_eq!(of(&row, "reflection_dropped") > 0.01, dropped, "{name}: {row:?}");
            assert_eq!(of(&row, "bounces_cut") > 0.01, cut, "{name}: {row:?}");
            let parts = [
                "reflected",
                "through_yarns",
                "through_gaps",
                "absorbed",
                "reflection_dropped",
                "bounces_cut",
                "sampling_net",
            ];
            let sum: f64 = parts.iter().map(|column| of(&row, column)).sum();
            assert!((sum - 1.0).abs() < 1e-9, "{name}: {row:?}");
        }
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    fs::write(here.join("shining.csv"), "wavelength_nm,value\n400,0.5\n700,1.5\n").unwrap();
    for (more, arguments, words) in [
        ("[cloth]\nbacking = \"mirror\"\n", &[][..], "cloth.backing"),
        ("[cloth]\nbacking = \"shining.csv\"\n", &[], "cloth.backing"),
        ("[cloth]\nbounces = \"some\"\n", &[], "cloth.bounces"),
        ("[yarn]\ntwist_deg = 20\n", &[], "yarn.twist_deg"),
        ("[cloth]\nbounces = -1\n", &[], "cloth.bounces"),
        ("[cloth]\nwarp_flattening = 9.0\n", &[], "cloth.warp_flattening"),
        (
            "[cloth]\nradius_variation = 0.2\nrepeats = 4\nspacing_diameters = 1.74\n",
            &[],
            "spacing",
        ),
        ("[weft]\nkappa_peak = -1.0\n", &[], "weft.kappa_peak"),
        ("[weft]\ndye = \"woad\"\n", &[], "weft.dye"),
        ("[weft]\nhost_index = \"shining.csv\"\n", &[], "weft.host_index"),
    ] {
        let output = measure(here, "wrong", more, arguments);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{more}: {text}");
        assert!(text.contains(words), "{more}: {text}");
        assert!(!here.join("wrong.csv").exists());
    }
}
