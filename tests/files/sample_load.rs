//! Built-in samples, a user's samples, and everything a file can get wrong.

use std::fs;
use std::path::Path;

use specval::colour::{ColourSystem, Convention, Illuminant, RgbSpace};
use specval::sample::{Sample, SampleError, SampleKind, SampleNotice, Uncertainty, published_ratios};
use specval::spectrum::WavelengthGrid;

const RGB: &str = "theta_i_deg,theta_v_deg,beta_r,beta_g,beta_b\n";
const SPECTRAL: &str = "theta_i_deg,theta_v_deg,wavelength_nm,beta\n";

/// A bare CSV file in a scratch folder.
fn load(text: impl AsRef<[u8]>) -> Result<Sample, SampleError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cloth.csv");
    fs::write(&path, text).unwrap();
    Sample::load(path.to_str().unwrap())
}

#[test]
fn built_in_samples() {
    for name in ["merl-red-fabric", "merl-red-fabric2"] {
        let sample = Sample::load(name).unwrap();
        assert_eq!(
            (sample.name(), sample.description().kind),
            (name, Some(SampleKind::Fit))
        );
        assert_eq!(sample.uncertainty(), Uncertainty::Relative(0.05));
        assert_eq!(sample.geometries().count(), 81);
        assert!(sample.published_ratios().is_none());
    }
    let sample = Sample::load("merl-red-fabric").unwrap();
    let reading = sample.reading(0.0, 0.0, &Convention::default()).unwrap().unwrap();
    // data.csv, line of 0,0; luminance row of linear sRGB.
    let (r, g, b) = (0.280098, 0.047679, 0.030764);
    let row = [0.21263900587151036, 0.7151686787677559, 0.07219231536073371];
    assert_eq!(reading.beta[..3], [r, g, b]);
    assert!((reading.beta[3] - (row[0] * r + row[1] * g + row[2] * b)).abs() < 1e-15);
    assert!(!reading.interpolated);
    let se = reading.se();
    assert!((se[0] - 0.05 * r).abs() < 1e-17 && (se[2] - 0.05 * b).abs() < 1e-17);
    let y_se = 0.05 * (row[0] * r).hypot(row[1] * g).hypot(row[2] * b);
    assert!((se[3] - y_se).abs() < 1e-15);
    assert!((reading.covariance[0][3] - row[0] * se[0] * se[0]).abs() < 1e-18);
    assert_eq!(reading.covariance[0][1], 0.0);
    let incidences = sample
        .geometries()
        .filter(|g| g.1 == 70.0)
        .map(|g| g.0)
        .collect::<Vec<_>>();
    assert_eq!(incidences, [0.0, 30.0, 60.0]);
    assert_eq!(sample.spectrum(0.0, 0.0), Ok(None));
}

#[test]
fn the_published_ratios() {
    let ratios = published_ratios().unwrap();
    assert_eq!(
        (ratios.real.blue_over_red, ratios.real.green_over_red),
        ([0.08; 2], [0.011; 2])
    );
    assert_eq!(
        (ratios.model.blue_over_red, ratios.model.green_over_red),
        ([0.05, 0.25], [0.001, 0.017])
    );
    let cotton = Sample::load("voloboy2008-cotton").unwrap();
    assert_eq!(cotton.published_ratios(), Some(&ratios));
    assert_eq!(cotton.reading(0.0, 0.0, &Convention::default()), Ok(None));
    assert_eq!(cotton.geometries().count(), 0);
}

