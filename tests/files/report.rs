//! The tables, the JSON document and the output folder.

use crate::report_data::data;
use specval::compare::Geometry;
use specval::formats::ReadNotice;
use specval::output::*;
use specval::report::*;
use specval::sample::SampleNotice;
use specval::spectrum::{Doubt, TextNotice};

fn text(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).unwrap()
}

#[test]
fn table_headers_are_fixed_and_match_the_rows() {
    let data = data();
    let tables = [
        (
            table1_csv(&data).unwrap(),
            "row,blue_over_red,blue_over_red_se,green_over_red,green_over_red_se",
            5,
            serde_json::to_value(&data.table1[0]).unwrap(),
        ),
        (
            curves_csv(&data).unwrap(),
            "theta_i_deg,theta_v_deg,source,channel,beta,se",
            3 * 27 * 3 * 4,
            serde_json::to_value(&data.curves[0]).unwrap(),
        ),
        (
            energy_csv(&data).unwrap(),
            "wavelength_nm,theta_in_deg,phi_in_deg,reflected,reflected_se,ballistic,ballistic_se,scattered,\
             scattered_se,absorbed,absorbed_se,roulette,roulette_se,residual,residual_se,mis_net,mis_net_se",
            2,
            serde_json::to_value(&data.energy[0]).unwrap(),
        ),
    ];
    for (bytes, header, rows, mut first) in tables {
        // Which values were interpolated is not among the fixed names.
        first.as_object_mut().unwrap().remove("interpolated");
        let table = text(bytes);
        let mut lines = table.lines();
        assert_eq!(lines.next(), Some(header));
        assert_eq!(lines.count(), rows);
        // The first row, read back by column name, is the value the row was made from.
        let mut reader = csv::Reader::from_reader(table.as_bytes());
        let row: std::collections::HashMap<String, String> = reader.deserialize().next().unwrap().unwrap();
        for (name, value) in first.as_object().unwrap() {
            match value {
                serde_json::Value::Number(number) => {
                    assert_eq!(row[name].parse::<f64>().unwrap(), number.as_f64().unwrap(), "{name}")
                }
                serde_json::Value::String(word) => assert_eq!(&row[name], word, "{name}"),
                _ => assert_eq!(row[name], "", "{name}"),
            }
        }
    }
}

#[test]
fn numbers_are_the_shortest_that_read_back_exactly() {
    let table = text(table1_csv(&data()).unwrap());
    let model = table.lines().nth(3).unwrap();
    let cells: Vec<&str> = model.split(',').collect();
    assert_eq!((cells[0], cells[1]), ("model", "0.30000000000000004"));
    let energy = text(energy_csv(&data()).unwrap());
    assert!(energy.contains("0.3333333333333333,"), "{energy}");
    assert!(energy.contains("-1e-17"), "{energy}");
}

#[test]
fn missing_value_is_empty_cell_and_null() {
    let table = text(table1_csv(&data()).unwrap());
    assert_eq!(table.lines().nth(1), Some("published,0.08,,0.011,"));
    let document: serde_json::Value = serde_json::from_str(&report_json(&data()).unwrap()).unwrap();
    assert!(document["table1"][0]["blue_over_red_se"].is_null());
}

#[test]
fn tables_without_rows_keep_their_header() {
    let mut data = data();
    data.energy.clear();
    assert_eq!(text(energy_csv(&data).unwrap()).lines().count(), 1);
}

#[test]
fn markdown_table_has_conventions_footnotes_and_notices() {
    let markdown = table1_markdown(&data());
    for expected in [
        "| published[^published] | 0.08 | 0.011 |",
        "| measured[^sample] | 0.0595 ± 0.0042 | 0.143 ± 0.010 |",
        "| model range[^range] | 0.047 to 0.26 | -0.0004 to 0.0171 |",
        "| CIE 1931 2°, E, CIE RGB, no adaptation | model | 0.30000000 ± 0.00000010 | 0.01200 ± 0.00040 |",
        "fit of a measurement",
        "CC-BY-SA-4.0",
        "white of the published ratios are not stated there",
        "the sweep's blue/red range 0.0470..0.2600 covers the preprint's 0.05..0.25",
    ] {
        assert!(markdown.contains(expected), "{expected} is missing in\n{markdown}");
    }
}

/// The result of the reference study is of the version that this program reads, and draws its report.
#[test]
fn committed_result_draws_the_committed_tables() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/preprint");
    let data = read_result(&folder).unwrap().data;
    let files = [
        ("table1.csv", table1_csv(&data).unwrap()),
        ("table1.md", table1_markdown(&data).into_bytes()),
        ("curves.csv", curves_csv(&data).unwrap()),
        ("energy.csv", energy_csv(&data).unwrap()),
        ("report.json", report_json(&data).unwrap().into_bytes()),
        (RESULT, result_json(&data).unwrap()),
    ];
    for (name, bytes) in files {
        assert!(std::fs::read(folder.join(name)).unwrap() == bytes, "{name}");
    }
}

