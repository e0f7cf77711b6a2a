use super::emulator::{Batches, Emulator};
use super::forward::ForwardRun;
use super::physical::{ParameterReport, PhysicalModel};
use super::readings::rms;
use super::{FitError, Solution};
use crate::transport::{Purpose, Stream};
use ndarray::Array2;
use rand::RngExt;
use rand::seq::SliceRandom;
use std::ops::ControlFlow;

/// How a physical model is searched.
pub struct SearchSettings<'a> {
    pub seed: u64,
    /// Told after every traced point; `Break` ends the search with the best so far.
    pub watch: &'a dyn Fn(&SearchProgress) -> ControlFlow<()>,
}

/// State of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchProgress {
    /// 0 while the whole range is surveyed, then the round of the trust region.
    pub round: usize,
    /// Points traced so far.
    pub runs: usize,
    /// Lowest rms misfit over uncertainty so far.
    pub rms: f64,
}

/// All points that were traced for a model, in their order. Fits to parts of the readings share them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ForwardPool {
    pub runs: Vec<ForwardRun>,
}

/// The lowest misfit that a search found.
#[derive(Clone, Debug)]
pub struct PhysicalFit {
    pub solution: Solution,
    pub report: ParameterReport,
    /// Values of the traced parameters.
    pub values: Vec<f64>,
    /// β at `[geometry][channel]`, of all geometries, and its Monte Carlo standard error.
    pub beta: Array2<f64>,
    pub beta_se: Array2<f64>,
    /// β of each Monte Carlo batch alone.
    pub batches: Vec<Array2<f64>>,
    /// rms misfit over uncertainty of the readings that were fitted.
    pub rms: f64,
    /// rms of the Monte Carlo standard error over the uncertainty of these readings.
    pub noise: f64,
    /// Whether the search ended by itself, with the best point inside the region of its runs.
    pub converged: bool,
    pub rounds: usize,
}

/// Points of the survey of the whole range for each traced parameter, besides three, and share of the particles of
/// each.
const SURVEY: usize = 6;
const SURVEY_SHARE: f64 = 0.2;
/// The same of runs in a trust region, and in the last one, whose noise is that of the result.
const REGION_SHARE: f64 = 0.5;
const LAST_SHARE: f64 = 2.0;
/// Half width of the first trust region, in coordinates, factor by which it shrinks, and half width at which the search
/// ends.
const FIRST_REGION: f64 = 0.22;
const SHRINK: f64 = 0.5;
const LAST_REGION: f64 = 0.07;
const ROUNDS: usize = 10;
/// Runs in a region over the number of coefficients of its emulator.
const RUNS_A_COEFFICIENT: f64 = 2.0;
/// Starts of a fit to the runs of the survey, and of one on an emulator.
const STARTS: usize = 4;
/// χ² of a traced point over the lowest so far up to which the search goes on from it: one run has noise.
const AS_GOOD: f64 = 1.2;
/// Share of the absorption found so far that paths are traced with: less leaves long paths for lower absorption, more
/// makes dark yarns faster.
const TRACED_ABSORPTION: f64 = 0.3;

