//! Physical and classical models side by side on samples: what they miss of readings that they were fitted to, and of
//! those that they were not.

use super::fit::FitWatch;
use super::{FitPlan, RunError};
use crate::colour::Convention;
use crate::fit::{
    Candidate, ColourDifference, FitError, FitReadings, FitVerdict, Fitted, FittedParameter, LeftOut, Modelled,
    Predictions, colour_differences, left_out, misfit_ratio, rms,
};
use crate::sample::Sample;
use crate::study::Study;
use serde::Serialize;

/// Physical and classical models on one sample.
#[derive(Clone, Debug, Serialize)]
pub struct SampleComparison {
    pub sample: String,
    pub readings: usize,
    pub models: Vec<ComparedModel>,
    /// Of each fitted study against the classical model that predicts best.
    pub verdicts: Vec<ComparedPair>,
    pub notices: Vec<String>,
}

/// One model on one sample.
#[derive(Clone, Debug, Serialize)]
pub struct ComparedModel {
    pub id: String,
    pub label: String,
    pub physical: bool,
    pub parameters: Vec<FittedParameter>,
    /// Rms of (model − measured) / uncertainty, absolute β.
    pub misfit: f64,
    pub misfit_left_out: Option<f64>,
    pub left_out: Vec<PredictedIncidence>,
    pub converged: bool,
    /// Mean over views of CIEDE2000 and CMC 2:1 of the fitted model from the sample.
    pub mean_delta_e_2000: Option<f64>,
    pub mean_delta_e_cmc_2_1: Option<f64>,
    pub colour_differences: Vec<ColourDifference>,
}

/// Rms misfit over uncertainty of an incidence that the model was not fitted to.
#[derive(Clone, Debug, Serialize)]
pub struct PredictedIncidence {
    pub theta_i_deg: f64,
    pub misfit: f64,
}

/// A physical model against a classical one, by their ids.
#[derive(Clone, Debug, Serialize)]
pub struct ComparedPair {
    pub physical: String,
    pub classical: String,
    pub verdict: FitVerdict,
}

/// A model fitted to a sample, and what it predicts.
struct Judged {
    row: ComparedModel,
    fitted: Box<dyn Fitted>,
    predictions: Option<Predictions>,
}

/// Compares studies, each as it stands and fitted, and the classical models, on one sample. `with_left_out`: also fits
/// without each incidence, and predicts it. The verdict is against the classical model that predicts best.
///
/// # Errors
/// Those of the studies, of the sample, and of the fits.
pub fn compare(
    sample: &Sample,
    studies: &[(String, Study)],
    with_left_out: bool,
    watch: &FitWatch,
) -> Result<SampleComparison, RunError> {
    let mut physical = Vec::new();
    let mut classical = Vec::new();
    let mut readings = None;
    for (name, study) in studies {
        let convention = study.colour.convention().map_err(RunError::from)?;
        let stated = FitPlan::as_stated(study, sample)?;
        let candidate = stated.candidate(&format!("{name}, as stated"), "as stated", watch);
        physical.push(judge(&candidate, &stated.readings, &convention, false)?);
        let plan = FitPlan::new(study.clone(), sample)?;
        let candidate = plan.candidate(name, "fitted", watch);
        physical.push(judge(&candidate, &plan.readings, &convention, with_left_out)?);
        if classical.is_empty() && !plan.readings.transmission {
            for rival in plan.rivals()? {
                classical.push(judge(&rival, &plan.readings, &convention, with_left_out)?);
            }
        }
        readings = Some(plan.readings);
    }
    let readings = readings.ok_or(FitError::NoRuns)?;
    let notices: Vec<String> = readings.notices.iter().map(ToString::to_string).collect();
    let error = |model: &Judged| model.row.misfit_left_out.unwrap_or(model.row.misfit);
    let best = classical.iter().min_by(|a, b| error(a).total_cmp(&error(b)));
    let mut verdicts = Vec::new();
    for model in physical.iter().skip(1).step_by(2) {
        if let Some(best) = best {
            verdicts.push(ComparedPair {
                physical: model.row.id.clone(),
                classical: best.row.id.clone(),
                verdict: verdict(&readings, model, best, studies[0].1.seed)?,
            });
        }
    }
    Ok(SampleComparison {
        sample: sample.name().into(),
        readings: readings.len(),
        models: physical.into_iter().chain(classical).map(|judged| judged.row).collect(),
        verdicts,
        notices,
    })
}

fn judge(
    candidate: &dyn Candidate,
    readings: &FitReadings,
    convention: &Convention,
    with_left_out: bool,
) -> Result<Judged, RunError> {
    let fitted = candidate.fit(readings)?;
    let parts: Vec<LeftOut> = match with_left_out {
        true => left_out(candidate, readings)?,
        false => Vec::new(),
    };
    let predictions = Predictions::of(&parts, readings);
    let beta = fitted.predict(&readings.geometries)?;
    let colour_differences = colour_differences(readings, &beta, convention)?.unwrap_or_default();
    let mean = |of: fn(&ColourDifference) -> f64| {
        let count = colour_differences.len() as f64;
        (count > 0.0).then(|| colour_differences.iter().map(of).sum::<f64>() / count)
    };
    let row = ComparedModel {
        id: candidate.id().into(),
        label: candidate.label().into(),
        physical: !fitted.batches(&readings.geometries)?.is_empty(),
        parameters: fitted.parameters().to_vec(),
        misfit: fitted.misfit(readings)?,
        misfit_left_out: predictions
            .as_ref()
            .map(|predictions| rms(readings.residuals(&predictions.beta))),
        left_out: (parts.iter())
            .map(|part| PredictedIncidence {
                theta_i_deg: part.theta_i_deg,
                misfit: part.misfit,
            })
            .collect(),
        converged: fitted.converged(),
        mean_delta_e_2000: mean(|difference| difference.delta_e_2000),
        mean_delta_e_cmc_2_1: mean(|difference| difference.delta_e_cmc),
        colour_differences,
    };
    Ok(Judged {
        row,
        fitted,
        predictions,
    })
}

fn verdict(readings: &FitReadings, physical: &Judged, classical: &Judged, seed: u64) -> Result<FitVerdict, FitError> {
    let beta = [physical, classical].map(|model| model.fitted.predict(&readings.geometries));
    let batches = [physical, classical].map(|model| model.fitted.batches(&readings.geometries));
    let [physical_beta, classical_beta] = beta;
    let [physical_batches, classical_batches] = batches;
    let (physical_beta, classical_beta) = (physical_beta?, classical_beta?);
    let (physical_batches, classical_batches) = (physical_batches?, classical_batches?);
    let modelled = |beta, batches| Modelled { beta, batches };
    let fitted = misfit_ratio(
        readings,
        modelled(&physical_beta, &physical_batches),
        modelled(&classical_beta, &classical_batches),
        seed,
    );
    let unseen = physical.predictions.as_ref().zip(classical.predictions.as_ref());
    let unseen = unseen.map(|(physical, classical)| {
        misfit_ratio(
            readings,
            modelled(&physical.beta, &physical.batches),
            modelled(&classical.beta, &classical.batches),
            seed,
        )
    });
    Ok(FitVerdict::new(fitted, unseen))
}
