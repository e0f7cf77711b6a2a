use super::TransportError;
use crate::fault::{self, Fault};

/// Reflections in a row, with no particle between them, after which roulette is played whatever the weight. Light that
/// entered at a grazing angle, or that total reflection traps in a body that hardly scatters, loses next to nothing in
/// each and would go round without end.
pub(super) const REFLECTIONS_IN_A_ROW: u64 = 10_000;

/// Unbiased end of a path: below `threshold` of the weight it entered with, at every wavelength, a path survives with
/// probability `survival` and is then worth 1/`survival` times as much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roulette {
    threshold: f64,
    survival: f64,
}

impl Roulette {
    pub fn new(threshold: f64, survival: f64) -> Result<Self, TransportError> {
        for (quantity, found, top) in [
            ("roulette threshold", threshold, 1.0),
            ("roulette survival", survival, 1.0),
        ] {
            if !(found > 0.0 && found < top) {
                return Err(TransportError::Domain {
                    quantity,
                    expected: "a fraction between 0 and 1, exclusive",
                    found,
                    remedy: "take the default by leaving it out of [trace]",
                });
            }
        }
        Ok(Self { threshold, survival })
    }

    /// Factor of a path's weights after Russian roulette: 0, 1 or 1/`survival`, so that the estimate stays unbiased. `largest` is
    /// the largest of its weights, `entered` of those it came in with, and `u` a uniform random number in [0, 1).
    #[inline(always)]
    pub(super) fn worth(&self, largest: f64, entered: f64, reflections: u64, u: f64) -> f64 {
        let plays = (largest < self.threshold * entered) | (reflections >= REFLECTIONS_IN_A_ROW);
        let survivor = if fault::active(Fault::RouletteBias) { 1.01 } else { 1.0 } / self.survival;
        let worth = if u < self.survival { survivor } else { 0.0 };
        if plays { worth } else { 1.0 }
    }
}

impl Default for Roulette {
    fn default() -> Self {
        Self {
            threshold: 0.1,
            survival: 0.2,
        }
    }
}
