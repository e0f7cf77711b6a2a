use super::tables::{channel_name, elsewhere, place, rounded, with_error, words_of};
use super::{EffortNote, Notice, ReportData, ledger_table};
use crate::compare::{Channel, PropagatedEstimate, Rmse, RmseRatio, Role, Source, SourceId, Table1Name, Verdict};
use std::fmt::Write;

/// The summary that `report` prints: Table 1, normalisation, RMSE with verdicts, the energy ledger, and every notice
/// and fallback.
pub fn summary(data: &ReportData) -> String {
    let mut text = String::new();
    table1(&mut text, data);
    comparison(&mut text, data);
    if !data.energy.is_empty() {
        let _ = write!(text, "\n{}", ledger_table(&data.energy));
    }
    for (place, sample) in data.samples.iter().enumerate() {
        let before = if place == 0 { "\n" } else { "" };
        let _ = writeln!(
            text,
            "{before}sample: {} ({}). {}",
            sample.name, sample.kind, sample.caption
        );
    }
    if let Some(line) = readings_line(data) {
        let _ = writeln!(text, "{line}");
    }
    let _ = writeln!(text, "{}", effort_line(&data.provenance.effort));
    for notice in &data.provenance.notices {
        let _ = writeln!(text, "notice: {notice}");
    }
    for fallback in &data.provenance.fallbacks {
        let _ = writeln!(text, "fallback: {fallback}");
    }
    text
}

/// How many of the sample's readings were compared, and why the others were not; `None` for a sample without readings.
fn readings_line(data: &ReportData) -> Option<String> {
    let count = &data.readings;
    if count.total == 0 {
        return None;
    }
    let whose = if count.geometries_of_sample {
        "the sample"
    } else {
        "the study's [rig]"
    };
    let mut parts = vec![format!(
        "{} of {} compared at the geometries of {whose}",
        count.used, count.total
    )];
    for (number, words) in [
        (count.interpolated, "used to interpolate between"),
        (count.outside_plane, "outside the plane of incidence"),
        (count.outside_rig, "at geometries that are not measured"),
        (count.no_model_value, "where the model shows no light"),
    ] {
        if number > 0 {
            parts.push(format!("{number} {words}"));
        }
    }
    let mut line = format!("readings: {}", parts.join(", "));
    if !count.examples_outside_rig.is_empty() {
        let named = count
            .examples_outside_rig
            .iter()
            .map(place)
            .collect::<Vec<_>>()
            .join(", ");
        let more = if count.outside_rig > count.examples_outside_rig.len() {
            ", ..."
        } else {
            ""
        };
        let _ = write!(line, "; not measured (incidence/view): {named}{more}");
    }
    if count.moved > 0 || count.combined > 0 {
        let _ = write!(
            line,
            "; angles of {} readings taken as nominal, by {} degrees at most (tolerance {}); {} repeats combined",
            count.moved,
            rounded(count.largest_move_deg),
            count.tolerance_deg,
            count.combined
        );
    }
    Some(line)
}

/// What was traced, why tracing stopped, and which precision it reached.
pub fn effort_line(effort: &EffortNote) -> String {
    let asked = [
        effort.asked.until.clone(),
        effort.asked.max_time_s.map(|seconds| format!("{seconds} s")),
        Some(format!("{} batches at most", effort.asked.batches)),
    ];
    let asked: Vec<String> = asked.into_iter().flatten().collect();
    let reached = effort.reached.as_ref().map_or_else(String::new, |reached| {
        let kind = match reached.tolerance.as_ref() {
            "rel" => "relative ",
            _ => "",
        };
        let of = match reached.of.as_ref() {
            "scattered" => "scattered fractions",
            other => other,
        };
        match reached.largest_error {
            Some(error) => format!("; largest {kind}standard error of the {of}: {}", rounded(error)),
            None => format!("; the {of} are not all known: no light was hit at some"),
        }
    });
    let remedy = match effort.stopped_by.as_ref() {
        "precision out of reach" => {
            "; ask for less, or trace more --paths, which are then the limit, or set --max-time"
        }
        _ => "",
    };
    format!(
        "effort: {} batches, each of {} paths a tilt and {} a direction of the ledger; stopped by {} (asked: \
         {}){reached}{remedy}",
        effort.batches,
        effort.paths_per_batch.direct,
        effort.paths_per_batch.bssrdf,
        effort.stopped_by,
        asked.join(", ")
    )
}

