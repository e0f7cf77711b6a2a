use super::TransportError;
use crate::fault::{self, Fault};

/// Number of consecutive internal reflections after which Russian roulette applies whatever the weight. Light that
/// entered at grazing incidence, or is trapped by total internal reflection in a body that hardly scatters, loses
/// almost nothing at each reflection and would never end otherwise.
pub(super) const REFLECTIONS_IN_A_ROW: u64 = 10_000;

/// Russian roulette: once a path's weight is below `threshold` times its entry weight at every wavelength, it survives
/// with probability `survival` and its weight is divided by `survival`, so the estimate stays unbiased.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roulette {
    threshold: f64,
    survival: f64,
}

impl Roulette {
    /// `threshold` is a fraction of the entry weight, `survival` a probability.
    ///
    /// # Errors
    /// [`TransportError::Domain`] if either is not between 0 and 1, exclusive.
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

    /// Factor of a path's weights after Russian roulette: 0, 1 or 1/`survival`. `largest` is the largest of its
    /// weights, `entered` the largest of its entry weights, `reflections` the number of consecutive internal
    /// reflections, and `u` a uniform random number in [0, 1).
    #[inline(always)]
    pub(super) fn worth(&self, largest: f64, entered: f64, reflections: u64, u: f64) -> f64 {
        let applies = (largest < self.threshold * entered) | (reflections >= REFLECTIONS_IN_A_ROW);
        let survivor = if fault::active(Fault::RouletteBias) { 1.01 } else { 1.0 } / self.survival;
        let worth = if u < self.survival { survivor } else { 0.0 };
        if applies { worth } else { 1.0 }
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
