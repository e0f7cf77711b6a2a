use super::{Approximations, EnergyRow, ReportData, ReportError};
use crate::compare::{Channel, Geometry, Table1Name, Table1Row, known_error};
use serde::Serialize;
use std::fmt::Write;

/// `table1.csv`: a missing value is an empty cell.
pub fn table1_csv(data: &ReportData) -> Result<Vec<u8>, ReportError> {
    csv_of(
        &data.table1,
        &[
            "row",
            "blue_over_red",
            "blue_over_red_se",
            "green_over_red",
            "green_over_red_se",
        ],
    )
}

/// `curves.csv`: one line a point; what is not known is an empty cell, as the error of a sample that states none.
pub fn curves_csv(data: &ReportData) -> Result<Vec<u8>, ReportError> {
    let rows: Vec<_> = data
        .curves
        .iter()
        .map(|p| {
            let known = |value: f64| Some(value).filter(|value| value.is_finite());
            let sample = data.sample(&p.source);
            let unstated = sample.is_some_and(|sample| !sample.uncertainty_stated) && p.se == 0.0;
            let se = known_error(p.beta, p.se).filter(|_| !unstated);
            (p.theta_i_deg, p.theta_v_deg, &p.source, p.channel, known(p.beta), se)
        })
        .collect();
    csv_of(
        &rows,
        &["theta_i_deg", "theta_v_deg", "source", "channel", "beta", "se"],
    )
}

/// `energy.csv`: one line a wavelength and incident direction.
pub fn energy_csv(data: &ReportData) -> Result<Vec<u8>, ReportError> {
    csv_of(&data.energy, &EnergyRow::header())
}

/// `approximations.csv`: one line an incidence, channel and way to follow light in the cloth.
pub fn approximations_csv(of: &Approximations) -> Result<Vec<u8>, ReportError> {
    csv_of(
        &of.rows,
        &[
            "theta_i_deg",
            "channel",
            "source",
            "mean_beta",
            "mean_beta_se",
            "over_volumetric",
            "over_volumetric_se",
        ],
    )
}

/// `locality.csv`: one line a wavelength.
pub fn locality_csv(of: &Approximations) -> Result<Vec<u8>, ReportError> {
    csv_of(
        &of.locality,
        &[
            "wavelength_nm",
            "beyond_half_spacing",
            "beyond_half_spacing_se",
            "beyond_spacing",
            "beyond_spacing_se",
            "beyond_8_radii",
            "beyond_8_radii_se",
        ],
    )
}

/// A CSV table. Numbers are the shortest text that reads back exactly; a table without rows keeps its header.
fn csv_of<T: Serialize>(rows: &[T], header: &[&str]) -> Result<Vec<u8>, ReportError> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    writer.write_record(header)?;
    for row in rows {
        writer.serialize(row)?;
    }
    writer
        .into_inner()
        .map_err(|error| ReportError::Csv(error.into_error().into()))
}

/// `table1.md`: Table 1 for readers, with the ratios under every colour convention and footnotes on its rows.
pub fn table1_markdown(data: &ReportData) -> String {
    let mut text = String::from("# Table 1. Colour ratios at normal illumination and view\n\n");
    text += "Ratios of linear RGB components of the brightness factor, diffuse part, dimensionless; ± one standard \
             error.\n\n";
    let _ = writeln!(text, "Colour convention: {}.\n", data.colour_convention);
    text += "| | BLUE/RED | GREEN/RED |\n| --- | --- | --- |\n";
    for (label, blue, green) in formatted_rows(data, &data.table1) {
        let _ = writeln!(text, "| {label} | {blue} | {green} |");
    }
    if !data.conventions.is_empty() {
        text += "\n## The same ratios under every colour convention\n\n";
        text += "GREEN/RED of a red this deep is a small difference of large numbers: it moves with the convention far \
                 more than with the cloth.\n\n";
        text += "| Convention | | BLUE/RED | GREEN/RED |\n| --- | --- | --- | --- |\n";
        for convention in &data.conventions {
            for (label, blue, green) in formatted_rows(data, &convention.rows) {
                let _ = writeln!(
                    text,
                    "| {} | {label} | {blue} | {green} |",
                    cell(&convention.convention)
                );
            }
        }
    }
    if !data.provenance.notices.is_empty() {
        text += "\n## Notices\n\n";
        for notice in &data.provenance.notices {
            let _ = writeln!(text, "- {notice}");
        }
    }
    let at = elsewhere(data).map_or_else(String::new, |at| {
        format!(
            " At incidence {}° and view {}°, the reading nearest to normal incidence and view; the model's rows are of \
             these.",
            at.theta_i_deg, at.theta_v_deg
        )
    });
    let _ = writeln!(
        text,
        "\n[^published]: Red cotton of Voloboy, Galaktionov, Lobalzo, Keldysh Institute preprint 63 (2008), Table 1. \
         The RGB space and the white of the published ratios are not stated there."
    );
    for (place, sample) in data.samples.iter().enumerate() {
        let mark = footnote(data, place);
        let at = if place == 0 { at.as_str() } else { "" };
        let _ = writeln!(
            text,
            "[^{mark}]: {}, kind: {}. {} Source: {}. Licence: {}.{at}",
            sample.name,
            sample.kind,
            sample.caption,
            sample.source.trim_end_matches('.'),
            sample.licence.trim_end_matches('.')
        );
    }
    text += "[^orders]: The same yarn, with a part of the paths: light that goes on from yarn to yarn is left out, as \
             in the preprint, or followed to its end.\n";
    text += "[^range]: Lowest and highest ratio over the study's parameter sweep; \"model\" is at the study's own \
             parameters.\n";
    text
}

