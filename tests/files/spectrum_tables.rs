//! Built-in tables against the sources they were taken from, and a user's own spectrum file.

use std::io::Write;

use specval::spectrum::{SpectrumError, WavelengthGrid, read_spectra, read_spectrum, tables};

#[test]
fn observers_and_illuminants_carry_the_cie_values() {
    // CIE 018:2019 and CIE 15:2004, values read off the published tables.
    let two = tables::observer("cie1931-2deg").unwrap();
    assert_eq!(two.y_bar.at(555.0).unwrap(), 1.0);
    assert_eq!(two.x_bar.at(550.0).unwrap(), 0.4334499);
    assert_eq!(two.z_bar.at(450.0).unwrap(), 1.77211);
    let ten = tables::observer("cie1964-10deg").unwrap();
    assert_eq!(ten.z_bar.at(380.0).unwrap(), 0.000704776);
    assert_eq!(tables::illuminant("D65").unwrap().at(390.0).unwrap(), 54.6482);
    assert_eq!(tables::illuminant("D50").unwrap().at(500.0).unwrap(), 95.724);
    assert_eq!(tables::illuminant("C").unwrap().at(450.0).unwrap(), 124.0);
    assert_eq!(tables::illuminant("E").unwrap().at(812.0).unwrap(), 1.0);
    // The CIE rule between tabulated points is linear.
    assert_eq!(
        tables::illuminant("D65").unwrap().at(392.5).unwrap(),
        (54.6482 + 68.7015) / 2.0
    );
}

#[test]
fn illuminant_a_follows_its_formula() {
    let a = tables::illuminant("A").unwrap();
    for nm in (360..=780).step_by(5).map(f64::from) {
        let c2_over_t: f64 = 1.435e7 / 2848.0;
        let formula = 100.0 * (560.0 / nm).powi(5) * ((c2_over_t / 560.0).exp() - 1.0) / ((c2_over_t / nm).exp() - 1.0);
        // Six printed digits: 4e-6 relative.
        assert!((a.at(nm).unwrap() / formula - 1.0).abs() < 4e-6, "{nm}");
    }
}

#[test]
fn every_dye_covers_the_preprint_grid_and_peaks_at_one() {
    let grid = WavelengthGrid::preprint();
    for name in [
        "preprint-red",
        "RR195",
        "RR2",
        "DR28",
        "TURKEY",
        "DR80",
        "RY145",
        "NYLON_KS",
        "NYLON_KS_s2",
    ] {
        let samples = tables::dye(name).unwrap().on(&grid).unwrap();
        let peak = samples.values().iter().copied().fold(0.0, f64::max);
        // The source's RR2 reaches 0.929868 only, as the table's header says.
        let low = if name == "RR2" { 0.92 } else { 1.0 };
        assert!((low..=1.0).contains(&peak), "{name} {peak}");
        assert!(samples.values().iter().all(|v| *v >= 0.0), "{name}");
    }
}

#[test]
fn preprint_red_is_the_formula_of_its_header() {
    let gaussian = |w: f64, centre: f64, width: f64| {
        let sigma = width / (2.0 * (2.0 * 2.0f64.ln()).sqrt());
        (-(w - centre).powi(2) / (2.0 * sigma * sigma)).exp()
    };
    let raw = |w: f64| gaussian(w, 545.0, 60.0) + 1.2 * gaussian(w, 510.0, 80.0) + 1.3 * gaussian(w, 370.0, 100.0);
    let peak = WavelengthGrid::preprint()
        .nm()
        .iter()
        .map(|&w| raw(w))
        .fold(0.0, f64::max);
    let dye = tables::dye("preprint-red").unwrap();
    for nm in (380..=780).step_by(5).map(f64::from) {
        // Nine printed decimals.
        assert!((dye.at(nm).unwrap() - raw(nm) / peak).abs() <= 5.1e-10, "{nm}");
    }
}

#[test]
fn measured_fabrics() {
    assert_eq!(
        tables::reflectance("usgs-nylon-red").unwrap().at(525.0).unwrap(),
        0.028831696
    );
    assert_eq!(
        tables::reflectance("usgs-cotton-white").unwrap().at(440.0).unwrap(),
        0.64400971
    );
}

