use super::assessment::{Indistinct, assess};
use super::candidate::{Candidate, Fitted, FittedParameter};
use super::error::FitError;
use super::least_squares::{Settings, minimise};
use super::parameter::{FreeParameter, Scale};
use super::readings::{Channel, FitReadings};
use crate::rig::{Geometry, omega_in, omega_out};
use crate::shading::{Basis, ClassicalModel, Lobes, Parameter, Specular, classical_models};
use ndarray::Array2;

/// Starts of a rival's search. Its misfit has few minima, and one evaluation takes microseconds.
const STARTS: usize = 12;

/// A classical model that is fitted: an albedo of each channel, never negative, and the parameters of the shape, which
/// are the same in all channels. Gloss has the colour of the light.
pub struct Rival {
    model: &'static ClassicalModel,
    basis: Basis,
    seed: u64,
}

impl Rival {
    /// `specular` is the study's gloss, from which the search starts.
    pub fn new(model: &'static ClassicalModel, specular: Specular, seed: u64) -> Self {
        Self {
            model,
            basis: Basis {
                normal: [1.0; 4],
                specular,
            },
            seed,
        }
    }

    /// Every classical model.
    pub fn all(specular: Specular, seed: u64) -> Vec<Self> {
        let models = classical_models().iter();
        models.map(|model| Self::new(model, specular, seed)).collect()
    }

    fn lobes(&self, shape: &[f64], geometries: &[Geometry]) -> Result<Vec<Lobes>, FitError> {
        let shading = self.model.shaped(&self.basis, shape)?;
        // The models are the same for every azimuth of the plane of incidence.
        let of = |g: &Geometry| shading.lobes(&omega_in(g.theta_i_deg, 0.0), &omega_out(g.theta_v_deg, 0.0));
        Ok(geometries.iter().map(of).collect())
    }

    fn shape_parameters(&self) -> Vec<FreeParameter> {
        let free = |parameter: &Parameter| FreeParameter {
            name: parameter.name.into(),
            unit: parameter.unit.into(),
            bounds: parameter.range,
            scale: Scale::Linear,
            prior: None,
        };
        self.model.shape().iter().map(free).collect()
    }
}

/// β of albedos and lobes, `[geometry][channel]`.
fn brightness(lobes: &[Lobes], albedos: &[f64], white: &[f64]) -> Array2<f64> {
    Array2::from_shape_fn((lobes.len(), albedos.len()), |(g, c)| {
        albedos[c] * lobes[g].base + white[c] * lobes[g].gloss
    })
}

/// The albedos of least misfit, the exact minimum over albedos of 0 or more: a channel's misfit is a parabola in its
/// albedo.
fn albedos(lobes: &[Lobes], readings: &FitReadings) -> Vec<f64> {
    let of = |c: usize| {
        let (mut product, mut square) = (0.0, 0.0);
        for (g, Lobes { base, gloss }) in lobes.iter().enumerate() {
            let weight = base / readings.se[(g, c)].powi(2);
            product += weight * (readings.beta[(g, c)] - readings.white[c] * gloss);
            square += weight * base;
        }
        if square > 0.0 { (product / square).max(0.0) } else { 0.0 }
    };
    (0..readings.channels.len()).map(of).collect()
}

impl Candidate for Rival {
    fn id(&self) -> &str {
        self.model.id
    }

    fn label(&self) -> &str {
        self.model.label
    }

    fn fit(&self, readings: &FitReadings) -> Result<Box<dyn Fitted>, FitError> {
        if readings.transmission {
            return Err(FitError::Transmission {
                sample: readings.sample.clone(),
                model: self.model.label,
            });
        }
        let shape = self.shape_parameters();
        let channels = readings.channels.len();
        let albedo = |channel: &Channel| FreeParameter {
            name: format!("albedo {}", channel.name()),
            unit: String::new(),
            bounds: [0.0, f64::INFINITY],
            scale: Scale::Linear,
            prior: None,
        };
        let all: Vec<FreeParameter> = readings
            .channels
            .iter()
            .map(albedo)
            .chain(shape.iter().cloned())
            .collect();
        if all.len() > readings.len() {
            let names: Vec<&str> = all.iter().map(|parameter| parameter.name.as_str()).collect();
            return Err(FitError::TooFewReadings {
                parameters: all.len(),
                names: names.join(", "),
                readings: readings.len(),
            });
        }
        let residuals = |lobes: &[Lobes], albedos: &[f64]| -> Vec<f64> {
            let model = brightness(lobes, albedos, &readings.white);
            readings.residuals(&model).into_iter().collect()
        };
        // The albedos are eliminated (variable projection): the search is over the shape alone.
        let projected = |shape: &[f64]| -> Result<Vec<f64>, FitError> {
            let lobes = self.lobes(shape, &readings.geometries)?;
            Ok(residuals(&lobes, &albedos(&lobes, readings)))
        };
        let start = (self.model.start)(&self.basis)[1..].to_vec();
        let bounded = start
            .iter()
            .zip(&shape)
            .map(|(value, p)| value.clamp(p.bounds[0], p.bounds[1]));
        let settings = Settings {
            start: Some(bounded.collect()),
            starts: STARTS,
            seed: self.seed,
            ..Settings::default()
        };
        let solution = minimise(&shape, &projected, &settings)?;
        let lobes = self.lobes(&solution.parameters, &readings.geometries)?;
        let values = [albedos(&lobes, readings), solution.parameters].concat();
        let full = |values: &[f64]| -> Result<Vec<f64>, FitError> {
            let lobes = self.lobes(&values[channels..], &readings.geometries)?;
            Ok(residuals(&lobes, &values[..channels]))
        };
        let assessment = assess(&all, &full, &values, settings.differences)?;
        Ok(Box::new(FittedRival {
            rival: Self::new(self.model, self.basis.specular, self.seed),
            parameters: FittedParameter::all(&all, &values, &assessment),
            white: readings.white.clone(),
            indistinct: assessment.indistinct,
            converged: solution.converged,
            values,
        }))
    }
}

struct FittedRival {
    rival: Rival,
    /// Albedos, then the shape.
    values: Vec<f64>,
    white: Vec<f64>,
    parameters: Vec<FittedParameter>,
    indistinct: Vec<Indistinct>,
    converged: bool,
}

impl Fitted for FittedRival {
    fn parameters(&self) -> &[FittedParameter] {
        &self.parameters
    }

    fn predict(&self, geometries: &[Geometry]) -> Result<Array2<f64>, FitError> {
        let (albedos, shape) = self.values.split_at(self.white.len());
        Ok(brightness(&self.rival.lobes(shape, geometries)?, albedos, &self.white))
    }

    fn indistinct(&self) -> &[Indistinct] {
        &self.indistinct
    }

    fn converged(&self) -> bool {
        self.converged
    }
}
