use super::{Failure, Options, Terminal, help, study};
use serde::Serialize;
use specval::compare::Verdict;
use specval::fit::SearchProgress;
use specval::run::{self, RunError, SampleComparison};
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
    samples: Vec<SampleComparison>,
    verdict: Verdict,
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
        let busy = terminal.busy("comparing");
        let watch = |progress: &SearchProgress| {
            busy.say(format!(
                "{}: round {}, {} points traced, misfit {:.2}",
                sample.name(),
                progress.round,
                progress.runs,
                progress.rms
            ));
            ControlFlow::Continue(())
        };
        let compared = run::compare(sample, &studies, !arguments.no_left_out, &watch)?;
        busy.finish();
        compared.notices.iter().for_each(|notice| terminal.notice(notice));
        document.samples.push(compared);
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