#[test]
fn an_unknown_name_lists_the_known_and_the_nearest() {
    let message = tables::dye("prepint-red").unwrap_err().to_string();
    assert!(
        message.contains("did you mean 'preprint-red'?") && message.contains("RY145"),
        "{message}"
    );
    assert!(
        tables::observer("1931")
            .unwrap_err()
            .to_string()
            .contains("cie1964-10deg")
    );
    assert!(
        tables::illuminant("D55")
            .unwrap_err()
            .to_string()
            .contains("did you mean 'D65'")
            || tables::illuminant("D55")
                .unwrap_err()
                .to_string()
                .contains("did you mean 'D50'")
    );
    let far = tables::reflectance("xyzzy").unwrap_err().to_string();
    assert!(!far.contains("did you mean"), "{far}");
}

fn file(text: &str) -> tempfile::NamedTempFile {
    let mut file = tempfile::NamedTempFile::new().unwrap();
    file.write_all(text.as_bytes()).unwrap();
    file
}

#[test]
fn a_users_dye_file() {
    let good = file("# my dye\nwavelength_nm,value\n400,0.5\n500,1\n");
    assert_eq!(read_spectrum(good.path(), 0.0..=1.0).unwrap().at(450.0).unwrap(), 0.75);
    let cases = [
        ("wavelength_nm,value\n500,0.1\n500,0.2\n", 3, "above 500 nm"),
        ("wavelength_nm,value\n-500,0.1\n", 2, "above 0 nm"),
        ("wavelength_nm,value\n500,NaN\n", 2, "0..1"),
        ("# c\nwavelength_nm,value\n500,1.01\n", 3, "0..1"),
        ("wavelength_nm,value\n500,-0.1\n", 2, "0..1"),
        ("wavelength_nm,value\n500,\n", 2, "0..1"),
        ("wave,value\n500,1\n", 1, "a column wavelength_nm"),
        ("wavelength_nm,value,other\n500,1,1\n", 1, "one spectrum"),
        ("500,1\n600,0.5\n", 1, "a column wavelength_nm"),
        ("wavelength_nm;value\n500;1,234\n", 2, "one decimal mark"),
        ("wavelength_nm,value\n0.5,1\n0.6,1\n", 2, "a wavelength in nm"),
        ("", 1, "header"),
    ];
    for (text, line, expected) in cases {
        let file = file(text);
        match read_spectrum(file.path(), 0.0..=1.0).unwrap_err() {
            SpectrumError::Csv(e) => {
                assert_eq!(e.line, line, "{text:?}: {e}");
                assert!(e.expected.contains(expected), "{text:?}: {e}");
                assert!(e.to_string().contains(file.path().to_str().unwrap()), "{e}");
            }
            other => panic!("{text:?}: {other}"),
        }
    }
    for (text, remedy) in [
        ("wavelength_nm,value\n0.5,1\n", "looks like micrometres: multiply"),
        ("wavelength_nm,value\n500,45\n", "divided by 100"),
        ("wavelength_nm,value\n500,-0.001\n", "set to 0"),
    ] {
        let error = read_spectrum(file(text).path(), 0.0..=1.0).unwrap_err().to_string();
        assert!(error.contains(remedy), "{text:?}: {error}");
    }
    for text in [
        "Wavelength (nm);Value\n400;0,5\n500;1\n",
        "\"lambda\",\"K/S\"\n400,0.5\n500,1\n",
    ] {
        assert_eq!(
            read_spectrum(file(text).path(), 0.0..=1.0).unwrap().at(450.0).unwrap(),
            0.75,
            "{text:?}"
        );
    }
    assert!(matches!(
        read_spectrum(std::path::Path::new("/nowhere/at/all.csv"), 0.0..=1.0),
        Err(SpectrumError::Read { .. })
    ));
}

#[test]
fn spectra_by_column_and_by_row_are_the_same() {
    let by_column = file("wavelength_nm,a,b\n400,1,-3\n500,2,4\n");
    let by_row = file("id,name,R400,R500\n1,a,1,2\n2,b,-3,4\n");
    let (columns, rows) = (
        read_spectra(by_column.path()).unwrap(),
        read_spectra(by_row.path()).unwrap(),
    );
    assert_eq!(columns, rows);
    assert_eq!(columns[1].1.values(), [-3.0, 4.0]);
    let named = read_spectra(file("sample,400 nm,500 nm,600 nm\nred,1,2.5,3\n").path()).unwrap();
    assert_eq!(named[0].0, "red");
    // Without names a row has its number, and two titles may be values.
    let unnamed = read_spectra(file("400 nm;500 nm;600 nm\n1;2,5;3\n").path()).unwrap();
    assert_eq!(
        (unnamed[0].0.as_str(), unnamed[0].1.values()),
        ("1", &[1.0, 2.5, 3.0][..])
    );
    for bad in [
        "400,500\n1,2\n",
        "name,0.4,0.5\na,1,2\n",
        "a,b\n1,2\n",
        "name,group\nx,y\n",
        "wavelength_nm\n400\n",
    ] {
        assert!(read_spectra(file(bad).path()).is_err(), "{bad:?}");
    }
}

