use crate::study::MediumSection;
use serde::{Deserialize, Serialize};

/// One change of absorption of a trace: part of the identity of the resulting file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reabsorbed {
    /// SHA-256 of the file that was changed, without its trailing checksum.
    pub source_sha256: String,
    /// The medium of that file.
    pub from: MediumSection,
    /// Least and greatest change of the absorption coefficient over the wavelengths, 1/mm.
    pub mu_a_change_per_mm: [f64; 2],
    /// Least and greatest change of the scattering coefficient that came with it, relative.
    pub mu_s_change: [f64; 2],
    pub notices: Vec<ReabsorptionNotice>,
}

/// A limitation of a changed trace that its user should know.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReabsorptionNotice {
    pub kind: NoticeKind,
    /// The wavelength where it is worst.
    pub wavelength_nm: f64,
    /// Its size there; see the kind.
    pub value: f64,
    /// Fraction of the light of f* there that is concerned.
    pub share_of_light: f64,
    /// Number of wavelengths where the notice applies.
    pub wavelengths: usize,
}

/// Subject of a notice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NoticeKind {
    /// Few of the paths still count: below 10 % of them in cells with 5 % of the light or more. Value: the mean share
    /// of paths that counts.
    FewPathsCount,
    /// The systematic error of the bins exceeds the statistical one, and 1 %, in cells with 5 % of the light or more.
    /// Value: the relative systematic error of all light.
    BinsTooWide,
    /// Less absorption brings light into the last bin, whose lengths have no end: 1 % of the light or more, and the
    /// change takes place over half a mean length there. Value: that ratio.
    OpenBin,
    /// κ changed μ_s by more than 2 %. Value: the relative change.
    Scattering,
}
