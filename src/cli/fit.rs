use super::{Failure, Options, Replace, Terminal, help, in_words, inputs_of, study};
use clap::builder::NonEmptyStringValueParser;
use serde::Serialize;
use specval::fit::{Candidate, FitReadings, FittedParameter, Indistinct, SearchProgress, rms};
use specval::output::{NamedFile, ReportFolder};
use specval::report::{FitCurves, fit_panels};
use specval::run::{DYE_FILE, FitOutcome, FitPlan, RunError};
use specval::sample::Sample;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Fits a study to a measured sample: what the cloth is, and how sure that is.
///
/// `[fit]` of the study says which keys vary, their bounds and priors, and whether the absorption is free. Writes the
/// fitted study with its dye, fit.json with intervals and correlations, the curves before and after, and a chart.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Study file; without it the built-in study.
    #[arg(value_name = "STUDY")]
    study: Option<PathBuf>,
    #[arg(long, help = format!("Measured sample instead of the study's: a built-in name ({}), a folder or a file", help::samples()), value_name = "SAMPLE", value_parser = NonEmptyStringValueParser::new())]
    measured: Option<String>,
    /// Folder for the results; made if need be.
    #[arg(long, value_name = "DIR", default_value = "fit")]
    out: PathBuf,
    /// Trace no longer than this, such as 90s or 10min; the best so far is then the result, which says that it has not
    /// converged.
    #[arg(long, value_name = "TIME", value_parser = humantime::parse_duration)]
    max_time: Option<Duration>,
    #[command(flatten)]
    replace: Replace,
}

const STUDY_FILE: &str = "study.toml";
const RESULT_FILE: &str = "fit.json";
const CURVES_FILE: &str = "curves.csv";
const CHART: &str = "fit";

fn names() -> Vec<String> {
    let own = [STUDY_FILE, DYE_FILE, RESULT_FILE, CURVES_FILE, "fit.svg", "fit.png"];
    own.map(str::to_owned).to_vec()
}

/// fit.json.
#[derive(Serialize)]
struct Document<'a> {
    sample: &'a str,
    readings: usize,
    /// Whether β is the mean over the cloth's azimuth.
    isotropic: bool,
    converged: bool,
    rounds: usize,
    /// Points that were traced.
    runs: usize,
    /// Rms of (model − measured) / uncertainty, absolute β, of a trace of its own at the parameters that were found.
    misfit: f64,
    /// The same of the emulator of traced light with which they were found.
    misfit_of_emulator: f64,
    misfit_as_stated: Option<f64>,
    /// The same of each incidence.
    misfit_by_incidence: Vec<[f64; 2]>,
    /// Rms of the Monte Carlo standard error over the uncertainty.
    monte_carlo_share: f64,
    /// Factor of the standard errors where the misfit exceeds the uncertainty (Birge ratio).
    error_scale: f64,
    parameters: &'a [FittedParameter],
    correlation: &'a [Vec<f64>],
    indistinct: &'a [Indistinct],
    /// Wavelength in nm and absorption in 1/mm.
    dye: &'a [[f64; 2]],
    /// The classical models, fitted to the same readings with the same weights.
    rivals: Vec<RivalRow>,
    notices: Vec<String>,
}

#[derive(Serialize)]
struct RivalRow {
    id: String,
    label: String,
    parameters: usize,
    misfit: f64,
}

#[derive(Serialize)]
struct CurveRow {
    theta_i_deg: f64,
    theta_v_deg: f64,
    channel: String,
    measured: f64,
    measured_se: f64,
    stated: Option<f64>,
    /// Of a trace of its own at the parameters that were found.
    fitted: f64,
    /// Monte Carlo standard error of the emulator.
    fitted_se: f64,
    /// (fitted − measured) / measured_se.
    residual: f64,
}

