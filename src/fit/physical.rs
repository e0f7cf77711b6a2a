use super::emulator::Emulator;
use super::forward::ForwardModel;
use super::{
    Differences, FitError, FitReadings, FittedParameter, FreeDye, FreeParameter, Indistinct, Residuals, Scale,
    Settings, Solution, minimise,
};
use ndarray::{Array1, Array2};

/// A physical model and the readings that it is fitted to. Its parameters are, in this order: the coordinates of the
/// traced parameters, those of the gloss, and the free absorption.
pub struct PhysicalModel<'a> {
    pub forward: &'a dyn ForwardModel,
    /// At the geometries of `forward`.
    pub readings: &'a FitReadings,
    /// Absorption that is fitted; none where the study's own is kept.
    pub dye: Option<FreeDye>,
}

/// The model near a point, as a function of its parameters, against some of the readings.
pub struct PhysicalProblem<'a> {
    pub model: &'a PhysicalModel<'a>,
    pub emulator: &'a Emulator,
    /// Indices of the geometries that count.
    pub kept: &'a [usize],
}

/// Parameters of a physical model, apart.
pub struct PhysicalParameters<'p> {
    pub point: &'p [f64],
    pub gloss: &'p [f64],
    pub dye: &'p [f64],
}

impl PhysicalModel<'_> {
    /// Splits the parameters by what they are of.
    pub fn split<'p>(&self, parameters: &'p [f64]) -> PhysicalParameters<'p> {
        let (point, others) = parameters.split_at(self.forward.traced().len());
        let (gloss, dye) = others.split_at(self.forward.gloss_parameters().len());
        PhysicalParameters { point, gloss, dye }
    }

    /// The parameters, the traced ones as coordinates between `low` and `high`.
    pub fn parameters(&self, low: &[f64], high: &[f64]) -> Vec<FreeParameter> {
        let traced = self.forward.traced().iter().zip(low.iter().zip(high));
        let coordinates = traced.map(|(parameter, (low, high))| FreeParameter {
            name: parameter.name.clone(),
            unit: String::new(),
            bounds: [*low, *high],
            scale: Scale::Linear,
            prior: None,
        });
        coordinates
            .chain(self.forward.gloss_parameters().iter().cloned())
            .chain(self.dye.iter().flat_map(FreeDye::parameters))
            .collect()
    }

    /// Absorption that the free dye adds at each wavelength, 1/mm.
    pub fn added_mu_a_per_mm(&self, dye: &[f64]) -> Vec<f64> {
        self.absorption_at(self.forward.wavelengths_nm(), dye)
    }

    /// The same at the nodes where scattering is traced.
    pub fn mu_a_at_nodes(&self, dye: &[f64]) -> Vec<f64> {
        self.absorption_at(self.forward.nodes_nm(), dye)
    }

    fn absorption_at(&self, nm: &[f64], dye: &[f64]) -> Vec<f64> {
        let at = |nm: &f64| self.dye.as_ref().map_or(0.0, |of| of.at(*nm, dye));
        nm.iter().map(at).collect()
    }

    /// β at `[geometry][channel]` of an emulator's light and of the gloss.
    ///
    /// # Errors
    /// [`FitError`] for values that the gloss cannot have.
    pub fn beta(&self, emulator: &Emulator, parameters: &[f64]) -> Result<Array2<f64>, FitError> {
        let PhysicalParameters { point, gloss, dye } = self.split(parameters);
        let diffuse = emulator.beta(point, &self.added_mu_a_per_mm(dye));
        let mut beta = diffuse.dot(&self.forward.to_channels().t());
        let gloss = Array1::from(self.forward.gloss(gloss)?);
        for (c, white) in self.readings.white.iter().enumerate() {
            beta.column_mut(c).scaled_add(*white, &gloss);
        }
        Ok(beta)
    }

    /// The fit on an emulator, with the traced parameters between `low` and `high`.
    ///
    /// # Errors
    /// Those of [`minimise`].
    pub fn fit(
        &self,
        emulator: &Emulator,
        kept: &[usize],
        [low, high]: [&[f64]; 2],
        start: Option<Vec<f64>>,
        starts: usize,
        seed: u64,
    ) -> Result<Solution, FitError> {
        let problem = PhysicalProblem {
            model: self,
            emulator,
            kept,
        };
        // A coordinate without room to move is kept fixed.
        let parameters = self.parameters(low, high);
        let free: Vec<usize> = (0..parameters.len())
            .filter(|&p| parameters[p].bounds[0] < parameters[p].bounds[1])
            .collect();
        let all = |values: &[f64]| -> Vec<f64> {
            let mut all: Vec<f64> = parameters.iter().map(|parameter| parameter.bounds[0]).collect();
            free.iter().zip(values).for_each(|(&place, value)| all[place] = *value);
            all
        };
        let of_free = |values: &[f64]| -> Vec<f64> { free.iter().map(|&place| values[place]).collect() };
        let varied: Vec<FreeParameter> = free.iter().map(|&place| parameters[place].clone()).collect();
        let start = start.map(|start| {
            let clamped: Vec<f64> = (start.iter().zip(&parameters))
                .map(|(value, parameter)| value.clamp(parameter.bounds[0], parameter.bounds[1]))
                .collect();
            of_free(&clamped)
        });
        let settings = Settings {
            start,
            starts,
            seed,
            tolerance: 1e-6,
            most_evaluations: 60 * (varied.len() + 2),
            differences: Differences {
                step: 1e-4,
                central: false,
            },
            watch: None,
        };
        let residuals = |values: &[f64]| problem.residuals(&all(values));
        let mut solution = minimise(&varied, &residuals, &settings)?;
        solution.parameters = all(&solution.parameters);
        Ok(solution)
    }
}

