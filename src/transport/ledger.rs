use super::Estimate;
use crate::fault::{self, Fault};

/// Where the light of one incident direction and wavelength went, as fractions of the incident flux.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ledger {
    /// Reflected by the surface on the way in.
    pub reflected: f64,
    /// Left without meeting a particle.
    pub ballistic: f64,
    /// Left after one or more scatterings.
    pub scattered: f64,
    pub absorbed: f64,
    /// Weight that roulette took less what it gave; 0 in the mean.
    pub roulette: f64,
    /// Weight that the balance heuristic of shared paths took less what it gave, as a path told more and more of whose it
    /// is, and what their single precision rounded off; 0 in the mean, and 0 for paths of one wavelength.
    pub sharing: f64,
}

impl Ledger {
    /// How many there are, the residual apart.
    pub const FRACTIONS: usize = 6;

    /// 1 − everything accounted for; 0 to rounding for a closed ledger.
    pub fn residual(&self) -> f64 {
        1.0 - (self.reflected + self.ballistic + self.scattered + self.absorbed + self.roulette + self.sharing)
    }

    pub fn add(&mut self, other: &Self) {
        self.reflected += other.reflected;
        self.ballistic += other.ballistic;
        self.scattered += other.scattered;
        self.absorbed += other.absorbed;
        self.roulette += other.roulette;
        self.sharing += other.sharing;
    }

    pub fn scaled(&self, factor: f64) -> Self {
        let mut fractions = self.fractions().map(|fraction| fraction * factor);
        if fault::active(Fault::HalfAbsorbed) {
            fractions[3] *= 0.5;
        }
        Self::from_fractions(fractions)
    }

    /// What the two games of chance took less what they gave: roulette and the balance heuristic. 0 in the mean.
    pub fn games(&self) -> f64 {
        self.roulette + self.sharing
    }

    /// Reflected, ballistic, scattered, absorbed, roulette, sharing.
    pub fn fractions(&self) -> [f64; Self::FRACTIONS] {
        [
            self.reflected,
            self.ballistic,
            self.scattered,
            self.absorbed,
            self.roulette,
            self.sharing,
        ]
    }

    pub fn from_fractions(
        [reflected, ballistic, scattered, absorbed, roulette, sharing]: [f64; Self::FRACTIONS],
    ) -> Self {
        Self {
            reflected,
            ballistic,
            scattered,
            absorbed,
            roulette,
            sharing,
        }
    }
}

/// Mean of batches with its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LedgerEntry {
    pub mean: Ledger,
    /// Standard errors of reflected, ballistic, scattered, absorbed, roulette, sharing, residual and games.
    pub se: [f64; Ledger::FRACTIONS + 2],
}

impl LedgerEntry {
    /// Mean and standard error of the mean of equally weighted batches.
    pub fn from_batches(batches: &[Ledger]) -> Self {
        let estimate = |of: &dyn Fn(&Ledger) -> f64| Estimate::from_batches(batches.iter().map(of));
        let of: [Estimate; Ledger::FRACTIONS] = std::array::from_fn(|k| estimate(&|ledger| ledger.fractions()[k]));
        let [residual, games] = [Ledger::residual, Ledger::games].map(|derived| estimate(&derived));
        let [reflected, ballistic, scattered, absorbed, roulette, sharing] = of.map(|estimate| estimate.se);
        Self {
            mean: Ledger::from_fractions(of.map(|estimate| estimate.value)),
            se: [
                reflected,
                ballistic,
                scattered,
                absorbed,
                roulette,
                sharing,
                residual.se,
                games.se,
            ],
        }
    }
}
