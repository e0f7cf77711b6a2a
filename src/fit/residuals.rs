use super::error::FitError;
use ndarray::Array2;

/// Residuals of a model, (model − measured) / standard uncertainty, as a function of its free parameters. Any closure
/// of that form is one.
pub trait Residuals {
    /// # Errors
    /// [`FitError`] ends the fit. Parameters without a finite value are no error: NaN or ∞ are avoided by the search.
    fn residuals(&self, parameters: &[f64]) -> Result<Vec<f64>, FitError>;

    /// Their derivatives, `[residual][parameter]`; `None` if they are to be taken from differences.
    fn jacobian(&self, _parameters: &[f64]) -> Option<Array2<f64>> {
        None
    }
}

impl<F: Fn(&[f64]) -> Result<Vec<f64>, FitError>> Residuals for F {
    fn residuals(&self, parameters: &[f64]) -> Result<Vec<f64>, FitError> {
        self(parameters)
    }
}

/// How derivatives are taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Differences {
    /// Step relative to the range of the parameter on its scale. Smooth functions take 1e-5; a Monte Carlo model with
    /// common random numbers takes one over which its values change by more than their remaining noise.
    pub step: f64,
    /// Two evaluations a parameter in place of one, with an error of the second order in the step.
    pub central: bool,
}