/// Label, BLUE/RED and GREEN/RED of each row; both ends of the model's range are one row.
fn formatted_rows(data: &ReportData, rows: &[Table1Row]) -> Vec<(String, String, String)> {
    let find = |name| rows.iter().find(|row| row.row == name);
    let mut out = Vec::new();
    for row in rows {
        let label = match &row.row {
            Table1Name::Published => "published[^published]".to_owned(),
            Table1Name::Source(id) => match data.samples.iter().position(|sample| sample.id == *id) {
                Some(place) => format!("{id}[^{}]", footnote(data, place)),
                None => id.to_string(),
            },
            Table1Name::ModelLow => {
                if let Some(high) = find(Table1Name::ModelHigh) {
                    out.push((
                        "model range[^range]".to_owned(),
                        range(row.blue_over_red, high.blue_over_red),
                        range(row.green_over_red, high.green_over_red),
                    ));
                }
                continue;
            }
            Table1Name::ModelHigh => continue,
            Table1Name::ModelDirect => "model, direct light alone[^orders]".to_owned(),
            Table1Name::ModelAllBounces => "model, all light between yarns[^orders]".to_owned(),
        };
        out.push((
            label,
            or_dash(row.blue_over_red, row.blue_over_red_se),
            or_dash(row.green_over_red, row.green_over_red_se),
        ));
    }
    out
}

/// Mark of the footnote of a sample.
fn footnote(data: &ReportData, place: usize) -> &str {
    match place {
        0 => "sample",
        _ => data.samples[place].id.as_str(),
    }
}

/// Where the comparison is normalised, if that is not normal incidence and view.
pub(super) fn elsewhere(data: &ReportData) -> Option<Geometry> {
    let at = data.readings.normalised_at?;
    (at.theta_i_deg != 0.0 || at.theta_v_deg != 0.0).then_some(at)
}

/// Incidence and view as instruments write them: 45/0.
pub(super) fn place(at: &Geometry) -> String {
    format!("{}/{}", at.theta_i_deg, at.theta_v_deg)
}

/// The place of a normalisation as a phrase.
pub(super) fn words_of(at: &Geometry) -> String {
    match (at.theta_i_deg, at.theta_v_deg) {
        (0.0, 0.0) => "normal light and view".to_owned(),
        (theta_i_deg, theta_v_deg) => format!("incidence {theta_i_deg}° and view {theta_v_deg}°"),
    }
}

/// A value and its standard error to the two leading digits of the error: 0.931 ± 0.012. A dash stands for what is not
/// known.
pub(super) fn with_error(value: f64, se: f64) -> String {
    /// Far below what any table shows: rounding of values that are 0 by construction.
    const NOTHING: f64 = 1e-9;
    if value.abs().max(se.abs()) < NOTHING {
        return "0".into();
    }
    let Some(se) = known_error(value, se) else {
        return format!("{} ± –", rounded(value));
    };
    let decimals = (1.0 - se.log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.decimals$} ± {se:.decimals$}")
}

/// Three significant digits without zeros at the end, which would claim a precision published values do not have; the
/// exact numbers stand in the CSV tables.
/// A value that is not known is a dash.
pub(super) fn rounded(value: f64) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    if value == 0.0 {
        return "0".into();
    }
    let text = format!("{value:.2e}");
    // What was just formatted as a number reads back as one.
    text.parse::<f64>().map_or(text, |shorter| {
        if shorter != 0.0 && (shorter.abs() < 1e-5 || shorter.abs() >= 1e7) {
            format!("{shorter:e}")
        } else {
            shorter.to_string()
        }
    })
}

/// As panels and columns are titled.
pub(super) fn channel_name(channel: Channel) -> &'static str {
    match channel {
        Channel::R => "R",
        Channel::G => "G",
        Channel::B => "B",
        Channel::Y => "Y",
    }
}

fn or_dash(value: Option<f64>, se: Option<f64>) -> String {
    match (value, se) {
        (None, _) => "–".to_owned(),
        (Some(value), None) => rounded(value),
        (Some(value), Some(se)) => with_error(value, se),
    }
}

fn range(low: Option<f64>, high: Option<f64>) -> String {
    match (low, high) {
        (Some(low), Some(high)) => format!("{} to {}", rounded(low), rounded(high)),
        _ => "–".to_owned(),
    }
}

/// A bar would end the cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}
