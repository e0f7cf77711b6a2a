//! The study file: accepted input, rejected input, and error messages.

use proptest::prelude::*;
use specval::cloth::Weave;
use specval::run::{Plan, medium};
use specval::study::{EstimatorChoice, InterferenceChoice, NumberOrTable, Study, StudyError};
use std::io::Write;

fn refused(text: &str) -> StudyError {
    Study::from_toml(text, "my.toml").unwrap_err()
}

#[test]
fn the_commented_file_is_the_default_study() {
    let text = Study::commented_toml();
    assert_eq!(Study::from_toml(&text, "study.toml"), Ok(Study::default()));
    assert!(text.contains("radius_mm = 0.15"), "{text}");
    assert!(text.contains("# a number, 1e-6 to 100 mm"), "{text}");
}

#[test]
fn obsolete_keys_are_read_with_a_notice() {
    let study = Study::from_toml(
        "seed = 3\n[cloth]\nsegments_around = 96\nspacing_diameters = 2.0\n",
        "old.toml",
    )
    .unwrap();
    assert_eq!(study.cloth.spacing_diameters, 2.0);
    let notices: Vec<String> = study.origin.old_keys().iter().map(ToString::to_string).collect();
    assert!(notices.len() == 1, "{notices:?}");
    assert!(
        notices[0].starts_with("old.toml, line 3: `cloth.segments_around` has no effect any more"),
        "{notices:?}"
    );
    // A value of another type is still refused.
    assert!(Study::from_toml("[cloth]\nsegments_around = \"many\"\n", "old.toml").is_err());
    let before = Study::from_toml("[cloth]\nspacing_diameters = 2.0\n", "new.toml").unwrap();
    assert_eq!(before.cloth, study.cloth);
}

/// `specval init --keys` writes the page.
#[test]
fn docs_list_every_key() {
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/study.md")).unwrap();
    assert!(
        page == Study::page_of_keys(),
        "docs/study.md is out of date: run `specval init --keys > docs/study.md`"
    );
}

/// The commented file contains every key, so no key is documented in the source alone.
#[test]
fn the_commented_file_has_every_key() {
    let text = Study::commented_toml();
    let mut full = Study::default();
    full.spectrum.wavelengths_nm = Some(vec![500.0]);
    full.cloth.sinusoid_amplitude_mm = Some(0.1);
    full.yarn.twist_deg = Some(20.0);
    full.specular.roughness_across = Some(0.5);
    for (section, value) in toml::Table::try_from(&full).unwrap() {
        let keys = value
            .as_table()
            .map_or(vec![section.clone()], |t| t.keys().cloned().collect());
        for key in keys {
            assert!(
                text.lines()
                    .any(|l| l.trim_start_matches("# ").starts_with(&format!("{key} = "))),
                "{section}.{key}"
            );
        }
    }
}

/// The examples of keys without a default are valid.
#[test]
fn the_commented_examples_may_be_uncommented() {
    let text = Study::commented_toml()
        .replace("# wavelengths_nm", "wavelengths_nm")
        .replace("# sinusoid_amplitude_mm", "sinusoid_amplitude_mm")
        .replace("# twist_deg", "twist_deg")
        .replace("# roughness_across", "roughness_across")
        .replace("surface = \"cloth\"", "surface = \"fibres\"")
        .replace("centre_line = \"peirce\"", "centre_line = \"sinusoid\"");
    let study = Study::from_toml(&text, "study.toml").unwrap();
    assert_eq!(study.spectrum.wavelengths(), [450.0, 550.0, 650.0]);
    assert_eq!(study.cloth.sinusoid_amplitude_mm, Some(0.15));
    assert_eq!(
        (study.yarn.twist_deg, study.specular.roughness_across),
        (Some(20.0), Some(0.6))
    );
}