impl PhysicalModel<'_> {
    /// Searches the parameters that bring the model nearest to the readings at `kept` geometries: a survey of the whole
    /// range, then a trust region with an emulator of the traced light (response surface), which moves to the best
    /// point and shrinks about it.
    ///
    /// # Errors
    /// [`FitError`] for more parameters than readings and for errors of the model.
    pub fn search(
        &self,
        pool: &mut ForwardPool,
        kept: &[usize],
        settings: &SearchSettings,
    ) -> Result<PhysicalFit, FitError> {
        let coordinates = self.forward.traced().len();
        let mut state = Search {
            model: self,
            pool,
            kept,
            settings,
            best: None,
            stopped: false,
            round: 0,
        };
        state.survey()?;
        let mut region = FIRST_REGION;
        let mut converged = coordinates == 0;
        let mut result = None;
        let most = if coordinates == 0 { 1 } else { ROUNDS };
        for round in 1..=most {
            state.round = round;
            let Some(best) = state.best.clone() else {
                return Err(FitError::NoRuns);
            };
            let centre = self.split(&best.parameters).point.to_vec();
            let (low, high) = around(&centre, region);
            let share = if region <= LAST_REGION {
                LAST_SHARE
            } else {
                REGION_SHARE
            };
            state.fill(&low, &high, share)?;
            let (mut low, mut high) = (low, high);
            let mut members = state.members(&low, &high, share);
            if members.is_empty() {
                // Stopped before the region had runs: the best run alone, whose coordinates stay.
                members.extend(state.pool.runs.iter().position(|run| run.point == centre));
                (low, high) = (centre.clone(), centre.clone());
            }
            let runs: Vec<&ForwardRun> = members.iter().map(|&k| &state.pool.runs[k]).collect();
            let emulator = Emulator::new(self.forward, &runs, &centre, Batches::All)?;
            let start = Some(best.parameters.clone());
            let solution = self.fit(&emulator, kept, [&low, &high], start, STARTS, settings.seed)?;
            let point = self.split(&solution.parameters).point.to_vec();
            let edges = low.iter().zip(&high).map(|(low, high)| 0.05 * (high - low));
            let inside = (point.iter().zip(low.iter().zip(&high)).zip(edges))
                .all(|((x, (low, high)), edge)| (x - low > edge || *low == 0.0) && (high - x > edge || *high == 1.0));
            let batches = runs[0].tables.amounts.shape()[0];
            let by_batch = (0..batches)
                .map(|batch| Emulator::new(self.forward, &runs, &centre, Batches::One(batch)))
                .collect::<Result<Vec<_>, _>>()?;
            let ended = state.stopped || (inside && region <= LAST_REGION);
            converged |= inside && region <= LAST_REGION;
            result = Some(self.conclude(&emulator, &by_batch, kept, solution, converged, round)?);
            if ended {
                break;
            }
            // A region in which the emulator misleads is too large.
            let led = coordinates == 0 || state.follow(&point)?;
            if inside || !led {
                region = (region * SHRINK).max(LAST_REGION);
            }
        }
        result.ok_or(FitError::NoRuns)
    }

    fn conclude(
        &self,
        emulator: &Emulator,
        by_batch: &[Emulator],
        kept: &[usize],
        solution: Solution,
        converged: bool,
        rounds: usize,
    ) -> Result<PhysicalFit, FitError> {
        let beta = self.beta(emulator, &solution.parameters)?;
        let of_batches: Vec<Array2<f64>> = (by_batch.iter())
            .map(|emulator| self.beta(emulator, &solution.parameters))
            .collect::<Result<_, _>>()?;
        let count = of_batches.len() as f64;
        let beta_se = Array2::from_shape_fn(beta.raw_dim(), |at| {
            let values = of_batches.iter().map(|batch| batch[at]);
            let mean = values.clone().sum::<f64>() / count;
            let squares: f64 = values.map(|value| (value - mean).powi(2)).sum();
            if count > 1.0 {
                (squares / (count * (count - 1.0))).sqrt()
            } else {
                f64::NAN
            }
        });
        let noise: Vec<f64> = (kept.iter())
            .flat_map(|&g| (0..self.readings.channels.len()).map(move |c| [g, c]))
            .map(|at| beta_se[at] / self.readings.se[at])
            .collect();
        Ok(PhysicalFit {
            report: self.report(emulator, by_batch, kept, &solution)?,
            values: emulator.values(self.split(&solution.parameters).point),
            rms: rms(self.readings.residuals_at(&beta, kept)),
            noise: rms(noise),
            beta,
            beta_se,
            batches: of_batches,
            solution,
            converged,
            rounds,
        })
    }
}

struct Search<'s, 'a> {
    model: &'s PhysicalModel<'a>,
    pool: &'s mut ForwardPool,
    kept: &'s [usize],
    settings: &'s SearchSettings<'s>,
    best: Option<Solution>,
    stopped: bool,
    round: usize,
}

impl Search<'_, '_> {
    /// Fits what needs no tracing to each point of a survey of the whole range.
    fn survey(&mut self) -> Result<(), FitError> {
        let coordinates = self.model.forward.traced().len();
        for k in 0..self.pool.runs.len() {
            self.judge(k)?;
        }
        if !self.pool.runs.is_empty() {
            return Ok(());
        }
        let (low, high) = (vec![0.0; coordinates], vec![1.0; coordinates]);
        let (points, share) = match coordinates {
            0 => (vec![Vec::new()], 1.0),
            _ => (
                self.latin_hypercube(&low, &high, SURVEY * coordinates + 3),
                SURVEY_SHARE,
            ),
        };
        for point in points {
            if self.stopped {
                break;
            }
            self.trace(&point, share)?;
        }
        Ok(())
    }

    /// Traces points until the region has runs of a share of the particles for its emulator.
    fn fill(&mut self, low: &[f64], high: &[f64], share: f64) -> Result<(), FitError> {
        let coordinates = low.len();
        if coordinates == 0 {
            return Ok(());
        }
        let wanted = (RUNS_A_COEFFICIENT * Emulator::coefficients(coordinates) as f64).ceil() as usize;
        let missing = wanted.saturating_sub(self.members(low, high, share).len());
        for point in self.latin_hypercube(low, high, missing) {
            if self.stopped {
                break;
            }
            self.trace(&point, share)?;
        }
        Ok(())
    }

