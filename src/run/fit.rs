//! Fits of a study to a sample: the search, the study that it found, and the study as it stands beside it.

use super::plan::specular;
use super::{RunError, StudyForward};
use crate::fit::{
    Batches, Emulator, FitError, FitReadings, ForwardModel, ForwardPool, FreeDye, PhysicalCandidate, PhysicalFit,
    PhysicalModel, Rival, SearchProgress,
};
use crate::sample::Sample;
use crate::study::{DyeChoice, MethodChoice, NumberOrTable, Study};
use ndarray::Array2;
use std::ops::ControlFlow;
use std::sync::Mutex;

/// Told of every traced point; `Break` ends the search with the best so far.
pub type FitWatch<'a> = dyn Fn(&SearchProgress) -> ControlFlow<()> + Sync + 'a;

/// A study made ready for a fit to a sample.
pub struct FitPlan {
    pub forward: StudyForward,
    pub readings: FitReadings,
    /// Whether β is the mean over the cloth's azimuth, as the sample's is.
    pub isotropic: bool,
    study: Study,
}

/// What a fit found.
pub struct FitOutcome {
    pub fit: PhysicalFit,
    /// The study with the values that were found. Its absorption, where it was free, stands in the file
    /// [`DYE_FILE`] beside it.
    pub study: Study,
    /// Wavelength in nm and absorption in 1/mm; empty where the dye is fixed.
    pub dye: Vec<[f64; 2]>,
    /// β at `[geometry][channel]` of a trace of its own at the parameters that were found. The emulator that they were
    /// found with is nearer to the readings, as it was chosen for that.
    pub traced: Array2<f64>,
    /// Points that were traced.
    pub runs: usize,
}

/// Share of the particles of the trace at the parameters that a fit found.
const CHECK_SHARE: f64 = 4.0;

/// File of the fitted absorption, beside the fitted study.
pub const DYE_FILE: &str = "dye.csv";

impl FitPlan {
    /// # Errors
    /// Errors of the study, of a sample without readings, and of keys that no fit varies.
    pub fn new(study: Study, sample: &Sample) -> Result<Self, RunError> {
        let readings = FitReadings::new(sample, &study.colour.convention()?)?;
        if readings.transmission {
            return Err(RunError::Fit(FitError::Transmission {
                sample: sample.name().into(),
                model: "the light that a fit traces",
            }));
        }
        let isotropic = sample.is_isotropic() == Some(true);
        Ok(Self {
            forward: StudyForward::new(study.clone(), &readings, isotropic)?,
            readings,
            isotropic,
            study,
        })
    }

    /// The study as it stands: nothing of it varies.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn as_stated(study: &Study, sample: &Sample) -> Result<Self, RunError> {
        let mut fixed = study.clone();
        fixed.fit.free.clear();
        fixed.fit.dye = DyeChoice::Fixed;
        Self::new(fixed, sample)
    }

    /// The classical models, which start from the study's gloss.
    ///
    /// # Errors
    /// A gloss that they cannot have.
    pub fn rivals(&self) -> Result<Vec<Rival>, RunError> {
        Ok(Rival::all(specular(&self.study.specular)?, self.study.seed))
    }

    /// The study as a model that is fitted to all readings or some.
    pub fn candidate<'a>(&'a self, id: &str, label: &str, watch: &'a FitWatch<'a>) -> PhysicalCandidate<'a> {
        let bounds = &self.study.fit.dye_bounds_per_mm;
        let dye = self.forward.is_dye_free().then(|| {
            FreeDye::for_channels(
                &self.readings.channels,
                [bounds[0], bounds[1]],
                self.study.fit.dye_roughness,
            )
        });
        PhysicalCandidate {
            id: id.into(),
            label: label.into(),
            model: PhysicalModel {
                forward: &self.forward,
                readings: &self.readings,
                dye,
            },
            seed: self.study.seed,
            watch,
            pool: Mutex::new(ForwardPool::default()),
        }
    }

    /// β of the study at `[geometry][channel]`, with the values that the keys have.
    ///
    /// # Errors
    /// Those of the model.
    pub fn beta(&self) -> Result<Array2<f64>, RunError> {
        let candidate = self.candidate("stated", "as stated", &|_| ControlFlow::Continue(()));
        Ok(candidate.search(&self.readings)?.beta)
    }

    /// Fits the study to all readings.
    ///
    /// # Errors
    /// Those of the model, and more free parameters than readings.
    pub fn fit(&self, watch: &FitWatch) -> Result<FitOutcome, RunError> {
        let candidate = self.candidate("physical", "physical", watch);
        let fit = candidate.search(&self.readings)?;
        let runs = candidate.pool.lock().map_or(0, |pool| pool.runs.len());
        let parameters = candidate.model.split(&fit.solution.parameters);
        let added = candidate.model.mu_a_at_nodes(parameters.dye);
        let run = self.forward.trace(parameters.point, &added, CHECK_SHARE)?;
        let emulator = Emulator::new(&self.forward, &[&run], parameters.point, Batches::All)?;
        let traced = candidate.model.beta(&emulator, &fit.solution.parameters)?;
        let (study, _) = self.forward.study_at(parameters.point)?;
        let mut study = self.forward.with_gloss(&study, parameters.gloss)?;
        study.cloth.method = MethodChoice::Volumetric;
        let mut dye = Vec::new();
        if self.forward.is_dye_free() {
            let nm = self.forward.wavelengths_nm();
            let added = candidate.model.added_mu_a_per_mm(parameters.dye);
            dye = nm.iter().zip(added).map(|(nm, mu_a)| [*nm, mu_a]).collect();
            study.medium.kappa_peak = 0.0;
            study.medium.host_mu_a_per_mm = NumberOrTable::Table(DYE_FILE.into());
            study.weft.kappa_peak = study.weft.kappa_peak.map(|_| 0.0);
            study.weft.host_mu_a_per_mm = None;
        }
        Ok(FitOutcome {
            fit,
            study,
            dye,
            traced,
            runs,
        })
    }
}