/// Keys that apply only to fibres are not silently ignored with another surface.
#[test]
fn keys_of_fibres_require_the_fibres_surface() {
    for key in ["[yarn]\ntwist_deg = 0", "[specular]\nroughness_across = 0.6"] {
        let message = refused(key).to_string();
        let words = ["line 2", "no value while [specular] surface is \"cloth\"", "\"fibres\""];
        assert!(words.iter().all(|w| message.contains(w)), "{message}");
    }
    let message = refused("[specular]\nsurface = \"yarn\"\nroughness_across = 0.6\n").to_string();
    assert!(message.contains("surface is \"yarn\""), "{message}");
    for (text, range) in [
        (
            "[specular]\nsurface = \"fibres\"\n[yarn]\ntwist_deg = -91\n",
            "-90 to 90 degrees",
        ),
        (
            "[specular]\nsurface = \"fibres\"\nroughness_across = 1.1\n",
            "0.001 to 1",
        ),
    ] {
        let message = refused(text).to_string();
        assert!(message.contains(range), "{message}");
    }
    let study = Study::from_toml("[specular]\nsurface = \"fibres\"\n[yarn]\ntwist_deg = -25\n", "t").unwrap();
    assert!(Plan::new(study).unwrap().fibres.unwrap().is_handed());
    assert!(Plan::new(Study::default()).unwrap().fibres.is_none());
}

/// The parser accepts every choice listed in the file.
#[test]
fn every_documented_choice_is_accepted() {
    let text = Study::commented_toml();
    let lines: Vec<&str> = text.lines().collect();
    let (mut section, mut tried) = ("", 0);
    for pair in lines.windows(2) {
        if pair[0].starts_with('[') {
            section = pair[0];
        }
        if let Some(choices) = pair[0].strip_prefix("# one of ") {
            let key = pair[1].split(" = ").next().unwrap();
            let (choices, _) = choices.split_once("; ").unwrap_or((choices, ""));
            for choice in choices.split(", ") {
                Study::from_toml(&format!("{section}\n{key} = {choice}\n"), "t").unwrap();
                tried += 1;
            }
        }
    }
    assert_eq!(tried, 33 + Weave::NAMES.len());
}

#[test]
fn written_study_reads_back_unchanged() {
    let mut study = Study {
        seed: 77,
        ..Study::default()
    };
    study.spectrum.wavelengths_nm = Some(vec![400.0, 410.5]);
    study.medium.interference = InterferenceChoice::PercusYevick;
    study.cloth.weave = "twill-2-1".into();
    study.colour.observer = "cie1964-10deg".into();
    study.trace.roulette_threshold = 1e-5;
    study.trace.estimator = EstimatorChoice::Shared;
    study.medium.host_index = NumberOrTable::Table("host.csv".into());
    assert_eq!(Study::from_toml(&study.to_toml().unwrap(), "t"), Ok(study));
    assert_eq!(Study::from_toml("", "t"), Ok(Study::default()));
}

#[test]
fn the_default_grid_and_views_are_the_preprints() {
    let study = Study::default();
    assert_eq!(study.validate(), Ok(()));
    let (nm, views) = (study.spectrum.wavelengths(), study.rig.views_deg());
    assert_eq!((nm.len(), nm[0], nm[34]), (35, 390.0, 730.0));
    assert_eq!((views.len(), views[0], views[12], views[26]), (27, -60.0, 0.0, 70.0));
}

#[test]
fn unknown_keys_are_rejected_with_a_suggestion() {
    let error = refused("seed = 2\n\n[medium]\nvolume_fracton = 0.2\n");
    assert_eq!(
        error.to_string(),
        "my.toml, line 4: unknown key `volume_fracton` in [medium]: did you mean `volume_fraction`? Known keys: \
         host_index, host_mu_a_per_mm, particle_index, particle_diameter_nm, volume_fraction, kappa_peak, dye, \
         interference"
    );
    let section = refused("[medum]\nhost_index = 1.5\n").to_string();
    assert!(
        section.contains("line 1") && section.contains("`medium`") && section.contains("sweep"),
        "{section}"
    );
    let elsewhere = refused("[medium]\nradius_mm = 1\n").to_string();
    assert!(elsewhere.contains("did you mean `radius_mm` in [yarn]?"), "{elsewhere}");
    let nothing_near = refused("[yarn]\nhumidity = 1\n").to_string();
    assert!(!nothing_near.contains("did you mean"), "{nothing_near}");
}

#[test]
fn first_error_of_the_file_is_reported() {
    let error = refused("[yarn]\nradius_mm = \"x\"\n[medium]\nbad = 1\n");
    assert!(
        error.to_string().starts_with("my.toml, line 2: `yarn.radius_mm`"),
        "{error}"
    );
}

