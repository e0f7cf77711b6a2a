//! Files as the programs they are for read them. Each test is skipped, with a notice, where its program is missing:
//! `pip install mitsuba==3.9.1 pyradiance`, and `SPECVAL_PYTHON` for a Python other than `python3`.

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use specval::formats::{Format, Goniometric, ReadOptions, Table, WriteOptions, direction, parse, read, write};
use specval::geometry::Vec3;
use specval::run::Plan;
use specval::study::Study;

const STUDY: &str = "[spectrum]\nwavelengths_nm = [400, 450, 500, 550, 600, 650, 700]\n[trace]\nbatches = 2\n";

/// A file of `measure --full`, coarse.
fn measured(folder: &Path, name: &str, more: &[&str]) -> Vec<u8> {
    std::fs::write(folder.join("study.toml"), STUDY).unwrap();
    let program = Command::new(env!("CARGO_BIN_EXE_specval"))
        .args([
            "bsdf",
            "study.toml",
            "--theta-step",
            "15",
            "--phi-step",
            "45",
            "--paths",
            "4000",
        ])
        .args(["--out", name])
        .args(more)
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(program.status.success(), "{}", String::from_utf8_lossy(&program.stderr));
    std::fs::read(folder.join(name)).unwrap()
}

fn load(name: &str) -> Goniometric {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/formats")
        .join(name);
    read(&path, &ReadOptions::default()).unwrap()
}

/// What a script prints, a list of numbers a line; `None` where Python or the module is missing.
fn python(module: &str, script: &str, arguments: &[&str]) -> Option<Vec<Vec<f64>>> {
    let interpreter = std::env::var("SPECVAL_PYTHON").unwrap_or_else(|_| "python3".into());
    let there = Command::new(&interpreter)
        .args(["-c", &format!("import {module}")])
        .output();
    if !there.is_ok_and(|output| output.status.success()) {
        println!("notice: skipped, {interpreter} has no module {module}");
        return None;
    }
    let output = Command::new(&interpreter)
        .args(["-c", script])
        .args(arguments)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let numbers = |line: &str| line.split_whitespace().map(|word| word.parse().unwrap()).collect();
    Some(text.lines().map(numbers).collect())
}

const MITSUBA: &str = "
import sys, numpy as np, mitsuba as mi
mi.set_variant(sys.argv[1])
bsdf = mi.load_dict({'type': 'measured', 'filename': sys.argv[2]})
for line in open(sys.argv[3]):
    v = [float(x) for x in line.split()]
    si = mi.SurfaceInteraction3f()
    if 'spectral' in sys.argv[1]:
        si.wavelengths = v[6:10]
    si.wi = mi.Vector3f(v[:3])
    print(*np.array(bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(v[3:6]))).ravel())
";

