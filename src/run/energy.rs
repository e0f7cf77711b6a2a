use crate::report::EnergyRow;
use crate::transport::{Ledger, LedgerEntry};
use crate::yarn::IncidentGrid;

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
                _,
                sharing_se,
                residual_se,
                roulette_se,
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
                roulette: entry.mean.games(),
                roulette_se,
                residual: entry.mean.residual(),
                residual_se,
                sharing: entry.mean.sharing,
                sharing_se,
            });
        }
    }
    rows
}
