//! What is written reads back, and says what it could not hold.

use specval::formats::{
    ChannelSet, Format, Goniometric, ReadOptions, Scatter, Side, Table, WriteError, WriteNotice, WriteOptions,
    direction, parse, write,
};
use specval::geometry::Vec3;

use crate::golden::load;

fn degrees(theta: f64, phi: f64) -> Vec3 {
    direction(theta.to_radians(), phi.to_radians())
}

/// Written and read again, by a name that tells transmission.
fn again(data: &Goniometric, format: Format) -> (Goniometric, Vec<WriteNotice>) {
    let written = write(data, format, &WriteOptions::default()).unwrap();
    let transmission = data.components.iter().all(|c| c.scatter == Scatter::Transmission);
    let name = match (format, transmission) {
        (Format::DDR, true) => "x.ddt",
        (Format::DDR, false) => "x.ddr",
        (Format::SDR, true) => "x.sdt",
        (Format::SDR, false) => "x.sdr",
        (_, true) => "x.btdf.astm",
        (_, false) => "x.astm",
    };
    let read = parse(name, &written.bytes, &ReadOptions::default()).unwrap();
    assert_eq!(read.format, format);
    (read, written.notices)
}

fn again_as(data: &Goniometric, format: Format, name: &str) -> (Goniometric, Vec<WriteNotice>) {
    let written = write(data, format, &WriteOptions::default()).unwrap();
    (
        parse(name, &written.bytes, &ReadOptions::default()).unwrap(),
        written.notices,
    )
}

/// Pairs of directions within the ranges of the golden files.
fn pairs(beyond: bool) -> Vec<(Vec3, Vec3)> {
    let theta_o = |t: f64| if beyond { 180.0 - t } else { t };
    [
        (0.0, 0.0, 10.0, 40.0),
        (20.0, 0.0, 15.0, 45.0),
        (40.0, 90.0, 33.0, 200.0),
        (55.0, 10.0, 61.0, 313.0),
    ]
    .map(|(ti, pi, to, po)| (degrees(ti, pi), degrees(theta_o(to), po)))
    .to_vec()
}

/// Largest deviation of f between two files, relative to the largest f.
fn deviation(a: &Goniometric, b: &Goniometric, beyond: bool) -> f64 {
    let mut worst = 0.0f64;
    for (omega_in, omega_out) in pairs(beyond) {
        let (fa, fb) = (
            a.eval(&omega_in, &omega_out).unwrap(),
            b.eval(&omega_in, &omega_out).unwrap(),
        );
        let (fa, fb) = (fa.bsdf().unwrap(), fb.bsdf().unwrap());
        assert_eq!(fa.len(), fb.len());
        let scale = fa.iter().copied().fold(0.0, f64::max);
        for (x, y) in fa.iter().zip(fb) {
            worst = worst.max((x - y).abs() / scale);
        }
    }
    worst
}

/// Formats whose own tables pass through unchanged, to the precision of their numbers.
#[test]
fn a_format_reads_what_it_wrote() {
    for (name, format, tolerance) in [
        ("dir_iso_rgb.ddr", Format::DDR, 1e-9),
        ("dir_plane_bw.ddr", Format::DDR, 1e-9),
        ("dir_aniso_rgb.ddr", Format::DDR, 1e-9),
        ("libbsdf_iso_spectral7.ddr", Format::DDR, 1e-9),
        ("dir_btdf_sigmat_bw.ddt", Format::DDR, 1e-9),
        ("dir_spherical_bw.ssdd", Format::SSDD, 1e-9),
        ("dir_specular_aniso_rgb.ssdd", Format::SSDD, 1e-9),
        ("dir_specular_bilateral_xyz.ssdd", Format::SSDD, 1e-9),
        ("dir_specular_spectral7_binary.ssdd", Format::SSDD, 1e-9),
        ("dir_btdf_sigmat_bw.ddt", Format::SSDD, 1e-9),
        ("dir_iso_rgb.ddr", Format::SSDD, 1e-9),
        ("dir_iso_rgb.astm", Format::ASTM, 1e-9),
        ("dir_iso_rgb.astm", Format::CSV, 1e-7),
        ("dir_spherical_bw.ssdd", Format::CSV, 1e-9),
        ("dir_spherical_bw.ssdd", Format::ASTM, 1e-9),
        // Single precision.
        ("rgl_lambert_rgb.bsdf", Format::RGL, 1e-5),
        ("rgl_lambert_spec.bsdf", Format::RGL, 1e-5),
    ] {
        let data = load(name);
        let (back, notices) = again(&data, format);
        let beyond = data.components[0].scatter == Scatter::Transmission;
        let found = deviation(&data, &back, beyond);
        assert!(found < tolerance, "{name} as {format}: {found:e}");
        assert_eq!(data.components[0].channels, back.components[0].channels);
        assert!(notices.is_empty(), "{name} as {format}: {notices:?}");
    }
}