#[test]
fn wrong_types_report_expected_and_found() {
    for (text, expected, found) in [
        (
            "[yarn]\nradius_mm = \"thick\"",
            "a number, 1e-6 to 100 mm",
            "\"thick\" (string)",
        ),
        ("[trace]\nbatches = 2.5", "a whole number, 2 to 100000", "2.5 (float)"),
        ("[trace]\nbatches = -3", "a whole number, 2 to 100000", "-3 (integer)"),
        ("[trace]\nfold_symmetry = 1", "true or false", "1 (integer)"),
        (
            "[rig]\nincidences_deg = 30",
            "a list of 1 or more numbers",
            "30 (integer)",
        ),
        (
            "[rig]\nincidences_deg = [0, \"a\"]",
            "each 0 to below 90 degrees",
            "[0, \"a\"] (array)",
        ),
        ("[medium]\ndye = 3", "a text in quotes", "3 (integer)"),
        (
            "[medium]\nhost_mu_a_per_mm = [0, 1]",
            "a number, 0 to 1000000 1/mm, or a path in quotes to a CSV of such numbers, columns wavelength_nm,value",
            "[0, 1] (array)",
        ),
        (
            "[specular]\nindex = 'host.csv'",
            "a number, 1 to 4",
            "'host.csv' (string)",
        ),
        ("medium = 3", "a section, [medium]", "integer"),
        ("[[medium]]\ndye = 'a'", "a section, [medium]", "array"),
    ] {
        let error = refused(text);
        let message = error.to_string();
        assert!(matches!(error, StudyError::Type { .. }), "{message}");
        assert!(message.contains(expected) && message.contains(found), "{message}");
    }
}

#[test]
fn choices_are_suggested() {
    let message = refused("[cloth]\n\nweave = \"twil-2-1\"").to_string();
    assert_eq!(
        message,
        format!(
            "my.toml, line 3: `cloth.weave`: expected one of \"{}\"; or a path with a dot or slash in it, found \
             \"twil-2-1\"; did you mean \"twill-2-1\"?",
            Weave::NAMES.join("\", \"")
        )
    );
    assert!(
        refused("[colour]\nilluminant = 'd65'")
            .to_string()
            .contains("did you mean \"D65\"?")
    );
}

#[test]
fn values_out_of_range_are_rejected_with_their_line() {
    for (text, key, line) in [
        ("[medium]\nvolume_fraction = 0.74", "medium.volume_fraction", 2),
        ("[medium]\nvolume_fraction = -0.1", "medium.volume_fraction", 2),
        ("[medium]\n\nhost_index = nan", "medium.host_index", 3),
        ("[medium]\nhost_index = 0.9", "medium.host_index", 2),
        ("[medium]\nhost_index = '1.5'", "medium.host_index", 2),
        ("[medium]\nhost_index = ' '", "medium.host_index", 2),
        ("[medium]\nhost_mu_a_per_mm = -1", "medium.host_mu_a_per_mm", 2),
        ("[medium]\nparticle_index = 5", "medium.particle_index", 2),
        ("[yarn]\nradius_mm = inf", "yarn.radius_mm", 2),
        ("[yarn]\nradius_mm = 0", "yarn.radius_mm", 2),
        ("[medium]\ndye = ''", "medium.dye", 2),
        ("[rig]\nincidences_deg = [0, 90]", "rig.incidences_deg", 2),
        ("[rig]\nincidences_deg = []", "rig.incidences_deg", 2),
        ("[rig]\nincidences_deg = [0, 30, 0]", "rig.incidences_deg", 2),
        ("[rig]\nview_step_deg = 7", "rig.view_step_deg", 2),
        ("[rig]\nview_step_deg = 1e-300", "rig.view_step_deg", 2),
        ("[rig]\nview_max_deg = -70", "rig.view_max_deg", 2),
        ("[spectrum]\nwavelength_max_nm = 380", "spectrum.wavelength_max_nm", 2),
        ("[spectrum]\nwavelength_step_nm = 11", "spectrum.wavelength_step_nm", 2),
        ("[spectrum]\nwavelengths_nm = [500, 400]", "spectrum.wavelengths_nm", 2),
        ("[sweep]\nvolume_fraction = [0.1, 0.8]", "sweep.volume_fraction", 2),
        ("[trace]\npaths_bssrdf = 8", "trace.paths_bssrdf", 2),
        ("[trace]\nazimuth_cells = 10", "trace.azimuth_cells", 2),
        ("[cloth]\nsinusoid_amplitude_mm = 0.1", "cloth.sinusoid_amplitude_mm", 2),
    ] {
        match refused(text) {
            StudyError::Value {
                place: Some(place),
                key: found,
                ..
            } => assert_eq!((found.as_str(), place.line), (key, line)),
            other => panic!("{text}: {other}"),
        }
    }
    let message = refused("[medium]\nvolume_fraction = 14").to_string();
    assert_eq!(
        message,
        "my.toml, line 2: `medium.volume_fraction`: expected a number, 0 to below 0.74, found 14; correct it, or leave \
         it out for its default; it is: Share of the yarn's volume that is particles"
    );
}