/// Mitsuba at nodes of the table and between them.
#[test]
fn mitsuba_reads_rgl_files() {
    let folder = tempfile::tempdir().unwrap();
    for (name, variant, wavelengths) in [
        (
            "dir_specular_spectral7_binary.ssdd",
            "scalar_spectral",
            [400.0, 500.0, 600.0, 700.0].as_slice(),
        ),
        ("dir_iso_rgb.ddr", "scalar_rgb", &[]),
        ("dir_aniso_rgb.ddr", "scalar_rgb", &[]),
        ("full.bsdf", "scalar_spectral", &[400.0, 500.0, 600.0, 700.0]),
        ("full_rgb.bsdf", "scalar_rgb", &[]),
    ] {
        let bytes = match name {
            "full.bsdf" => measured(folder.path(), name, &[]),
            "full_rgb.bsdf" => measured(folder.path(), name, &["--rgb"]),
            _ => write(&load(name), Format::RGL, &WriteOptions::default()).unwrap().bytes,
        };
        let data = parse("x.bsdf", &bytes, &ReadOptions::default()).unwrap();
        let file = folder.path().join(format!("{name}.bsdf"));
        std::fs::write(&file, &bytes).unwrap();
        let Table::Warped(table) = &data.components[0].table else {
            panic!("no warped table")
        };
        let mut pairs: Vec<(Vec3, Vec3)> = Vec::new();
        for theta in table
            .incidence()
            .nodes_rad()
            .iter()
            .copied()
            .filter(|theta| *theta > 0.05)
        {
            for (x, y) in [(5, 3), (9, 12), (14, 27)] {
                let unit = |k: usize| k as f64 / (table.size() - 1) as f64;
                let half = direction(
                    unit(x).powi(2) * std::f64::consts::FRAC_PI_2,
                    unit(y) * std::f64::consts::TAU - std::f64::consts::PI,
                );
                let omega_in = direction(theta, 0.0);
                pairs.push((omega_in, half * (2.0 * half.dot(&omega_in)) - omega_in));
            }
            pairs.push((direction(0.9 * theta, 0.7), direction(0.5, 4.0)));
        }
        pairs.retain(|(_, omega_out)| omega_out.z > 0.05);
        let mut lines = String::new();
        for (i, o) in &pairs {
            writeln!(
                lines,
                "{} {} {} {} {} {} {}",
                i.x,
                i.y,
                i.z,
                o.x,
                o.y,
                o.z,
                words(wavelengths)
            )
            .unwrap();
        }
        let list = folder.path().join("pairs");
        std::fs::write(&list, lines).unwrap();
        let arguments = [variant, file.to_str().unwrap(), list.to_str().unwrap()];
        let Some(found) = python("mitsuba", MITSUBA, &arguments) else {
            return;
        };
        let mut worst = 0.0f64;
        for ((omega_in, omega_out), found) in pairs.iter().zip(&found) {
            let values = data.eval(omega_in, omega_out).unwrap().values;
            let expected: Vec<f64> = if wavelengths.is_empty() {
                values
            } else {
                wavelengths
                    .iter()
                    .map(|nm| values[((nm - 400.0) / 50.0) as usize])
                    .collect()
            };
            assert_eq!(found.len(), expected.len());
            for (f, e) in found.iter().zip(expected) {
                worst = worst.max((f / e - 1.0).abs());
            }
        }
        println!("{name}: Mitsuba within {worst:e}");
        assert_eq!(found.len(), pairs.len());
        assert!(worst < 0.01, "{name}: {worst}");
    }
}

fn words(numbers: &[f64]) -> String {
    numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}

const RADIANCE: &str = "
import sys, pyradiance as pr
sd = pr.bsdf.load_file(sys.argv[1])
for line in open(sys.argv[2]):
    print(*pr.bsdf.query(sd, *[float(x) for x in line.split()]))
";

/// Radiance's own library at the centres of patches, as CIE X, Y, Z.
#[test]
fn radiance_reads_klems_files() {
    let folder = tempfile::tempdir().unwrap();
    for name in [
        "dir_spherical_bw.ssdd",
        "dir_specular_spectral7_binary.ssdd",
        "lbgen_lambert_bsdf_mono.ssdd",
        "full.xml",
    ] {
        let bytes = match name {
            "full.xml" => measured(folder.path(), name, &[]),
            _ => {
                write(&load(name), Format::RADIANCE_XML, &WriteOptions::default())
                    .unwrap()
                    .bytes
            }
        };
        let data = parse("x.xml", &bytes, &ReadOptions::default()).unwrap();
        let file = folder.path().join(format!("{name}.xml"));
        std::fs::write(&file, &bytes).unwrap();
        let angles = [
            (0.0, 0.0, 20.0, 0.0),
            (30.0, 18.0, 40.0, 60.0),
            (50.0, 90.0, 10.0, 225.0),
            (20.0, 180.0, 60.0, 30.0),
        ];
        let mut queries: Vec<(f64, f64, f64, f64)> = angles.to_vec();
        if data.components.len() > 1 {
            queries.extend(angles.map(|(ti, pi, to, po)| (ti, pi, 180.0 - to, po)));
        }
        if data.components.len() > 2 {
            queries.extend(angles.map(|(ti, pi, to, po)| (180.0 - ti, pi, 180.0 - to, po)));
            queries.extend(angles.map(|(ti, pi, to, po)| (180.0 - ti, pi, to, po)));
            // Straight on, where the light through the gaps is.
            queries.extend(angles.map(|(ti, pi, ..)| (ti, pi, 180.0 - ti, pi + 180.0)));
            queries.extend(angles.map(|(ti, pi, ..)| (180.0 - ti, pi, ti, pi + 180.0)));
        }
        let lines: Vec<String> = queries.iter().map(|(a, b, c, d)| format!("{a} {b} {c} {d}")).collect();
        let list = folder.path().join("angles");
        std::fs::write(&list, lines.join("\n")).unwrap();
        let Some(found) = python(
            "pyradiance",
            RADIANCE,
            &[file.to_str().unwrap(), list.to_str().unwrap()],
        ) else {
            return;
        };
        let mut worst = 0.0f64;
        for ((ti, pi, to, po), xyz) in queries.iter().zip(&found) {
            let degrees = |theta: f64, phi: f64| direction(theta.to_radians(), phi.to_radians());
            let values = data.eval(&degrees(*ti, *pi), &degrees(*to, *po)).unwrap().values;
            let y = if values.len() == 3 { values[1] } else { values[0] };
            worst = worst.max((xyz[1] - y).abs() / y.max(1.0));
        }
        println!("{name}: Radiance within {worst:e}");
        assert!(found.len() == queries.len() && worst < 1e-3, "{name}: {worst}");
    }
}

