use crate::report::EnergyRow;
use crate::transport::{Column, Ledger};
use crate::yarn::IncidentGrid;

/// The ledger of every wavelength and incident direction, mirrored ones included, from that of every batch.
pub fn energy_rows(wavelength_nm: &[f64], incident: &IncidentGrid, batches: &[Vec<Ledger>]) -> Vec<EnergyRow> {
    let wavelengths = wavelength_nm.len();
    let estimates: Vec<_> = (0..incident.traced() * wavelengths)
        .map(|i| Column::estimates(&batches.iter().map(|batch| batch[i]).collect::<Vec<_>>()))
        .collect();
    let mut rows = Vec::with_capacity(wavelengths * incident.len());
    for (wavelength, &wavelength_nm) in wavelength_nm.iter().enumerate() {
        for direction in 0..incident.len() {
            let columns = estimates[incident.representative(direction).0 * wavelengths + wavelength];
            rows.push(EnergyRow::new(wavelength_nm, incident.angles_deg(direction), columns));
        }
    }
    rows
}
