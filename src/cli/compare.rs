use super::{Failure, Options, Terminal, help, study};
use serde::Serialize;
use specval::colour::Convention;
use specval::compare::Verdict;
use specval::fit::{
    Candidate, ColourDifference, FitError, FitReadings, FitVerdict, Fitted, FittedParameter, LeftOut, Modelled,
    Predictions, Rival, colour_differences, left_out, misfit_ratio,
};
use specval::run::{FitPlan, Plan, RunError};
use specval::sample::Sample;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::ExitCode;

/// Compares physical models with classical ones on measured samples: what each misses of the readings it was fitted to,
/// and of incidences that were left out. The verdict is that on incidences left out.
///
/// Exit code: 0 the physical model is better on every sample, 1 a classical one on any, 2 otherwise, or bad input.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Study files; each is taken as it stands and with its [fit]. Without one the built-in study.
    #[arg(value_name = "STUDY")]
    studies: Vec<PathBuf>,
    #[arg(long, help = format!("Measured sample: a built-in name ({}), a folder or a file. May be repeated", help::samples()), value_name = "SAMPLE", required = true)]
    measured: Vec<String>,
    /// Do not fit incidences anew without each: faster, and without a verdict.
    #[arg(long)]
    no_left_out: bool,
}

#[derive(Serialize)]
struct Document {
    samples: Vec<SampleRow>,
    verdict: Verdict,
}

#[derive(Serialize)]
struct SampleRow {
    sample: String,
    readings: usize,
    models: Vec<ModelRow>,
    /// Of each fitted study against the classical model that predicts best.
    verdicts: Vec<VerdictRow>,
    notices: Vec<String>,
}

#[derive(Serialize)]
struct ModelRow {
    id: String,
    label: String,
    physical: bool,
    parameters: Vec<FittedParameter>,
    /// Rms of (model − measured) / uncertainty, absolute β.
    misfit: f64,
    misfit_left_out: Option<f64>,
    left_out: Vec<LeftOutRow>,
    converged: bool,
    /// Mean over views of CIEDE2000 and CMC 2:1 of the fitted model from the sample.
    mean_delta_e_2000: Option<f64>,
    mean_delta_e_cmc_2_1: Option<f64>,
    colour_differences: Vec<ColourDifference>,
}

#[derive(Serialize)]
struct LeftOutRow {
    theta_i_deg: f64,
    misfit: f64,
}

#[derive(Serialize)]
struct VerdictRow {
    physical: String,
    classical: String,
    verdict: FitVerdict,
}

/// A model fitted to a sample, and what it predicts.
struct Judged {
    row: ModelRow,
    fitted: Box<dyn Fitted>,
    predictions: Option<Predictions>,
}

pub fn run(arguments: &Arguments, options: &Options) -> Result<ExitCode, Failure> {
    let terminal = &Terminal::new(options);
    let mut studies = Vec::new();
    let paths = arguments.studies.iter().map(|path| Some(path.as_path()));
    let paths: Vec<_> = if arguments.studies.is_empty() {
        vec![None]
    } else {
        paths.collect()
    };
    for path in paths {
        let mut study = study::load(path, options)?;
        if let Some(paths) = options.paths {
            study.fit.particles = paths.get();
        }
        let name = path.map_or("built-in".into(), |path| path.display().to_string());
        studies.push((name, study));
    }
    let mut samples = Vec::new();
    for name in &arguments.measured {
        study::expect_sample(name)?;
        samples.push(Sample::load(name).map_err(RunError::from)?);
    }
    let mut document = Document {
        samples: Vec::new(),
        verdict: Verdict::CannotTell,
    };
    for sample in &samples {
        let row = sample_row(sample, &studies, arguments, terminal)?;
        document.samples.push(row);
    }
    let all: Vec<Verdict> = (document.samples.iter())
        .flat_map(|sample| sample.verdicts.iter().map(|row| row.verdict.verdict))
        .collect();
    document.verdict = match () {
        () if all.contains(&Verdict::Worse) => Verdict::Worse,
        () if !all.is_empty() && all.iter().all(|verdict| *verdict == Verdict::Better) => Verdict::Better,
        () => Verdict::CannotTell,
    };
    terminal.result(&document, text)?;
    Ok(match document.verdict {
        Verdict::Better => ExitCode::SUCCESS,
        Verdict::Worse => ExitCode::from(1),
        Verdict::CannotTell => ExitCode::from(2),
    })
}

