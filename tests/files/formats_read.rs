//! Readers against files that other programs wrote and values that other programs read.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_1_PI, PI};

use specval::formats::{
    AngleUnit, ChannelSet, Format, Goniometric, Parameters, Placement, Quantity, ReadOptions, Scatter, Side, Table,
    direction, parse, read,
};
use specval::geometry::Vec3;

use crate::golden::{golden, load};

fn bsdf(data: &Goniometric, omega_in: &Vec3, omega_out: &Vec3) -> Vec<f64> {
    data.eval(omega_in, omega_out).unwrap().bsdf().unwrap()
}

fn degrees(theta: f64, phi: f64) -> Vec3 {
    direction(theta.to_radians(), phi.to_radians())
}

/// f of the 13 nodes in the mirror direction of `lbgen_roughdiffuse_mono.ddr` at an incidence, from the numbers of the
/// file.
fn rough_diffuse_columns(theta_i_deg: f64) -> Vec<f64> {
    let text = std::fs::read_to_string(golden("lbgen_roughdiffuse_mono.ddr")).unwrap();
    let data = text.lines().skip_while(|line| line.trim() != "def").skip(1);
    let rows: Vec<f64> = data
        .filter(|line| !line.contains(";;") && !line.contains("enddef"))
        .map(|line| line.split_whitespace().next().unwrap().parse::<f64>().unwrap())
        .collect();
    // Incidences every 15 degrees.
    let (below, t) = ((theta_i_deg / 15.0) as usize, theta_i_deg / 15.0 % 1.0);
    let at = |sigma: usize, phi: usize| rows[13 * sigma + phi] / PI;
    (0..13)
        .map(|phi| (1.0 - t) * at(below, phi) + t * at(below + 1, phi))
        .collect()
}

/// Values as libbsdf printed them, to 6 digits.
#[test]
fn golden_files_have_the_values_of_libbsdf() {
    let text = std::fs::read_to_string(golden("EXPECTED.tsv")).unwrap();
    let mut worst: BTreeMap<&str, f64> = BTreeMap::new();
    for line in text.lines().filter(|l| !l.starts_with('#') && !l.starts_with("file")) {
        let cells: Vec<&str> = line.split('\t').collect();
        let angle = |i: usize| cells[i].parse::<f64>().unwrap();
        let expected: Vec<f64> = cells[5].split(' ').map(|v| v.parse().unwrap()).collect();
        // The mirror direction is one node of the table for each azimuth about it. Those of this file, by Monte Carlo,
        // differ, and libbsdf printed what its rounding met between them.
        if cells[0] == "lbgen_roughdiffuse_mono.ddr" && cells[1] == cells[3] {
            let columns = rough_diffuse_columns(angle(1));
            let found = bsdf(&load(cells[0]), &degrees(angle(1), 0.0), &degrees(angle(3), angle(4)))[0];
            // The first node is the last again.
            let mean = columns[1..].iter().sum::<f64>() / 12.0 + (columns[0] - columns[12]) / 24.0;
            let (low, high) = columns
                .iter()
                .fold((1.0, 0.0f64), |(low, high): (f64, _), v| (low.min(*v), high.max(*v)));
            assert!(
                (found - mean).abs() < 1e-9 && (low..=high).contains(&expected[0]),
                "{line}: {found} {mean}"
            );
            continue;
        }
        let found = bsdf(
            &load(cells[0]),
            &degrees(angle(1), angle(2)),
            &degrees(angle(3), angle(4)),
        );
        assert_eq!(found.len(), expected.len(), "{line}");
        for (f, e) in found.iter().zip(&expected) {
            let deviation = worst.entry(cells[0]).or_default();
            *deviation = deviation.max((f - e).abs());
        }
    }
    println!("{worst:#?}");
    assert_eq!(worst.len(), 15);
    assert!(worst.values().all(|&deviation| deviation < 1e-6), "{worst:#?}");
}

/// The function the `dir_iso_*` files sample, where `phi` is the outgoing azimuth from the light's.
fn iso(theta_i: f64, theta_o: f64, phi: f64) -> f64 {
    0.3 + 0.1 * theta_i.cos() + 0.05 * theta_o.sin() * phi.cos() + 0.04 * theta_o.sin() * phi.sin() * theta_i.sin()
}

