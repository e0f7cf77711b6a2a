use super::physical::PhysicalModel;
use super::search::{ForwardPool, PhysicalFit, SearchProgress, SearchSettings};
use super::{Candidate, FitError, FitReadings, Fitted, FittedParameter, Indistinct};
use crate::rig::Geometry;
use ndarray::{Array2, Axis};
use std::ops::ControlFlow;
use std::sync::Mutex;

/// A physical model as a candidate beside others. Its fits to parts of the readings share what was traced.
pub struct PhysicalCandidate<'a> {
    pub id: String,
    pub label: String,
    pub model: PhysicalModel<'a>,
    pub seed: u64,
    pub watch: &'a (dyn Fn(&SearchProgress) -> ControlFlow<()> + Sync),
    pub pool: Mutex<ForwardPool>,
}

impl PhysicalCandidate<'_> {
    /// The fit to some of the readings, with all that a physical fit says.
    ///
    /// # Errors
    /// As [`PhysicalModel::search`].
    pub fn search(&self, readings: &FitReadings) -> Result<PhysicalFit, FitError> {
        let kept = self.places(&readings.geometries)?;
        let settings = SearchSettings {
            seed: self.seed,
            watch: self.watch,
        };
        let mut pool = self.pool.lock().map_err(|_| FitError::NoRuns)?;
        self.model.search(&mut pool, &kept, &settings)
    }

    /// Indices of geometries among those of the model.
    fn places(&self, geometries: &[Geometry]) -> Result<Vec<usize>, FitError> {
        places(self.model.forward.geometries(), geometries)
    }
}

fn places(all: &[Geometry], geometries: &[Geometry]) -> Result<Vec<usize>, FitError> {
    let place = |geometry: &Geometry| {
        let found = all.iter().position(|one| one == geometry);
        found.ok_or(FitError::NotTraced {
            theta_i_deg: geometry.theta_i_deg,
            theta_v_deg: geometry.theta_v_deg,
        })
    };
    geometries.iter().map(place).collect()
}

impl Candidate for PhysicalCandidate<'_> {
    fn id(&self) -> &str {
        &self.id
    }

    fn label(&self) -> &str {
        &self.label
    }

    fn fit(&self, readings: &FitReadings) -> Result<Box<dyn Fitted>, FitError> {
        let fit = self.search(readings)?;
        Ok(Box::new(FittedPhysical {
            geometries: self.model.forward.geometries().to_vec(),
            fit,
        }))
    }
}

struct FittedPhysical {
    geometries: Vec<Geometry>,
    fit: PhysicalFit,
}

impl Fitted for FittedPhysical {
    fn parameters(&self) -> &[FittedParameter] {
        &self.fit.report.parameters
    }

    fn predict(&self, geometries: &[Geometry]) -> Result<Array2<f64>, FitError> {
        Ok(self.fit.beta.select(Axis(0), &places(&self.geometries, geometries)?))
    }

    fn batches(&self, geometries: &[Geometry]) -> Result<Vec<Array2<f64>>, FitError> {
        let places = places(&self.geometries, geometries)?;
        Ok((self.fit.batches.iter())
            .map(|batch| batch.select(Axis(0), &places))
            .collect())
    }

    fn indistinct(&self) -> &[Indistinct] {
        &self.fit.report.indistinct
    }

    fn converged(&self) -> bool {
        self.fit.converged
    }
}