/// One file in every layout of CGATS-like text.
#[test]
fn spectra_in_cgats_text() {
    let by_set = "CGATS.17\n# a comment\nORIGINATOR \"someone's \"\"lab\"\"\"\nKEYWORD \"LAMP\"\nLAMP \"two of \
                  them\"\n\nNUMBER_OF_FIELDS 4\nBEGIN_DATA_FORMAT\nSAMPLE_ID SAMPLE_NAME\n SPEC_400 SPEC_500 # \
                  bands\nEND_DATA_FORMAT\nNUMBER_OF_SETS 2\nBEGIN_DATA\n1 \"first one\" 1 2\n\n2\tsecond -3 \
                  4\nEND_DATA\n# the end\n";
    let expected = vec![[1.0, 2.0], [-3.0, 4.0]];
    for field in [
        "SPEC_",
        "SPECTRAL_NM",
        "SPECTRAL_NM_",
        "SPECTRAL_",
        "nm",
        "R_",
        "R",
        "",
        "X",
    ] {
        let found = read_spectra(file(&by_set.replace("SPEC_", field)).path()).unwrap();
        let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["first one", "second"], "{field}");
        let values: Vec<&[f64]> = found.iter().map(|(_, samples)| samples.values()).collect();
        assert_eq!(values, expected, "{field}");
        assert_eq!(found[0].1.grid().nm(), [400.0, 500.0], "{field}");
    }
    let behind = by_set.replace("SPEC_400 SPEC_500", "400_NM 500_nm");
    assert_eq!(read_spectra(file(&behind).path()).unwrap()[1].1.values(), expected[1]);
    for end in ["\r\n", "\r"] {
        let found = read_spectra(file(&by_set.replace('\n', end)).path()).unwrap();
        assert_eq!(found[1].1.values(), expected[1], "{end:?}");
    }
    let by_wavelength =
        "BEGIN_DATA_FORMAT\nSAMPLE_ID WAVELENGTH a\nEND_DATA_FORMAT\nBEGIN_DATA\n1 400 1\n2 500 0.5\nEND_DATA\n";
    assert_eq!(
        read_spectrum(file(by_wavelength).path(), ..).unwrap().at(450.0),
        Ok(0.75)
    );
    // ISO 28178: SPECTRAL_PCT is per cent, SPECTRAL_DEC a fraction.
    let percent = by_wavelength
        .replace("WAVELENGTH a", "SPECTRAL_NM SPECTRAL_PCT")
        .replace("0.5", "50")
        .replace("400 1", "400 100");
    assert_eq!(
        read_spectrum(file(&percent).path(), 0.0..=1.0).unwrap().at(450.0),
        Ok(0.75)
    );
}

/// Bands of 10/3 nm, whose titles are rounded, and values over a norm, as in Argyll's `.sp` files.
#[test]
fn key_words_state_bands_and_norm() {
    let text = "SPECT\nSPECTRAL_BANDS \"4\"\nSPECTRAL_START_NM \"400.0\"\nSPECTRAL_END_NM \"410.0\"\nSPECTRAL_NORM \"100.0\"\nNUMBER_OF_FIELDS 4\nBEGIN_DATA_FORMAT\nSPEC_400 SPEC_403 SPEC_407 SPEC_410\nEND_DATA_FORMAT\nNUMBER_OF_SETS 1\nBEGIN_DATA\n0 50 100 25\nEND_DATA\n";
    let found = read_spectra(file(text).path()).unwrap();
    assert_eq!(found[0].0, "1");
    assert_eq!(found[0].1.values(), [0.0, 0.5, 1.0, 0.25]);
    for (nm, expected) in found[0]
        .1
        .grid()
        .nm()
        .iter()
        .zip([400.0, 403.0 + 1.0 / 3.0, 406.0 + 2.0 / 3.0, 410.0])
    {
        assert!((nm - expected).abs() < 1e-12, "{nm}");
    }
    for (from, to) in [("\"4\"", "\"5\""), ("\"410.0\"", "\"420.0\""), ("\"400.0\"", "\"-1\"")] {
        let error = read_spectra(file(&text.replacen(from, to, 1)).path()).unwrap_err();
        assert!(matches!(error, SpectrumError::Csv(_)), "{from} {to}: {error}");
    }
    let too_much = read_spectrum(file(&text.replace(" 100 ", " 101 ")).path(), 0.0..=1.0).unwrap_err();
    assert!(too_much.to_string().contains("line 12, column SPEC_407"), "{too_much}");
}

