//! Tables of spectra and of readings as spreadsheets, scripts and instruments write them: the same values, or a refusal
//! that names file, line, cause and remedy.

use crate::command::specval;
use serde_json::Value;
use specval::formats::{ReadOptions, parse, registry};
use specval::sample::Sample;
use specval::spectrum::SpectraFile;
use std::fs;

type Rows = Vec<Vec<String>>;

fn row(cells: &[&str]) -> Vec<String> {
    cells.iter().map(|cell| (*cell).to_owned()).collect()
}

/// Titles and rows of two spectra.
fn spectra() -> Rows {
    let mut rows = vec![row(&["wavelength_nm", "red", "white"])];
    for k in 0..8 {
        let values = [format!("0.{}", 15 + 7 * k), format!("0.{}", 81 - k)];
        rows.push(vec![format!("{}", 400 + 40 * k), values[0].clone(), values[1].clone()]);
    }
    rows
}

/// Titles and rows of readings, three geometries of four wavelengths.
fn readings() -> Rows {
    let mut rows = vec![row(&["theta_i_deg", "theta_v_deg", "wavelength_nm", "beta", "beta_se"])];
    for (i, v) in [(0, 0), (45, -15), (45, 30)] {
        for k in 0..4 {
            let beta = format!("0.{}", 20 + i / 5 + 3 * k);
            rows.push(vec![
                i.to_string(),
                v.to_string(),
                (420 + 80 * k).to_string(),
                beta,
                "0.01".into(),
            ]);
        }
    }
    rows
}

struct Layout {
    separator: &'static str,
    end: &'static str,
    quoted: bool,
    decimal: &'static str,
    before: &'static str,
    behind: &'static str,
}

const PLAIN: Layout = Layout {
    separator: ",",
    end: "\n",
    quoted: false,
    decimal: ".",
    before: "",
    behind: "",
};

fn text(rows: &Rows, layout: &Layout) -> String {
    let cell = |cell: &String| match layout.quoted {
        true => format!("\"{}\"", cell.replace('.', layout.decimal)),
        false => cell.replace('.', layout.decimal),
    };
    let mut text = layout.before.to_owned();
    for row in rows {
        let cells: Vec<String> = row.iter().map(cell).collect();
        text += &cells.join(layout.separator);
        text += layout.end;
    }
    text + layout.behind
}

/// Layouts that hold the same table.
fn layouts() -> Vec<Layout> {
    let mut layouts = Vec::new();
    for (separator, before) in [
        (",", ""),
        (";", ""),
        ("\t", ""),
        ("|", ""),
        (" ", ""),
        ("   ", ""),
        (", ", ""),
        (";", "sep=;\n"),
        (";", "\"Sep=;\"\r\n"),
        (",", "# a comment, of two\n\n# more\n"),
        (";", "Instrument: X 100\nDate: 2026-01-01\n\n"),
        (",", "; made by a program\n% and another\n"),
    ] {
        for (end, behind) in [
            ("\n", ""),
            ("\r\n", "\r\n\r\n"),
            ("\r", ""),
            ("\n", "# end\n"),
            ("\n", "\u{1a}"),
        ] {
            for quoted in [false, true] {
                layouts.push(Layout {
                    separator,
                    end,
                    quoted,
                    decimal: ".",
                    before,
                    behind,
                });
                if !separator.contains(',') && !before.contains(',') {
                    layouts.push(Layout {
                        separator,
                        end,
                        quoted,
                        decimal: ",",
                        before,
                        behind,
                    });
                }
            }
        }
    }
    layouts
}

fn values_of_spectra(bytes: &[u8]) -> Vec<(String, Vec<f64>, Vec<f64>)> {
    let file = SpectraFile::parse("t.csv", bytes).unwrap_or_else(|e| panic!("{}: {e}", String::from_utf8_lossy(bytes)));
    let of = |(name, samples): &(String, specval::spectrum::Samples)| {
        (name.clone(), samples.grid().nm().to_vec(), samples.values().to_vec())
    };
    file.spectra.iter().map(of).collect()
}

