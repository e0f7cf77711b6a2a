//! Graphs: what is in them, their size, and the odd cases.

use crate::report_data::{ROLES, curves, data, views};
use specval::compare::{Channel, CurvePoint, Rmse, Role, Source, SourceId};
use specval::report::*;
use std::collections::BTreeSet;

fn decoded(png: &[u8]) -> (u32, u32, Vec<u8>) {
    let mut reader = png::Decoder::new(png).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!(
        (info.color_type, info.bit_depth),
        (png::ColorType::Rgb, png::BitDepth::Eight)
    );
    (info.width, info.height, pixels)
}

/// Strokes of one colour in an SVG document.
fn strokes(svg: &str, colour: &str) -> usize {
    svg.matches(&format!("stroke=\"{colour}\"")).count()
}

const MODEL: &str = "#1446A0";
const MEASURED: &str = "#191919";
const CLASSICAL: &str = "#CD5500";
/// Lines of the grid, and of the directions of light and mirror.
const GRID: &str = "#D7D7D7";
const MARK: &str = "#6E6E6E";

#[test]
fn three_incidences_give_the_six_graphs_of_the_preprint() {
    let data = data();
    let graphs = graphs(&data);
    assert_eq!(graphs.iter().map(Graph::number).collect::<Vec<_>>(), [1, 2, 3, 4, 5, 6]);
    for (graph, incidence) in graphs.iter().zip([0, 30, 60, 0, 30, 60]) {
        let svg = graph.svg().unwrap();
        assert!(svg.contains(&format!("Graph {}. Light at {incidence}°", graph.number())));
        assert_eq!(strokes(&svg, CLASSICAL) > 0, graph.number() > 3);
        // The measured curve is broken into dashes, the model's is not.
        assert!(strokes(&svg, MEASURED) > 3 * strokes(&svg, MODEL));
        for expected in [
            "signed view angle, degrees",
            "brightness factor β, –",
            "measured (fit of a measurement)",
            "bands: ±1 standard error",
            "model × 0.931 ± 0.012",
            "5 % standard uncertainty",
        ] {
            assert!(svg.contains(expected), "graph {}: {expected}", graph.number());
        }
    }
}

#[test]
fn pictures_have_the_stated_size_and_are_not_blank() {
    let data = data();
    let graph = &graphs(&data)[3];
    let svg = graph.svg().unwrap();
    assert!(svg.starts_with("<svg width=\"1600\" height=\"1000\" viewBox=\"0 0 3200 2000\""));
    let (width, height, pixels) = decoded(&graph.png().unwrap());
    assert_eq!((width, height), (1600, 1000));
    let inked = pixels.chunks(3).filter(|pixel| *pixel != [255, 255, 255]).count();
    assert!(inked > 50_000, "{inked} pixels are not white");
    for colour in [[20, 70, 160], [25, 25, 25], [205, 85, 0]] {
        assert!(pixels.chunks(3).any(|pixel| pixel == colour), "{colour:?}");
    }
}

#[test]
fn graphs_are_the_same_bytes_every_time() {
    let data = data();
    let graph = &graphs(&data)[5];
    assert_eq!(graph.svg().unwrap(), graph.svg().unwrap());
    assert_eq!(graph.png().unwrap(), graph.png().unwrap());
}

#[test]
fn numbering_follows_the_number_of_incidences() {
    for incidences in [&[15.0][..], &[0.0, 20.0, 40.0, 75.0]] {
        let mut data = data();
        data.curves = curves(incidences, &views(), &ROLES);
        let graphs = graphs(&data);
        assert_eq!(graphs.len(), 2 * incidences.len());
        let first_with_classical = graphs[incidences.len()].svg().unwrap();
        assert!(first_with_classical.contains(&format!("Graph {}. Light at {}°", incidences.len() + 1, incidences[0])));
        assert!(strokes(&first_with_classical, CLASSICAL) > 0);
    }
}

#[test]
fn sample_is_not_mentioned_without_a_measured_curve() {
    let mut data = data();
    data.curves = curves(&[30.0], &views(), &[Role::Model, Role::Classical]);
    let svg = graphs(&data)[0].svg().unwrap();
    assert!(svg.contains("Light at 30° from the normal: model"));
    assert!(!svg.contains("MERL") && !svg.contains("measured (") && strokes(&svg, MEASURED) == 0);
}

