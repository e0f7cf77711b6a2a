//! Built-in tables against the sources they were taken from, and a user's own spectrum file.

use std::io::Write;

use specval::spectrum::{SpectrumError, WavelengthGrid, read_csv_spectra, read_csv_spectrum, tables};

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
    assert_eq!(read_csv_spectrum(good.path()).unwrap().at(450.0).unwrap(), 0.75);
    let cases = [
        ("wavelength_nm,value\n500,0.1\n400,0.2\n", 3, "above 500 nm"),
        ("wavelength_nm,value\n500,0.1\n500,0.2\n", 3, "above 500 nm"),
        ("wavelength_nm,value\n-500,0.1\n", 2, "above 0 nm"),
        ("wavelength_nm,value\n500,NaN\n", 2, "0..1"),
        ("# c\nwavelength_nm,value\n500,1.01\n", 3, "0..1"),
        ("wavelength_nm,value\n500,-0.1\n", 2, "0..1"),
        ("wavelength_nm,value\n500,\n", 2, "0..1"),
        ("wavelength,value\n500,1\n", 1, "wavelength_nm,value"),
        ("wavelength_nm;value\n500;0,5\n", 2, "1 values"),
        ("", 1, "header"),
    ];
    for (text, line, expected) in cases {
        let file = file(text);
        match read_csv_spectrum(file.path()).unwrap_err() {
            SpectrumError::Csv(e) => {
                assert_eq!(e.line, line, "{text:?}: {e}");
                assert!(e.expected.contains(expected), "{text:?}: {e}");
                assert!(e.to_string().contains(file.path().to_str().unwrap()), "{e}");
            }
            other => panic!("{text:?}: {other}"),
        }
    }
    assert!(matches!(
        read_csv_spectrum(std::path::Path::new("/nowhere/at/all.csv")),
        Err(SpectrumError::Read { .. })
    ));
}

#[test]
fn spectra_by_column_and_by_row_are_the_same() {
    let by_column = file("wavelength_nm,a,b\n400,1,-3\n500,2,4\n");
    let by_row = file("id,name,R400,R500\n1,a,1,2\n2,b,-3,4\n");
    let (columns, rows) = (
        read_csv_spectra(by_column.path()).unwrap(),
        read_csv_spectra(by_row.path()).unwrap(),
    );
    assert_eq!(columns, rows);
    assert_eq!(columns[1].1.values(), [-3.0, 4.0]);
    for bad in [
        "a,b\n1,2\n",
        "name,group\nx,y\n",
        "name,R500,R400\nx,1,2\n",
        "wavelength_nm\n400\n",
    ] {
        assert!(read_csv_spectra(file(bad).path()).is_err(), "{bad:?}");
    }
}
