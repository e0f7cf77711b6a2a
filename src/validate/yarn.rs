use rand_xoshiro::Xoshiro256PlusPlus;
use serde::Deserialize;

use super::cylinder::parallel_beam;
use super::reference::rows;
use super::statistics::{check, joint};
use super::{Check, ValidateError};
use crate::optics::{Interference, Medium, MediumSpec};
use crate::spectrum::{Spectrum, WavelengthGrid};
use crate::transport::{Coefficients, Cylinder, Estimate, Fraction, Interior, Roulette, Walk};

/// Yarn of the reference: host and particle index, particle diameter, volume fraction and radius.
const HOST_INDEX: f64 = 1.557;
const PARTICLE_INDEX: f64 = 1.61;
const DIAMETER_NM: f64 = 150.0;
const VOLUME_FRACTION: f64 = 0.14;
const RADIUS_MM: f64 = 0.125;
/// Relative error above which a bin of the reference has too few photons (< 400) for a normal deviate.
const POOLED_FROM: f64 = 0.05;
/// Reflected, ballistic, scattered, absorbed.
const TOTALS: [(&str, &str); 4] = [
    ("reflected", "ext_fresnel"),
    ("ballistic", "unscattered"),
    ("scattered", "scattered"),
    ("absorbed", "absorbed"),
];

#[derive(Clone, Debug, Deserialize)]
struct Row {
    lambda_nm: f64,
    mu_a_per_mm: f64,
    psi_deg: f64,
    kind: String,
    component: String,
    lo_deg: Option<f64>,
    hi_deg: Option<f64>,
    fraction: f64,
    se: f64,
}

/// Uniform bins of an exit angle; the almost empty ones are merged into the last cell.
struct Histogram {
    quantity: &'static str,
    width_deg: f64,
    /// Cell of each bin.
    cells: Vec<usize>,
    references: Vec<Estimate>,
}

impl Histogram {
    fn new(quantity: &'static str, rows: &[&Row]) -> Self {
        let pooled = |row: &Row| row.se >= POOLED_FROM * row.fraction;
        let mut references: Vec<Estimate> = Vec::new();
        let mut cells = vec![0; rows.len()];
        for (cell, row) in cells.iter_mut().zip(rows).filter(|(_, row)| !pooled(row)) {
            *cell = references.len();
            references.push(Estimate {
                value: row.fraction,
                se: row.se,
            });
        }
        let (mut value, mut variance) = (0.0, 0.0);
        for (cell, row) in cells.iter_mut().zip(rows).filter(|(_, row)| pooled(row)) {
            *cell = references.len();
            value += row.fraction;
            variance += row.se * row.se;
        }
        if variance > 0.0 {
            references.push(Estimate {
                value,
                se: variance.sqrt(),
            });
        }
        Self {
            quantity,
            width_deg: rows
                .first()
                .and_then(|row| Some(row.hi_deg? - row.lo_deg?))
                .unwrap_or(f64::INFINITY),
            cells,
            references,
        }
    }

    /// Adds `weight` at an exit angle. Bins that no light reaches have no cell.
    fn add(&self, sums: &mut [f64], angle_deg: f64, weight: f64) {
        let bin = ((angle_deg / self.width_deg) as usize).min(self.cells.len() - 1);
        if let Some(sum) = sums.get_mut(self.cells[bin]) {
            *sum += weight;
        }
    }
}