impl PhysicalProblem<'_> {
    /// (model − measured) / uncertainty of the readings that count.
    ///
    /// # Errors
    /// [`FitError`] for values that the gloss cannot have.
    pub fn misfits(&self, parameters: &[f64]) -> Result<Vec<f64>, FitError> {
        let beta = self.model.beta(self.emulator, parameters)?;
        Ok(self.model.readings.residuals_at(&beta, self.kept))
    }
}

impl Residuals for PhysicalProblem<'_> {
    /// Misfits, then penalties of the free absorption's roughness, then priors of the traced parameters.
    fn residuals(&self, parameters: &[f64]) -> Result<Vec<f64>, FitError> {
        let mut residuals = self.misfits(parameters)?;
        let PhysicalParameters { point, dye, .. } = self.model.split(parameters);
        residuals.extend(self.model.dye.iter().flat_map(|of| of.penalties(dye)));
        let values = self.emulator.values(point);
        let priors = self.model.forward.traced().iter().zip(&values);
        residuals.extend(priors.filter_map(|(parameter, value)| parameter.prior_residual(*value)));
        Ok(residuals)
    }
}

/// What a fit says of its parameters.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct ParameterReport {
    pub parameters: Vec<FittedParameter>,
    /// Correlations of the parameters, in their order.
    pub correlation: Vec<Vec<f64>>,
    /// Parameters that the readings cannot tell apart.
    pub indistinct: Vec<Indistinct>,
    /// Factor of the readings' standard errors where the misfit exceeds the uncertainty: the square root of the reduced
    /// χ², at least 1 (Birge ratio).
    pub scale: f64,
}

impl PhysicalModel<'_> {
    /// Values, errors and correlations of a solution. `by_batch` are emulators of single batches, whose scatter is the
    /// Monte Carlo noise.
    ///
    /// # Errors
    /// Those of the model.
    pub fn report(
        &self,
        emulator: &Emulator,
        by_batch: &[Emulator],
        kept: &[usize],
        solution: &Solution,
    ) -> Result<ParameterReport, FitError> {
        let low = vec![0.0; self.forward.traced().len()];
        let high = vec![1.0; low.len()];
        let parameters = self.parameters(&low, &high);
        if parameters.is_empty() {
            return Ok(ParameterReport {
                parameters: Vec::new(),
                correlation: Vec::new(),
                indistinct: Vec::new(),
                scale: 1.0,
            });
        }
        let problem = PhysicalProblem {
            model: self,
            emulator,
            kept,
        };
        let differences = Differences {
            step: 1e-4,
            central: true,
        };
        let assessment = super::assess(&parameters, &problem, &solution.parameters, differences)?;
        let misfit = problem.misfits(&solution.parameters)?;
        let freedom = misfit.len() as f64 - parameters.len() as f64;
        let chi2: f64 = misfit.iter().map(|x| x * x).sum();
        let scale = if freedom > 0.0 {
            (chi2 / freedom).sqrt().max(1.0)
        } else {
            1.0
        };
        let noise = self.monte_carlo(by_batch, kept, &solution.parameters, &assessment)?;
        let point = self.split(&solution.parameters).point;
        let values = emulator.values(point);
        let fitted = (0..parameters.len()).map(|p| {
            let readings = assessment.se[p].map(|se| se * scale);
            let monte_carlo = readings.map(|_| noise[p]);
            let at_bound = assessment.at_bound[p];
            let Some(traced) = self.forward.traced().get(p) else {
                return FittedParameter::new(&parameters[p], solution.parameters[p], readings, monte_carlo, at_bound);
            };
            // From coordinates to values, along the coordinate.
            let step = 1e-4;
            let mut moved = point.to_vec();
            moved[p] += step;
            let slope = ((emulator.values(&moved)[p] - values[p]) / step).abs();
            let [readings, monte_carlo] = [readings, monte_carlo].map(|se| se.map(|se| se * slope));
            FittedParameter::new(traced, values[p], readings, monte_carlo, at_bound)
        });
        Ok(ParameterReport {
            parameters: fitted.collect(),
            correlation: assessment.correlation.outer_iter().map(|row| row.to_vec()).collect(),
            indistinct: assessment.indistinct,
            scale,
        })
    }

    /// Standard error of each parameter from the noise of the traced light: the solution moves with the batches, to
    /// first order.
    fn monte_carlo(
        &self,
        by_batch: &[Emulator],
        kept: &[usize],
        parameters: &[f64],
        assessment: &super::Assessment,
    ) -> Result<Vec<f64>, FitError> {
        let readings: Vec<Array1<f64>> = (by_batch.iter())
            .map(|emulator| {
                let beta = self.beta(emulator, parameters)?;
                Ok(Array1::from(self.readings.residuals_at(&beta, kept)))
            })
            .collect::<Result<_, FitError>>()?;
        let count = readings.len() as f64;
        let Some(first) = readings.first().filter(|_| count > 1.0) else {
            return Ok(vec![0.0; parameters.len()]);
        };
        let mut mean: Array1<f64> = Array1::zeros(first.len());
        readings.iter().for_each(|batch| mean.scaled_add(1.0 / count, batch));
        let jacobian = assessment.jacobian.slice(ndarray::s![..mean.len(), ..]);
        let mut squares = vec![0.0; parameters.len()];
        for batch in &readings {
            let shift = assessment.covariance.dot(&jacobian.t().dot(&(batch - &mean)));
            squares
                .iter_mut()
                .zip(&shift)
                .for_each(|(sum, shift)| *sum += shift * shift);
        }
        Ok(squares
            .iter()
            .map(|sum| (sum / (count * (count - 1.0))).sqrt())
            .collect())
    }
}
