/// Where the light of a beam onto a cloth went, as fractions of the incident flux at one wavelength.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ClothLedger {
    /// Left on the side it came from.
    pub reflected: f64,
    /// Left on the other side after meeting a yarn.
    pub through_yarns: f64,
    /// Went through the gaps without meeting any.
    pub through_gaps: f64,
    /// By the media of the yarns and by the backing: 0 where neither absorbs.
    pub absorbed: f64,
    /// Reflected by the outer surface of a yarn and left out, by [`super::YarnSurface::Lost`].
    pub reflection_dropped: f64,
    /// On its way to a yarn beyond the most that are followed, or caught inside a yarn that neither scatters nor absorbs.
    pub bounces_cut: f64,
    /// What games of chance took from the particles' weights less what they gave; 0 in the mean.
    pub games: f64,
}

impl ClothLedger {
    pub const FRACTIONS: usize = 7;

    /// 1 − everything accounted for; 0 to rounding of single precision where nothing is lost.
    pub fn residual(&self) -> f64 {
        1.0 - self.fractions().iter().sum::<f64>()
    }

    pub fn transmitted(&self) -> f64 {
        self.through_yarns + self.through_gaps
    }

    pub fn from_fractions(fractions: [f64; Self::FRACTIONS]) -> Self {
        let [
            reflected,
            through_yarns,
            through_gaps,
            absorbed,
            reflection_dropped,
            bounces_cut,
            games,
        ] = fractions;
        Self {
            reflected,
            through_yarns,
            through_gaps,
            absorbed,
            reflection_dropped,
            bounces_cut,
            games,
        }
    }

    /// In the order of the fields.
    pub fn fractions(&self) -> [f64; Self::FRACTIONS] {
        [
            self.reflected,
            self.through_yarns,
            self.through_gaps,
            self.absorbed,
            self.reflection_dropped,
            self.bounces_cut,
            self.games,
        ]
    }
}
