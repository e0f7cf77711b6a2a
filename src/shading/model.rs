use super::{ShadingError, Specular};
use crate::geometry::Vec3;

/// Parts of a classical model that the colour of a cloth does not change.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lobes {
    /// Brightness factor of the base per unit of its albedo; 1 for Lambert.
    pub base: f64,
    /// Brightness factor of what is reflected at the surface and has the colour of the light.
    pub gloss: f64,
}

/// A model of how a flat cloth reflects light about its normal, as renderers have it: albedo of each channel × base +
/// white × gloss.
pub trait ShadingModel: Send + Sync {
    /// Albedo of the base in red, green, blue and luminance.
    fn albedo(&self) -> [f64; 4];

    /// The parts towards `omega_out` for light from `omega_in`, unit vectors from the surface with the normal +z; 0
    /// with either in the plane or below it.
    fn lobes(&self, omega_in: &Vec3, omega_out: &Vec3) -> Lobes;

    /// Brightness factor π L / E in red, green, blue and luminance. `white` holds the channels of the perfect diffuser,
    /// of which gloss takes its colour.
    fn eval(&self, omega_in: &Vec3, omega_out: &Vec3, white: &[f64; 4]) -> [f64; 4] {
        let (albedo, Lobes { base, gloss }) = (self.albedo(), self.lobes(omega_in, omega_out));
        std::array::from_fn(|channel| base * albedo[channel] + gloss * white[channel])
    }
}

/// A parameter of a classical model that a fit may vary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    pub name: &'static str,
    /// Unit; empty for a dimensionless parameter.
    pub unit: &'static str,
    /// Range in which a fit searches.
    pub range: [f64; 2],
    pub meaning: &'static str,
}

/// First parameter of every classical model: what its base's albedo is of the sample's brightness factor at the normal.
/// A fit has an albedo of each channel in its place.
pub(super) const DIFFUSE: Parameter = Parameter {
    name: "diffuse",
    unit: "",
    range: [0.0, 2.0],
    meaning: "albedo of the base, in units of the sample's brightness factor at the normal",
};

/// Input of a classical model: a sample's reading and the gloss of the study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    /// The sample's brightness factors in red, green, blue and luminance with light and viewer on the normal, or
    /// nearest to it. Finite; below 0 where the sample's colour is outside the gamut, above 1 where it shines.
    pub normal: [f64; 4],
    pub specular: Specular,
}

/// A model, or the error that prevents it.
pub type Shading = Result<Box<dyn ShadingModel>, ShadingError>;

/// A row of the registry: names, parameters and constructor of a classical model.
#[derive(Debug)]
pub struct ClassicalModel {
    pub id: &'static str,
    /// Name in legends.
    pub label: &'static str,
    pub parameters: &'static [Parameter],
    /// Initial values of the parameters for a basis, used without a fit.
    pub start: fn(&Basis) -> Vec<f64>,
    /// Builds the model from one value for each parameter.
    pub build: fn(&Basis, &[f64]) -> Shading,
}

impl ClassicalModel {
    /// The model for a sample and a study, without a fit.
    ///
    /// # Errors
    /// [`ShadingError`] if the model rejects the basis.
    pub fn of(&self, basis: &Basis) -> Shading {
        self.with(basis, &(self.start)(basis))
    }

    /// The model with parameters proposed by a fit.
    ///
    /// # Errors
    /// [`ShadingError`] if the number of values is not that of the parameters, or the model rejects a value.
    pub fn with(&self, basis: &Basis, values: &[f64]) -> Shading {
        (self.build)(basis, values)
    }

    /// Parameters other than the albedo of the base, which is the first of all.
    pub fn shape(&self) -> &'static [Parameter] {
        &self.parameters[1..]
    }

    /// The parts of the model for values of [`Self::shape`].
    ///
    /// # Errors
    /// As [`Self::with`].
    pub fn shaped(&self, basis: &Basis, shape: &[f64]) -> Shading {
        let values: Vec<f64> = std::iter::once(1.0).chain(shape.iter().copied()).collect();
        self.with(basis, &values)
    }

    /// Error of `build` for a wrong number of values.
    pub fn wrong_count(&self, values: &[f64]) -> ShadingError {
        ShadingError::Parameters {
            model: self.id,
            expected: self.parameters.iter().map(|parameter| parameter.name).collect(),
            found: values.len(),
        }
    }
}