pub fn run(arguments: &Arguments, options: &Options) -> Result<(), Failure> {
    let terminal = &Terminal::new(options);
    let mut study = study::load(arguments.study.as_deref(), options)?;
    if let Some(paths) = options.paths {
        study.fit.particles = paths.get();
    }
    if let Some(sample) = &arguments.measured {
        study.measured.sample.clone_from(sample);
        study.origin.give("measured.sample", "--measured");
    }
    let inputs = inputs_of(arguments.study.as_deref(), &study);
    study::expect_sample(&study.measured.sample)?;
    let sample = Sample::load(&study.measured.sample).map_err(RunError::from)?;
    let plan = FitPlan::new(study.clone(), &sample)?;
    let stated = FitPlan::as_stated(&study, &sample)?;
    let folder = ReportFolder::prepare(&arguments.out, &names(), &inputs, arguments.replace.force)?;
    let mut notices: Vec<String> = plan.readings.notices.iter().map(ToString::to_string).collect();
    if sample.is_isotropic().is_none() {
        notices.push(
            "the sample does not say whether it is isotropic: it is compared with the cloth at its own azimuth, cloth.azimuth_deg"
                .into(),
        );
    }
    // A cloth that cannot be traced as stated, such as one of two dyes, has no curve before.
    let before = match stated.beta() {
        Ok(before) => Some(before),
        Err(error) => {
            notices.push(format!("there is no curve of the study as stated: {error}"));
            None
        }
    };
    for notice in &notices {
        terminal.notice(notice);
    }
    let watch = watch(terminal, arguments.max_time);
    let outcome = plan.fit(&watch)?;
    for (beta, model) in [(before.as_ref(), "as stated"), (Some(&outcome.traced), "fitted")] {
        let below = beta.map_or(0, |beta| beta.iter().filter(|beta| **beta < 0.0).count());
        if below > 0 {
            let notice = format!(
                "model {model}: {below} of {} values of beta are below 0, as polynomials of degree {} do not resolve the light \
                 that crosses its transparent yarns; raise fit.expansion_order and fit.particles, and check with `measure`",
                plan.readings.len(),
                outcome.study.fit.expansion_order
            );
            terminal.notice(&notice);
            notices.push(notice);
        }
    }
    let kept: Vec<usize> = (0..plan.readings.geometries.len()).collect();
    let rivals = plan.rivals()?;
    let rivals = rivals.iter().filter(|_| !plan.readings.transmission).map(|rival| {
        let fitted = rival.fit(&plan.readings)?;
        Ok(RivalRow {
            id: rival.id().into(),
            label: rival.label().into(),
            parameters: fitted.count(),
            misfit: fitted.misfit(&plan.readings)?,
        })
    });
    let rivals = rivals
        .collect::<Result<Vec<_>, specval::fit::FitError>>()
        .map_err(RunError::from)?;
    let readings = &plan.readings;
    let of = |beta: &ndarray::Array2<f64>, places: &[usize]| rms(readings.residuals_at(beta, places));
    let fit = &outcome.fit;
    let document = Document {
        sample: sample.name(),
        readings: readings.len(),
        isotropic: plan.isotropic,
        converged: fit.converged,
        rounds: fit.rounds,
        runs: outcome.runs,
        misfit: of(&outcome.traced, &kept),
        misfit_of_emulator: fit.rms,
        misfit_as_stated: before.as_ref().map(|before| of(before, &kept)),
        misfit_by_incidence: (readings.incidences_deg().into_iter())
            .map(|theta_i_deg| {
                let places: Vec<usize> = (kept.iter().copied())
                    .filter(|&g| readings.geometries[g].theta_i_deg == theta_i_deg)
                    .collect();
                [theta_i_deg, of(&outcome.traced, &places)]
            })
            .collect(),
        monte_carlo_share: fit.noise,
        error_scale: fit.report.scale,
        parameters: &fit.report.parameters,
        correlation: &fit.report.correlation,
        indistinct: &fit.report.indistinct,
        dye: &outcome.dye,
        rivals,
        notices,
    };
    let files = files(readings, before.as_ref(), &outcome, &document)?;
    folder.write(&files, |name| names().iter().any(|own| own == name))?;
    terminal.result(&document, |document| text(document, folder.path()))
}

/// Progress on stderr, and the end of the time allowed.
fn watch(terminal: &Terminal, limit: Option<Duration>) -> impl Fn(&SearchProgress) -> ControlFlow<()> + Sync {
    let start = Instant::now();
    let line = terminal.busy("fitting");
    move |progress: &SearchProgress| {
        line.say(format!(
            "fitting: round {}, {} points traced, misfit {:.2}",
            progress.round, progress.runs, progress.rms
        ));
        match limit.is_some_and(|limit| start.elapsed() >= limit) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }
}