/// A scattering yarn in a parallel beam.
pub(super) struct YarnProblem {
    lambda_nm: f64,
    mu_a_per_mm: f64,
    psi_deg: f64,
    totals: Vec<(&'static str, Estimate)>,
    /// Azimuth of scattered light, azimuth of ballistic light, angle of scattered light to the axis.
    histograms: [Histogram; 3],
    cylinder: Cylinder,
    medium: Medium,
}

pub(super) fn problems() -> Result<Vec<YarnProblem>, ValidateError> {
    let table: Vec<Row> = rows(
        "yarn_mitsuba.csv",
        include_str!("../../tests/data/yarn/yarn_mitsuba.csv"),
    )?;
    let mut problems: Vec<YarnProblem> = Vec::new();
    for first in &table {
        let same = |row: &Row| {
            row.lambda_nm == first.lambda_nm && row.mu_a_per_mm == first.mu_a_per_mm && row.psi_deg == first.psi_deg
        };
        let known = |p: &YarnProblem| {
            p.lambda_nm == first.lambda_nm && p.mu_a_per_mm == first.mu_a_per_mm && p.psi_deg == first.psi_deg
        };
        if problems.iter().any(known) {
            continue;
        }
        let select = |kind: &str, component: &str| -> Vec<&Row> {
            let wanted = |row: &&Row| same(row) && row.kind == kind && row.component == component;
            table.iter().filter(wanted).collect()
        };
        let totals = TOTALS.iter().flat_map(|&(quantity, component)| {
            let estimate = |row: &Row| Estimate {
                value: row.fraction,
                se: row.se,
            };
            let rows = select("total", component);
            rows.into_iter().map(move |row| (quantity, estimate(row)))
        });
        problems.push(YarnProblem {
            lambda_nm: first.lambda_nm,
            mu_a_per_mm: first.mu_a_per_mm,
            psi_deg: first.psi_deg,
            totals: totals.collect(),
            histograms: [
                Histogram::new("azimuth of scattered, all bins", &select("azimuth", "scattered")),
                Histogram::new("azimuth of ballistic, all bins", &select("azimuth", "unscattered")),
                Histogram::new("angle to axis of scattered, all bins", &select("theta", "scattered")),
            ],
            cylinder: Cylinder::new(RADIUS_MM)?,
            medium: medium(first.lambda_nm, first.mu_a_per_mm)?,
        });
    }
    Ok(problems)
}

fn medium(lambda_nm: f64, mu_a_per_mm: f64) -> Result<Medium, ValidateError> {
    let spec = MediumSpec {
        host_index: Spectrum::Constant(HOST_INDEX),
        particle_index: Spectrum::Constant(PARTICLE_INDEX),
        particle_kappa: Spectrum::Constant(0.0),
        host_mu_a_per_mm: Spectrum::Constant(mu_a_per_mm),
        particle_diameter_nm: DIAMETER_NM,
        volume_fraction: VOLUME_FRACTION,
        interference: Interference::Independent,
    };
    Ok(Medium::new(&spec, &WavelengthGrid::new(vec![lambda_nm])?)?)
}

impl YarnProblem {
    pub fn name(&self) -> String {
        let Self {
            lambda_nm,
            mu_a_per_mm,
            psi_deg,
            ..
        } = self;
        format!("yarn {lambda_nm} nm mu_a={mu_a_per_mm} tilt={psi_deg}")
    }

    /// Batch means: the totals in order, then the cells of the histograms.
    pub fn batch(&self, paths: u64, stream: Xoshiro256PlusPlus) -> Result<Vec<f64>, ValidateError> {
        let interior = Interior::new(
            self.medium.host_index()[0],
            &[Coefficients {
                mu_s: self.medium.mu_s_per_mm()[0],
                mu_a: self.medium.mu_a_per_mm()[0],
                phase: self.medium.phase(0),
            }],
        )?;
        let walk = Walk {
            shape: &self.cylinder,
            interior: &interior,
            roulette: Roulette::default(),
        };
        let [azimuth, straight, theta] = &self.histograms;
        let mut cells = self.histograms.each_ref().map(|h| vec![0.0; h.references.len()]);
        let traced = parallel_beam(&walk, self.psi_deg.to_radians(), paths, stream, |exit| {
            let (direction, weight) = (exit.direction, exit.weights[0]);
            // 0 is forward, 180 backward.
            let azimuth_deg = direction.x.atan2(-direction.z).to_degrees().rem_euclid(360.0);
            if exit.scattered {
                azimuth.add(&mut cells[0], azimuth_deg, weight);
                theta.add(&mut cells[2], direction.y.clamp(-1.0, 1.0).acos().to_degrees(), weight);
            } else {
                straight.add(&mut cells[1], azimuth_deg, weight);
            }
        });
        let totals = traced.ledgers.iter().flat_map(|ledger| {
            [
                ledger[Fraction::Reflected],
                ledger[Fraction::Ballistic],
                ledger[Fraction::Scattered],
                ledger[Fraction::Absorbed],
            ]
        });
        let sums = totals.chain(cells.into_iter().flatten());
        Ok(sums.map(|s| s / paths as f64).collect())
    }

    pub fn checks(&self, estimates: &[Estimate]) -> Vec<Check> {
        let (totals, mut cells) = estimates.split_at(TOTALS.len());
        let mut checks: Vec<Check> = totals
            .iter()
            .zip(&self.totals)
            .map(|(estimate, &(quantity, reference))| check(*estimate, self.name(), quantity, reference))
            .collect();
        for histogram in &self.histograms {
            let (own, rest) = cells.split_at(histogram.references.len());
            checks.push(joint(self.name(), histogram.quantity, own, &histogram.references));
            cells = rest;
        }
        checks
    }
}
