use super::{Plan, Progress, RunError};
use crate::report::EnergyRow;
use crate::study::ShadeWith;
use crate::yarn::{BssrdfRun, DirectRun, RadianceFactorTable, trace_bssrdf, trace_direct};

/// The yarn, traced.
#[derive(Debug)]
pub struct Simulation {
    pub bssrdf: BssrdfRun,
    pub direct: DirectRun,
}

impl Simulation {
    /// The f* table the study shades with.
    pub fn table(&self, plan: &Plan) -> &RadianceFactorTable {
        match plan.study.trace.shade_with {
            ShadeWith::Direct => &self.direct.table,
            ShadeWith::Bssrdf => &self.bssrdf.table,
        }
    }
}

/// Traces the yarn from a patch and under parallel beams.
pub fn simulate(plan: &Plan, progress: Progress) -> Result<Simulation, RunError> {
    let wavelengths = plan.grid.len();
    let paths = |effort: &crate::yarn::Effort, directions: usize| {
        (effort.batches * effort.paths_per_batch * directions * wavelengths) as f64
    };
    let total =
        paths(&plan.bssrdf_effort, plan.incident.traced()) + paths(&plan.direct_effort, plan.factor_grid.tilts());
    let done = |paths: u64| progress(paths as f64 / total);
    let direct = trace_direct(&plan.yarn, plan.factor_grid, plan.direct_effort, &done);
    let bssrdf = trace_bssrdf(
        &plan.yarn,
        plan.incident,
        plan.bssrdf_surface,
        plan.factor_grid.tilts(),
        plan.study.trace.z_cells as usize,
        plan.bssrdf_effort,
        &done,
    )?;
    Ok(Simulation { bssrdf, direct })
}

/// The ledger of every wavelength and incident direction, mirrored ones included.
pub fn energy_rows(plan: &Plan, run: &BssrdfRun) -> Vec<EnergyRow> {
    let mut rows = Vec::with_capacity(plan.grid.len() * plan.incident.len());
    for (wavelength, &wavelength_nm) in plan.grid.nm().iter().enumerate() {
        for direction in 0..plan.incident.len() {
            let entry = &run.ledgers[wavelength][plan.incident.representative(direction).0];
            let [theta_in_deg, phi_in_deg] = plan.incident.angles_deg(direction);
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
