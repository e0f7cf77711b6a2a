use crate::sample::SampleError;
use crate::shading::ShadingError;
use crate::yarn::YarnError;

/// Why there is no fit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FitError {
    #[error("{sample}: expected readings to fit to, found {found}; {remedy}")]
    NoReadings {
        sample: String,
        found: &'static str,
        remedy: &'static str,
    },
    #[error("{sample}: expected reflection, which {model} describes, found transmission; take a sample of reflection")]
    Transmission { sample: String, model: &'static str },
    #[error(
        "expected at most as many free parameters as readings, found {parameters} free parameters ({names}) and \
         {readings} \
         readings; fix some of them, or add geometries"
    )]
    TooFewReadings {
        parameters: usize,
        names: String,
        readings: usize,
    },
    #[error(
        "bounds of {name}: expected a lower bound below the upper one, found [{low}, {high}]{unit}; exchange or widen \
         them"
    )]
    Bounds {
        name: String,
        low: f64,
        high: f64,
        unit: String,
    },
    #[error(
        "bounds of {name}: expected bounds above 0 on a logarithmic scale, found [{low}, {high}]{unit}; raise the \
         lower bound or take a linear scale"
    )]
    LogarithmicBounds {
        name: String,
        low: f64,
        high: f64,
        unit: String,
    },
    #[error(
        "prior of {name}: expected a finite mean and a standard deviation above 0, found mean {mean} and standard \
         deviation {sd}{unit}; on a logarithmic scale the mean is above 0 too"
    )]
    Prior {
        name: String,
        mean: f64,
        sd: f64,
        unit: String,
    },
    #[error("start of {name}: expected a value from {low} to {high}{unit}, found {found}; move it between the bounds")]
    Start {
        name: String,
        low: f64,
        high: f64,
        unit: String,
        found: f64,
    },
    #[error(
        "expected a start for each of {expected} free parameters, found {found}; without bounds on both sides a \
         parameter needs one"
    )]
    Starts { expected: usize, found: usize },
    #[error("the model has no finite value at any start; the last was {at}; narrow the bounds of the parameters")]
    NotFinite { at: String },
    #[error(
        "the model's number of values changed from {expected} to {found}; compare the same geometries in every call"
    )]
    Length { expected: usize, found: usize },
    #[error("expected a traced point of the model, found none; allow more time")]
    NoRuns,
    #[error(
        "incidence {theta_i_deg} and view {theta_v_deg} degrees: expected a geometry of the fit's readings, found another; \
         compare the model at those that it was traced at"
    )]
    NotTraced { theta_i_deg: f64, theta_v_deg: f64 },
    #[error(
        "--vary {text}: expected KEY=FROM:TO:COUNT, with :log behind it for equal ratios, KEY=FROM:TO of --design lhs and sobol, or \
         KEY=V1,V2,..., found {found}; write such as medium.kappa_peak=0.002:0.02:10:log"
    )]
    Axis { text: String, found: String },
    #[error("design of the sweep: expected {expected}, found {found}; change --design, --points or --vary")]
    Design { expected: &'static str, found: String },
    /// Of the model that is fitted, in its own words.
    #[error("{0}")]
    Model(String),
    #[error(transparent)]
    Sample(#[from] SampleError),
    #[error(transparent)]
    Shading(#[from] ShadingError),
    #[error(transparent)]
    Yarn(#[from] YarnError),
}