const HEMISPHERICAL: &str = "
import sys, pyradiance as pr
sd = pr.bsdf.load_file(sys.argv[1])
b = pr.bsdf
reflected, transmitted = (kind | b.SAMPLE_SP | b.SAMPLE_DF for kind in (b.SAMPLE_R, b.SAMPLE_T))
for line in open(sys.argv[2]):
    theta, phi = (float(x) for x in line.split())
    print(b.direct_hemi(sd, theta, phi, reflected), b.direct_hemi(sd, theta, phi, transmitted))
";

/// Radiance finds all the light that the ledger has, through yarns and gaps together, from both sides.
#[test]
fn radiance_finds_the_light_of_the_ledger() {
    let folder = tempfile::tempdir().unwrap();
    measured(folder.path(), "ledger.xml", &[]);
    let mut csv = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_path(folder.path().join("ledger.xml.hemispherical.csv"))
        .unwrap();
    let names = csv.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = csv.records().map(Result::unwrap).collect();
    let column = |name: &str| names.iter().position(|n| n == name).unwrap();
    let value = |row: &csv::StringRecord, name: &str| row[column(name)].parse::<f64>().unwrap();
    let plan = Plan::new(Study::from_toml(STUDY, "study").unwrap()).unwrap();
    let mut expected = Vec::new();
    let mut lines = String::new();
    for spectrum in rows.chunks_exact(7) {
        let of = |name: &str| -> f64 {
            let fractions: Vec<f64> = spectrum.iter().map(|row| value(row, name)).collect();
            plan.colour.xyz(&fractions).y
        };
        let (theta, phi) = (value(&spectrum[0], "theta_i_deg"), value(&spectrum[0], "phi_i_deg"));
        assert_eq!(&spectrum[0][column("light_from")], "front");
        // The back of a plain weave is its front, turned about the warp.
        for (theta, phi) in [(theta, phi), (180.0 - theta, -phi)] {
            writeln!(lines, "{theta} {phi}").unwrap();
            expected.push([of("reflectance"), of("transmittance")]);
        }
        assert!(of("through_gaps") > 0.0 || theta > 20.0);
    }
    let list = folder.path().join("incidences");
    std::fs::write(&list, lines).unwrap();
    let file = folder.path().join("ledger.xml");
    let arguments = [file.to_str().unwrap(), list.to_str().unwrap()];
    let Some(found) = python("pyradiance", HEMISPHERICAL, &arguments) else {
        return;
    };
    let pairs = found.iter().flatten().zip(expected.iter().flatten());
    let worst = pairs
        .map(|(found, expected)| (found - expected).abs())
        .fold(0.0, f64::max);
    println!("{} incidences: Radiance within {worst:e}", expected.len());
    assert!(
        found.len() == expected.len() && found.len() > 40 && worst < 1e-5,
        "{worst}"
    );
}
