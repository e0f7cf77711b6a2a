//! The conversion against exact rational arithmetic (`tests/data/colour`), every convention tabulated there.

use std::collections::HashMap;

use specval::colour::{
    Adaptation, ColourError, ColourSystem, Convention, Illuminant, Lab, LinearRgb, Observer, RgbSpace, delta_e_2000,
};
use specval::spectrum::WavelengthGrid;

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
                illuminant: row["illuminant"].parse().unwrap(),
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
            illuminant: row["illuminant"].parse().unwrap(),
            ..Convention::default()
        };
        let white = ColourSystem::new(&WavelengthGrid::preprint(), convention)
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
        let system = ColourSystem::new(&grid, convention).unwrap();
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
        let system = ColourSystem::new(&WavelengthGrid::preprint(), convention).unwrap();
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

#[test]
fn a_grid_with_unequal_steps_weighs_by_interval() {
    let convention = Convention {
        illuminant: Illuminant::E,
        ..Convention::default()
    };
    let uneven = WavelengthGrid::new(vec![450.0, 500.0, 600.0]).unwrap();
    let found = ColourSystem::new(&uneven, convention).unwrap().xyz(&[1.0, 0.0, 0.5]);
    // ybar and xbar of the CIE 1931 table at 450, 500, 600 nm; widths 50, 75, 100 nm.
    let y = 50.0 * 0.038 + 75.0 * 0.323 + 100.0 * 0.631;
    assert!((found.y - (50.0 * 0.038 + 50.0 * 0.631) / y).abs() < 1e-15);
    assert!((found.x - (50.0 * 0.3362 + 50.0 * 1.0622) / y).abs() < 1e-15);
    // Equal steps that decimals cannot write exactly are still plain sums.
    let tenth = WavelengthGrid::new((0..3000).map(|i| 400.0 + f64::from(i) * 0.1).collect()).unwrap();
    let system = ColourSystem::new(&tenth, convention).unwrap();
    assert!((system.white().y - 1.0).abs() < 1e-12);
}

#[test]
fn a_grid_without_colour_is_refused() {
    for (nm, outside) in [
        (vec![700.0], false),
        (vec![340.0, 500.0], true),
        (vec![500.0, 800.0], true),
    ] {
        let grid = WavelengthGrid::new(nm).unwrap();
        let error = ColourSystem::new(&grid, Convention::default()).unwrap_err();
        assert_eq!(matches!(error, ColourError::Spectrum(_)), outside, "{error}");
    }
}

#[test]
fn names_in_files_and_flags() {
    assert_eq!(
        Convention::default().to_string(),
        "cie1931-2deg, D65, srgb, adaptation none"
    );
    let parsed: Convention =
        toml::from_str("illuminant = \"E\"\nrgb = \"cie-rgb\"\nadaptation = \"bradford\"").unwrap();
    assert_eq!((parsed.observer, parsed.illuminant), (Observer::Cie1931, Illuminant::E));
    assert_eq!(
        toml::from_str::<Convention>(&toml::to_string(&parsed).unwrap()).unwrap(),
        parsed
    );
    assert_eq!("d50".parse(), Ok(Illuminant::D50));
    assert!(toml::from_str::<Convention>("iluminant = \"E\"").is_err());
    let message = "sRGBB".parse::<RgbSpace>().unwrap_err().to_string();
    assert!(
        message.contains("did you mean 'srgb'?") && message.contains("cie-rgb, ntsc"),
        "{message}"
    );
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