/// Values of readings as `report --measured` reads them, and as `inspect` does: both must.
fn values_of_readings(bytes: &[u8]) -> Vec<(f64, f64, Vec<f64>, Vec<f64>)> {
    let scratch = tempfile::tempdir().unwrap();
    let path = scratch.path().join("t.csv");
    fs::write(&path, bytes).unwrap();
    let shown = String::from_utf8_lossy(bytes);
    let sample = Sample::load(path.to_str().unwrap()).unwrap_or_else(|e| panic!("{shown}: {e}"));
    let data = parse("t.csv", bytes, &ReadOptions::default()).unwrap_or_else(|e| panic!("{shown}: {e}"));
    let readings: Vec<_> = sample
        .raw()
        .map(|r| (r.theta_i_deg, r.theta_v_deg, r.beta.to_vec(), r.se.to_vec()))
        .collect();
    assert_eq!(data.components[0].incidences_deg(), [0.0, 45.0], "{shown}");
    assert_eq!(data.components[0].channels.count(), readings[0].2.len(), "{shown}");
    readings
}

#[test]
fn layouts_of_text_change_no_value() {
    let good = values_of_spectra(text(&spectra(), &PLAIN).as_bytes());
    let measured = values_of_readings(text(&readings(), &PLAIN).as_bytes());
    assert_eq!((good.len(), measured.len()), (2, 3));
    let layouts = layouts();
    assert!(layouts.len() > 150);
    for layout in &layouts {
        assert_eq!(values_of_spectra(text(&spectra(), layout).as_bytes()), good);
        assert_eq!(values_of_readings(text(&readings(), layout).as_bytes()), measured);
    }
}

#[test]
fn titles_of_other_languages_and_scripts_are_known() {
    let good = values_of_spectra(text(&spectra(), &PLAIN).as_bytes());
    for title in [
        "Wellenl\u{e4}nge",
        "Wellenla\u{308}nge (nm)",
        "longueur d'onde",
        "Longueur d\u{2019}onde (nm)",
        "\u{3bb}",
        "\u{3bb}/nm",
        "lambda [nm]",
        "WL",
        "wvl",
        "Wavelength (nm)",
        "wavelength_nm",
        "waveLengthNm",
        "nm",
        "Nanometers",
        "\u{6ce2}\u{9577} (nm)",
        "longitud de onda",
    ] {
        let mut rows = spectra();
        rows[0][0] = title.into();
        assert_eq!(values_of_spectra(text(&rows, &PLAIN).as_bytes()), good, "{title}");
    }
    let measured = values_of_readings(text(&readings(), &PLAIN).as_bytes());
    for [theta_i, theta_v, beta, se] in [
        ["theta_i", "theta_v", "beta", "beta_se"],
        ["theta_in", "theta_out", "BRF", "BRF_se"],
        ["Incidence (deg)", "View (deg)", "radiance factor", "std"],
        ["\u{3b8}_i (\u{b0})", "\u{3b8}_r (\u{b0})", "\u{3b2}", "u(\u{3b2})"],
        ["angle of incidence", "viewing angle", "reflectance", "uncertainty"],
        ["thetaI", "thetaR", "value", "se"],
    ] {
        let mut rows = readings();
        rows[0] = row(&[theta_i, theta_v, "\u{3bb} (nm)", beta, se]);
        assert_eq!(
            values_of_readings(text(&rows, &PLAIN).as_bytes()),
            measured,
            "{theta_i}"
        );
        rows.insert(1, row(&["deg", "deg", "nm", "1", "1"]));
        assert_eq!(
            values_of_readings(text(&rows, &PLAIN).as_bytes()),
            measured,
            "{theta_i}, units"
        );
        rows[1] = row(&["rad", "rad", "nm", "1", "1"]);
        for error in refusals(&text(&rows, &PLAIN)) {
            assert!(error.contains("57.29578") && error.contains("line 2"), "{error}");
        }
    }
}

/// What both readers of readings say.
fn refusals(text: &str) -> [String; 2] {
    let scratch = tempfile::tempdir().unwrap();
    let path = scratch.path().join("t.csv");
    fs::write(&path, text).unwrap();
    let sample = Sample::load(path.to_str().unwrap()).unwrap_err().to_string();
    [
        sample,
        parse("t.csv", text.as_bytes(), &ReadOptions::default())
            .unwrap_err()
            .to_string(),
    ]
}

