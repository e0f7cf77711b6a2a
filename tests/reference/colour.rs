//! The conversion against exact rational arithmetic (`tests/data/colour`), every convention tabulated there.

use std::collections::HashMap;

use specval::colour::{
    Adaptation, ColourError, ColourSystem, Convention, Illuminant, Lab, LinearRgb, Observer, RgbSpace, delta_e_2000,
    delta_e_cmc,
};
use specval::run::Plan;
use specval::spectrum::{Spectrum, WavelengthGrid, tables};
use specval::study::{ColourSection, Study};

/// Rows of a reference table by column name.
fn rows(file: &str) -> Vec<HashMap<String, String>> {
    let path = format!("{}/tests/data/colour/{file}", env!("CARGO_MANIFEST_DIR"));
    csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_path(path)
        .unwrap()
        .deserialize()
        .map(Result::unwrap)
        .collect()
}

fn number(row: &HashMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap()
}

fn spectra() -> HashMap<String, Vec<f64>> {
    rows("spectra_test.csv")
        .iter()
        .map(|row| {
            let values = (0..35).map(|i| number(row, &format!("R{}", 390 + 10 * i))).collect();
            (row["name"].clone(), values)
        })
        .collect()
}

#[track_caller]
fn close(found: f64, row: &HashMap<String, String>, column: &str, worst: &mut f64) {
    // 1e-12 is asked of values of order 1; Lab runs to 100 and is printed to 15 digits.
    let expected = number(row, column);
    let difference = (found - expected).abs() / expected.abs().max(1.0);
    *worst = worst.max(difference);
    assert!(difference < 1e-12, "{} {column}: {found} {expected}", row["name"]);
}

#[test]
fn every_tabulated_convention() {
    let spectra = spectra();
    let grid = WavelengthGrid::preprint();
    let expected = rows("colour_expected.csv");
    assert_eq!(expected.len(), 38);
    let mut worst = 0.0;
    for row in &expected {
        let beta = &spectra[&row["name"]];
        for (rgb, adaptation, prefix) in [
            (RgbSpace::Srgb, Adaptation::None, "srgb_raw"),
            (RgbSpace::Srgb, Adaptation::Bradford, "srgb_bw35"),
            (RgbSpace::CieRgb, Adaptation::None, "ciergb_raw"),
            (RgbSpace::CieRgb, Adaptation::Bradford, "ciergb_bw35"),
            (RgbSpace::Ntsc, Adaptation::None, "ntsc_raw"),
            (RgbSpace::Ntsc, Adaptation::Bradford, "ntsc_bw35"),
        ] {
            let convention = Convention {
                observer: if row["observer"] == "2deg" {
                    Observer::Cie1931
                } else {
                    Observer::Cie1964
                },
                illuminant: Illuminant::load(&row["illuminant"]).unwrap(),
                rgb,
                adaptation,
            };
            let system = ColourSystem::new(&grid, convention).unwrap();
            let colour = system.convert(beta);
            let w = &mut worst;
            close(colour.xyz.x, row, "X", w);
            close(colour.xyz.y, row, "Y", w);
            close(colour.xyz.z, row, "Z", w);
            for (component, letter) in colour.linear_rgb.0.iter().zip(["R", "G", "B"]) {
                close(*component, row, &format!("{prefix}_{letter}"), w);
            }
            for (component, letter) in colour.lab.0.iter().zip(["L", "a", "b"]) {
                close(*component, row, letter, w);
            }
            let reference = ["R", "G", "B"].map(|letter| number(row, &format!("{prefix}_{letter}")));
            assert_eq!(colour.in_gamut, reference.iter().all(|c| *c >= 0.0));
        }
    }
    println!("worst deviation {worst:e}");
}

#[test]
fn whites_of_all_illuminants_and_observers() {
    let expected = rows("whites_35.csv");
    assert_eq!(expected.len(), 10);
    for row in expected {
        let convention = Convention {
            observer: if row["observer"] == "2deg" {
                Observer::Cie1931
            } else {
                Observer::Cie1964
            },
            illuminant: Illuminant::load(&row["illuminant"]).unwrap(),
            ..Convention::default()
        };
        let white = ColourSystem::new(&WavelengthGrid::preprint(), convention.clone())
            .unwrap()
            .white();
        for (found, column) in [(white.x, "X"), (white.y, "Y"), (white.z, "Z")] {
            assert!((found - number(&row, column)).abs() < 1e-12, "{convention} {column}");
        }
    }
}

