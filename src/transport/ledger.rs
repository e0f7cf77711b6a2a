use super::Estimate;

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
}

impl Ledger {
    /// 1 − everything accounted for; 0 to rounding for a closed ledger.
    pub fn residual(&self) -> f64 {
        1.0 - (self.reflected + self.ballistic + self.scattered + self.absorbed + self.roulette)
    }

    pub fn add(&mut self, other: &Self) {
        self.reflected += other.reflected;
        self.ballistic += other.ballistic;
        self.scattered += other.scattered;
        self.absorbed += other.absorbed;
        self.roulette += other.roulette;
    }

    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            reflected: self.reflected * factor,
            ballistic: self.ballistic * factor,
            scattered: self.scattered * factor,
            absorbed: self.absorbed * factor,
            roulette: self.roulette * factor,
        }
    }

    fn fields(&self) -> [f64; 6] {
        [
            self.reflected,
            self.ballistic,
            self.scattered,
            self.absorbed,
            self.roulette,
            self.residual(),
        ]
    }
}

/// Mean of batches with its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LedgerEntry {
    pub mean: Ledger,
    /// Standard errors of reflected, ballistic, scattered, absorbed, roulette and residual.
    pub se: [f64; 6],
}

impl LedgerEntry {
    /// Mean and standard error of the mean of equally weighted batches.
    pub fn from_batches(batches: &[Ledger]) -> Self {
        let fields: Vec<[f64; 6]> = batches.iter().map(Ledger::fields).collect();
        let of: [Estimate; 6] = std::array::from_fn(|k| Estimate::from_batches(fields.iter().map(|f| f[k])));
        Self {
            mean: Ledger {
                reflected: of[0].value,
                ballistic: of[1].value,
                scattered: of[2].value,
                absorbed: of[3].value,
                roulette: of[4].value,
            },
            se: of.map(|estimate| estimate.se),
        }
    }
}
