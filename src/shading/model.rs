use super::{ShadingError, Specular};
use crate::geometry::Vec3;

/// A model of how a flat cloth reflects light about its normal, as renderers have it.
pub trait ShadingModel: Send + Sync {
    /// Brightness factor π L / E in red, green, blue and luminance towards `omega_out` for light from `omega_in`, unit vectors
    /// from the surface with the normal +z; 0 with either in the plane or below it. `white` holds the channels of the perfect
    /// diffuser, of which gloss takes its colour.
    fn eval(&self, omega_in: &Vec3, omega_out: &Vec3, white: &[f64; 4]) -> [f64; 4];
}

/// A number of a classical model that a fit may vary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    pub name: &'static str,
    /// Empty for a pure number.
    pub unit: &'static str,
    /// Where a fit searches.
    pub range: [f64; 2],
    pub meaning: &'static str,
}

/// What a classical model is made from: a sample and the gloss of the study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    /// The sample's brightness factors in red, green, blue and luminance with light and viewer on the normal, or nearest to it.
    /// Finite; below 0 where the sample's colour is outside the gamut, above 1 where it shines.
    pub normal: [f64; 4],
    pub specular: Specular,
}

/// A model that is made, or why it is not.
pub type Shading = Result<Box<dyn ShadingModel>, ShadingError>;

/// A row of the registry: what a classical model is called, what it depends on and how it is made.
#[derive(Debug)]
pub struct ClassicalModel {
    pub id: &'static str,
    /// As legends name it.
    pub label: &'static str,
    pub parameters: &'static [Parameter],
    /// Values of the parameters that a basis gives without a fit.
    pub start: fn(&Basis) -> Vec<f64>,
    /// The model with these values, as many as there are parameters.
    pub build: fn(&Basis, &[f64]) -> Shading,
}

impl ClassicalModel {
    /// The model as a sample and a study give it, without a fit.
    ///
    /// # Errors
    /// A basis that the model refuses.
    pub fn of(&self, basis: &Basis) -> Shading {
        self.with(basis, &(self.start)(basis))
    }

    /// The model with parameters that a fit proposes.
    ///
    /// # Errors
    /// Another number of values than parameters, or one that the model refuses.
    pub fn with(&self, basis: &Basis, values: &[f64]) -> Shading {
        (self.build)(basis, values)
    }

    /// What `build` says of other than as many values as there are parameters.
    pub fn wrong_count(&self, values: &[f64]) -> ShadingError {
        ShadingError::Parameters {
            model: self.id,
            expected: self.parameters.iter().map(|parameter| parameter.name).collect(),
            found: values.len(),
        }
    }
}
