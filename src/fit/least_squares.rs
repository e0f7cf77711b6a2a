use super::assessment::{Assessment, assess};
use super::error::FitError;
use super::parameter::FreeParameter;
use super::residuals::{Differences, Residuals};
use crate::transport::{Purpose, Stream};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt, TerminationReason};
use nalgebra::{DMatrix, DVector, Dyn, storage::Owned};
use rand::RngExt;
use rand::seq::SliceRandom;
use std::cell::RefCell;
use std::ops::ControlFlow;

/// Callback of a search; `Break` ends it.
pub type Watch<'a> = dyn Fn(&Progress) -> ControlFlow<()> + 'a;

/// How a search goes.
pub struct Settings<'a> {
    /// First start; the middle of the bounds where there is none.
    pub start: Option<Vec<f64>>,
    /// Number of starts, at least 1. Those after the first are a Latin hypercube over the bounds.
    pub starts: usize,
    pub seed: u64,
    /// Relative change of χ² or of the parameters at which a search has converged.
    pub tolerance: f64,
    /// Evaluations of a start, those for derivatives included, after which it ends without having converged.
    pub most_evaluations: usize,
    pub differences: Differences,
    /// Told of every evaluation; `Break` ends the search with the best so far.
    pub watch: Option<&'a Watch<'a>>,
}

impl Default for Settings<'_> {
    /// For smooth functions.
    fn default() -> Self {
        Self {
            start: None,
            starts: 1,
            seed: 1,
            tolerance: 1e-10,
            most_evaluations: 2000,
            differences: Differences {
                step: 1e-5,
                central: true,
            },
            watch: None,
        }
    }
}

/// State of a search after an evaluation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// From 0, of `starts`.
    pub start: usize,
    pub starts: usize,
    /// Of all starts.
    pub evaluations: usize,
    /// Of this evaluation, priors included.
    pub chi2: f64,
    /// Lowest of all starts.
    pub best_chi2: f64,
}

/// Where one start led.
#[derive(Clone, Debug, PartialEq)]
pub struct StartOutcome {
    pub start: Vec<f64>,
    pub parameters: Vec<f64>,
    pub chi2: f64,
    pub converged: bool,
}

/// The lowest misfit that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    pub parameters: Vec<f64>,
    /// Sum of the squared residuals, priors included.
    pub chi2: f64,
    /// Of the readings alone, without priors.
    pub residuals: Vec<f64>,
    /// Whether the best start's search ended by its tolerance.
    pub converged: bool,
    pub evaluations: usize,
    pub starts: Vec<StartOutcome>,
    pub assessment: Assessment,
}

impl Solution {
    /// Sum of the squared residuals of the readings over their number less that of the parameters.
    pub fn reduced_chi2(&self) -> f64 {
        let chi2: f64 = self.residuals.iter().map(|r| r * r).sum();
        chi2 / (self.residuals.len() as f64 - self.parameters.len() as f64)
    }
}

/// Lowest sum of squared residuals and priors between the bounds: the trust-region method of Levenberg and Marquardt as
/// in MINPACK (J. J. Moré, Lect. Notes Math. 630 (1978) 105), in coordinates without bounds, from several starts. The
/// same settings give the same bits.
///
/// # Errors
/// [`FitError`] for contradictory bounds, a start outside them, more free parameters than readings, a model without
/// finite values, and errors of the model.
pub fn minimise(
    parameters: &[FreeParameter],
    model: &dyn Residuals,
    settings: &Settings,
) -> Result<Solution, FitError> {
    parameters.iter().try_for_each(FreeParameter::check)?;
    let starts = starts(parameters, settings)?;
    let readings = model.residuals(&starts[0])?.len();
    if parameters.len() > readings {
        let names: Vec<&str> = parameters.iter().map(|parameter| parameter.name.as_str()).collect();
        return Err(FitError::TooFewReadings {
            parameters: parameters.len(),
            names: names.join(", "),
            readings,
        });
    }
    let search = Search {
        parameters,
        model,
        settings,
        readings,
        starts: starts.len(),
        state: RefCell::default(),
    };
    let mut outcomes = Vec::new();
    for (place, start) in starts.iter().enumerate() {
        if place > 0 && search.state.borrow().stopped {
            break;
        }
        outcomes.extend(search.from(place, start)?);
    }
    let best = outcomes.iter().min_by(|a, b| a.chi2.total_cmp(&b.chi2));
    let Some(best) = best.cloned() else {
        let last = starts.last().into_iter().flatten();
        let at = parameters
            .iter()
            .zip(last)
            .map(|(parameter, value)| format!("{} {value}", parameter.name));
        return Err(FitError::NotFinite {
            at: at.collect::<Vec<_>>().join(", "),
        });
    };
    let residuals = model.residuals(&best.parameters)?;
    let assessment = assess(parameters, model, &best.parameters, settings.differences)?;
    Ok(Solution {
        parameters: best.parameters,
        chi2: best.chi2,
        residuals,
        converged: best.converged,
        evaluations: search.state.borrow().evaluations,
        starts: outcomes,
        assessment,
    })
}