#[test]
fn readings_are_interpolated_between_views_but_not_extrapolated() {
    let convention = Convention::default();
    let text = format!("{RGB}0,10,0.4,0.2,0.1\n0,0,0.2,0.1,0.1\n30,0,9,9,9\n");
    let sample = load(
        text.replace("beta_b\n", "beta_b,beta_r_se,beta_g_se,beta_b_se\n")
            .replace("0.1\n", "0.1,0.03,0.02,0.01\n")
            .replace("9,9,9\n", "9,9,9,0,0,0\n"),
    )
    .unwrap();
    assert_eq!(sample.uncertainty(), Uncertainty::Columns);
    let reading = sample.reading(0.0, 2.5, &convention).unwrap().unwrap();
    assert!(reading.interpolated);
    assert!((reading.beta[0] - 0.25).abs() < 1e-16 && (reading.beta[1] - 0.125).abs() < 1e-16);
    assert!((reading.se()[0] - 0.03 * 0.75f64.hypot(0.25)).abs() < 1e-16);
    assert!(
        !sample
            .reading(0.0, 10.0 + 1e-12, &convention)
            .unwrap()
            .unwrap()
            .interpolated
    );
    // An encoder's noise about the last view and the incidence.
    for (i, v, red) in [(0.0, 10.2, 0.4), (0.1, -0.2, 0.2)] {
        assert_eq!(
            sample.reading(i, v, &convention).unwrap().unwrap().beta[0],
            red,
            "{i} {v}"
        );
    }
    for (i, v) in [(0.0, 10.3), (0.0, -0.3), (30.0, 1.0), (15.0, 0.0), (0.0, f64::NAN)] {
        assert_eq!(sample.reading(i, v, &convention), Ok(None), "{i} {v}");
    }
}

#[test]
fn spectral_data_go_through_the_one_conversion() {
    let grid = WavelengthGrid::preprint();
    let beta = |nm: f64, v: f64| 0.02 + 0.5 * ((nm - 390.0) / 340.0).powi(3) + 0.001 * v;
    // Rows in an order nobody would choose.
    let mut text = "# spectral\n".to_owned() + SPECTRAL.trim_end() + ",beta_se\n";
    for nm in grid.nm().iter().rev() {
        for v in [20.0, 0.0] {
            text += &format!("0,{v},{nm},{},{}\n", beta(*nm, v), 0.01);
        }
    }
    let sample = load(&text).unwrap();
    for convention in [
        Convention::default(),
        Convention {
            illuminant: Illuminant::E,
            rgb: RgbSpace::Ntsc,
            ..Convention::default()
        },
    ] {
        let system = ColourSystem::new(&grid, convention.clone()).unwrap();
        for (v, interpolated) in [(0.0, false), (20.0, false), (15.0, true)] {
            let spectrum = sample.spectrum(0.0, v).unwrap().unwrap();
            for (nm, found) in grid.nm().iter().zip(spectrum.values()) {
                assert!((found - beta(*nm, v)).abs() < 1e-15);
            }
            let colour = system.convert(spectrum.values());
            let reading = sample.reading(0.0, v, &convention).unwrap().unwrap();
            assert_eq!(reading.beta[..3], colour.linear_rgb.0);
            assert_eq!((reading.beta[3], reading.interpolated), (colour.xyz.y, interpolated));
        }
        // Standard error of Y by the definition: 0.01 k sqrt(sum of (S ybar)^2).
        let weights = system.channel_weights();
        let y_se = 0.01 * weights.iter().map(|w| w[3] * w[3]).sum::<f64>().sqrt();
        let reading = sample.reading(0.0, 0.0, &convention).unwrap().unwrap();
        assert!((reading.se()[3] - y_se).abs() < 1e-16);
        // Without adaptation Y is the luminance of the RGB values, so the covariance has to know it too.
        let row = convention.rgb.luminance_row();
        let through_rgb: f64 = (0..3).map(|j| row[j] * reading.covariance[0][j]).sum();
        assert!((through_rgb - reading.covariance[0][3]).abs() < 1e-15);
    }
}