#[test]
fn negative_values_single_views_and_missing_numbers_are_drawn() {
    let mut data = data();
    for point in &mut data.curves {
        if point.channel == Channel::G {
            point.beta -= 0.0042;
        }
    }
    let svg = graphs(&data)[0].svg().unwrap();
    assert!(svg.contains("−0.0"), "the ordinates go below 0");

    data.curves = curves(&[0.0], &[0.0], &ROLES);
    let svg = graphs(&data)[1].svg().unwrap();
    for colour in [MODEL, MEASURED, CLASSICAL] {
        assert!(strokes(&svg, colour) > 0, "{colour}");
    }

    data.curves = curves(&[0.0], &views(), &ROLES);
    for point in &mut data.curves {
        point.se = f64::NAN;
        if point.channel == Channel::R {
            point.beta = f64::NAN;
        }
    }
    let graphs = graphs(&data);
    assert!(graphs[1].svg().unwrap().contains("R: no data"));
    graphs[1].png().unwrap();
}

/// Second sources of each role have their own line, colour, label, errors and footnote.
#[test]
fn second_sources_have_their_own_curve_label_and_footnote() {
    let mut data = data();
    let second = |id: &SourceId| SourceId::from(format!("{id}-2"));
    let more: Vec<Source> = data
        .sources
        .iter()
        .map(|source| Source::numbered(source.role, 1, format!("another {}", source.id)))
        .collect();
    data.sources.extend(more);
    let curves: Vec<CurvePoint> = data
        .curves
        .iter()
        .map(|point| CurvePoint {
            source: second(&point.source),
            beta: 1.2 * point.beta,
            ..point.clone()
        })
        .collect();
    data.curves.extend(curves);
    data.samples.push(SampleNote {
        id: second(&data.samples[0].id),
        name: "felt".into(),
        ..data.samples[0].clone()
    });
    let rmse: Vec<Rmse> = data
        .rmse
        .iter()
        .map(|metric| Rmse {
            source: second(&metric.source),
            sample: second(&metric.sample),
            ..metric.clone()
        })
        .collect();
    data.rmse.extend(rmse);

    let graphs = graphs(&data);
    let [without, with] = [&graphs[0], &graphs[3]].map(|graph| graph.svg().unwrap());
    assert!(without.contains("Light at 0° from the normal: 2 models and 2 measured cloths"));
    assert!(with.contains("2 models, 2 measured cloths and 2 classical models"));
    let colours = |svg: &str| {
        let strokes = svg.split("stroke=\"").skip(1).filter_map(|rest| rest.split('"').next());
        let drawn = strokes.filter(|colour| ![GRID, MARK, "#000000", "none"].contains(colour));
        drawn.map(str::to_owned).collect::<BTreeSet<_>>()
    };
    assert_eq!((colours(&without).len(), colours(&with).len()), (4, 6));
    for label in ["another model", "another classical", "another measured", "Sample: felt"] {
        assert!(with.contains(label), "{label}");
    }
    let table = String::from_utf8(curves_csv(&data).unwrap()).unwrap();
    assert!(table.contains(",model-2,r,") && table.contains(",classical-2,y,") && table.contains(",measured-2,b,"));
    let summary = summary(&data);
    assert!(summary.contains("model and classical against measured:"), "{summary}");
    assert!(
        summary.contains("model-2 and classical-2 against measured-2:"),
        "{summary}"
    );
    let document: serde_json::Value = serde_json::from_str(&report_json(&data).unwrap()).unwrap();
    assert_eq!(document["more_samples"][0]["name"], "felt");
    assert_eq!(document["rmse"][data.rmse.len() - 1]["sample"], "measured-2");
    assert!(document["rmse"][0].get("sample").is_none());
    let scratch = tempfile::tempdir().unwrap();
    std::fs::write(scratch.path().join(RESULT), result_json(&data).unwrap()).unwrap();
    assert_eq!(read_result(scratch.path()).unwrap().data, data);
}
