//! A made-up result with every part filled in.

use specval::compare::*;
use specval::report::*;
use specval::transport::Fraction;

const NORMAL: Geometry = Geometry {
    theta_i_deg: 0.0,
    theta_v_deg: 0.0,
};

/// β of a made-up red cloth: a broad lobe about the mirror direction on a Lambert floor.
fn beta(source: Role, channel: Channel, theta_i_deg: f64, theta_v_deg: f64) -> f64 {
    let level = match channel {
        Channel::R => 0.25,
        Channel::G => 0.004,
        Channel::B => 0.02,
        Channel::Y => 0.06,
    };
    let lobe = |width: f64| (-((theta_v_deg - theta_i_deg) / width).powi(2)).exp();
    match source {
        Role::Model => level * (0.9 + 0.15 * lobe(25.0) + 0.1 * (theta_v_deg / 70.0).powi(2)),
        Role::Classical => level * (0.95 + 0.3 * lobe(12.0)),
        Role::Measured => level * (0.8 + 0.25 * lobe(35.0)),
    }
}

fn se(source: Role, beta: f64) -> f64 {
    match source {
        Role::Model => 0.02 * beta,
        Role::Classical | Role::Measured => 0.05 * beta,
    }
}

pub fn curves(incidences_deg: &[f64], views_deg: &[f64], roles: &[Role]) -> Vec<CurvePoint> {
    let mut curves = Vec::new();
    for &theta_i_deg in incidences_deg {
        for &role in roles {
            for channel in [Channel::R, Channel::G, Channel::B, Channel::Y] {
                for &theta_v_deg in views_deg {
                    let beta = beta(role, channel, theta_i_deg, theta_v_deg);
                    let se = se(role, beta);
                    curves.push(CurvePoint {
                        theta_i_deg,
                        theta_v_deg,
                        source: role.id().into(),
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

pub const ROLES: [Role; 3] = [Role::Model, Role::Classical, Role::Measured];

/// One source a role.
fn sources() -> Vec<Source> {
    let label = |role| match role {
        Role::Model => "model",
        Role::Classical => "classical model",
        Role::Measured => "measured (fit of a measurement)",
    };
    ROLES.map(|role| Source::numbered(role, 0, label(role))).to_vec()
}

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
            Table1Name::Source(Role::Measured.id().into()),
            Some(0.0595),
            Some(0.0042),
            Some(0.143),
            Some(0.0101),
        ),
        row(
            Table1Name::Source(Role::Model.id().into()),
            Some(0.1 + 0.2),
            Some(1e-7),
            Some(0.012),
            Some(0.0004),
        ),
        row(Table1Name::ModelLow, Some(0.047), None, Some(-0.0004), None),
        row(Table1Name::ModelHigh, Some(0.26), None, Some(0.0171), None),
    ]
}

fn energy() -> Vec<EnergyRow> {
    let mut rows = [EnergyRow::default(), EnergyRow::default()];
    rows[0].wavelength_nm = 500.0;
    rows[0].theta_in_deg = 5.0;
    rows[0].phi_in_deg = 11.25;
    rows[0][Fraction::Reflected].value = 0.05;
    rows[0][Fraction::Ballistic].value = 0.25;
    rows[0][Fraction::Scattered].value = 0.3;
    rows[0][Fraction::Scattered].se = 1.0 / 3.0;
    rows[0][Fraction::Absorbed].value = 0.4;
    rows[0].residual.value = -1e-17;
    rows[1].wavelength_nm = 600.0;
    rows.into()
}

pub fn data() -> ReportData {
    let estimate = |value, se| PropagatedEstimate {
        value,
        se,
        bias_monte_carlo: 0.0,
        se_monte_carlo: se,
        se_measurement: 0.0,
    };
    let mut rmse = Vec::new();
    let mut rmse_ratios = Vec::new();
    for theta_i_deg in [0.0, 30.0, 60.0] {
        for (role, value) in [(Role::Model, 0.011), (Role::Classical, 0.022)] {
            rmse.push(Rmse {
                theta_i_deg,
                source: role.id().into(),
                channel: Channel::R,
                rmse: estimate(value, 0.1 * value),
                relative: None,
                views: 27,
                sample: Role::Measured.id().into(),
            });
        }
        rmse_ratios.push(RmseRatio {
            theta_i_deg,
            channel: Channel::R,
            model: Role::Model.id().into(),
            classical: Role::Classical.id().into(),
            sample: Role::Measured.id().into(),
            ratio: 2.0,
            interval: Some([1.3, 2.9]),
            too_few_paths: false,
            verdict: Verdict::Better,
        });
    }
    ReportData {
        wavelengths_nm: vec![500.0, 600.0],
        colour_convention: "CIE 1931 2°, D65, linear sRGB, no adaptation".to_owned(),
        sources: sources(),
        curves: curves(&[0.0, 30.0, 60.0], &views(), &ROLES),
        table1: table1(),
        conventions: vec![ConventionRatios {
            convention: "CIE 1931 2°, E, CIE RGB, no adaptation".to_owned(),
            rows: table1(),
        }],
        energy: energy(),
        normalisation: [
            (Role::Model, estimate(0.931, 0.0121)),
            (Role::Classical, estimate(1.0, 0.05)),
        ]
        .map(|(role, factor)| Coefficient {
            source: role.id().into(),
            sample: Role::Measured.id().into(),
            at: NORMAL,
            factor,
        })
        .to_vec(),
        rmse,
        peaks: vec![Peak {
            theta_i_deg: 30.0,
            source: Role::Model.id().into(),
            channel: Channel::R,
            angle_deg: Some(estimate(35.0, 2.0)),
            at_edge: false,
            sample: Role::Measured.id().into(),
        }],
        rmse_ratios,
        samples: vec![SampleNote {
            id: Role::Measured.id().into(),
            name: "MERL red-fabric".to_owned(),
            kind: "fit of a measurement".to_owned(),
            source: "W. Matusik et al. 2003, fit by A. Sztrajman et al. 2021".to_owned(),
            licence: "CC-BY-SA-4.0".to_owned(),
            uncertainty_stated: true,
            caption: "5 % standard uncertainty; linear camera RGB of the MERL rig, not CIE.".to_owned(),
        }],
        readings: ReadingCount {
            total: 81,
            used: 81,
            tolerance_deg: 0.25,
            normalised_at: Some(NORMAL),
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