/// The given start or the middle, then a Latin hypercube on the parameters' scales. A parameter without bounds on both
/// sides varies by a factor of 1/2 to 3/2 about its first start.
fn starts(parameters: &[FreeParameter], settings: &Settings) -> Result<Vec<Vec<f64>>, FitError> {
    let bounded = |parameter: &FreeParameter| parameter.bounds.iter().all(|bound| bound.is_finite());
    let first = match &settings.start {
        Some(start) if start.len() == parameters.len() => start.clone(),
        None if parameters.iter().all(bounded) => parameters
            .iter()
            .map(|parameter| {
                let [low, high] = parameter.scaled_bounds();
                parameter.value(0.5 * (low + high))
            })
            .collect(),
        start => {
            return Err(FitError::Starts {
                expected: parameters.len(),
                found: start.as_ref().map_or(0, Vec::len),
            });
        }
    };
    for (parameter, &found) in parameters.iter().zip(&first) {
        let [low, high] = parameter.bounds;
        if !(low..=high).contains(&found) {
            return Err(FitError::Start {
                name: parameter.name.clone(),
                low,
                high,
                unit: parameter.unit_after_number(),
                found,
            });
        }
    }
    let others = settings.starts.saturating_sub(1);
    let mut all = vec![first.clone(); others + 1];
    for (place, parameter) in parameters.iter().enumerate() {
        let mut stream = Stream::open(settings.seed, Purpose::Fit, place, 0, 0);
        let mut cells: Vec<usize> = (0..others).collect();
        cells.shuffle(&mut stream);
        for (start, cell) in all[1..].iter_mut().zip(cells) {
            let share = (cell as f64 + stream.random::<f64>()) / others as f64;
            let [low, high] = parameter.scaled_bounds();
            start[place] = match bounded(parameter) {
                true => parameter.value(low + share * (high - low)),
                false => (first[place] * (0.5 + share)).clamp(parameter.bounds[0], parameter.bounds[1]),
            };
        }
    }
    Ok(all)
}

struct Search<'a> {
    parameters: &'a [FreeParameter],
    model: &'a dyn Residuals,
    settings: &'a Settings<'a>,
    readings: usize,
    starts: usize,
    state: RefCell<State>,
}

#[derive(Default)]
struct State {
    start: usize,
    evaluations: usize,
    evaluations_of_start: usize,
    /// Lowest χ² of this start and its parameters.
    best_of_start: Option<(f64, Vec<f64>)>,
    best_chi2: Option<f64>,
    stopped: bool,
    failure: Option<FitError>,
}

