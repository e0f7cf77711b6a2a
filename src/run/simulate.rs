use super::{CameraBatch, Plan, Progress, RunError, SpectralCurves};
use crate::compare::Geometry;
use crate::report::EnergyRow;
use crate::study::ShadeWith;
use crate::transport::{Ledger, LedgerEntry};
use crate::yarn::{BssrdfGrid, DirectTracer, EnergyTracer, IncidentGrid, PatchTracer};
use rayon::prelude::*;

/// Batches under way at once; each holds a table of f*.
const ROUND: usize = 4;

/// What one batch of light through yarn, cloth and rig gives. Nothing in it grows with the number of paths.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// Energy ledgers: traced incident direction × wavelength, wavelength fastest.
    pub ledgers: Vec<Ledger>,
    /// Diffuse β at [geometry][wavelength].
    pub diffuse: Vec<Vec<f64>>,
}

/// Makes batches: each traces the yarn and shades the cloth with what it found.
pub struct Simulator<'a> {
    plan: &'a Plan,
    geometries: Vec<Geometry>,
    energy: EnergyTracer<'a>,
    shading: Shading<'a>,
}

/// The road to the f* that the study shades with.
enum Shading<'a> {
    Direct(DirectTracer<'a>),
    Bssrdf(BssrdfGrid),
}

impl<'a> Simulator<'a> {
    pub fn new(plan: &'a Plan, geometries: Vec<Geometry>) -> Result<Self, RunError> {
        Ok(Self {
            plan,
            geometries,
            energy: EnergyTracer::new(&plan.yarn, plan.incident, plan.bssrdf_effort, None)?,
            shading: match plan.study.trace.shade_with {
                ShadeWith::Direct => Shading::Direct(DirectTracer::new(
                    &plan.yarn,
                    plan.factor_grid,
                    plan.direct_effort,
                    None,
                )?),
                ShadeWith::Bssrdf => Shading::Bssrdf(plan.bssrdf_grid()?),
            },
        })
    }

    /// Batch number `batch`, the same whenever and wherever it is made.
    pub fn batch(&self, batch: usize) -> Result<Batch, RunError> {
        let plan = self.plan;
        let ledgers = self.energy.batch(batch).ledgers;
        let table = match &self.shading {
            Shading::Direct(tracer) => tracer.batch(batch).radiance_factor,
            Shading::Bssrdf(grid) => {
                PatchTracer::new(&plan.yarn, grid, plan.factor_grid, plan.bssrdf_effort)?
                    .batch(batch)
                    .radiance_factor
            }
        };
        let diffuse = CameraBatch::trace(plan, &self.geometries, batch).shade(&table);
        Ok(Batch { ledgers, diffuse })
    }
}

/// All batches of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulation {
    pub curves: SpectralCurves,
    /// [batch][traced incident direction × wavelength].
    pub ledgers: Vec<Vec<Ledger>>,
}

/// Traces, shades and measures at the geometries.
pub fn simulate(plan: &Plan, geometries: Vec<Geometry>, progress: Progress) -> Result<Simulation, RunError> {
    let simulator = Simulator::new(plan, geometries.clone())?;
    let batches = plan.direct_effort.batches;
    let mut done = Vec::with_capacity(batches);
    for round in (0..batches).step_by(ROUND) {
        let made: Vec<Result<Batch, RunError>> = (round..(round + ROUND).min(batches))
            .into_par_iter()
            .map(|batch| {
                let made = simulator.batch(batch);
                progress(1.0 / batches as f64);
                made
            })
            .collect();
        for batch in made {
            done.push(batch?);
        }
    }
    let (ledgers, diffuse) = done.into_iter().map(|b| (b.ledgers, b.diffuse)).unzip();
    Ok(Simulation {
        curves: SpectralCurves::new(plan, geometries, diffuse),
        ledgers,
    })
}

/// The ledger of every wavelength and incident direction, mirrored ones included, from that of every batch.
pub fn energy_rows(wavelength_nm: &[f64], incident: &IncidentGrid, batches: &[Vec<Ledger>]) -> Vec<EnergyRow> {
    let wavelengths = wavelength_nm.len();
    let entries: Vec<LedgerEntry> = (0..incident.traced() * wavelengths)
        .map(|i| LedgerEntry::from_batches(&batches.iter().map(|batch| batch[i]).collect::<Vec<_>>()))
        .collect();
    let mut rows = Vec::with_capacity(wavelengths * incident.len());
    for (wavelength, &wavelength_nm) in wavelength_nm.iter().enumerate() {
        for direction in 0..incident.len() {
            let entry = &entries[incident.representative(direction).0 * wavelengths + wavelength];
            let [theta_in_deg, phi_in_deg] = incident.angles_deg(direction);
            let [
                reflected_se,
                ballistic_se,
                scattered_se,
                absorbed_se,
                roulette_se,
                residual_se,
            ] = entry.se;
            rows.push(EnergyRow {
                wavelength_nm,
                theta_in_deg,
                phi_in_deg,
                reflected: entry.mean.reflected,
                reflected_se,
                ballistic: entry.mean.ballistic,
                ballistic_se,
                scattered: entry.mean.scattered,
                scattered_se,
                absorbed: entry.mean.absorbed,
                absorbed_se,
                roulette: entry.mean.roulette,
                roulette_se,
                residual: entry.mean.residual(),
                residual_se,
            });
        }
    }
    rows
}
