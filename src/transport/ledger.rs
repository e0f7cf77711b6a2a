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
    /// Mean and standard error of the mean of equally weighted batches, summed in their order.
    pub fn from_batches(batches: &[Ledger]) -> Self {
        let n = batches.len() as f64;
        let mut sum = Ledger::default();
        batches.iter().for_each(|b| sum.add(b));
        let mean = sum.scaled(1.0 / n);
        let centre = mean.fields();
        let mut se = [0.0; 6];
        if batches.len() > 1 {
            for batch in batches {
                for (s, (x, m)) in se.iter_mut().zip(batch.fields().iter().zip(&centre)) {
                    *s += (x - m) * (x - m);
                }
            }
            se.iter_mut().for_each(|s| *s = (*s / (n * (n - 1.0))).sqrt());
        }
        Self { mean, se }
    }
}
