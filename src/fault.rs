//! Deliberate faults of the physics, for tests alone: each must turn a gate of [`crate::check`] red.
//!
//! Without the cargo feature `faults` (off by default, never in a release) [`active`] is a constant `false` and the
//! seams compile to nothing. With it one fault may be named in the environment variable `SPECVAL_FAULT`, read once, or
//! committed by `commit`.

#[cfg(feature = "faults")]
use std::sync::LazyLock;
#[cfg(feature = "faults")]
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// One fault, named in `SPECVAL_FAULT` as [`Fault::name`] says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The particles' index n − iκ under the time factor exp(−iωt): they amplify.
    KappaSign,
    /// Fresnel's reflectance of s-polarised light for unpolarised.
    FresnelPolarisation,
    /// f* summed from the BSSRDF without the cosine of incidence on the patch.
    MissingCosine,
    /// Shading with f* multiplies by the cosine of incidence that f* holds already.
    DoubleCosine,
    /// Survivors of roulette are worth 1 % too much.
    RouletteBias,
    /// Phase tables read one node late.
    PhaseBin,
    /// Light beyond the last z edge is dropped from the BSSRDF.
    ZOverflow,
    /// Colour-matching functions read 10 nm beside.
    ObserverShift,
    /// f* divided by the cosine of the tilt, as a BRDF would be.
    FactorOverCosine,
    /// Ballistic light binned into f* as well.
    BallisticBinned,
    /// Illuminant D65 in place of E, and E in place of D65.
    IlluminantSwap,
    /// Dyes 2 % stronger than their tables.
    DyeScale,
    /// Light from one side of the yarn's normal plane looked up on the other.
    AxisMirror,
    /// Absorbed light counted at half of what it is.
    HalfAbsorbed,
    /// Camera rays jittered over half of their pixel alone.
    HalfPixel,
    /// The draft woven in its mirror image: the first warp last.
    DraftMirrored,
    /// The draft read with its wefts up where warps are: the cloth's back for its face.
    FacesExchanged,
    /// The plane of incidence along the warp, whatever the rig's azimuth.
    AzimuthIgnored,
    /// Centre lines of the mesh a tenth too low.
    CrimpLow,
    /// Light from the mirror side of the normal.
    LightMirrored,
    /// The gloss about the cloth's normal doubled.
    GlossDoubled,
    /// The shadow ray meets the yarn it starts on.
    OwnShadow,
    /// A hundredth of the light that leaves the cloth is not counted.
    ClothLoss,
    /// The Percus–Yevick factor worked out, and left out of the phase function.
    InterferenceUnused,
    /// |S1|² alone in the phase function, as of light polarised across the scattering plane.
    OnePolarisation,
    /// μ_s of the medium 1 % too high.
    ScatteringHigh,
    /// κ of the particles not divided by the host's index.
    KappaAbsolute,
    /// The size parameter with the vacuum wavelength.
    VacuumSize,
    /// Independent paths: μ_a of the wavelength in the middle 2 % too high.
    OneAbsorption,
    /// Shared paths fly and are weighed with 1 % more μ_s than the medium has.
    FlightsShort,
    /// Shared paths turn by the phase function of the hero's neighbour.
    NeighbourAngle,
    /// Re-absorption with the sign of the change reversed.
    ReabsorptionSign,
    /// f* looked up half a cell of tilt beside.
    TiltHalfCell,
    /// f* looked up with the sign of the azimuth reversed.
    AzimuthSign,
    /// Light binned into the next cell of exit azimuth.
    ExitAzimuthShift,
    /// Light binned with its tangent reversed.
    ExitTangentMirrored,
    /// Standard errors of half their size.
    ErrorsHalved,
    /// Normalisation by red in place of luminance.
    NormalisedByRed,
    /// 3 % of what shading in the sun shows left out.
    SunlitLoss,
    /// A tenth too much of what views see of light between yarns.
    BetweenGain,
    /// Light that a yarn sends on by its f* worth 3 % too much.
    BounceGain,
    /// 3 % of the light missing in the tables of where it leaves.
    PassageLoss,
    /// What enters a yarn and meets a particle or is absorbed 3 % too high.
    EnteringHigh,
    /// 3 % of the light that cones about views catch left out.
    ApertureLoss,
    /// The warp's medium in wefts of another.
    WeftAsWarp,
    /// The matrix from XYZ to RGB transposed.
    RgbTransposed,
    /// Slopes of the facets √2 times as wide as the roughness, and D not normalised.
    FacetSlope,
}