#[test]
fn study_changed_in_memory_is_validated() {
    let mut study = Study::default();
    study.yarn.radius_mm = f64::NAN;
    let message = study.validate().unwrap_err().to_string();
    assert!(
        message.starts_with("`yarn.radius_mm`: expected a number, 1e-6 to 100 mm, found no number"),
        "{message}"
    );
    assert!(study.to_toml().is_err());
    let study = Study {
        seed: u64::MAX,
        ..Study::default()
    };
    assert!(study.validate().unwrap_err().to_string().contains("`seed`"));
}

#[test]
fn invalid_toml_reports_its_line() {
    for text in ["seed = 1\n[medium\n", "seed = 1\nseed = 2\n", "seed = 1\nx ="] {
        match refused(text) {
            StudyError::Syntax { place, .. } => assert_eq!((place.file.as_str(), place.line), ("my.toml", 2), "{text}"),
            other => panic!("{text}: {other}"),
        }
    }
}

fn table(text: &str) -> tempfile::NamedTempFile {
    let mut file = tempfile::NamedTempFile::new().unwrap();
    file.write_all(text.as_bytes()).unwrap();
    file
}

/// A study of three wavelengths with tables for some of the medium's numbers.
fn with_tables(tables: &[(&str, &str)]) -> Study {
    let keys: String = tables.iter().map(|(key, path)| format!("{key} = '{path}'\n")).collect();
    Study::from_toml(
        &format!("[spectrum]\nwavelengths_nm = [450, 500, 650]\n[medium]\n{keys}"),
        "t",
    )
    .unwrap()
}