    /// Traces the point that an emulator found best, and takes it as the best where it is not much worse than that.
    /// Returns whether it did.
    fn follow(&mut self, point: &[f64]) -> Result<bool, FitError> {
        let before = self.best.clone();
        self.trace(point, REGION_SHARE)?;
        let found = self.fit_run(self.pool.runs.len() - 1)?;
        let good = before.is_none_or(|before| found.chi2 < AS_GOOD * before.chi2);
        if good {
            self.best = Some(found);
        }
        Ok(good)
    }

    /// Runs in a region with at least a share of the particles.
    fn members(&self, low: &[f64], high: &[f64], share: f64) -> Vec<usize> {
        let inside = |run: &ForwardRun| {
            let bounds = low.iter().zip(high);
            run.share >= share
                && run
                    .point
                    .iter()
                    .zip(bounds)
                    .all(|(x, (low, high))| (*low..=*high).contains(x))
        };
        (0..self.pool.runs.len())
            .filter(|&k| inside(&self.pool.runs[k]))
            .collect()
    }

    fn trace(&mut self, point: &[f64], share: f64) -> Result<(), FitError> {
        let known = self.best.as_ref().map(|best| {
            let dye = self.model.split(&best.parameters).dye;
            self.model.mu_a_at_nodes(dye)
        });
        let added = match known {
            Some(found) => found.iter().map(|mu_a| TRACED_ABSORPTION * mu_a).collect(),
            None => vec![0.0; self.model.forward.nodes_nm().len()],
        };
        let run = self.model.forward.trace(point, &added, share)?;
        self.pool.runs.push(run);
        self.judge(self.pool.runs.len() - 1)?;
        let readings = self.kept.len() * self.model.readings.channels.len();
        let of_readings = |best: &Solution| rms(best.residuals.iter().take(readings).copied());
        let rms = self.best.as_ref().map_or(f64::INFINITY, of_readings);
        let progress = SearchProgress {
            round: self.round,
            runs: self.pool.runs.len(),
            rms,
        };
        self.stopped |= (self.settings.watch)(&progress).is_break();
        Ok(())
    }

    /// Takes a run as the best if gloss and absorption bring it nearest to the readings.
    fn judge(&mut self, k: usize) -> Result<(), FitError> {
        let solution = self.fit_run(k)?;
        if self.best.as_ref().is_none_or(|best| solution.chi2 < best.chi2) {
            self.best = Some(solution);
        }
        Ok(())
    }

    /// Fits gloss and absorption to one run.
    fn fit_run(&self, k: usize) -> Result<Solution, FitError> {
        let run = &self.pool.runs[k];
        let point = run.point.clone();
        let emulator = Emulator::new(self.model.forward, &[run], &point, Batches::All)?;
        let start = self.best.as_ref().map(|best| {
            let mut start = best.parameters.clone();
            start[..point.len()].copy_from_slice(&point);
            start
        });
        // The survey must not be led by the first minimum that it meets.
        let starts = if self.round == 0 { STARTS } else { 1 };
        self.model.fit(
            &emulator,
            self.kept,
            [&point, &point],
            start,
            starts,
            self.settings.seed,
        )
    }

    fn latin_hypercube(&self, low: &[f64], high: &[f64], count: usize) -> Vec<Vec<f64>> {
        let mut points = vec![vec![0.0; low.len()]; count];
        for k in 0..low.len() {
            let mut stream = Stream::open(self.settings.seed, Purpose::Fit, k, self.pool.runs.len(), 1);
            let mut cells: Vec<usize> = (0..count).collect();
            cells.shuffle(&mut stream);
            for (point, cell) in points.iter_mut().zip(cells) {
                let share = (cell as f64 + stream.random::<f64>()) / count as f64;
                point[k] = low[k] + share * (high[k] - low[k]);
            }
        }
        points
    }
}

/// The region of a half width about a centre, within the whole range: shifted inwards where it would reach beyond.
fn around(centre: &[f64], half: f64) -> (Vec<f64>, Vec<f64>) {
    let low: Vec<f64> = (centre.iter())
        .map(|c| (c - half).min(1.0 - 2.0 * half).max(0.0))
        .collect();
    let high = low.iter().map(|low| (low + 2.0 * half).min(1.0)).collect();
    (low, high)
}