#[test]
fn report_json_has_the_fixed_fields() {
    let document: serde_json::Value = serde_json::from_str(&report_json(&data()).unwrap()).unwrap();
    assert_eq!(document["table1"][3]["row"], "model_low");
    assert_eq!(document["normalisation"]["model"]["value"], 0.931);
    assert_eq!(document["rmse"][1]["source"], "classical");
    assert_eq!(document["rmse"][1]["channel"], "r");
    assert_eq!(document["rmse"][1]["value"], 0.022);
    assert_eq!(document["rmse"][1]["se"], 0.1 * 0.022);
    assert_eq!(document["rmse_ratios"][0]["verdict"], "better");
    let provenance = &document["provenance"];
    assert_eq!(provenance["seed"], 1);
    assert_eq!(provenance["effort"]["batches"], 24);
    assert_eq!(provenance["effort"]["stopped_by"], "precision");
    assert_eq!(provenance["effort"]["asked"]["until"], "rel 0.01 curves");
    assert_eq!(provenance["effort"]["reached"]["largest_error"], 0.0098);
    // FIPS 180-4, the digest of "abc".
    assert_eq!(
        provenance["inputs"][0]["sha256"],
        "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    );
}

/// The result holds them as data, the report in words.
#[test]
fn notices_and_fallbacks_survive_the_result_file() {
    let paths = LongPaths {
        particles: 4e5,
        mu_s_per_mm: 1234.5,
        host_index: 1.557,
    };
    let doubt = Doubt::ParticleDiameter { diameter_nm: 0.15 };
    let notices = [
        (Notice::Quick, "--quick: paths and camera rays are reduced"),
        (
            Notice::GrazingGain {
                gains: vec![GrazingGain {
                    theta_i_deg: 80.0,
                    white_albedo: 1.234,
                }],
            },
            "falls on it at 80 deg (factor 1.23); brightness",
        ),
        (
            Notice::LongRun {
                seconds: Some(7300.0),
                paths: Some(paths),
                longest: Some(("trace.tilts".into(), 180)),
            },
            "a long run: by an estimate it takes about 2 h on one core; a path meets about 400000 particles in a yarn",
        ),
        (
            Notice::ParticleDiameter {
                section: "weft".into(),
                doubt: doubt.clone(),
            },
            "`weft.particle_diameter_nm`: a particle of 0.15 nm is smaller than a molecule",
        ),
        (SampleNotice::Doubt { doubt }.into(), "a particle of 0.15 nm"),
        (
            SampleNotice::Text {
                notice: TextNotice::Preamble { lines: 2 },
            }
            .into(),
            "2 lines before the titles of the columns: passed over as comments",
        ),
        (
            SampleNotice::Format {
                notice: ReadNotice::Several {
                    notice: ReadNotice::BelowZero {
                        array: "rgb".into(),
                        count: 3,
                        lowest: -0.1,
                        rgb: true,
                    }
                    .into(),
                    times: 2,
                },
            }
            .into(),
            "3 values of `rgb` are below 0, down to -0.1, as colours outside the RGB space have them; what is below 0 \
             after interpolation counts as 0 (2 times)",
        ),
        (
            SampleNotice::RenamedColumns {
                columns: vec!["'view' as theta_v_deg".into()],
                unsigned: true,
            }
            .into(),
            "read as these: 'view' as theta_v_deg; no view is below 0, so all are on the mirror side",
        ),
        (
            Notice::MorePaths {
                relative_se: 0.1,
                times: 4.0,
                paths: 100,
            },
            "standard error of 10.0 %: for 5 % it takes about 4.0 times the paths of this run, 400 a tilt in place of \
             100",
        ),
    ];
    let fallbacks = [
        (
            Fallback::NothingCompared {
                sample: "felt".into(),
                incidences_deg: vec![22.5, 45.0],
            },
            "sample felt has no reading at any geometry of the study's [rig]: nothing is compared; its incidences are \
             22.5, 45",
        ),
        (
            Fallback::OtherReference {
                at: Geometry {
                    theta_i_deg: 45.0,
                    theta_v_deg: -5.0,
                },
            },
            "incidence 45 and view -5 degrees",
        ),
    ];
    let mut data = data();
    data.provenance.notices = notices.iter().map(|(notice, _)| notice.clone()).collect();
    data.provenance.fallbacks = fallbacks.iter().map(|(fallback, _)| fallback.clone()).collect();
    let scratch = tempfile::tempdir().unwrap();
    std::fs::write(scratch.path().join(RESULT), result_json(&data).unwrap()).unwrap();
    assert_eq!(read_result(scratch.path()).unwrap().data, data);
    let document: serde_json::Value = serde_json::from_str(&report_json(&data).unwrap()).unwrap();
    let told = |list: &str, place: usize| document["provenance"][list][place].as_str().unwrap().to_owned();
    for (place, (notice, words)) in notices.iter().enumerate() {
        assert_eq!(told("notices", place), notice.to_string());
        assert!(notice.to_string().contains(words), "{notice}");
    }
    for (place, (fallback, words)) in fallbacks.iter().enumerate() {
        assert_eq!(told("fallbacks", place), fallback.to_string());
        assert!(fallback.to_string().contains(words), "{fallback}");
    }
}

#[test]
fn terminal_summary_has_verdicts_notices_and_fallbacks() {
    let summary = summary(&data());
    for expected in [
        "0.0110 ± 0.0011",
        "better (ratio 2, 95 % interval 1.3 to 2.9)",
        "model multiplied by 0.931 ± 0.012",
        "effort: 24 batches, each of 12500 paths a tilt and 1250 a direction of the ledger; stopped by precision \
         (asked: rel 0.01 curves, 60 s, 100000 batches at most); largest relative standard error of the curves: 0.0098",
        "notice: the sweep's blue/red range 0.0470..0.2600 covers",
        "fallback: the sample states no uncertainty",
    ] {
        assert!(summary.contains(expected), "{expected} is missing in\n{summary}");
    }
}

#[test]
fn report_is_reproducible_and_written_whole() {
    let data = data();
    let files = render(&data).unwrap();
    assert_eq!(files, render(&data).unwrap());
    let scratch = tempfile::tempdir().unwrap();
    let names: Vec<String> = files.iter().map(|file| file.name.clone()).collect();
    assert_eq!(
        names,
        file_names(&Outline {
            incidences: 3,
            approximations: false
        })
    );
    let folder = ReportFolder::prepare(&scratch.path().join("deep/er"), &names, &[], false).unwrap();
    for _ in 0..2 {
        folder.write(&files, |_| false).unwrap();
        let mut found: Vec<_> = std::fs::read_dir(folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        let mut expected = [&names[..], &["report.sha256".to_owned(), "specval.lock".to_owned()]].concat();
        found.sort();
        expected.sort();
        assert_eq!(found, expected);
    }
    for file in &files {
        assert_eq!(std::fs::read(folder.path().join(&file.name)).unwrap(), file.bytes);
    }
}

#[test]
fn file_in_place_of_the_folder_is_refused_first() {
    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("report");
    std::fs::write(&file, "mine").unwrap();
    for path in [file.clone(), file.join("inside")] {
        let message = ReportFolder::prepare(&path, &[], &[], false).unwrap_err().to_string();
        assert!(message.contains(&file.display().to_string()), "{message}");
        assert!(message.contains("name another folder"), "{message}");
    }
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "mine");
}

#[test]
fn a_failed_write_leaves_the_earlier_report_alone() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = ReportFolder::prepare(scratch.path(), &[], &[], true).unwrap();
    let file = |name: &str, bytes: &[u8]| NamedFile {
        name: name.to_owned(),
        bytes: bytes.to_vec(),
    };
    folder.write(&[file("a", b"old")], |_| false).unwrap();
    std::fs::create_dir(scratch.path().join("b")).unwrap();
    let error = folder
        .write(&[file("a", b"new"), file("b", b"new")], |_| false)
        .unwrap_err();
    assert!(matches!(error, OutputError::FolderInTheWay { .. }), "{error}");
    assert_eq!(std::fs::read(scratch.path().join("a")).unwrap(), b"old");
    // A name the file system refuses fails while staging; again nothing changes.
    let error = folder
        .write(&[file("a", b"new"), file(&"x".repeat(300), b"new")], |_| false)
        .unwrap_err();
    assert!(matches!(error, OutputError::NotWritable { .. }), "{error}");
    assert_eq!(std::fs::read(scratch.path().join("a")).unwrap(), b"old");
    // Both, the record and the lock.
    assert_eq!(std::fs::read_dir(scratch.path()).unwrap().count(), 4);
}

#[test]
fn one_file_is_written_whole_or_not_at_all() {
    let scratch = tempfile::tempdir().unwrap();
    let path = scratch.path().join("curves.csv");
    let write = |path: &std::path::Path, bytes: &[u8]| write_whole(&Destination::find(path)?, bytes);
    write(&path, b"first").unwrap();
    write(&path, b"second").unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), b"second");
    assert!(write(scratch.path(), b"").is_err());
    let missing = scratch.path().join("none/curves.csv");
    let message = write(&missing, b"").unwrap_err().to_string();
    assert!(message.contains("none/curves.csv"), "{message}");
    assert_eq!(std::fs::read_dir(scratch.path()).unwrap().count(), 1);
}