/// Smooth functions resampled: within the linear interpolation of the tables.
#[test]
fn other_formats_hold_resampled_values() {
    for (name, format, tolerance) in [
        ("dir_iso_rgb.astm", Format::DDR, 0.02),
        ("dir_spherical_bw.ssdd", Format::DDR, 0.02),
        ("dir_specular_spectral7_binary.ssdd", Format::ASTM, 0.02),
        ("dir_aniso_rgb.ddr", Format::ASTM, 0.02),
        ("dir_specular_spectral7_binary.ssdd", Format::RGL, 0.02),
        ("dir_aniso_rgb.ddr", Format::RGL, 0.04),
        ("rgl_lambert_spec.bsdf", Format::DDR, 0.02),
        ("klems_full_lambert_0p1.xml", Format::SSDD, 1e-9),
        ("ttree4_lambert_0p1.xml", Format::RADIANCE_XML, 1e-9),
        // Constant on patches of 10 degrees and more.
        ("dir_spherical_bw.ssdd", Format::RADIANCE_XML, 0.05),
    ] {
        let data = load(name);
        let (back, notices) = again(&data, format);
        let found = deviation(&data, &back, false);
        assert!(found < tolerance, "{name} as {format}: {found:e}");
        assert!(notices.contains(&WriteNotice::Resampled), "{notices:?}");
    }
}

#[test]
fn klems_holds_reflection_and_transmission_and_xyz() {
    let both = load("lbgen_lambert_bsdf_mono.ssdd");
    let (back, _) = again(&both, Format::RADIANCE_XML);
    for scatter in [Scatter::Reflection, Scatter::Transmission] {
        let component = back.component(scatter, Side::Front).unwrap();
        let total = component.directional_hemispherical(0.5, 0.0).unwrap().values;
        assert!((total[0] - 1.0).abs() < 1e-6, "{total:?}");
    }
    let spectral = load("dir_specular_spectral7_binary.ssdd");
    let (back, notices) = again(&spectral, Format::RADIANCE_XML);
    assert_eq!(back.components[0].channels, ChannelSet::Xyz);
    assert!(notices.contains(&WriteNotice::SpectraAsXyz), "{notices:?}");
    // What was never measured, incidences beyond 60 degrees, is told.
    assert!(
        notices.iter().any(|n| matches!(n, WriteNotice::Filled { .. })),
        "{notices:?}"
    );
}

#[test]
fn merl_holds_the_isotropic_mean() {
    let aniso = load("dir_aniso_rgb.ddr");
    let (back, notices) = again(&aniso, Format::MERL);
    assert!(
        notices.iter().any(|n| matches!(n, WriteNotice::Isotropic { .. })),
        "{notices:?}"
    );
    // aniso: f = 0.4 + 0.1 in.x + 0.05 in.y + 0.06 out.x - 0.03 out.y + 0.02 out.z in.z, whose mean over turns is
    // 0.4 + 0.02 out.z in.z.
    for (omega_in, omega_out) in pairs(false) {
        let found = back.eval(&omega_in, &omega_out).unwrap().bsdf().unwrap();
        let f = 0.4 + 0.02 * omega_in.z * omega_out.z;
        for (found, share) in found.iter().zip([1.0, 0.5, 0.25]) {
            assert!((found - share * f).abs() < 0.01 * f, "{found} {f}");
        }
    }
}

#[test]
fn specular_fractions_pass_through() {
    for (name, wavelengths) in [("spec_rgb.sdr", 3), ("spec_bw.sdt", 1)] {
        let data = load(name);
        for format in [Format::SDR, Format::SSDD] {
            let (back, _) = again(&data, format);
            let (Table::Specular(a), Table::Specular(b)) = (&data.components[0].table, &back.components[0].table)
            else {
                panic!("no specular table")
            };
            for theta in [0.0, 0.3, 1.5] {
                let found = b.fraction(theta, 0.0).unwrap();
                assert_eq!((a.fraction(theta, 0.0).unwrap(), found.len()), (found, wavelengths));
            }
            assert_eq!(data.components[0].scatter, back.components[0].scatter);
        }
        assert!(matches!(
            write(&data, Format::DDR, &WriteOptions::default()),
            Err(WriteError::CannotHold { .. })
        ));
    }
}