fn table1(text: &mut String, data: &ReportData) {
    let _ = writeln!(
        text,
        "{:<19} {:>10} {:>9} {:>10} {:>9}   ({})",
        "Table 1", "BLUE/RED", "se", "GREEN/RED", "se", data.colour_convention
    );
    for row in &data.table1 {
        let name = match &row.row {
            Table1Name::Published => "published".to_owned(),
            Table1Name::Source(id) => match elsewhere(data).filter(|_| id.as_str() == Role::Measured.id()) {
                Some(at) => format!("{id}, {}", place(&at)),
                None => id.to_string(),
            },
            Table1Name::ModelLow => "model low".to_owned(),
            Table1Name::ModelHigh => "model high".to_owned(),
            Table1Name::ModelDirect => "model, direct light".to_owned(),
            Table1Name::ModelAllBounces => "model, all bounces".to_owned(),
        };
        let show = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), rounded);
        let _ = writeln!(
            text,
            "{name:<19} {:>10} {:>9} {:>10} {:>9}",
            show(row.blue_over_red),
            show(row.blue_over_red_se),
            show(row.green_over_red),
            show(row.green_over_red_se)
        );
    }
}

fn comparison(text: &mut String, data: &ReportData) {
    for coefficient in &data.normalisation {
        let (source, sample) = (&coefficient.source, &coefficient.sample);
        let PropagatedEstimate { value, se, .. } = coefficient.factor;
        let doubt = if se > 0.5 * value.abs() {
            ", hardly known: most of it is noise"
        } else {
            ""
        };
        let _ = writeln!(
            text,
            "{source} multiplied by {} ({sample}/{source} luminance at {}){doubt}",
            with_error(value, se),
            words_of(&coefficient.at)
        );
    }
    if data.rmse.is_empty() {
        return;
    }
    for sample in data.sources_of(Role::Measured) {
        for model in data.sources_of(Role::Model) {
            for classical in data.sources_of(Role::Classical) {
                errors(text, data, [model, classical, sample]);
            }
        }
    }
}

/// RMSE and verdicts of one model beside one classical shading and one sample.
fn errors(text: &mut String, data: &ReportData, [model, classical, sample]: [&Source; 3]) {
    let several = [Role::Model, Role::Classical, Role::Measured]
        .into_iter()
        .any(|role| data.sources_of(role).count() > 1);
    let title = match several {
        true => format!("\n{} and {} against {}:", model.id, classical.id, sample.id),
        false => String::new(),
    };
    let _ = writeln!(
        text,
        "{title}\n{:<10} {:>7} {:>18} {:>18}   the model against the classical shading",
        "incidence", "channel", "RMSE model", "RMSE classical"
    );
    if data.hue.is_some_and(|hue| hue.plainly_different) {
        let _ = writeln!(
            text,
            "model and sample plainly differ in colour: these verdicts compare two different cloths"
        );
    }
    let of = |source: &SourceId| {
        let (source, sample) = (source.clone(), &sample.id);
        let metrics = data.rmse.iter();
        metrics.filter(move |metric| metric.source == source && metric.sample == *sample)
    };
    let black = data.provenance.notices.contains(&Notice::NoModelLight);
    for metric in of(&model.id) {
        let here = |theta_i_deg: f64, channel: Channel| theta_i_deg == metric.theta_i_deg && channel == metric.channel;
        let beside = of(&classical.id).find(|metric| here(metric.theta_i_deg, metric.channel));
        let ratio = data.rmse_ratios.iter().find(|ratio| {
            here(ratio.theta_i_deg, ratio.channel)
                && [&ratio.model, &ratio.classical, &ratio.sample] == [&model.id, &classical.id, &sample.id]
        });
        let error = |rmse: &Rmse| with_error(rmse.rmse.value, rmse.rmse.se);
        let _ = writeln!(
            text,
            "{:>8}° {:>7} {:>18} {:>18}   {}",
            metric.theta_i_deg,
            channel_name(metric.channel),
            error(metric),
            beside.map_or_else(|| "–".to_owned(), error),
            ratio.map(|ratio| verdict(ratio, black)).unwrap_or_default()
        );
    }
}

/// `black` is a model without light.
fn verdict(ratio: &RmseRatio, black: bool) -> String {
    if ratio.too_few_paths {
        return if black {
            "withheld: no light of the model"
        } else {
            "withheld: too few paths"
        }
        .to_owned();
    }
    let words = match ratio.verdict {
        Verdict::Better => "better",
        Verdict::Worse => "worse",
        Verdict::CannotTell => "cannot tell",
    };
    let interval = ratio.interval.map_or_else(String::new, |[low, high]| {
        format!(", 95 % interval {} to {}", rounded(low), rounded(high))
    });
    match ratio.ratio.is_finite() {
        true => format!("{words} (ratio {}{interval})", rounded(ratio.ratio)),
        false => words.into(),
    }
}