#[test]
fn the_perfect_diffuser_is_white_under_every_convention() {
    let grid = WavelengthGrid::preprint();
    assert_eq!(Convention::all().count(), 60);
    for convention in Convention::all() {
        let system = ColourSystem::new(&grid, convention.clone()).unwrap();
        let colour = system.convert(&[1.0; 35]);
        assert!((colour.xyz.y - 1.0).abs() < 1e-14, "{convention}");
        assert!(delta_e_2000(colour.lab, Lab([100.0, 0.0, 0.0])) < 1e-11, "{convention}");
        if convention.adaptation == Adaptation::Bradford {
            assert!(
                colour.linear_rgb.0.iter().all(|c| (c - 1.0).abs() < 1e-13),
                "{convention}"
            );
        } else {
            // Without adaptation the luminance of the RGB values is Y whatever the white.
            let y = convention.rgb.luminance(colour.linear_rgb);
            assert!((y - 1.0).abs() < 1e-13, "{convention} {y}");
        }
        assert!(system.convert(&[0.0; 35]).in_gamut);
    }
}

#[test]
fn channel_weights_are_the_conversion() {
    let beta: Vec<f64> = (0..35).map(|i| 0.01 + 0.02 * f64::from(i)).collect();
    for convention in Convention::all() {
        let system = ColourSystem::new(&WavelengthGrid::preprint(), convention.clone()).unwrap();
        let colour = system.convert(&beta);
        let sums = system
            .channel_weights()
            .iter()
            .zip(&beta)
            .fold([0.0; 4], |mut sums, (w, b)| {
                sums.iter_mut().zip(w).for_each(|(sum, w)| *sum += w * b);
                sums
            });
        let [r, g, b] = colour.linear_rgb.0;
        for (sum, channel) in sums.iter().zip([r, g, b, colour.xyz.y]) {
            assert!((sum - channel).abs() < 1e-13, "{convention}");
        }
    }
}

fn grid(nm: impl IntoIterator<Item = u32>) -> WavelengthGrid {
    WavelengthGrid::new(nm.into_iter().map(f64::from).collect()).unwrap()
}

/// Coarse, short and uneven grids, and some beyond the tables.
fn grids() -> Vec<WavelengthGrid> {
    vec![
        grid([450, 550, 650]),
        grid((440..=720).step_by(10)),
        grid((400..=700).step_by(10)),
        grid((400..=700).step_by(20)),
        grid((400..=700).step_by(50)),
        grid((394..=730).step_by(7)),
        grid([405, 436, 546, 578, 633, 694]),
        grid((300..=1000).step_by(10)),
        grid((390..=490).step_by(5).chain((500..=730).step_by(10))),
    ]
}

#[test]
fn grey_stays_grey_on_any_grid() {
    for convention in Convention::all() {
        let whole = ColourSystem::new(&grid([450, 550, 650]), convention.clone()).unwrap();
        for grid in grids() {
            let system = ColourSystem::new(&grid, convention.clone()).unwrap();
            let colour = system.convert(&vec![0.4; grid.len()]);
            // One white for all of them.
            for (found, of) in [
                (system.white().x, whole.white().x),
                (system.white().z, whole.white().z),
                (colour.xyz.x, 0.4 * whole.white().x),
                (colour.xyz.y, 0.4),
                (colour.xyz.z, 0.4 * whole.white().z),
            ] {
                assert!((found - of).abs() < 1e-13, "{convention} {:?} {found} {of}", grid.nm());
            }
            let [r, g, b] = colour.linear_rgb.0;
            if convention == Convention::default() {
                // The table's D65 against the white of sRGB, four digits of chromaticity.
                assert!((b / r - 1.0).abs() < 1e-3 && (g / r - 1.0).abs() < 1e-3, "{b} {g} {r}");
            }
        }
    }
    // 0.95047, 1.08883 are the published sums of D65 and the 2 degree observer (CIE 15).
    let white = ColourSystem::new(&grid([450, 550, 650]), Convention::default())
        .unwrap()
        .white();
    assert!(
        (white.x - 0.95047).abs() < 1e-5 && (white.z - 1.08883).abs() < 1e-5,
        "{white:?}"
    );
}