#[test]
fn one_column_a_wavelength_in_plane_and_sphere() {
    let measured = values_of_readings(text(&readings(), &PLAIN).as_bytes());
    for form in [
        "{}",
        "{} nm",
        "R{}",
        "R_{}",
        "nm{}",
        "R({})",
        "{} (nm)",
        "Reflectance {}",
        "SPEC_{}",
        "\u{3bb}{}",
    ] {
        let long = readings();
        let mut rows = vec![row(&["theta_i_deg", "theta_v_deg"])];
        rows[0].extend(long[1..5].iter().map(|r| form.replace("{}", &r[2])));
        rows[0].extend(long[1..5].iter().map(|r| format!("{}_se", form.replace("{}", &r[2]))));
        for geometry in long[1..].chunks(4) {
            let mut wide = geometry[0][..2].to_vec();
            wide.extend(geometry.iter().map(|r| r[3].clone()));
            wide.extend(geometry.iter().map(|r| r[4].clone()));
            rows.push(wide);
        }
        assert_eq!(values_of_readings(text(&rows, &PLAIN).as_bytes()), measured, "{form}");
    }
    for header in [
        "theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,450,550",
        "theta_in,phi_in,theta_out,phi_out,450 nm,550 nm",
        "theta_i (deg);azimuth_in;theta_v;azimuth_out;R450;R550",
    ] {
        let rows = "0,0,30,0,0.4,0.5\n0,0,30,180,0.6,0.7\n".replace(',', if header.contains(';') { ";" } else { "," });
        let data = parse("t.csv", format!("{header}\n{rows}").as_bytes(), &ReadOptions::default()).unwrap();
        assert_eq!(data.components[0].channels.count(), 2, "{header}");
    }
}

#[test]
fn any_order_is_sorted_and_repeated_readings_are_one() {
    let told = |bytes: &str| {
        let notices = SpectraFile::parse("t.csv", bytes.as_bytes()).unwrap().notices;
        notices.iter().map(|notice| format!("{notice}\n")).collect::<String>()
    };
    let good = spectra();
    let descending: Rows = good[..1].iter().chain(good[1..].iter().rev()).cloned().collect();
    let descending = text(&descending, &PLAIN);
    assert_eq!(
        values_of_spectra(descending.as_bytes()),
        values_of_spectra(text(&good, &PLAIN).as_bytes())
    );
    assert!(
        told(&descending).contains("from 680 to 400 nm: sorted"),
        "{}",
        told(&descending)
    );
    let mut repeated = good.clone();
    repeated.push(good[3].clone());
    assert!(told(&text(&repeated, &PLAIN)).contains("1 line repeats a reading"));
    repeated[9][1] = "0.9".into();
    let error = SpectraFile::parse("t.csv", text(&repeated, &PLAIN).as_bytes())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("line 10, column wavelength_nm") && error.contains("or their mean"),
        "{error}"
    );

    let measured = readings();
    let expected = values_of_readings(text(&measured, &PLAIN).as_bytes());
    let reversed: Rows = measured[..1]
        .iter()
        .chain(measured[1..].iter().rev())
        .cloned()
        .collect();
    assert_eq!(values_of_readings(text(&reversed, &PLAIN).as_bytes()), expected);
    let mut repeated = measured.clone();
    repeated.push(measured[2].clone());
    assert_eq!(values_of_readings(text(&repeated, &PLAIN).as_bytes()), expected);
    repeated[13][3] = "0.9".into();
    for error in refusals(&text(&repeated, &PLAIN)) {
        assert!(error.contains("line 14") && error.contains("their mean"), "{error}");
        assert!(!error.contains("column 1"), "{error}");
    }
}