fn files(
    readings: &FitReadings,
    before: Option<&ndarray::Array2<f64>>,
    outcome: &FitOutcome,
    document: &Document,
) -> Result<Vec<NamedFile>, Failure> {
    let fit = &outcome.fit;
    let residuals = readings.residuals(&outcome.traced);
    let mut curves = csv::Writer::from_writer(Vec::new());
    for (g, geometry) in readings.geometries.iter().enumerate() {
        for (c, channel) in readings.channels.iter().enumerate() {
            curves.serialize(CurveRow {
                theta_i_deg: geometry.theta_i_deg,
                theta_v_deg: geometry.theta_v_deg,
                channel: channel.name(),
                measured: readings.beta[[g, c]],
                measured_se: readings.se[[g, c]],
                stated: before.map(|before| before[[g, c]]),
                fitted: outcome.traced[[g, c]],
                fitted_se: fit.beta_se[[g, c]],
                residual: residuals[[g, c]],
            })?;
        }
    }
    let study = format!(
        "# Fitted by specval to {}: misfit {:.3} of the readings' uncertainty. Intervals: {RESULT_FILE}.\n{}",
        document.sample,
        document.misfit,
        toml::to_string(&absolute(&outcome.study)?)?
    );
    let file = |name: &str, bytes: Vec<u8>| NamedFile {
        name: name.into(),
        bytes,
    };
    let mut files = vec![
        file(STUDY_FILE, study.into_bytes()),
        file(
            RESULT_FILE,
            (serde_json::to_string_pretty(document)? + "\n").into_bytes(),
        ),
        file(CURVES_FILE, curves.into_inner()?),
    ];
    if !outcome.dye.is_empty() {
        let mut dye = String::from("# Absorption of the yarns' host that the fit found, 1/mm.\nwavelength_nm,value\n");
        for [nm, mu_a] in &outcome.dye {
            dye += &format!("{nm},{mu_a}\n");
        }
        files.push(file(DYE_FILE, dye.into_bytes()));
    }
    files.extend(fit_panels(
        CHART,
        FitCurves {
            readings,
            before: before.unwrap_or(&outcome.traced),
            after: &outcome.traced,
        },
    )?);
    Ok(files)
}

/// The study with the paths of its files whole, but for that of the fitted dye, which lies beside it.
fn absolute(study: &specval::study::Study) -> Result<specval::study::Study, Failure> {
    let mut absolute = study.clone().at_folder(&std::env::current_dir()?);
    absolute.medium.host_mu_a_per_mm = study.medium.host_mu_a_per_mm.clone();
    Ok(absolute)
}

fn text(document: &Document, folder: &Path) -> String {
    let mut text = format!(
        "misfit {:.2} of the readings' uncertainty, {:.2} of the emulator ({} readings of {}{})\n",
        document.misfit,
        document.misfit_of_emulator,
        document.readings,
        document.sample,
        match document.misfit_as_stated {
            Some(stated) => format!(", {stated:.2} as stated"),
            None => String::new(),
        }
    );
    for [theta_i_deg, misfit] in &document.misfit_by_incidence {
        text += &format!("  incidence {theta_i_deg}°: {misfit:.2}\n");
    }
    for parameter in document.parameters {
        let unit = match parameter.unit.as_str() {
            "" => String::new(),
            unit => format!(" {unit}"),
        };
        let sure = match (parameter.interval, parameter.at_bound) {
            (_, Some(_)) => "on its bound".into(),
            (Some([low, high]), None) => format!("95 %: {low:.4} to {high:.4}"),
            (None, None) => "not determined by the readings".into(),
        };
        text += &format!("  {:28} {:.4}{unit}  {sure}\n", parameter.name, parameter.value);
    }
    for indistinct in document.indistinct {
        text += &format!("  cannot be told apart: {}\n", indistinct.names.join(", "));
    }
    text += "classical models fitted to the same readings:\n";
    for rival in &document.rivals {
        text += &format!(
            "  {:32} {:.2}  ({} parameters)\n",
            rival.label, rival.misfit, rival.parameters
        );
    }
    if !document.converged {
        text += "not converged: the best point within the time or the rounds allowed\n";
    }
    if document.monte_carlo_share > 1.0 / 3.0 {
        text += &format!(
            "Monte Carlo error {:.2} of the uncertainty, above a third: raise fit.particles\n",
            document.monte_carlo_share
        );
    }
    text + &format!("{} points traced; written to {}\n", document.runs, in_words(folder))
}