/// Linear between rows, exact at them, and the same coefficients as a number where the table has that number.
#[test]
fn numbers_of_the_medium_may_be_tables() {
    let host = table("# n of a fibre\nwavelength_nm,value\n400,1.58\n500,1.56\n700,1.55\n");
    let particle = table("wavelength_nm,value\n400,1.63\n500,1.61\n700,1.61\n");
    let mu_a = table("wavelength_nm,value\n400,3\n500,2\n700,0\n");
    let path = |file: &tempfile::NamedTempFile| file.path().display().to_string();
    let study = with_tables(&[
        ("host_index", &path(&host)),
        ("particle_index", &path(&particle)),
        ("host_mu_a_per_mm", &path(&mu_a)),
    ]);
    let tabulated = medium(&study).unwrap();
    for (found, expected) in tabulated.host_index().iter().zip([1.57, 1.56, 1.5525]) {
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
    assert!(tabulated.is_dispersive());
    let mut plain = with_tables(&[]);
    plain.medium.host_index = NumberOrTable::Number(1.56);
    plain.medium.particle_index = NumberOrTable::Number(1.61);
    plain.medium.host_mu_a_per_mm = NumberOrTable::Number(2.0);
    let constant = medium(&plain).unwrap();
    for pair in [
        (tabulated.mu_s_per_mm(), constant.mu_s_per_mm()),
        (tabulated.mu_a_per_mm(), constant.mu_a_per_mm()),
        (tabulated.g(), constant.g()),
    ] {
        assert_eq!(pair.0[1], pair.1[1]);
        assert_ne!(pair.0[0], pair.1[0]);
    }
    let names: Vec<String> = Plan::new(study).unwrap().inputs.into_iter().map(|i| i.name).collect();
    assert_eq!(
        names,
        [
            "dye preprint-red".to_owned(),
            format!("host_index {}", path(&host)),
            format!("host_mu_a_per_mm {}", path(&mu_a)),
            format!("particle_index {}", path(&particle)),
            "sample merl-red-fabric".into(),
        ]
    );
}

/// One column of values beside the wavelengths is plain under any title.
#[test]
fn table_may_use_any_title_for_its_values() {
    let file = table("wavelength_nm,n\n400,1.5\n700,1.5\n");
    let medium = medium(&with_tables(&[("host_index", &file.path().display().to_string())])).unwrap();
    assert!(medium.host_index().iter().all(|&n| n == 1.5));
}

#[test]
fn invalid_table_is_rejected_with_key_and_file() {
    for (key, text, words) in [
        (
            "host_index",
            "wavelength_nm,value\n400,1.5\n500,0.5\n700,1.5\n",
            &["each value 1 to 4", "0.5 at 500 nm"][..],
        ),
        (
            "host_mu_a_per_mm",
            "wavelength_nm,value\n400,-1\n700,1\n",
            &["each value 0 to 1000000 1/mm", "-1 at 400 nm"],
        ),
        (
            "particle_index",
            "wavelength_nm,value\n460,1.6\n700,1.6\n",
            &["460..700 nm", "no value at 450 nm"],
        ),
        (
            "host_index",
            "wavelength_nm,value\n400,1.5\n700,thick\n",
            &["line 3", "column value", "found thick"],
        ),
        (
            "host_index",
            "wavelength_nm,value,k\n400,1.5,0\n700,1.5,0\n",
            &["expected one spectrum, found 2", "keep one column of values"],
        ),
    ] {
        let file = table(text);
        let path = file.path().display().to_string();
        let message = medium(&with_tables(&[(key, &path)])).unwrap_err().to_string();
        assert!(
            message.starts_with("t, line ")
                && message.contains(&format!(": `medium.{key}`: "))
                && message.contains(&path),
            "{message}"
        );
        assert!(words.iter().all(|w| message.contains(w)), "{message}");
    }
    let study = with_tables(&[("host_index", "/nowhere/host.csv")]);
    let message = Plan::new(study).err().unwrap().to_string();
    assert!(
        message.contains(": `medium.host_index`: /nowhere/host.csv: cannot be read: "),
        "{message}"
    );
}

proptest! {
    #[test]
    fn no_text_makes_the_reader_panic(text in "\\PC*") {
        let _ = Study::from_toml(&text, "t");
    }

    #[test]
    fn no_damage_to_a_study_makes_the_reader_panic(at in 0usize..8000, insert in "\\PC{0,4}", cut in 0usize..6) {
        let text = Study::commented_toml();
        let chars: Vec<char> = text.chars().collect();
        let at = at.min(chars.len());
        let end = (at + cut).min(chars.len());
        let damaged: String = chars[..at].iter().copied().chain(insert.chars()).chain(chars[end..].iter().copied()).collect();
        if let Ok(study) = Study::from_toml(&damaged, "t") {
            prop_assert!(study.validate().is_ok());
        }
    }
}

#[test]
fn decimal_comma_is_reported_with_the_decimal_point_to_use() {
    for (text, found, point) in [
        ("[yarn]\nradius_mm = 0,15\n", "0,15", "write 0.15"),
        ("[yarn]\nradius_mm = 0,15 # mm\n", "0,15", "write 0.15"),
        ("[cloth]\nazimuth_deg=-12,5", "-12,5", "write -12.5"),
    ] {
        let message = Study::from_toml(text, "my.toml").unwrap_err().to_string();
        assert!(
            message.starts_with("my.toml, line 2") && message.contains(found) && message.contains(point),
            "{message}"
        );
    }
    let other = Study::from_toml("[yarn]\nradius_mm = 0.15 0\n", "my.toml")
        .unwrap_err()
        .to_string();
    assert!(!other.contains("decimal"), "{other}");
}
