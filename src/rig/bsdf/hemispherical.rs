use super::{FullBsdf, Incidence};
use crate::cloth::light::{ClothFraction, ClothLedger};
use crate::formats::Side;
use crate::transport::{Estimate, FractionList};
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};
use std::ops::Index;

/// Number of quantities stored for an incidence and wavelength: the fractions of the ledger, then the total
/// transmittance.
pub(super) const QUANTITIES: usize = ClothFraction::COUNT + 1;

pub(super) fn quantities(ledger: &[ClothLedger]) -> Vec<f64> {
    let all = |ledger: &ClothLedger| {
        let mut quantities = [ledger.transmitted(); QUANTITIES];
        quantities[..ClothFraction::COUNT].copy_from_slice(&ledger.amounts());
        quantities
    };
    ledger.iter().flat_map(all).collect()
}

/// Energy ledger of light from one direction at one wavelength: fractions of its flux with standard errors, indexed by
/// fraction. [`ClothFraction::Reflected`] is the directional-hemispherical reflectance.
#[derive(Clone, Debug, PartialEq)]
pub struct HemisphericalRow {
    pub light_from: Side,
    /// Angle from the normal of that side, degrees.
    pub theta_i_deg: f64,
    /// Azimuth from the warp towards the weft, degrees, seen from the front.
    pub phi_i_deg: f64,
    pub wavelength_nm: f64,
    /// Directional-hemispherical transmittance: through yarns and gaps.
    pub transmittance: Estimate,
    /// 1 − the sum of all fractions: 0 to rounding.
    pub residual: f64,
    fractions: [Estimate; ClothFraction::COUNT],
}

impl Index<ClothFraction> for HemisphericalRow {
    type Output = Estimate;

    fn index(&self, fraction: ClothFraction) -> &Estimate {
        &self.fractions[fraction.index()]
    }
}

impl Serialize for HemisphericalRow {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut row = serializer.serialize_struct("HemisphericalRow", 7 + 2 * ClothFraction::COUNT)?;
        row.serialize_field("light_from", &self.light_from)?;
        row.serialize_field("theta_i_deg", &self.theta_i_deg)?;
        row.serialize_field("phi_i_deg", &self.phi_i_deg)?;
        row.serialize_field("wavelength_nm", &self.wavelength_nm)?;
        let reflected = self[ClothFraction::Reflected];
        row.serialize_field("reflectance", &reflected.value)?;
        row.serialize_field("reflectance_se", &reflected.se)?;
        row.serialize_field("transmittance", &self.transmittance.value)?;
        row.serialize_field("transmittance_se", &self.transmittance.se)?;
        for &fraction in ClothFraction::ALL {
            if fraction != ClothFraction::Reflected {
                row.serialize_field(fraction.name(), &self[fraction].value)?;
                row.serialize_field(fraction.se_name(), &self[fraction].se)?;
            }
        }
        row.serialize_field("residual", &self.residual)?;
        row.end()
    }
}

impl Incidence {
    /// Fractions in the order of [`ClothFraction`], and the total transmittance.
    pub(super) fn fractions(&self, wavelength: usize) -> ([Estimate; ClothFraction::COUNT], Estimate) {
        let of = |k: usize| self.ledger.estimate(wavelength * QUANTITIES + k);
        (std::array::from_fn(of), of(ClothFraction::COUNT))
    }
}

impl FullBsdf {
    /// Ledger of every traced incidence at each wavelength.
    pub fn hemispherical(&self) -> Vec<HemisphericalRow> {
        let mut rows = Vec::new();
        for incidence in &self.incidences {
            let d = self.cells.incident_centre(incidence.cell);
            let rounded = |angle_rad: f64| (angle_rad.to_degrees() * 1e9).round() / 1e9;
            let theta_i_deg = rounded(d.x.hypot(d.y).atan2(d.z));
            let phi_i_deg = if incidence.cell == 0 {
                0.0
            } else {
                rounded(d.y.atan2(d.x)).rem_euclid(360.0)
            };
            for (w, &wavelength_nm) in self.grid.nm().iter().enumerate() {
                let (fractions, transmittance) = incidence.fractions(w);
                rows.push(HemisphericalRow {
                    light_from: incidence.side,
                    theta_i_deg,
                    phi_i_deg,
                    wavelength_nm,
                    transmittance,
                    residual: 1.0 - fractions.iter().map(|part| part.value).sum::<f64>(),
                    fractions,
                });
            }
        }
        rows
    }

    /// Median relative standard error over the values of f at all wavelengths; `None` if nothing is scattered.
    pub fn median_relative_error(&self) -> Option<f64> {
        let of = |incidence: &Incidence| {
            let values = (0..incidence.caught.sum.len()).map(|i| incidence.caught.estimate(i));
            values
                .filter(|f| f.value > 0.0)
                .map(|f| f.se / f.value)
                .collect::<Vec<f64>>()
        };
        let mut errors: Vec<f64> = self.incidences.iter().flat_map(of).collect();
        if errors.is_empty() {
            return None;
        }
        let middle = errors.len() / 2;
        Some(*errors.select_nth_unstable_by(middle, f64::total_cmp).1)
    }
}