#[test]
fn astm_columns_are_read_at_their_nodes_and_between() {
    let data = load("dir_iso_rgb.astm");
    assert_eq!(
        (data.format, &data.components[0].channels),
        (Format::ASTM, &ChannelSet::Rgb)
    );
    for (theta_i, theta_o, phi) in [(20.0, 15.0, 45.0), (40.0, 30.0, 270.0), (60.0, 75.0, 180.0)] {
        let f = iso(f64::to_radians(theta_i), f64::to_radians(theta_o), f64::to_radians(phi));
        for turn in [0.0, 100.0] {
            let evaluated = data
                .eval(&degrees(theta_i, turn), &degrees(theta_o, phi + turn))
                .unwrap();
            assert_eq!(evaluated.placement, Placement::OnNode);
            for (found, share) in evaluated.values.iter().zip([1.0, 0.5, 0.25]) {
                assert!((found - share * f).abs() < 3e-4, "{found} {f}");
            }
        }
    }
    let between = data.eval(&degrees(30.0, 0.0), &degrees(20.0, 10.0)).unwrap();
    assert_eq!(between.placement, Placement::Interpolated);
    assert!((between.values[0] - iso(30f64.to_radians(), 20f64.to_radians(), 10f64.to_radians())).abs() < 5e-3);
    assert_eq!(data.eval(&degrees(70.0, 0.0), &degrees(20.0, 10.0)), None);
}

#[test]
fn degrees_in_astm_are_never_guessed() {
    let text = b"VARS theta_i,phi_i,theta_s,phi_s,BRDF\n0,0,0,0,0.1\n30,0,0,0,0.1\n30,0,45,0,0.2\n";
    let error = parse("x.astm", text, &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("--degrees"), "{error}");
    let options = ReadOptions {
        angle_unit: Some(AngleUnit::Degrees),
        ..Default::default()
    };
    let data = parse("x.astm", text, &options).unwrap();
    assert!((bsdf(&data, &degrees(30.0, 0.0), &degrees(45.0, 0.0))[0] - 0.2).abs() < 1e-12);
}

#[test]
fn lambertian_files_are_lambertian_everywhere() {
    let rho = 0.5 * FRAC_1_PI;
    // RGL values are f cos θ in single precision, linear between nodes; the tolerance is theirs.
    for (name, expected, tolerance) in [
        ("rgl_lambert_rgb.bsdf", vec![rho, 0.5 * rho, 0.25 * rho], 0.02 * rho),
        (
            "rgl_lambert_spec.bsdf",
            [0.4, 0.6, 0.8, 1.0].map(|share| share * rho).to_vec(),
            0.02 * rho,
        ),
        ("klems_full_lambert_0p1.xml", vec![0.1], 1e-12),
        ("ttree4_lambert_0p1.xml", vec![0.1], 1e-12),
        ("lbgen_lambert_mono.ddr", vec![FRAC_1_PI], 1e-12),
    ] {
        let data = load(name);
        assert_eq!(data.components[0].channels.count(), expected.len());
        for (theta_i, theta_o, phi) in [
            (0.0, 0.0, 0.0),
            (10.0, 32.0, 100.0),
            (33.0, 51.0, 170.0),
            (60.0, 40.0, 300.0),
        ] {
            let found = bsdf(&data, &degrees(theta_i, 0.0), &degrees(theta_o, phi));
            for (f, e) in found.iter().zip(&expected) {
                assert!((f - e).abs() < tolerance, "{name} {theta_i} {theta_o} {phi}: {found:?}");
            }
        }
    }
}

/// Nodes of the file hold f cos θ exactly (0.5/π in single precision).
#[test]
fn rgl_nodes_are_on_the_grid() {
    let data = load("rgl_lambert_spec.bsdf");
    let Table::Warped(table) = &data.components[0].table else {
        panic!("{:?}", data.components[0].table)
    };
    assert!(table.is_unwarped() && table.size() == 24);
    let node = |k: usize| k as f64 / 23.0;
    let half = direction(node(7).powi(2) * PI / 2.0, node(4) * 2.0 * PI - PI);
    let omega_in = degrees(20.0, 0.0);
    let omega_out = half * (2.0 * half.dot(&omega_in)) - omega_in;
    let found = data.eval(&omega_in, &omega_out).unwrap();
    assert_eq!(found.placement, Placement::OnNode);
    for (f, share) in found.bsdf().unwrap().iter().zip([0.4, 0.6, 0.8, 1.0]) {
        assert!((f - share * 0.5 * FRAC_1_PI).abs() < 1e-6, "{f}");
    }
}

