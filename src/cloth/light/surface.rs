use crate::shading::FibreGloss;

/// What becomes of light that the outer surface of a yarn reflects on its way in. How much that is, Fresnel's equations of
/// the smooth surface say in every case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum YarnSurface {
    /// It is left out, and the ledger says how much that is: the cloth of f* without gloss.
    Lost,
    /// A mirror sends it on.
    Smooth,
    /// Fibres send it on, spread out.
    Fibres(FibreGloss),
}
