use crate::transport::{LedgerOf, fractions};

fractions! {
    /// Fractions of the flux of a beam onto a cloth.
    pub enum ClothFraction {
        /// Left on the side it came from.
        Reflected = "reflected",
        /// Left on the other side after meeting a yarn.
        ThroughYarns = "through_yarns",
        /// Passed through the gaps without meeting a yarn.
        ThroughGaps = "through_gaps",
        /// Absorbed by the media of the yarns and by the backing; 0 where neither absorbs.
        Absorbed = "absorbed",
        /// Reflected by the outer surface of a yarn and discarded, by [`super::YarnSurface::Lost`].
        ReflectionDropped = "reflection_dropped",
        /// Not traced to a further yarn because of the limit on bounces, or trapped in a yarn that neither scatters nor
        /// absorbs.
        BouncesCut = "bounces_cut",
        /// Net weight that random sampling removed: Russian roulette between the yarns, and both nets of their media. 0
        /// in the mean.
        SamplingNet = "sampling_net",
    }
}

/// Energy ledger of a beam onto a cloth, as fractions of the incident flux at one wavelength. Its residual is 0 to the
/// rounding of single precision.
pub type ClothLedger = LedgerOf<ClothFraction, { ClothFraction::COUNT }>;

impl ClothLedger {
    /// Total transmittance: through yarns and gaps.
    pub fn transmitted(&self) -> f64 {
        self[ClothFraction::ThroughYarns] + self[ClothFraction::ThroughGaps]
    }
}