fn merl_bytes() -> Vec<u8> {
    let packed = std::fs::read(golden("merl_lambert_rho0p5.binary.xz")).unwrap();
    let mut bytes = Vec::new();
    lzma_rs::xz_decompress(&mut packed.as_slice(), &mut bytes).unwrap();
    bytes
}

#[test]
fn merl_is_lambertian_up_to_the_horizon_and_quick_to_read() {
    let bytes = merl_bytes();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("material.any-name");
    std::fs::write(&path, &bytes).unwrap();
    let timed = || {
        let start = std::time::Instant::now();
        let data = read(&path, &ReadOptions::default()).unwrap();
        (start.elapsed(), data)
    };
    let mut runs: Vec<_> = (0..9).map(|_| timed()).collect();
    runs.sort_by_key(|(time, _)| *time);
    println!(
        "MERL read in {:?}, the median of 9, the shortest {:?}",
        runs[4].0, runs[0].0
    );
    let (_, data) = runs.swap_remove(0);
    for (theta_i, theta_o, phi) in [
        (0.0, 0.0, 0.0),
        (30.0, 45.0, 77.0),
        (80.0, 85.0, 180.0),
        (60.0, 88.0, 3.0),
    ] {
        let found = bsdf(&data, &degrees(theta_i, 0.0), &degrees(theta_o, phi));
        for (f, share) in found.iter().zip([1.0, 0.5, 0.25]) {
            assert!((f - share * 0.5 * FRAC_1_PI).abs() < 1e-12, "{found:?}");
        }
    }
    let cut = parse("x", &bytes[..bytes.len() - 8], &ReadOptions::default()).unwrap_err();
    assert!(cut.to_string().contains("34992012"), "{cut}");
}

/// The layout: red (1024 θi + 16 φi + 2 θv + φv/32)/8192 of the indices, green half, blue a quarter of it.
#[test]
fn utia_numbers_stay_raw_until_a_scale_is_given() {
    let mut bytes = Vec::new();
    for share in [1.0, 0.5, 0.25] {
        for (ti, pi, tv, pv) in (0..6 * 48 * 6 * 48).map(|i| (i / 13824, i / 288 % 48, i / 48 % 6, i % 48)) {
            let code = f64::from(1024 * ti + 16 * pi + 2 * tv) + 0.03125 * f64::from(pv);
            bytes.extend((share * code / 8192.0_f64).to_le_bytes());
        }
    }
    let raw = parse("x", &bytes, &ReadOptions::default()).unwrap();
    let at = (degrees(45.0, 75.0), degrees(30.0, 322.5));
    let code = (1024.0 * 3.0 + 16.0 * 10.0 + 2.0 * 2.0 + 0.03125 * 43.0) / 8192.0;
    let found = raw.eval(&at.0, &at.1).unwrap();
    assert_eq!((found.quantity, found.bsdf()), (Quantity::Unscaled, None));
    assert!((found.values[0] - code).abs() < 1e-9 && (found.values[2] - code / 4.0).abs() < 1e-9);
    let options = ReadOptions {
        scale: Some(0.1),
        ..Default::default()
    };
    let scaled = parse("x", &bytes, &options).unwrap();
    assert!((bsdf(&scaled, &at.0, &at.1)[1] - 0.05 * code).abs() < 1e-9);
    // Whatever the first byte of the first number is.
    for first in *b"<[" {
        let mut other = bytes.clone();
        other[0] = first;
        assert_eq!(
            parse("x", &other, &ReadOptions::default()).unwrap().format,
            Format::UTIA
        );
    }
    // Nothing is stored above 75 degrees; the circle closes after 352.5.
    assert_eq!(raw.eval(&degrees(80.0, 0.0), &at.1), None);
    assert!(raw.eval(&degrees(45.0, 357.0), &at.1).is_some());
}

