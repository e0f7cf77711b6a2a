use rand_xoshiro::Xoshiro256PlusPlus;
use serde::Deserialize;

use super::reference::rows;
use super::statistics::check;
use super::{Check, ValidateError};
use crate::geometry::Vec3;
use crate::optics::{HenyeyGreenstein, Phase};
use crate::transport::{Coefficients, Entry, Estimate, Fraction, Interior, Roulette, Slab, Walk};

#[derive(Clone, Debug, Deserialize)]
struct Row {
    /// Albedo μ_s/(μ_a + μ_s).
    a: f64,
    /// Optical thickness (μ_a + μ_s) d.
    tau: f64,
    g: f64,
    /// Refractive index of the slab.
    n: f64,
    #[serde(rename = "R_total_dom")]
    r_total: f64,
    #[serde(rename = "R_diffuse_dom")]
    r_diffuse: f64,
    #[serde(rename = "T_total_dom")]
    t_total: f64,
    #[serde(rename = "T_diffuse_dom")]
    t_diffuse: f64,
    #[serde(rename = "URU_dom")]
    r_lambertian: f64,
    #[serde(rename = "UTU_dom")]
    t_lambertian: f64,
}

/// Plane-parallel slab in light along its normal, or in uniform radiance from a hemisphere.
pub(super) struct SlabProblem {
    row: Row,
    lambertian: bool,
    slab: Slab,
    phase: Phase,
}

pub(super) fn problems() -> Result<Vec<SlabProblem>, ValidateError> {
    const TABLE: &str = "transport_slab.csv";
    let mut problems = Vec::new();
    for row in rows::<Row>(TABLE, include_str!("../../tests/data/transport/transport_slab.csv"))? {
        for lambertian in [false, true] {
            problems.push(SlabProblem {
                // 1 mm thick with coefficient τ; a half space has coefficient 1.
                slab: Slab::new(if row.tau.is_finite() { 1.0 } else { f64::INFINITY })?,
                phase: Phase::HenyeyGreenstein(HenyeyGreenstein::new(row.g)?),
                row: row.clone(),
                lambertian,
            });
        }
    }
    Ok(problems)
}

impl SlabProblem {
    pub fn name(&self) -> String {
        let Row { a, tau, g, n, .. } = self.row;
        let light = if self.lambertian { "Lambertian" } else { "collimated" };
        format!("slab a={a} tau={tau} g={g} n={n} {light}")
    }

    /// Batch means: total reflected, reflected after scattering, total transmitted, transmitted after scattering.
    pub fn batch(&self, paths: u64, stream: Xoshiro256PlusPlus) -> Result<Vec<f64>, ValidateError> {
        let extinction = if self.row.tau.is_finite() { self.row.tau } else { 1.0 };
        let interior = Interior::new(
            self.row.n,
            &[Coefficients {
                mu_s: extinction * self.row.a,
                mu_a: extinction * (1.0 - self.row.a),
                phase: &self.phase,
            }],
        )?;
        let walk = Walk {
            shape: &self.slab,
            interior: &interior,
            roulette: Roulette::default(),
        };
        let mut sums = [0.0; 4];
        let traced = walk.trace(
            stream,
            paths as usize,
            |[cos2, ..]| Entry {
                position: Vec3::zeros(),
                normal: Vec3::z(),
                omega_in: if self.lambertian {
                    // Under uniform radiance, cos²θ of the flux is uniform in 0..1.
                    Vec3::new((1.0 - cos2).sqrt(), 0.0, cos2.sqrt())
                } else {
                    Vec3::z()
                },
            },
            |exit| {
                let side = if exit.normal.z > 0.0 { 0 } else { 2 };
                sums[side] += exit.weights[0];
                if exit.scattered {
                    sums[side + 1] += exit.weights[0];
                }
            },
        );
        sums[0] += traced.ledgers[0][Fraction::Reflected];
        Ok(sums.iter().map(|s| s / paths as f64).collect())
    }

    pub fn checks(&self, estimates: &[Estimate]) -> Vec<Check> {
        let row = &self.row;
        let pairs = if self.lambertian {
            vec![(0, "URU", row.r_lambertian), (2, "UTU", row.t_lambertian)]
        } else {
            vec![
                (0, "R_total", row.r_total),
                (1, "R_diffuse", row.r_diffuse),
                (2, "T_total", row.t_total),
                (3, "T_diffuse", row.t_diffuse),
            ]
        };
        pairs
            .into_iter()
            .map(|(place, quantity, value)| check(estimates[place], self.name(), quantity, Estimate { value, se: 0.0 }))
            .collect()
    }
}