fn sample_row(
    sample: &Sample,
    studies: &[(String, specval::study::Study)],
    arguments: &Arguments,
    terminal: &Terminal,
) -> Result<SampleRow, Failure> {
    let with_left_out = !arguments.no_left_out;
    let busy = terminal.busy("comparing");
    let watch = |progress: &specval::fit::SearchProgress| {
        busy.say(format!(
            "{}: round {}, {} points traced, misfit {:.2}",
            sample.name(),
            progress.round,
            progress.runs,
            progress.rms
        ));
        ControlFlow::Continue(())
    };
    let mut physical = Vec::new();
    let mut classical = Vec::new();
    let mut readings = None;
    for (name, study) in studies {
        let convention = study.colour.convention().map_err(RunError::from)?;
        let stated = FitPlan::as_stated(study, sample)?;
        let candidate = stated.candidate(&format!("{name}, as stated"), "as stated", &watch);
        physical.push(judge(&candidate, &stated.readings, &convention, false)?);
        let plan = FitPlan::new(study.clone(), sample)?;
        let candidate = plan.candidate(name, "fitted", &watch);
        physical.push(judge(&candidate, &plan.readings, &convention, with_left_out)?);
        if classical.is_empty() && !plan.readings.transmission {
            let specular = Plan::new(study.clone())?.specular;
            for rival in Rival::all(specular, study.seed) {
                classical.push(judge(&rival, &plan.readings, &convention, with_left_out)?);
            }
        }
        readings = Some(plan.readings);
    }
    let readings = readings.ok_or("no study")?;
    let notices: Vec<String> = readings.notices.iter().map(ToString::to_string).collect();
    for notice in &notices {
        terminal.notice(notice);
    }
    let error = |model: &Judged| model.row.misfit_left_out.unwrap_or(model.row.misfit);
    let best = classical.iter().min_by(|a, b| error(a).total_cmp(&error(b)));
    let mut verdicts = Vec::new();
    for model in physical.iter().skip(1).step_by(2) {
        if let Some(best) = best {
            verdicts.push(VerdictRow {
                physical: model.row.id.clone(),
                classical: best.row.id.clone(),
                verdict: verdict(&readings, model, best, studies[0].1.seed)?,
            });
        }
    }
    Ok(SampleRow {
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
    let row = ModelRow {
        id: candidate.id().into(),
        label: candidate.label().into(),
        physical: !fitted.batches(&readings.geometries)?.is_empty(),
        parameters: fitted.parameters().to_vec(),
        misfit: fitted.misfit(readings)?,
        misfit_left_out: predictions
            .as_ref()
            .map(|predictions| specval::fit::rms(readings.residuals(&predictions.beta))),
        left_out: (parts.iter())
            .map(|part| LeftOutRow {
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

fn text(document: &Document) -> String {
    let mut text = String::new();
    for sample in &document.samples {
        text += &format!("{} ({} readings)\n", sample.sample, sample.readings);
        text += "  model                                     parameters  misfit  left out  dE00  dE CMC\n";
        let number = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.2}"));
        for model in &sample.models {
            let name = if model.physical { &model.id } else { &model.label };
            text += &format!(
                "  {name:40}  {:>10}  {:>6}  {:>8}  {:>4}  {:>6}\n",
                model.parameters.len(),
                number(Some(model.misfit)),
                number(model.misfit_left_out),
                number(model.mean_delta_e_2000),
                number(model.mean_delta_e_cmc_2_1),
            );
        }
        for row in &sample.verdicts {
            let ratio = row.verdict.left_out.unwrap_or(row.verdict.fitted);
            text += &format!(
                "  {} against {}: {}; classical over physical misfit {} {:.2}, 95 %: {:.2} to {:.2}\n",
                row.physical,
                row.classical,
                row.verdict.words(),
                if row.verdict.left_out.is_some() {
                    "on incidences left out"
                } else {
                    "on fitted readings"
                },
                ratio.ratio,
                ratio.interval[0],
                ratio.interval[1],
            );
        }
    }
    text
}