#[test]
fn layouts_and_names_of_instruments_are_read_alike() {
    let long = load(format!("{SPECTRAL}30,-10,450,0.1\n30,-10,550,0.2\n30,-10,650,0.3\n")).unwrap();
    assert!(long.notices().is_empty());
    for text in [
        "theta_i_deg,theta_v_deg,450,550,650,850\n30,-10,0.1,0.2,0.3,0.9\n",
        "theta_i_deg,theta_v_deg,R650,R550,R450\n30,-10,0.3,0.2,0.1\n",
        "Theta_i (deg),Viewing angle,450 nm,550nm,beta_650\n30,-10,0.1,0.2,0.3\n",
        "incidence,theta_r,wavelength,reflectance\n30,-10,450,0.1\n30,-10,550,0.2\n30,-10,650,0.3\n30,-10,900,1\n",
    ] {
        let sample = load(text).unwrap();
        assert_eq!(sample.wavelengths_nm(), long.wavelengths_nm(), "{text}");
        assert!(sample.raw().eq(long.raw()), "{text}");
    }
    let renamed = load("incidence,theta_r,450,550\n30,10,0.1,0.2\n30,20,0.1,0.2\n").unwrap();
    let notice = renamed.notices()[0].to_string();
    assert!(
        notice.contains("'theta_r' as theta_v_deg") && notice.contains("mirror side"),
        "{notice}"
    );
}

#[test]
fn noise_below_zero_is_read_and_wrong_units_are_noticed() {
    let sample = load(format!("{SPECTRAL}0,0,450,-0.002\n0,0,550,0.4\n")).unwrap();
    assert_eq!(sample.raw().next().unwrap().beta, [-0.002, 0.4]);
    assert_eq!(
        sample.notices()[0],
        SampleNotice::NegativeValues {
            count: 1,
            lowest: -0.002
        }
    );
    let told = |text: String, words: &str| {
        let sample = load(text).unwrap();
        let notices: String = sample.notices().iter().map(ToString::to_string).collect();
        assert!(notices.contains(words), "{notices}");
    };
    told(format!("{RGB}0,0,40,20,30\n0,10,41,21,31\n"), "per cent");
    told(
        format!("{RGB}0,-0.52,0.4,0.2,0.3\n0,0,0.4,0.2,0.3\n0,1.05,0.4,0.2,0.3\n"),
        "radians",
    );
    let message = load(format!("{SPECTRAL}0,0,0.45,1\n")).unwrap_err().to_string();
    assert!(message.contains("micrometres: multiply"), "{message}");
}

#[test]
fn angles_as_an_encoder_reads_them_are_the_nominal_ones() {
    let sample = load(format!(
        "{RGB}0.02,-0.01,0.4,0.2,0.3\n-0.01,5.03,0.4,0.2,0.3\n30.1,4.98,0.1,0.1,0.1\n29.95,5.02,0.3,0.1,0.1\n"
    ));
    let sample = sample.unwrap();
    assert_eq!(
        sample.geometries().collect::<Vec<_>>(),
        [(0.0, 0.0), (0.0, 5.0), (30.0, 5.0)]
    );
    let read = sample.angles_read();
    assert_eq!((read.moved, read.combined), (4, 2));
    let reading = sample.reading(30.0, 5.0, &Convention::default()).unwrap().unwrap();
    assert!((reading.beta[0] - 0.2).abs() < 1e-15 && !reading.interpolated);
}

/// An encoder that is read anew at each wavelength: a geometry has its mean angles, and other geometries stay apart.
#[test]
fn angles_read_anew_at_each_wavelength_are_one_geometry() {
    let mut text = SPECTRAL.to_owned();
    for (k, nm) in (400..=700).step_by(20).enumerate() {
        for (view, beta) in [(-30.0, 0.2), (0.0, 0.4), (30.0, 0.3)] {
            let off = 0.02 * ((k * 7 % 5) as f64 / 2.0 - 1.0);
            text += &format!("{:.3},{:.3},{nm},{beta}\n", 45.0 + off, view - off);
        }
    }
    let sample = load(&text).unwrap();
    let read: Vec<(f64, f64, f64, usize)> = sample
        .raw()
        .map(|r| (r.theta_i_deg, r.theta_v_deg, r.beta[3], r.beta.len()))
        .collect();
    let due = [(45.0, -30.0, 0.2, 16), (45.0, 0.0, 0.4, 16), (45.0, 30.0, 0.3, 16)];
    assert_eq!(read, due);
    let told = sample
        .notices()
        .iter()
        .any(|notice| matches!(notice, SampleNotice::AnglesOfWavelengths { largest_deg } if *largest_deg < 0.05));
    assert!(told, "{:?}", sample.notices());
    // Half a degree is another geometry.
    let apart = format!("{SPECTRAL}45,0,400,0.1\n45,0,500,0.1\n45,0.5,400,0.1\n45.5,0,500,0.1\n");
    assert!(
        load(apart)
            .unwrap_err()
            .to_string()
            .contains("the 2 wavelengths of theta_i_deg 45")
    );
}