impl Search<'_> {
    /// `None` if no value was finite.
    fn from(&self, place: usize, start: &[f64]) -> Result<Option<StartOutcome>, FitError> {
        {
            let mut state = self.state.borrow_mut();
            state.start = place;
            state.evaluations_of_start = 0;
            state.best_of_start = None;
        }
        // A model without free parameters is evaluated once.
        let converged = if self.parameters.is_empty() {
            self.evaluate(start).is_some()
        } else {
            let coordinates = self.parameters.iter().zip(start).map(|(p, &value)| p.u_of(value));
            let problem = Problem {
                search: self,
                u: DVector::from_iterator(start.len(), coordinates),
            };
            // The count of evaluations is kept here, where those for derivatives are known.
            let method = LevenbergMarquardt::new()
                .with_tol(self.settings.tolerance)
                .with_patience(usize::MAX >> 32);
            let (_, report) = method.minimize(problem);
            report.termination.was_successful()
                || matches!(report.termination, TerminationReason::NoImprovementPossible(_))
        };
        if let Some(failure) = self.state.borrow_mut().failure.take() {
            return Err(failure);
        }
        let Some((mut chi2, mut parameters)) = self.state.borrow_mut().best_of_start.take() else {
            return Ok(None);
        };
        self.move_to_bounds(&mut chi2, &mut parameters);
        if let Some(failure) = self.state.borrow_mut().failure.take() {
            return Err(failure);
        }
        Ok(Some(StartOutcome {
            start: start.to_vec(),
            parameters,
            chi2,
            converged,
        }))
    }

    /// Near a bound the derivative by u vanishes, so that a minimum on the bound is approached but not reached: values
    /// close to a bound move onto it if χ² does not rise.
    fn move_to_bounds(&self, chi2: &mut f64, parameters: &mut Vec<f64>) {
        /// Share of the range.
        const CLOSE: f64 = 1e-2;
        for (place, parameter) in self.parameters.iter().enumerate() {
            let [low, high] = parameter.scaled_bounds();
            let range = if (high - low).is_finite() { high - low } else { 1.0 };
            let at = parameter.scaled(parameters[place]);
            for (bound, scaled) in parameter.bounds.into_iter().zip([low, high]) {
                let distance = (at - scaled).abs();
                if distance > 0.0 && distance < CLOSE * range {
                    let mut moved = parameters.clone();
                    moved[place] = bound;
                    if let Some(residuals) = self.evaluate(&moved) {
                        let moved_chi2 = residuals.norm_squared();
                        if moved_chi2 <= *chi2 {
                            (*chi2, *parameters) = (moved_chi2, moved);
                        }
                    }
                }
            }
        }
    }

    /// Residuals of readings and priors; `None` ends the search of this start.
    fn evaluate(&self, parameters: &[f64]) -> Option<DVector<f64>> {
        {
            let state = self.state.borrow();
            if state.failure.is_some() || state.stopped || state.evaluations_of_start >= self.settings.most_evaluations
            {
                return None;
            }
        }
        let evaluated = self.model.residuals(parameters);
        let mut state = self.state.borrow_mut();
        let mut residuals = match evaluated {
            Ok(residuals) if residuals.len() == self.readings => residuals,
            Ok(residuals) => {
                state.failure = Some(FitError::Length {
                    expected: self.readings,
                    found: residuals.len(),
                });
                return None;
            }
            Err(failure) => {
                state.failure = Some(failure);
                return None;
            }
        };
        let priors = self.parameters.iter().zip(parameters);
        residuals.extend(priors.filter_map(|(parameter, &value)| parameter.prior_residual(value)));
        let residuals = DVector::from_vec(residuals);
        let chi2 = residuals.norm_squared();
        state.evaluations += 1;
        state.evaluations_of_start += 1;
        if chi2.is_finite() {
            if state.best_of_start.as_ref().is_none_or(|(best, _)| chi2 < *best) {
                state.best_of_start = Some((chi2, parameters.to_vec()));
            }
            state.best_chi2 = Some(state.best_chi2.map_or(chi2, |best| best.min(chi2)));
        }
        if let Some(watch) = self.settings.watch {
            let progress = Progress {
                start: state.start,
                starts: self.starts,
                evaluations: state.evaluations,
                chi2,
                best_chi2: state.best_chi2.unwrap_or(f64::INFINITY),
            };
            // What watches may look at the search no further than this.
            state.stopped |= watch(&progress).is_break();
        }
        Some(residuals)
    }
}

/// A start's search in coordinates without bounds.
struct Problem<'a> {
    search: &'a Search<'a>,
    u: DVector<f64>,
}

impl Problem<'_> {
    fn values(&self, u: &DVector<f64>) -> Vec<f64> {
        let pairs = self.search.parameters.iter().zip(u.iter());
        pairs.map(|(parameter, &u)| parameter.value_at(u)).collect()
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, u: &DVector<f64>) {
        self.u.copy_from(u);
    }

    fn params(&self) -> DVector<f64> {
        self.u.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        self.search.evaluate(&self.values(&self.u))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let parameters = self.search.parameters;
        let values = self.values(&self.u);
        if let Some(given) = self.search.model.jacobian(&values) {
            let mut rows: Vec<Vec<f64>> = given.outer_iter().map(|row| row.to_vec()).collect();
            for (place, (parameter, &value)) in parameters.iter().zip(&values).enumerate() {
                if let Some(derivative) = parameter.prior_derivative(value) {
                    let mut row = vec![0.0; values.len()];
                    row[place] = derivative;
                    rows.push(row);
                }
            }
            let by_u: Vec<f64> = parameters
                .iter()
                .zip(self.u.iter())
                .map(|(p, &u)| p.value_by_u(u))
                .collect();
            return Some(DMatrix::from_fn(rows.len(), values.len(), |r, p| rows[r][p] * by_u[p]));
        }
        let Differences { step, central } = self.search.settings.differences;
        let here = if central { None } else { Some(self.residuals()?) };
        let mut columns = Vec::new();
        for (place, parameter) in parameters.iter().enumerate() {
            let step = parameter.step_at(self.u[place], step);
            let at = |step: f64| {
                let mut u = self.u.clone();
                u[place] += step;
                self.search.evaluate(&self.values(&u))
            };
            columns.push(match &here {
                Some(here) => (at(step)? - here) / step,
                None => (at(step)? - at(-step)?) / (2.0 * step),
            });
        }
        Some(DMatrix::from_columns(&columns))
    }
}