#[test]
fn faults_of_cgats_text_are_named() {
    let good = "CGATS.17\nNUMBER_OF_FIELDS 3\nBEGIN_DATA_FORMAT\nSAMPLE_ID nm400 nm500\nEND_DATA_FORMAT\n\
                NUMBER_OF_SETS 2\nBEGIN_DATA\na 1 2\nb 3 4\nEND_DATA\n";
    assert_eq!(read_spectra(file(good).path()).unwrap().len(), 2);
    // Key words in small letters; a comma as decimal mark.
    assert_eq!(read_spectra(file(&good.to_lowercase()).path()).unwrap().len(), 2);
    let comma = read_spectra(file(&good.replace("a 1 2", "a 1 2,5")).path()).unwrap();
    assert_eq!(comma[0].1.values(), [1.0, 2.5]);
    for (from, to, line, says) in [
        ("FIELDS 3", "FIELDS 4", 2, "4, as stated here, found 3"),
        ("FIELDS 3", "FIELDS three", 2, "a number above 0, found three"),
        ("SETS 2", "SETS 3", 6, "3, as stated here, found 2"),
        ("SETS 2", "SETS 2\nNUMBER_OF_SETS 2", 7, "NUMBER_OF_SETS twice"),
        ("nm400 nm500", "nm400 nm400", 3, "'nm400' twice"),
        ("nm400 nm500", "XYZ_X XYZ_Y", 3, "SPEC_390"),
        (
            "a 1 2",
            "a 1",
            8,
            "3 values, one a field of the data format, or END_DATA, found 2",
        ),
        ("a 1 2", "a 1 2 3", 8, "found 4"),
        (
            "a 1 2",
            "a 1 NaN",
            8,
            "column nm500: expected a finite value, found NaN",
        ),
        ("a 1 2", "a 1.5 1,5", 8, "one decimal mark"),
        ("a 1 2", "\"a 1 2", 8, "closing quotation mark"),
        ("END_DATA\n", "", 9, "expected END_DATA, found the end of the file"),
        ("a 1 2\nb 3 4\n", "", 6, "2, as stated here, found 0"),
        ("END_DATA_FORMAT\n", "", 6, "END_DATA_FORMAT, found BEGIN_DATA"),
        (
            "BEGIN_DATA_FORMAT\nSAMPLE_ID nm400 nm500\nEND_DATA_FORMAT\n",
            "",
            4,
            "BEGIN_DATA_FORMAT",
        ),
        ("END_DATA\n", "END_DATA\nCGATS.17\n", 11, "keep one table"),
    ] {
        let file = file(&match from {
            // The second of the two that begin alike.
            "END_DATA\n" => good.strip_suffix(from).unwrap().to_owned() + to,
            _ => good.replacen(from, to, 1),
        });
        match read_spectra(file.path()).unwrap_err() {
            SpectrumError::Csv(e) => {
                assert!(e.to_string().contains(says), "{from} → {to}: {e}");
                assert_eq!(e.line, line, "{from} → {to}: {e}");
            }
            other => panic!("{from} → {to}: {other}"),
        }
    }
    // Cut anywhere, it is refused.
    for cut in 0..good.len() - "\n".len() {
        assert!(read_spectra(file(&good[..cut]).path()).is_err(), "{:?}", &good[..cut]);
    }
}

#[test]
fn what_is_no_file_of_spectra() {
    let folder = tempfile::tempdir().unwrap();
    let message = |path: &std::path::Path| read_spectra(path).unwrap_err().to_string();
    assert!(message(folder.path()).contains("a folder"));
    let sparse = folder.path().join("sparse");
    std::fs::File::create(&sparse).unwrap().set_len(10 << 30).unwrap();
    assert!(message(&sparse).contains("10737418240"));
}