#[test]
fn specular_files_hold_fractions() {
    let reflection = load("spec_rgb.sdr");
    let transmission = load("spec_bw.sdt");
    for (data, scatter, at_45) in [
        (&reflection, Scatter::Reflection, vec![0.05, 0.05, 0.04]),
        (&transmission, Scatter::Transmission, vec![0.85]),
    ] {
        let component = &data.components[0];
        assert_eq!((component.scatter, component.quantity), (scatter, Quantity::Fraction));
        let Table::Specular(table) = &component.table else {
            panic!("{:?}", component.table)
        };
        assert_eq!(table.fraction(45f64.to_radians(), 1.0).unwrap(), at_45);
        assert_eq!(component.eval(&degrees(0.0, 0.0), &degrees(0.0, 0.0)), None);
    }
}

/// Quantity, scatter and symmetry come from the file, and the blocks of one file are kept apart.
#[test]
fn types_are_told_apart() {
    let of = |name: &str| {
        let data = load(name);
        let c = &data.components[0];
        (data.format, c.scatter, c.quantity, c.is_isotropic())
    };
    use Quantity::{BrightnessFactor, Bsdf, BsdfCosine};
    use Scatter::{Reflection, Transmission};
    assert_eq!(of("dir_iso_bw.ddr"), (Format::DDR, Reflection, BrightnessFactor, true));
    assert_eq!(
        of("dir_aniso_rgb.ddr"),
        (Format::DDR, Reflection, BrightnessFactor, false)
    );
    assert_eq!(
        of("dir_btdf_sigmat_bw.ddt"),
        (Format::DDR, Transmission, BrightnessFactor, true)
    );
    assert_eq!(of("rgl_lambert_rgb.bsdf"), (Format::RGL, Reflection, BsdfCosine, true));
    assert_eq!(of("dir_plane_mono_zemax.bsdf"), (Format::ZEMAX, Reflection, Bsdf, true));
    assert_eq!(
        of("dir_asym_mono_lighttools.bsdf"),
        (Format::LIGHT_TOOLS, Reflection, Bsdf, true)
    );
    let both = load("lbgen_lambert_bsdf_mono.ssdd");
    assert_eq!(both.components.len(), 2);
    for scatter in [Reflection, Transmission] {
        let component = both.component(scatter, Side::Front).unwrap();
        let beyond = if scatter == Reflection { 40.0 } else { 140.0 };
        assert!(
            (component
                .eval(&degrees(30.0, 0.0), &degrees(beyond, 20.0))
                .unwrap()
                .values[0]
                - FRAC_1_PI)
                .abs()
                < 1e-5
        );
        assert_eq!(
            component.eval(&degrees(30.0, 0.0), &degrees(180.0 - beyond, 20.0)),
            None
        );
    }
}

/// Directional-hemispherical reflectance of the Lambertian of reflectance 1, to the 6 digits of the file.
#[test]
fn reflectances_integrate() {
    for (name, expected) in [
        ("lbgen_lambert_mono.ddr", 1.0),
        ("klems_full_lambert_0p1.xml", 0.1 * PI),
    ] {
        let data = load(name);
        let found = data.components[0].directional_hemispherical(0.5, 0.0).unwrap();
        assert!((found.values[0] - expected).abs() < 1e-5, "{name}: {found:?}");
        assert_eq!(found.measured, 1.0);
    }
}

