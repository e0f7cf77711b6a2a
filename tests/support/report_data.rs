//! A made-up result with every part filled in.

use specval::compare::*;
use specval::report::*;

/// β of a made-up red cloth: a broad lobe about the mirror direction on a Lambert floor.
fn beta(source: Source, channel: Channel, theta_i_deg: f64, theta_v_deg: f64) -> f64 {
    let level = match channel {
        Channel::R => 0.25,
        Channel::G => 0.004,
        Channel::B => 0.02,
        Channel::Y => 0.06,
    };
    let lobe = |width: f64| (-((theta_v_deg - theta_i_deg) / width).powi(2)).exp();
    match source {
        Source::Model => level * (0.9 + 0.15 * lobe(25.0) + 0.1 * (theta_v_deg / 70.0).powi(2)),
        Source::Classical => level * (0.95 + 0.3 * lobe(12.0)),
        Source::Measured => level * (0.8 + 0.25 * lobe(35.0)),
    }
}

fn se(source: Source, beta: f64) -> f64 {
    match source {
        Source::Model => 0.02 * beta,
        Source::Classical | Source::Measured => 0.05 * beta,
    }
}

pub fn curves(incidences_deg: &[f64], views_deg: &[f64], sources: &[Source]) -> Vec<CurvePoint> {
    let mut curves = Vec::new();
    for &theta_i_deg in incidences_deg {
        for &source in sources {
            for channel in [Channel::R, Channel::G, Channel::B, Channel::Y] {
                for &theta_v_deg in views_deg {
                    let beta = beta(source, channel, theta_i_deg, theta_v_deg);
                    let se = se(source, beta);
                    curves.push(CurvePoint {
                        theta_i_deg,
                        theta_v_deg,
                        source,
                        channel,
                        beta,
                        se,
                        interpolated: false,
                    });
                }
            }
        }
    }
    curves
}

pub fn views() -> Vec<f64> {
    (-12..=14).map(|k| 5.0 * f64::from(k)).collect()
}

pub const SOURCES: [Source; 3] = [Source::Model, Source::Classical, Source::Measured];

pub fn table1() -> Vec<Table1Row> {
    let row = |row, blue: Option<f64>, blue_se: Option<f64>, green: Option<f64>, green_se: Option<f64>| Table1Row {
        row,
        blue_over_red: blue,
        blue_over_red_se: blue_se,
        green_over_red: green,
        green_over_red_se: green_se,
    };
    vec![
        Table1Row::bare(Table1Name::Published, 0.08, 0.011),
        row(
            Table1Name::Measured,
            Some(0.0595),
            Some(0.0042),
            Some(0.143),
            Some(0.0101),
        ),
        row(
            Table1Name::Model,
            Some(0.1 + 0.2),
            Some(1e-7),
            Some(0.012),
            Some(0.0004),
        ),
        row(Table1Name::ModelLow, Some(0.047), None, Some(-0.0004), None),
        row(Table1Name::ModelHigh, Some(0.26), None, Some(0.0171), None),
    ]
}

pub fn data() -> ReportData {
    let estimate = |value, se| Estimate {
        value,
        se,
        bias_monte_carlo: 0.0,
        se_monte_carlo: se,
        se_measurement: 0.0,
    };
    let mut rmse = Vec::new();
    let mut rmse_ratios = Vec::new();
    for theta_i_deg in [0.0, 30.0, 60.0] {
        for (source, value) in [(Source::Model, 0.011), (Source::Classical, 0.022)] {
            rmse.push(Rmse {
                theta_i_deg,
                source,
                channel: Channel::R,
                rmse: estimate(value, 0.1 * value),
                relative: None,
                views: 27,
            });
        }
        rmse_ratios.push(RmseRatio {
            theta_i_deg,
            channel: Channel::R,
            ratio: 2.0,
            interval: Some([1.3, 2.9]),
            too_few_paths: false,
            verdict: Verdict::Better,
        });
    }
    ReportData {
        wavelengths_nm: vec![500.0, 600.0],
        colour_convention: "CIE 1931 2°, D65, linear sRGB, no adaptation".to_owned(),
        curves: curves(&[0.0, 30.0, 60.0], &views(), &SOURCES),
        table1: table1(),
        conventions: vec![Convention {
            convention: "CIE 1931 2°, E, CIE RGB, no adaptation".to_owned(),
            rows: table1(),
        }],
        energy: vec![
            EnergyRow {
                wavelength_nm: 500.0,
                theta_in_deg: 5.0,
                phi_in_deg: 11.25,
                reflected: 0.05,
                ballistic: 0.25,
                scattered: 0.3,
                scattered_se: 1.0 / 3.0,
                absorbed: 0.4,
                residual: -1e-17,
                ..EnergyRow::default()
            },
            EnergyRow {
                wavelength_nm: 600.0,
                ..EnergyRow::default()
            },
        ],
        normalisation: Some(Normalisation {
            model: estimate(0.931, 0.0121),
            classical: estimate(1.0, 0.05),
        }),
        rmse,
        peaks: vec![Peak {
            theta_i_deg: 30.0,
            source: Source::Model,
            channel: Channel::R,
            angle_deg: Some(estimate(35.0, 2.0)),
            at_edge: false,
        }],
        rmse_ratios,
        sample: SampleNote {
            name: "MERL red-fabric".to_owned(),
            kind: "fit of a measurement".to_owned(),
            source: "W. Matusik et al. 2003, fit by A. Sztrajman et al. 2021".to_owned(),
            licence: "CC-BY-SA-4.0".to_owned(),
            uncertainty_stated: true,
            caption: "5 % standard uncertainty; linear camera RGB of the MERL rig, not CIE.".to_owned(),
        },
        readings: ReadingCount {
            total: 81,
            used: 81,
            tolerance_deg: 0.25,
            normalised_at: Some(Geometry {
                theta_i_deg: 0.0,
                theta_v_deg: 0.0,
            }),
            ..ReadingCount::default()
        },
        hue: None,
        approximations: None,
        provenance: Provenance {
            version: "0.1.0".to_owned(),
            command: vec!["specval".to_owned(), "report".to_owned()],
            study: serde_json::json!({ "seed": 1 }),
            seed: 1,
            inputs: vec![InputDigest::of("abc", b"abc")],
            effort: EffortNote {
                batches: 24,
                paths_per_batch: PathsPerBatch {
                    bssrdf: 1_250,
                    direct: 12_500,
                },
                stopped_by: "precision".into(),
                asked: AskedEffort {
                    until: Some("rel 0.01 curves".to_owned()),
                    max_time_s: Some(60.0),
                    batches: 100_000,
                },
                reached: Some(ReachedPrecision {
                    tolerance: "rel".into(),
                    of: "curves".into(),
                    largest_error: Some(0.0098),
                }),
            },
            fallbacks: vec![Fallback::UncertaintyNotStated],
            notices: vec![Notice::SweepRange {
                ratio: TableRatio::BlueOverRed,
                range: [0.047, 0.26],
                preprint: [0.05, 0.25],
            }],
        },
    }
}