#[test]
fn readings_of_one_plane_fill_no_hemisphere() {
    let text = "theta_i_deg,theta_v_deg,wavelength_nm,beta\n0,-30,500,0.4\n0,-30,600,0.5\n0,30,500,0.6\n0,30,600,0.7\n";
    let data = parse("x.csv", text.as_bytes(), &ReadOptions::default()).unwrap();
    let beta = data
        .eval(&degrees(0.0, 0.0), &degrees(15.0, 0.0))
        .unwrap()
        .brightness_factor()
        .unwrap();
    assert!(
        (beta[0] - 0.55).abs() < 1e-12 && (beta[1] - 0.65).abs() < 1e-12,
        "{beta:?}"
    );
    assert_eq!(data.eval(&degrees(0.0, 0.0), &degrees(15.0, 90.0)), None);
    let written = write(&data, Format::CSV, &WriteOptions::default()).unwrap();
    assert_eq!(parse("x.csv", &written.bytes, &ReadOptions::default()).unwrap(), data);
    assert!(matches!(
        write(&data, Format::RGL, &WriteOptions::default()),
        Err(WriteError::NotMeasured { .. })
    ));
    assert!(matches!(
        write(&data, Format::ZEMAX, &WriteOptions::default()),
        Err(WriteError::NotWritten { .. })
    ));
}

/// Fractions are on the diagonal, and what leaves is what scatters and what goes straight on.
#[test]
fn klems_holds_specular_fractions_on_the_diagonal() {
    let text = "VERSION 0.3\nDATA_TYPE btdf\nCOLOR_MODEL monochrome\nPARAM_TYPE \
                spherical_coordinate_system\nPARAM0_LIST 0 90\nPARAM2_LIST 0 90\nPARAM3_LIST 0 180\nDATA \
                ascii\n0.1\n0.1\n0.1\n0.1\n0.1\n0.1\n0.1\n0.1\nDATA_TYPE specular_transmittance\nCOLOR_MODEL \
                monochrome\nPARAM0_LIST 0 40 70\nDATA ascii\n0.4\n0.4\n0\nDATA_TYPE specular_reflectance\nCOLOR_MODEL \
                monochrome\nPARAM0_LIST 0\nDATA ascii\n0.2\n";
    let data = parse("x.ssdd", text.as_bytes(), &ReadOptions::default()).unwrap();
    let (back, notices) = again_as(&data, Format::RADIANCE_XML, "x.xml");
    assert_eq!(back.components.len(), 1);
    let told = |words: &str| notices.iter().any(|notice| notice.to_string().contains(words));
    assert!(
        told("on the diagonal") && told("left out") && told("beyond the first and last"),
        "{notices:?}"
    );
    for (theta, phi, fraction) in [
        (0.0, 0.0, 0.4),
        (20.0, 70.0, 0.4),
        (30.0, 200.0, 0.4),
        (85.0, 10.0, 0.0),
    ] {
        let omega_in = degrees(theta, phi);
        let total = back.components[0]
            .directional_hemispherical(f64::to_radians(theta), f64::to_radians(phi))
            .unwrap()
            .values;
        let scattered = 0.1 * std::f64::consts::PI;
        assert!(
            (total[0] - scattered - fraction).abs() < 0.01 * (theta / 80.0) + 1e-9,
            "{theta}: {total:?}"
        );
        let straight = back.eval(&omega_in, &(omega_in * -1.0)).unwrap().values[0];
        assert_eq!(straight > 0.2, fraction > 0.0, "{theta}: {straight}");
    }
}