/// The test function of the `dir_*` files, written here in the two SSDD parameter types no golden file has.
#[test]
fn half_difference_and_distorted_parameters() {
    let list = |step: f64, last: f64| {
        (0..=(last / step) as u32)
            .map(|i| f64::from(i) * step)
            .collect::<Vec<_>>()
    };
    let words = |list: &[f64]| list.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
    let at = (degrees(30.0, 0.0), degrees(40.0, 110.0));
    let (half, distorted) = (
        "half_difference_coordinate_system",
        "distorted_spherical_coordinate_system",
    );
    for name in [half, distorted] {
        let axes = [list(10.0, 90.0), list(10.0, 90.0), list(30.0, 360.0)];
        let mut text = format!(
            "VERSION 0.3\nDATA_TYPE brdf\nCOLOR_MODEL monochrome\nPARAM_TYPE {name}\nPARAM0_LIST {}\nPARAM2_LIST {}\n\
             PARAM3_LIST {}\nDATA ascii\n",
            words(&axes[0]),
            words(&axes[1]),
            words(&axes[2])
        );
        for p3 in &axes[2] {
            for p2 in &axes[1] {
                for p0 in &axes[0] {
                    let [p0, p2, p3] = [p0, p2, p3].map(|a| a.to_radians());
                    // Directions from the angles, as the format defines them.
                    let (omega_in, omega_out) = if name == half {
                        let h = direction(p0, 0.0);
                        let d = direction(p2, p3);
                        let omega_in = Vec3::new(p0.cos() * d.x + p0.sin() * d.z, d.y, p0.cos() * d.z - p0.sin() * d.x);
                        (omega_in, h * (2.0 * h.dot(&omega_in)) - omega_in)
                    } else {
                        let r = p2 / (PI / 2.0);
                        let x = r * p3.cos() - (1.0 - r) * p0 / (PI / 2.0);
                        let y = r * p3.sin();
                        (direction(p0, 0.0), direction(x.hypot(y) * PI / 2.0, y.atan2(x)))
                    };
                    let f = 0.4 + 0.1 * omega_in.z + 0.05 * omega_out.z + 0.03 * omega_in.dot(&omega_out);
                    text += &format!("{f}\n");
                }
            }
        }
        let data = parse("x.ssdd", text.as_bytes(), &ReadOptions::default()).unwrap();
        let Table::Grid(grid) = &data.components[0].table else {
            panic!("no grid")
        };
        assert_eq!(*grid.parameters() == Parameters::HalfDifference, name == half);
        let found = bsdf(&data, &at.0, &at.1)[0];
        let f = 0.4 + 0.1 * at.0.z + 0.05 * at.1.z + 0.03 * at.0.dot(&at.1);
        assert!((found - f).abs() < 2e-3, "{name}: {found} {f}");
    }
}

/// `Relative` tables get the reflectance their factors state; `Intensity` holds the cosine.
#[test]
fn relative_and_intensity_tables() {
    let file = |data: &str, factor: &str, value: f64| {
        let row = vec![value.to_string(); 3].join(" ");
        format!(
            "Source Generated\nTypeSym PlaneSymmetrical\nTypeColorModel BW\nTypeData {data}\nsigma 2\n 0 60\nphi 3\n 0 \
             90 180\ntheta 3\n 0 90 180\nbw\n{factor} def\n{}enddef\n",
            format!("{row}\n").repeat(6)
        )
    };
    let at = (degrees(60.0, 0.0), degrees(30.0, 100.0));
    let value = |text: String| {
        parse("x.ddr", text.as_bytes(), &ReadOptions::default())
            .unwrap()
            .eval(&at.0, &at.1)
            .unwrap()
    };
    let relative = value(file("Luminance Relative", "kbdf 0.25 0.5", 7.0));
    assert!(
        (relative.brightness_factor().unwrap()[0] - 0.5).abs() < 1e-4,
        "{relative:?}"
    );
    let intensity = parse(
        "x.ddr",
        file("Intensity Absolute", "kbdf 1 2", 0.1).as_bytes(),
        &ReadOptions::default(),
    );
    let mirror = intensity.unwrap().eval(&at.0, &degrees(60.0, 180.0)).unwrap();
    assert_eq!((mirror.quantity, mirror.placement), (Quantity::Bsdf, Placement::OnNode));
    assert!((mirror.bsdf().unwrap()[0] - 0.2 / 60f64.to_radians().cos()).abs() < 1e-12);
    assert_eq!(value(file("Luminance Relative", "", 7.0)).bsdf(), None);
}

/// A table behind a warp, anisotropic, with the Jacobian's factor, as Mitsuba 3 evaluates it in single precision.
#[test]
fn warped_tables_have_the_values_of_mitsuba() {
    let data = load("rgl_warped_rgb.bsdf");
    assert!(!data.components[0].is_isotropic());
    let text = std::fs::read_to_string(golden("rgl_warped_expected.tsv")).unwrap();
    let mut worst = 0.0f64;
    for line in text.lines().skip(2) {
        let v: Vec<f64> = line.split('\t').map(|word| word.parse().unwrap()).collect();
        let found = data
            .eval(&Vec3::new(v[0], v[1], v[2]), &Vec3::new(v[3], v[4], v[5]))
            .unwrap();
        for (f, e) in found.values.iter().zip(&v[6..]) {
            worst = worst.max((f - e).abs());
        }
    }
    println!("worst {worst:e}");
    assert!(worst < 1e-5, "{worst:e}");
}