/// What is lost of real colours between coarse or missing wavelengths, as the documentation of `ColourSystem` states
/// it.
#[test]
fn interpolated_colours_against_the_finest_data() {
    let spectra = spectra();
    let real = |name: &str| ["cc", "red", "usgs"].iter().any(|begins| name.starts_with(begins));
    let preprint = WavelengthGrid::preprint();
    let lab = |grid: &WavelengthGrid, all: &[f64]| {
        let at = |nm: &f64| all[((nm - 390.0) / 10.0) as usize];
        let system = ColourSystem::new(grid, Convention::default()).unwrap();
        system.convert(&grid.nm().iter().map(at).collect::<Vec<_>>()).lab.0
    };
    for (name, of, allowed) in [
        ("400..700/10", grid((400..=700).step_by(10)), 0.04),
        ("390..730/20", grid((390..=730).step_by(20)), 0.3),
        ("400..700/20", grid((400..=700).step_by(20)), 0.3),
        ("three", grid([450, 550, 650]), 20.0),
    ] {
        let mut worst: (f64, &str) = (0.0, "");
        for (spectrum, all) in spectra.iter().filter(|(name, _)| real(name)) {
            let pair = std::iter::zip(lab(&of, all), lab(&preprint, all));
            let difference = pair.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
            worst = if difference > worst.0 {
                (difference, spectrum)
            } else {
                worst
            };
        }
        println!("{name}: at most {:.3} of {}", worst.0, worst.1);
        assert!(worst.0 < allowed && worst.0 > allowed / 4.0, "{name}: {worst:?}");
    }
}

#[test]
fn a_grid_with_unequal_steps_is_interpolated_linearly() {
    let convention = Convention {
        illuminant: Illuminant::E,
        ..Convention::default()
    };
    let uneven = WavelengthGrid::new(vec![450.0, 500.0, 600.0]).unwrap();
    let found = ColourSystem::new(&uneven, convention.clone())
        .unwrap()
        .xyz(&[1.0, 0.0, 0.5]);
    let beta = |nm: f64| match nm {
        ..450.0 => 1.0,
        450.0..500.0 => 1.0 - (nm - 450.0) / 50.0,
        500.0..600.0 => 0.5 * (nm - 500.0) / 100.0,
        _ => 0.5,
    };
    let table = tables::observer("cie1931-2deg").unwrap();
    let sum = |of: &Spectrum, beta: &dyn Fn(f64) -> f64| -> f64 {
        (360..=780).map(f64::from).map(|nm| of.at(nm).unwrap() * beta(nm)).sum()
    };
    let whole = sum(&table.y_bar, &|_| 1.0);
    for (found, of) in [
        (found.x, &table.x_bar),
        (found.y, &table.y_bar),
        (found.z, &table.z_bar),
    ] {
        assert!((found - sum(of, &beta) / whole).abs() < 1e-14);
    }
    // Equal steps that decimals cannot write exactly are still plain sums.
    let tenth = WavelengthGrid::new((0..4000).map(|i| 380.0 + f64::from(i) * 0.1).collect()).unwrap();
    let system = ColourSystem::new(&tenth, convention).unwrap();
    assert!(system.method().starts_with("plain sums") && (system.white().y - 1.0).abs() < 1e-12);
}

#[test]
fn what_cannot_carry_a_colour_says_so() {
    let of = |nm: &[u32]| ColourSystem::new(&grid(nm.iter().copied()), Convention::default()).unwrap();
    let ranges = |from: u32, to: u32, step: usize| of(&(from..=to).step_by(step).collect::<Vec<_>>());
    for system in [
        ranges(390, 730, 10),
        ranges(400, 700, 10),
        ranges(410, 710, 20),
        ranges(300, 1000, 10),
    ] {
        assert_eq!(system.doubt(), None);
        assert_eq!(system.require(), Ok(()));
    }
    for (system, says) in [
        (of(&[450, 550, 650]), "up to 100 nm apart"),
        (
            of(&[450, 550, 650]),
            "42 % of the colour-matching function zbar lie outside 450 to 650 nm",
        ),
        (ranges(440, 720, 10), "25 % of the colour-matching function zbar"),
        (ranges(400, 700, 25), "up to 25 nm apart, where 20 nm"),
    ] {
        assert!(
            system.doubt().is_some_and(|why| why.contains(says)),
            "{:?}",
            system.doubt()
        );
        assert_eq!(system.require(), Ok(()));
    }
    for system in [
        of(&[850]),
        of(&[650]),
        of(&[450, 650]),
        ranges(500, 600, 10),
        ranges(800, 900, 10),
    ] {
        assert!(
            matches!(system.require(), Err(ColourError::NoColour { .. })),
            "{system:?}"
        );
    }
    // A table of the user's own has to cover the data.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lamp.csv");
    let lamp: String = (450..=650).map(|nm| format!("{nm},1\n")).collect();
    std::fs::write(&path, format!("wavelength_nm,value\n{lamp}")).unwrap();
    let convention = Convention {
        illuminant: Illuminant::load(path.to_str().unwrap()).unwrap(),
        ..Convention::default()
    };
    let error = ColourSystem::new(&grid((400..=700).step_by(20)), convention).unwrap_err();
    assert!(matches!(error, ColourError::Spectrum(_)), "{error}");
}