/// Standard errors of a CSV come through a CSV, and between readings are those of independent ones.
#[test]
fn standard_errors_survive() {
    for text in [
        "theta_i_deg,theta_v_deg,wavelength_nm,beta,beta_se\n0,-30,500,0.4,0.04\n0,-30,600,0.5,0.05\n0,30,500,0.6,0.03\n0,30,600,0.7,0\n",
        "theta_i_deg,theta_v_deg,beta_r,beta_g,beta_b,beta_r_se,beta_g_se,beta_b_se\n0,-30,0.4,0.5,0.1,0.04,0.05,0\n0,30,0.6,0.7,0.1,0.03,0,0\n",
        "theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,beta_x,beta_y,beta_z,beta_x_se,beta_y_se,beta_z_se\n0,0,30,0,0.4,0.5,0.1,0.04,0.05,0\n0,0,30,180,0.6,0.7,0.1,0.03,0,0\n",
    ] {
        let data = parse("x.csv", text.as_bytes(), &ReadOptions::default()).unwrap();
        assert!(data.warnings.is_empty(), "{:?}", data.warnings);
        let written = write(&data, Format::CSV, &WriteOptions::default()).unwrap();
        assert_eq!(std::str::from_utf8(&written.bytes).unwrap(), text);
    }
    let half = parse(
        "x.csv",
        b"theta_i_deg,theta_v_deg,beta,beta_se\n0,10,0.4,0.03\n0,30,0.6,0.04\n",
        &ReadOptions::default(),
    )
    .unwrap();
    let (omega_in, omega_out) = (direction(0.0, 0.0), direction(20f64.to_radians(), 0.0));
    let found = half.components[0].standard_errors(&omega_in, &omega_out).unwrap();
    assert!((found[0] - 0.025).abs() < 1e-15, "{found:?}");
    let sphere = parse(
        "x.csv",
        b"theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,beta,beta_se\n0,0,0,0,0.4,0.03\n0,0,90,0,0.6,0.04\n0,0,90,180,0.6,0.04\n",
        &ReadOptions::default(),
    )
    .unwrap();
    for (format, holds) in [
        (Format::CSV, true),
        (Format::ASTM, false),
        (Format::SSDD, false),
        (Format::DDR, false),
        (Format::RGL, false),
        (Format::MERL, false),
        (Format::RADIANCE_XML, false),
    ] {
        let notices = write(&sphere, format, &WriteOptions::default()).unwrap().notices;
        let told = notices.contains(&WriteNotice::ErrorsLeftOut { format });
        assert_eq!(told, !holds, "{format}: {notices:?}");
    }
    for bad in ["beta,beta_r_se", "beta,beta_se,beta_se"] {
        let text = format!("theta_i_deg,theta_v_deg,{bad}\n0,10,0.4,0.03\n");
        assert!(
            parse("x.csv", text.as_bytes(), &ReadOptions::default()).is_err(),
            "{bad}"
        );
    }
    let negative = "theta_i_deg,theta_v_deg,beta,beta_se\n0,10,0.4,-0.03\n";
    assert!(parse("x.csv", negative.as_bytes(), &ReadOptions::default()).is_err());
}

/// MERL from an anisotropic source: at each node the mean over eight turns of what the source has there.
#[test]
fn merl_holds_the_mean_over_turns() {
    let name = "dir_aniso_rgb.ddr";
    let source = load(name);
    let written = write(&source, Format::MERL, &WriteOptions::default()).unwrap();
    let merl = parse("x.binary", &written.bytes, &ReadOptions::default()).unwrap();
    let mut compared = 0;
    for (theta_i, theta_o, phi) in [
        (0.0, 0.0, 0.0),
        (20.0, 0.0, 0.0),
        (20.0, 20.0, 180.0),
        (30.0, 30.0, 180.0),
    ] {
        let toward = |theta: f64, phi: f64| direction(theta.to_radians(), phi.to_radians());
        let Some(found) = merl.eval(&toward(theta_i, 0.0), &toward(theta_o, phi)) else {
            continue;
        };
        let turns = (0..8).map(|turn| 45.0 * f64::from(turn));
        let all: Option<Vec<Vec<f64>>> = turns
            .map(|turn| {
                let pair = (toward(theta_i, turn), toward(theta_o, phi + turn));
                source.eval(&pair.0, &pair.1)?.bsdf()
            })
            .collect();
        let Some(all) = all else { continue };
        for (channel, value) in found.bsdf().unwrap().iter().enumerate() {
            let mean = all.iter().map(|f| f[channel]).sum::<f64>() / 8.0;
            assert!(
                (value - mean).abs() < 1e-12,
                "{name} {theta_i} {theta_o}: {value} {mean}"
            );
        }
        compared += 1;
    }
    assert!(compared > 0);
}

/// The values counted as beyond the source are those alone: a cloth read to 60 degrees from the normal.
#[test]
fn values_beyond_the_source_are_counted_among_all() {
    let mut text = "theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,beta\n".to_owned();
    for theta_i in [0, 15, 30, 45, 60] {
        for theta_o in (0..=60).step_by(5) {
            for phi in (0..360).step_by(15) {
                text += &format!("{theta_i},0,{theta_o},{phi},0.5\n");
            }
        }
    }
    let data = parse("x.csv", text.as_bytes(), &ReadOptions::default()).unwrap();
    let written = write(&data, Format::RADIANCE_XML, &WriteOptions::default()).unwrap();
    let filled = written.notices.iter().find_map(|notice| match notice {
        WriteNotice::Filled { filled, asked } => Some(*filled as f64 / *asked as f64),
        _ => None,
    });
    let share = filled.unwrap();
    // Beyond 60 degrees are the outer rings of Klems' basis: 3 of 9 with 52 of 145 patches of exit, and 52 of
    // incidence.
    assert!((0.3..0.7).contains(&share), "{:?}", written.notices);
}
