use super::{FullBsdf, Incidence};
use crate::cloth::light::{ClothFraction, ClothLedger};
use crate::formats::Side;
use crate::transport::Estimate;
use serde::Serialize;

/// Fractions kept of an incidence at a wavelength: those of the ledger, then the whole transmission.
pub(super) const QUANTITIES: usize = ClothFraction::COUNT + 1;

pub(super) fn quantities(ledger: &[ClothLedger]) -> Vec<f64> {
    let all = |ledger: &ClothLedger| {
        let mut quantities = [ledger.transmitted(); QUANTITIES];
        quantities[..ClothFraction::COUNT].copy_from_slice(&ledger.amounts());
        quantities
    };
    ledger.iter().flat_map(all).collect()
}

/// Where the light of one direction went, as fractions of its flux at one wavelength, each with its standard error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HemisphericalRow {
    pub light_from: Side,
    /// From the normal of that side.
    pub theta_i_deg: f64,
    /// From the warp towards the weft, seen from the front.
    pub phi_i_deg: f64,
    pub wavelength_nm: f64,
    /// Directional-hemispherical reflectance.
    pub reflectance: f64,
    pub reflectance_se: f64,
    /// Directional-hemispherical transmittance: through yarns and gaps.
    pub transmittance: f64,
    pub transmittance_se: f64,
    pub through_yarns: f64,
    pub through_yarns_se: f64,
    /// Straight through, without meeting a yarn.
    pub through_gaps: f64,
    pub through_gaps_se: f64,
    /// By the media of the yarns alone.
    pub absorbed: f64,
    pub absorbed_se: f64,
    /// Reflected by the yarns' outer surface, where that light is left out.
    pub reflection_dropped: f64,
    pub reflection_dropped_se: f64,
    /// Not followed further.
    pub bounces_cut: f64,
    pub bounces_cut_se: f64,
    /// What games of chance took; 0 in the mean.
    pub games: f64,
    pub games_se: f64,
    /// 1 less the sum of the others: 0 to rounding.
    pub residual: f64,
}

impl Incidence {
    /// Those of [`ClothFraction`], and all that is transmitted.
    pub(super) fn fractions(&self, wavelength: usize) -> [Estimate; QUANTITIES] {
        std::array::from_fn(|k| self.ledger.estimate(wavelength * QUANTITIES + k))
    }
}

impl FullBsdf {
    /// Of every incidence that was traced, at each wavelength.
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
                let [reflected, yarns, gaps, absorbed, dropped, cut, games, transmitted] = incidence.fractions(w);
                let all = [reflected, yarns, gaps, absorbed, dropped, cut, games];
                rows.push(HemisphericalRow {
                    light_from: incidence.side,
                    theta_i_deg,
                    phi_i_deg,
                    wavelength_nm,
                    reflectance: reflected.value,
                    reflectance_se: reflected.se,
                    transmittance: transmitted.value,
                    transmittance_se: transmitted.se,
                    through_yarns: yarns.value,
                    through_yarns_se: yarns.se,
                    through_gaps: gaps.value,
                    through_gaps_se: gaps.se,
                    absorbed: absorbed.value,
                    absorbed_se: absorbed.se,
                    reflection_dropped: dropped.value,
                    reflection_dropped_se: dropped.se,
                    bounces_cut: cut.value,
                    bounces_cut_se: cut.se,
                    games: games.value,
                    games_se: games.se,
                    residual: 1.0 - all.iter().map(|part| part.value).sum::<f64>(),
                });
            }
        }
        rows
    }

    /// Median over the values of f, at all wavelengths, of the standard error over the value; `None` where nothing is
    /// scattered.
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