#[test]
fn names_in_files_and_flags() {
    assert_eq!(
        Convention::default().to_string(),
        "cie1931-2deg, D65, srgb, adaptation none"
    );
    let parsed: ColourSection =
        toml::from_str("illuminant = \"E\"\nrgb = \"cie-rgb\"\nadaptation = \"bradford\"").unwrap();
    let convention = parsed.convention().unwrap();
    assert_eq!(
        (convention.observer, convention.illuminant, convention.rgb),
        (Observer::Cie1931, Illuminant::E, RgbSpace::CieRgb)
    );
    assert_eq!(
        toml::from_str::<ColourSection>(&toml::to_string(&parsed).unwrap()).unwrap(),
        parsed
    );
    assert_eq!(Illuminant::load("d50"), Ok(Illuminant::D50));
    assert!(toml::from_str::<ColourSection>("iluminant = \"E\"").is_err());
    let message = "sRGBB".parse::<RgbSpace>().unwrap_err().to_string();
    assert!(
        message.contains("did you mean 'srgb'?") && message.contains("cie-rgb, ntsc"),
        "{message}"
    );
}

/// Rows of a table in `spectra/`: its wavelengths and the columns named.
fn built_in(table: &str, columns: &[&str]) -> Vec<Vec<String>> {
    let path = format!("{}/spectra/{table}.csv", env!("CARGO_MANIFEST_DIR"));
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).unwrap();
    let rows = reader.deserialize::<HashMap<String, String>>().map(Result::unwrap);
    let row = |row: HashMap<String, String>| {
        let cells = ["wavelength_nm"].iter().chain(columns);
        cells.map(|column| row[*column].clone()).collect()
    };
    rows.map(row).collect()
}

/// The same table as CSV, as CGATS with a set a wavelength, and as CGATS with a set a spectrum.
fn files_of(rows: &[Vec<String>], titles: &[&str]) -> [String; 3] {
    let csv: String = rows.iter().map(|row| row.join(",") + "\n").collect();
    let lines: String = rows.iter().map(|row| row.join("\t") + "\n").collect();
    let columns = titles.join(" ");
    let by_wavelength = format!(
        "CGATS.17\nORIGINATOR \"a lamp\"\nNUMBER_OF_FIELDS {}\nBEGIN_DATA_FORMAT\nSPECTRAL_NM \
         {columns}\nEND_DATA_FORMAT\nNUMBER_OF_SETS {}\nBEGIN_DATA\n{lines}END_DATA\n",
        1 + titles.len(),
        rows.len()
    );
    let bands: String = rows.iter().map(|row| format!(" SPEC_{}", row[0])).collect();
    let sets: String = (1..=titles.len())
        .map(|k| {
            let values: String = rows.iter().map(|row| format!(" {}", row[k])).collect();
            format!("{} {values}\n", titles[k - 1])
        })
        .collect();
    let by_spectrum = format!("BEGIN_DATA_FORMAT\nSAMPLE_NAME{bands}\nEND_DATA_FORMAT\nBEGIN_DATA\n{sets}END_DATA\n");
    [
        format!("wavelength_nm,{}\n{csv}", titles.join(",")),
        by_wavelength,
        by_spectrum,
    ]
}