#[test]
fn bare_file_has_no_description() {
    let sample = load(format!("{RGB}0,0,0.2,0.1,0.1\n")).unwrap();
    assert_eq!((sample.name(), sample.description().kind), ("cloth", None));
    assert_eq!(sample.uncertainty(), Uncertainty::NotStated);
    assert_eq!(
        sample.reading(0.0, 0.0, &Convention::default()).unwrap().unwrap().se(),
        [0.0; 4]
    );
}

#[test]
fn digest_is_of_the_file_bytes() {
    // SHA-256 of the text, by sha256sum.
    let sample = load("theta_i_deg,theta_v_deg,beta_r,beta_g,beta_b\n0,0,1,1,1\n").unwrap();
    assert_eq!(
        sample.digest(),
        "00b5b30e5830ad7edfc7816aa05b3a15fae04cecff2be1d7cd096090f3470423"
    );
}

#[test]
fn faults_are_reported_with_their_line() {
    let cases = [
        (String::new(), 1, "header line"),
        ("# nothing but a comment\n".into(), 1, "header line"),
        (RGB.into(), 1, "at least one row"),
        (
            "theta_i_deg,theta_v_deg,beta_r,beta_g\n0,0,1,1\n".into(),
            1,
            "a column beta_b",
        ),
        (
            "theta_i_deg,theta_v_deg,wavelength_nm\n0,0,500\n".into(),
            1,
            "a column beta",
        ),
        (
            "theta_i (rad),theta_v_deg,beta_r,beta_g,beta_b\n0,0,1,1,1\n".into(),
            1,
            "angles in degrees",
        ),
        (
            "theta_i_deg,theta_v_deg,0.45,0.55\n0,0,1,1\n".into(),
            1,
            "wavelengths in nm",
        ),
        (
            RGB.replace("beta_b", "beta_b,note") + "0,0,1,1,1,x\n",
            1,
            "only the columns",
        ),
        (
            RGB.replace("beta_b", "beta_b,beta_r_se") + "0,0,1,1,1,0\n",
            1,
            "a column beta_g_se",
        ),
        (format!("{RGB}0,0,1,1,1\n0,5,1,NaN,1\n"), 3, "brightness factor"),
        (format!("{RGB}0,0,1,1,\n"), 2, "brightness factor"),
        (format!("{RGB}0,0,1,1,inf\n"), 2, "brightness factor"),
        (format!("{RGB}0,0,1,-0.06,1\n"), 2, "0 or more"),
        (format!("# c\n\n{RGB}90,0,1,1,1\n"), 4, "below 90"),
        (format!("{RGB}-30,0,1,1,1\n"), 2, "below 90"),
        (format!("{RGB}0,-90,1,1,1\n"), 2, "below 90"),
        (format!("{RGB}0,90,1,1,1\n"), 2, "below 90"),
        (
            format!("{RGB}0,0,1,1,1\n0,5,1,1,1\n0,-0,1,1,0.9\n"),
            4,
            "every geometry once",
        ),
        (format!("{RGB}0,0,1,1\n"), 2, "5 values"),
        (format!("{SPECTRAL}0,0,500,1\n0,0,500,0.9\n"), 3, "every geometry once"),
        (
            format!("{SPECTRAL}0,0,500,1\n0,0,600,1\n0,5,500,1\n0,5,610,1\n"),
            4,
            "the 2 wavelengths",
        ),
        (
            format!("{SPECTRAL}0,0,500,1\n0,0,600,1\n0,5,500,1\n"),
            4,
            "the 2 wavelengths",
        ),
        (format!("{SPECTRAL}0,0,500,1\n0,0,0.79,1\n"), 3, "360..780"),
        (format!("{SPECTRAL}0,0,800,1\n0,0,900,1\n"), 2, "360..780"),
        (format!("{SPECTRAL}0,0,500,-0.1\n"), 2, "0 or more"),
        (
            SPECTRAL.replace("beta", "beta,beta_se") + "0,0,500,0.1,-1\n",
            2,
            "standard error",
        ),
    ];
    for (text, line, expected) in cases {
        match load(&text) {
            Err(SampleError::Csv(e)) => {
                assert_eq!(e.line, line, "{text:?}: {e}");
                assert!(e.expected.contains(expected), "{text:?}: {e}");
                assert!(e.name.ends_with("cloth.csv"), "{e}");
            }
            other => panic!("{text:?}: {other:?}"),
        }
    }
    let message = load(format!("{RGB}0,95,1,1,1\n")).unwrap_err().to_string();
    assert!(
        message.ends_with(
            "cloth.csv, line 2, column theta_v_deg: expected a signed view angle in degrees, above -90 and below 90, \
             found 95; check the unit and the column; readings are of reflection alone, with the view above the cloth"
        ),
        "{message}"
    );
    for (junk, words) in [
        (
            &b"\x89PNG\r\n\x1a\n\0\0"[..],
            "expected a table as text, found an image",
        ),
        (&[0u8; 64], "text in UTF-8"),
        (&[0xff; 64], "text in UTF-8"),
        (b"theta_i_deg\0", "text in UTF-8"),
    ] {
        let message = load(junk).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn a_folder_needs_both_files_and_a_sound_description() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_str().unwrap();
    let missing = |expected: &str| match Sample::load(path) {
        Err(SampleError::Incomplete { missing, .. }) => assert_eq!(missing, expected),
        other => panic!("{other:?}"),
    };
    missing("sample.toml");
    let good = "name = \"mine\"\nsource = \"my rig\"\nlicence = \"CC0\"\nkind = \"measured\"\n";
    fs::write(folder.path().join("sample.toml"), good).unwrap();
    missing("data.csv");
    fs::write(folder.path().join("data.csv"), format!("{RGB}0,0,0.2,0.1,0.1\n")).unwrap();
    assert_eq!(Sample::load(path).unwrap().name(), "mine");
    for bad in [
        "name = 1\n".to_owned(),
        good.replace("measured", "guessed"),
        good.replace("kind = \"measured\"\n", ""),
        good.to_owned() + "sauce = \"ketchup\"\n",
        good.to_owned() + "relative_standard_uncertainty = 5\n",
        good.to_owned() + "relative_standard_uncertainty = nan\n",
    ] {
        fs::write(folder.path().join("sample.toml"), &bad).unwrap();
        let error = Sample::load(path).unwrap_err();
        assert!(matches!(error, SampleError::Description { .. }), "{bad}: {error}");
        assert!(error.to_string().contains("sample.toml"), "{error}");
    }
    fs::write(folder.path().join("sample.toml"), b"\xff\xfe").unwrap();
    assert!(matches!(Sample::load(path), Err(SampleError::Description { .. })));
}

#[test]
fn an_unknown_sample_lists_the_built_in_ones() {
    let message = Sample::load("merl-red-fabrik").unwrap_err().to_string();
    assert!(message.contains("did you mean 'merl-red-fabric'?"), "{message}");
    assert!(
        message.contains("voloboy2008-cotton") && message.contains("nor is there a file"),
        "{message}"
    );
    assert!(Sample::load("").is_err());
    assert!(!Path::new("merl-red-fabric").exists());
}
