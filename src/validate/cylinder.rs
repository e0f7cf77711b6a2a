use std::f64::consts::TAU;

use rand_xoshiro::Xoshiro256PlusPlus;
use serde::Deserialize;

use super::reference::rows;
use super::statistics::check;
use super::{Check, ValidateError};
use crate::geometry::Vec3;
use crate::optics::{HenyeyGreenstein, Phase};
use crate::transport::{Coefficients, Cylinder, Entry, Estimate, Exit, Fraction, Interior, Roulette, Traced, Walk};

#[derive(Debug, Deserialize)]
struct Row {
    case: String,
    n: f64,
    tilt_deg: Option<f64>,
    #[serde(rename = "mu_a_R")]
    mu_a_r: Option<f64>,
    #[serde(rename = "R_frac")]
    reflected: Option<f64>,
    #[serde(rename = "T_frac")]
    transmitted: Option<f64>,
    #[serde(rename = "A_frac")]
    absorbed: Option<f64>,
    #[serde(rename = "T_or_value")]
    value: Option<f64>,
    #[serde(rename = "absorbed")]
    absorbed_matched: Option<f64>,
}

/// Non-scattering cylinder of radius 1 mm.
pub(super) struct CylinderProblem {
    name: String,
    index: f64,
    mu_a: f64,
    /// Angle between the beam and the plane normal to the axis; `None` for uniform radiance from all directions.
    tilt: Option<f64>,
    /// Index in a batch, name and exact value.
    expected: Vec<(usize, &'static str, f64)>,
    cylinder: Cylinder,
    phase: Phase,
}

/// Rows of the reference that the kernel can reproduce: those without polarisation.
pub(super) fn problems() -> Result<Vec<CylinderProblem>, ValidateError> {
    const TABLE: &str = "cylinder_analytic.csv";
    let table = rows::<Row>(TABLE, include_str!("../../tests/data/transport/cylinder_analytic.csv"))?;
    let mut problems = Vec::new();
    for row in table {
        let tilt_deg = row.tilt_deg.unwrap_or(0.0);
        let mu_a = row.mu_a_r.unwrap_or(0.0);
        let n = row.n;
        let (name, values) = match row.case.as_str() {
            "A_absorb_matched" => (
                format!("cylinder absorbing n=1 tilt={tilt_deg} mu_a_R={mu_a}"),
                vec![(1, "transmitted", row.value), (2, "absorbed", row.absorbed_matched)],
            ),
            "B_fresnel_scalar" => (
                format!("cylinder dielectric n={n} tilt={tilt_deg} mu_a_R={mu_a}"),
                vec![
                    (0, "reflected", row.reflected),
                    (1, "transmitted", row.transmitted),
                    (2, "absorbed", row.absorbed),
                ],
            ),
            "C_external_reflectance_unpol" => (
                format!("cylinder dielectric n={n} tilt={tilt_deg}"),
                vec![(0, "reflected", row.reflected)],
            ),
            "E_mean_chord_parallel_over_R" => (
                "cylinder chords parallel".to_owned(),
                vec![(3, "mean_chord_over_R", row.value)],
            ),
            "E_mean_chord_isotropic_over_R" => (
                "cylinder chords Lambertian".to_owned(),
                vec![(3, "mean_chord_over_R", row.value)],
            ),
            _ => continue,
        };
        problems.push(CylinderProblem {
            name,
            index: n,
            mu_a,
            tilt: row.tilt_deg.map(f64::to_radians),
            expected: values
                .into_iter()
                .filter_map(|(place, name, value)| Some((place, name, value?)))
                .collect(),
            cylinder: Cylinder::new(1.0)?,
            phase: Phase::HenyeyGreenstein(HenyeyGreenstein::new(0.0)?),
        });
    }
    Ok(problems)
}

impl CylinderProblem {
    pub fn name(&self) -> String {
        self.name.clone()
    }

    /// Batch means: reflected, transmitted, absorbed, distance from entry to exit.
    pub fn batch(&self, paths: u64, stream: Xoshiro256PlusPlus) -> Result<Vec<f64>, ValidateError> {
        let interior = Interior::new(
            self.index,
            &[Coefficients {
                mu_s: 0.0,
                mu_a: self.mu_a,
                phase: &self.phase,
            }],
        )?;
        let walk = Walk {
            shape: &self.cylinder,
            interior: &interior,
            roulette: Roulette::default(),
        };
        let mut chords = 0.0;
        let mut tally = |exit: &Exit<'_>| chords += exit.weights[0] * (exit.position - exit.entry).norm();
        let traced = match self.tilt {
            Some(tilt) => parallel_beam(&walk, tilt, paths, stream, &mut tally),
            None => {
                let entry = self.cylinder.at(0.0);
                walk.trace(
                    stream,
                    paths as usize,
                    |[cos2, around, ..]| {
                        let (sin, azimuth) = ((1.0 - cos2).sqrt(), TAU * around);
                        Entry {
                            position: entry,
                            normal: Vec3::z(),
                            omega_in: Vec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos2.sqrt()),
                        }
                    },
                    &mut tally,
                )
            }
        };
        let [ledger] = traced.ledgers[..] else {
            return Ok(Vec::new());
        };
        let sums = [
            ledger[Fraction::Reflected],
            ledger[Fraction::Ballistic],
            ledger[Fraction::Absorbed],
            chords,
        ];
        Ok(sums.iter().map(|s| s / paths as f64).collect())
    }

    pub fn checks(&self, estimates: &[Estimate]) -> Vec<Check> {
        self.expected
            .iter()
            .map(|&(place, quantity, value)| {
                check(estimates[place], self.name(), quantity, Estimate { value, se: 0.0 })
            })
            .collect()
    }
}

/// Traces a parallel beam over the whole projected width of a cylinder; it travels towards −z and, if tilted, towards
/// +y.
pub(super) fn parallel_beam(
    walk: &Walk<'_, Cylinder>,
    tilt: f64,
    paths: u64,
    stream: Xoshiro256PlusPlus,
    sink: impl FnMut(&Exit<'_>),
) -> Traced {
    let omega_in = Vec3::new(0.0, -tilt.sin(), tilt.cos());
    walk.trace(
        stream,
        paths as usize,
        |[across, ..]| {
            let position = walk.shape.at((2.0 * across - 1.0).asin());
            Entry {
                position,
                normal: walk.shape.frame(&position).normal,
                omega_in,
            }
        },
        sink,
    )
}
