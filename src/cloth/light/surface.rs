use crate::shading::FibreGloss;

/// How the outer surface of a yarn distributes the light it reflects. The amount is the Fresnel reflectance of the
/// smooth surface in every case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum YarnSurface {
    /// Reflected light is discarded and recorded in the ledger: the cloth of f* without gloss.
    Lost,
    /// Specular reflection.
    Smooth,
    /// Reflection spread by the fibres of the surface.
    Fibres(FibreGloss),
}