/// Copies of the built-in tables, named by path in a study, give the bits of the built-in ones, white and Lab included.
#[test]
fn a_study_with_tables_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let d50 = files_of(&built_in("illuminants", &["D50"]), &["value"]);
    let functions = ["xbar", "ybar", "zbar"];
    let ten = files_of(&built_in("cie1964-10deg", &functions), &functions);
    let named = Plan::new(study("D50", "cie1964-10deg")).unwrap();
    let beta: Vec<f64> = (0..35).map(|i| 0.01 + 0.02 * f64::from(i)).collect();
    for (lamp, observer) in d50.iter().zip(&ten) {
        let (lamp_path, observer_path) = (at("lamp.txt", lamp), at("observer.txt", observer));
        let given = Plan::new(study(&lamp_path, &observer_path)).unwrap();
        assert_eq!(given.colour.white(), named.colour.white());
        assert_eq!(given.colour.convert(&beta), named.colour.convert(&beta));
        let digests: Vec<&str> = given.inputs.iter().map(|input| input.name.as_str()).collect();
        assert!(
            digests.contains(&format!("illuminant {lamp_path}").as_str()),
            "{digests:?}"
        );
        assert!(
            digests.contains(&format!("observer {observer_path}").as_str()),
            "{digests:?}"
        );
        // Another byte is another input, even where no value changes.
        at("lamp.txt", &format!("{lamp}# a note\n"));
        let noted = Plan::new(study(&lamp_path, &observer_path)).unwrap();
        assert_ne!(noted.inputs, given.inputs);
    }
    assert_ne!(
        named.colour.white(),
        Plan::new(Study::default()).unwrap().colour.white()
    );
}

fn study(illuminant: &str, observer: &str) -> Study {
    let mut study = Study::default();
    study.colour.illuminant = illuminant.into();
    study.colour.observer = observer.into();
    study
}

#[test]
fn tables_of_a_users_own_are_refused_before_a_run() {
    let folder = tempfile::tempdir().unwrap();
    let refusal = |text: &str, observer: bool| {
        let path = folder.path().join("table.txt");
        std::fs::write(&path, text).unwrap();
        let path = path.display().to_string();
        let study = match observer {
            true => study("D65", &path),
            false => study(&path, "cie1931-2deg"),
        };
        let message = Plan::new(study).err().unwrap().to_string();
        assert!(message.contains(&path), "{message}");
        message
    };
    let row = |nm: i32| format!("{nm},1\n");
    let lamp = |nm: &mut dyn Iterator<Item = i32>| format!("wavelength_nm,value\n{}", nm.map(row).collect::<String>());
    for (text, says) in [
        (lamp(&mut (400..=730).step_by(10)), "no value at 390 nm"),
        (lamp(&mut (390..=720).step_by(10)), "no value at 730 nm"),
        (
            lamp(&mut (390..=730)).replace("400,1", "400,-1"),
            "line 12, column value: expected a value of 0 or more, found -1",
        ),
        (lamp(&mut (390..=730)).replace("400,1", "400,NaN"), "found NaN"),
        (
            "wavelength_nm,xbar,ybar,zbar\n390,1,1,1\n".into(),
            "one spectrum, found 3",
        ),
        (lamp(&mut (390..=730)).replace(",1\n", ",0\n"), "must be positive"),
    ] {
        let message = refusal(&text, false);
        assert!(message.contains(says), "{message}");
    }
    for (text, says) in [
        (
            "wavelength_nm,xbar,ybar\n390,1,1\n",
            "three spectra, xbar, ybar and zbar",
        ),
        ("wavelength_nm,xbar,ybar,zbar,rbar\n390,1,1,1,1\n", "found rbar, xbar"),
        ("wavelength_nm,xbar,ybar,zbar\n390,1,1,-1\n", "column zbar"),
        ("wavelength_nm,xbar,ybar,zbar\n390,1,1,1\n", "no value at 730 nm"),
    ] {
        let message = refusal(text, true);
        assert!(message.contains(says), "{message}");
    }
    // Wavelengths may come in any order.
    let path = folder.path().join("descending.txt");
    std::fs::write(&path, lamp(&mut (390..=730).rev())).unwrap();
    assert!(Plan::new(study(&path.display().to_string(), "cie1931-2deg")).is_ok());
    let missing = Plan::new(study("no/such.csv", "cie1931-2deg"))
        .err()
        .unwrap()
        .to_string();
    assert!(missing.contains("nor is there a file"), "{missing}");
    let slip = study("D56", "cie1931-2deg").validate().unwrap_err().to_string();
    assert!(slip.contains("`colour.illuminant`") && slip.contains("D65"), "{slip}");
}