/// Radians are told and left: 1.05 is not moved to 1 degree.
#[test]
fn radians_are_no_nominal_degrees() {
    let scratch = tempfile::tempdir().unwrap();
    let path = scratch.path().join("t.csv");
    let mut text = "theta_i_deg,theta_v_deg,beta_r,beta_g,beta_b\n".to_owned();
    for theta_v in [-1.05, -0.52, 0.0, 0.03, 0.52, 1.05] {
        text += &format!("0.02,{theta_v},0.5,0.4,0.3\n");
    }
    fs::write(&path, text).unwrap();
    let sample = Sample::load(path.to_str().unwrap()).unwrap();
    let views: Vec<f64> = sample.geometries().map(|(_, theta_v)| theta_v).collect();
    assert_eq!(views, [-1.05, -0.52, 0.0, 0.03, 0.52, 1.05]);
    assert_eq!(sample.angles_read().moved, 0);
    assert!(
        sample
            .notices()
            .iter()
            .any(|notice| notice.to_string().contains("radians")),
        "{:?}",
        sample.notices()
    );
    for (header, remedy) in [
        ("theta_i_rad,theta_v_rad,450,550", "57.29578"),
        (
            "theta_i_deg,theta_v_deg,wavelength (um),beta",
            "multiply micrometres by 1000",
        ),
    ] {
        for error in refusals(&format!("{header}\n0,0.5,0.55,0.4\n")) {
            assert!(error.contains(remedy) && error.contains("line 1"), "{error}");
        }
    }
}

/// --scatter and --side choose the component in every command that reads one, and a missing one is refused with those
/// there.
#[test]
fn components_are_chosen_in_every_command() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let mut text = "theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,450,500,550,600,650\n".to_owned();
    for theta_i in [0, 40] {
        for theta_o in [100, 140, 180] {
            for phi_o in [0, 90, 180, 270] {
                text += &format!("{theta_i},0,{theta_o},{phi_o},0.2,0.2,0.2,0.2,0.2\n");
            }
        }
    }
    // Of one direction there is one value.
    let text: String = text
        .lines()
        .filter(|line| !line.contains(",180,") || line.contains(",180,0,"))
        .map(|l| format!("{l}\n"))
        .collect();
    fs::write(folder.join("through.csv"), text).unwrap();
    for command in [&["colour", "through.csv"][..], &["check", "--sample", "through.csv"]] {
        let refused = specval(folder, command);
        let error = String::from_utf8_lossy(&refused.stderr);
        assert_eq!(refused.status.code(), Some(2), "{command:?}: {error}");
        assert!(error.contains("found transmission of light from the front"), "{error}");
        assert!(error.contains("--scatter"), "{error}");
        let chosen = specval(folder, &[command, &["--scatter", "transmission"]].concat());
        assert_ne!(chosen.stdout.len(), 0, "{}", String::from_utf8_lossy(&chosen.stderr));
    }
    let colours = specval(
        folder,
        &["colour", "through.csv", "--scatter", "transmission", "--json"],
    );
    let colours: Value = serde_json::from_slice(&colours.stdout).unwrap();
    assert!((colours[0]["Y"].as_f64().unwrap() - 0.2).abs() < 1e-6, "{colours}");
    for command in [
        &["colour", "through.csv", "--side", "back"][..],
        &["inspect", "through.csv", "--side", "back"],
        &["check", "--sample", "through.csv", "--side", "back"],
        &["report", "--quick", "--measured", "through.csv", "--side", "back"],
        &["report", "--quick", "--scatter", "transmission"],
        &["check", "--side", "back"],
    ] {
        let refused = specval(folder, command);
        let error = String::from_utf8_lossy(&refused.stderr);
        assert_eq!(refused.status.code(), Some(2), "{command:?}: {error}");
        assert!(
            error.contains("expected") && error.contains("; "),
            "{command:?}: {error}"
        );
    }
    assert!(!folder.join("report").exists());
}

/// The list of formats is kept in one place; the page for users must have a row for each of them.
#[test]
fn every_format_is_in_the_docs() {
    let docs = fs::read_to_string("docs/formats.md").unwrap();
    for known in registry::all() {
        let name = known.format.name();
        assert!(
            docs.contains(&format!("\n| `{name}` |")),
            "docs/formats.md has no row of {name}"
        );
        assert_eq!(registry::descriptor(known.format).format, known.format);
        assert_eq!(
            registry::all()
                .iter()
                .filter(|other| other.format == known.format)
                .count(),
            1
        );
    }
}

/// Every extension of a file that is written says one format, and every name of a target is there once.
#[test]
fn targets_and_extensions_are_told_apart() {
    let mut extensions: Vec<&str> = registry::extensions().map(|(extension, ..)| extension).collect();
    let mut targets: Vec<&str> = registry::targets().map(|(name, ..)| name).collect();
    for list in [&mut extensions, &mut targets] {
        list.sort_unstable();
        assert!(list.windows(2).all(|pair| pair[0] != pair[1]), "{list:?}");
    }
}