impl Fault {
    pub const ALL: [Self; 47] = [
        Self::KappaSign,
        Self::FresnelPolarisation,
        Self::MissingCosine,
        Self::DoubleCosine,
        Self::RouletteBias,
        Self::PhaseBin,
        Self::ZOverflow,
        Self::ObserverShift,
        Self::FactorOverCosine,
        Self::BallisticBinned,
        Self::IlluminantSwap,
        Self::DyeScale,
        Self::AxisMirror,
        Self::HalfAbsorbed,
        Self::HalfPixel,
        Self::DraftMirrored,
        Self::FacesExchanged,
        Self::AzimuthIgnored,
        Self::CrimpLow,
        Self::LightMirrored,
        Self::GlossDoubled,
        Self::OwnShadow,
        Self::ClothLoss,
        Self::InterferenceUnused,
        Self::OnePolarisation,
        Self::ScatteringHigh,
        Self::KappaAbsolute,
        Self::VacuumSize,
        Self::OneAbsorption,
        Self::FlightsShort,
        Self::NeighbourAngle,
        Self::ReabsorptionSign,
        Self::TiltHalfCell,
        Self::AzimuthSign,
        Self::ExitAzimuthShift,
        Self::ExitTangentMirrored,
        Self::ErrorsHalved,
        Self::NormalisedByRed,
        Self::SunlitLoss,
        Self::BetweenGain,
        Self::BounceGain,
        Self::PassageLoss,
        Self::EnteringHigh,
        Self::ApertureLoss,
        Self::WeftAsWarp,
        Self::RgbTransposed,
        Self::FacetSlope,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::KappaSign => "kappa-sign",
            Self::FresnelPolarisation => "fresnel-polarisation",
            Self::MissingCosine => "missing-cosine",
            Self::DoubleCosine => "double-cosine",
            Self::RouletteBias => "roulette-bias",
            Self::PhaseBin => "phase-bin",
            Self::ZOverflow => "z-overflow",
            Self::ObserverShift => "observer-shift",
            Self::FactorOverCosine => "factor-over-cosine",
            Self::BallisticBinned => "ballistic-binned",
            Self::IlluminantSwap => "illuminant-swap",
            Self::DyeScale => "dye-scale",
            Self::AxisMirror => "axis-mirror",
            Self::HalfAbsorbed => "half-absorbed",
            Self::HalfPixel => "half-pixel",
            Self::DraftMirrored => "draft-mirrored",
            Self::FacesExchanged => "faces-exchanged",
            Self::AzimuthIgnored => "azimuth-ignored",
            Self::CrimpLow => "crimp-low",
            Self::LightMirrored => "light-mirrored",
            Self::GlossDoubled => "gloss-doubled",
            Self::OwnShadow => "own-shadow",
            Self::ClothLoss => "cloth-loss",
            Self::InterferenceUnused => "interference-unused",
            Self::OnePolarisation => "one-polarisation",
            Self::ScatteringHigh => "scattering-high",
            Self::KappaAbsolute => "kappa-absolute",
            Self::VacuumSize => "vacuum-size",
            Self::OneAbsorption => "one-absorption",
            Self::FlightsShort => "flights-short",
            Self::NeighbourAngle => "neighbour-angle",
            Self::ReabsorptionSign => "reabsorption-sign",
            Self::TiltHalfCell => "tilt-half-cell",
            Self::AzimuthSign => "azimuth-sign",
            Self::ExitAzimuthShift => "exit-azimuth-shift",
            Self::ExitTangentMirrored => "exit-tangent-mirrored",
            Self::ErrorsHalved => "errors-halved",
            Self::NormalisedByRed => "normalised-by-red",
            Self::SunlitLoss => "sunlit-loss",
            Self::BetweenGain => "between-gain",
            Self::BounceGain => "bounce-gain",
            Self::PassageLoss => "passage-loss",
            Self::EnteringHigh => "entering-high",
            Self::ApertureLoss => "aperture-loss",
            Self::WeftAsWarp => "weft-as-warp",
            Self::RgbTransposed => "rgb-transposed",
            Self::FacetSlope => "facet-slope",
        }
    }
}

/// Whether this fault is to be committed.
#[cfg(not(feature = "faults"))]
#[inline(always)]
pub const fn active(_: Fault) -> bool {
    false
}

/// Whether this fault is to be committed: the one that [`commit`] or `SPECVAL_FAULT` names. A name of none is none.
#[cfg(feature = "faults")]
#[inline]
pub fn active(fault: Fault) -> bool {
    COMMITTED.load(Relaxed) == fault as usize
}

/// Commits this fault from now on, in place of any other.
#[cfg(feature = "faults")]
pub fn commit(fault: Option<Fault>) {
    COMMITTED.store(fault.map_or(NONE, |fault| fault as usize), Relaxed);
}

#[cfg(feature = "faults")]
const NONE: usize = usize::MAX;

#[cfg(feature = "faults")]
static COMMITTED: LazyLock<AtomicUsize> = LazyLock::new(|| {
    let name = std::env::var("SPECVAL_FAULT").unwrap_or_default();
    let named = Fault::ALL.into_iter().find(|fault| fault.name() == name);
    AtomicUsize::new(named.map_or(NONE, |fault| fault as usize))
});