#[test]
fn a_colour_as_json() {
    let system = ColourSystem::new(&WavelengthGrid::preprint(), Convention::default()).unwrap();
    let json = serde_json::to_value(system.convert(&[0.5; 35])).unwrap();
    assert!((json["Y"].as_f64().unwrap() - 0.5).abs() < 1e-15);
    assert_eq!(json["linear_rgb"].as_array().unwrap().len(), 3);
    assert_eq!(json["lab"].as_array().unwrap().len(), 3);
    assert!(!LinearRgb([0.4, -1e-9, 0.2]).in_gamut() && LinearRgb([1.2, 0.0, 0.2]).in_gamut());
}

#[test]
fn ciede2000_of_the_published_pairs() {
    let lab = |row: &HashMap<String, String>, i: u8| Lab(["L", "a", "b"].map(|c| number(row, &format!("{c}{i}"))));
    let pairs = rows("ciede2000_sharma.csv");
    assert_eq!(pairs.len(), 34);
    for row in pairs {
        let found = delta_e_2000(lab(&row, 1), lab(&row, 2));
        // Hues exactly opposite: the last bit of atan2 chooses between two legal values.
        let other = match row["pair"].as_str() {
            "10" => 7.2195,
            "14" => 4.7461,
            _ => f64::NAN,
        };
        let exact = (found - number(&row, "dE00_recomputed")).abs() < 1e-12;
        assert!(exact || (found - other).abs() < 5e-5, "pair {}: {found}", row["pair"]);
    }
}

/// Pairs of BYK-Gardner (brilliant red, brilliant yellow) and of the two calculators of B. Lindbloom and of
/// colour-science, each to the digits that they print.
#[test]
fn cmc_colour_differences_are_those_of_other_programs() {
    let pairs = [
        ([38.64, 64.26, 52.16], [38.59, 62.06, 51.11], 2.0, 0.8423, 4),
        ([38.83, 33.35, 26.67], [38.69, 31.14, 25.21], 2.0, 1.1297, 4),
        ([84.25, 5.74, 96.0], [84.46, 8.88, 96.49], 2.0, 1.6364, 4),
        ([84.25, 5.74, 96.0], [84.52, 5.75, 93.09], 2.0, 0.8770, 4),
        ([84.25, 5.74, 96.0], [84.37, 5.86, 99.42], 2.0, 1.0221, 4),
        ([100.0, -50.0, 50.0], [20.0, 10.0, -20.0], 1.0, 66.320207, 6),
        ([100.0, -50.0, 50.0], [20.0, 10.0, -20.0], 2.0, 47.038863, 6),
        ([100.0, 0.0, 0.0], [0.0, 0.0, 0.0], 2.0, 33.740085, 6),
        (
            [100.0, 21.57210357, 272.2281935],
            [100.0, 426.67945353, 72.39590835],
            2.0,
            172.70477129,
            8,
        ),
        (
            [100.0, 21.57210357, 272.2281935],
            [100.0, 74.05216981, 276.45318193],
            2.0,
            20.59732717,
            8,
        ),
        (
            [100.0, 21.57210357, 272.2281935],
            [100.0, 8.32281957, -73.58297716],
            1.0,
            121.71841479,
            8,
        ),
        (
            [48.99183622, -0.10561667, 400.65619925],
            [50.65907324, -0.1167191, 402.82235718],
            2.0,
            0.89969998,
            8,
        ),
        ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0, 1.7387, 4),
    ];
    for (standard, sample, l, expected, digits) in pairs {
        let found = delta_e_cmc(Lab(standard), Lab(sample), l, 1.0);
        let unit = 10f64.powi(-digits);
        assert!(
            (found - expected).abs() < unit,
            "{standard:?} {sample:?}: {found}, {expected}"
        );
    }
    // Dark standards have one lightness tolerance; the difference of lightness alone counts 1/l.
    let dark = [2.0, 1.0].map(|l| delta_e_cmc(Lab([15.9, 0.0, 0.0]), Lab([16.9, 0.0, 0.0]), l, 1.0));
    assert!((dark[1] - 1.0 / 0.511).abs() < 1e-12 && (dark[0] - 0.5 / 0.511).abs() < 1e-12);
}
