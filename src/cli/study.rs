//! From what was typed to a study.

use super::{Failure, Options};
use specval::input::{read_all, read_file};
use specval::run::{FileKind, OtherKind, Plan, RunError};
use specval::sample::Chosen;
use specval::study::{Study, StudyError};
use specval::weave::WeaveError;
use std::path::{Path, PathBuf};

/// Why there is no study to run.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    #[error("{}: expected a study, which is text, found {found}; `specval init` writes one", path.display())]
    Read { path: PathBuf, found: String },
    #[error("{error}{}", remedy(.error))]
    Study {
        #[from]
        error: StudyError,
    },
    #[error(transparent)]
    OtherKind(#[from] OtherKind),
    #[error(
        "--paths: expected {batches} or more, a path for each of the study's batches, found {found}; raise --paths, or \
         lower `trace.batches`"
    )]
    FewPaths { batches: u32, found: u64 },
}

/// For errors that name none themselves.
fn remedy(error: &StudyError) -> &'static str {
    match error {
        StudyError::Syntax { .. } => "; mend the line; `specval init` writes a study to compare with",
        StudyError::Type { .. } => "; correct the value, or remove the line for its default",
        StudyError::UnknownKey { .. } => "; correct or remove it",
        _ => "",
    }
}

/// The study of the file, or the built-in one, with the options of the command line in it.
pub fn load(path: Option<&Path>, options: &Options) -> Result<Study, LoadError> {
    let mut study = match path {
        None => Study::default(),
        Some(path) => read(path).map_err(|error| {
            let due = |kind| kind == FileKind::Study;
            OtherKind::find(path, "a study", due).map_or(error, LoadError::from)
        })?,
    };
    if let Some(seed) = options.seed {
        study.seed = seed;
        study.origin.give("seed", "--seed");
    }
    if let Some(paths) = options.paths {
        let batches = study.trace.batches;
        if paths.get() < u64::from(batches) {
            let found = paths.get();
            return Err(LoadError::FewPaths { batches, found });
        }
        study.trace.paths_bssrdf = paths.get();
        study.trace.paths_direct = paths.get();
        study.trace.particles = paths.get();
        study.trace.particles_volumetric = paths.get();
        for key in ["paths_bssrdf", "paths_direct", "particles", "particles_volumetric"] {
            study.origin.give(&format!("trace.{key}"), "--paths");
        }
    }
    study.validate()?;
    Ok(study)
}

/// Bytes of the longest study.
const MOST_BYTES: u64 = 16 << 20;

/// The study of a file, or of stdin where the path is `-`.
pub fn read(path: &Path) -> Result<Study, LoadError> {
    let refuse = |found: String| LoadError::Read {
        path: path.to_owned(),
        found,
    };
    let bytes = match path == Path::new("-") {
        true => read_all(std::io::stdin().lock(), MOST_BYTES),
        false => read_file(path, MOST_BYTES),
    };
    let bytes = bytes.map_err(|cause| refuse(cause.to_string()))?;
    let text = String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..at].iter().filter(|byte| **byte == b'\n').count();
        refuse(format!(
            "byte 0x{:02x} on line {line}, which is not UTF-8",
            error.as_bytes()[at]
        ))
    })?;
    let name = match path == Path::new("-") {
        true => "stdin".into(),
        false => path.display().to_string(),
    };
    let study = Study::from_toml(&text, &name)?;
    Ok(study.at_folder(path.parent().unwrap_or(Path::new(""))))
}

/// The plan of a study. The error of a sample or draft of another kind names that kind.
pub fn plan(study: Study) -> Result<Plan, Failure> {
    plan_with(study, Chosen::default())
}

/// [`plan`] with a component of the sample that is chosen.
pub fn plan_with(study: Study, chosen: Chosen) -> Result<Plan, Failure> {
    let (sample, weave) = (study.measured.sample.clone(), study.cloth.weave.clone());
    Plan::with_sample(study, chosen).map_err(|error| match error.unplaced() {
        RunError::Sample(_) => expect_sample(&sample).map_or_else(Failure::from, |()| error.into()),
        RunError::Weave(WeaveError::File(_)) => no_draft(error, Path::new(&weave)),
        _ => error.into(),
    })
}

/// Refuses a file that is of another kind than a sample; one that is not known, or not there, is left to the reader.
pub fn expect_sample(name_or_path: &str) -> Result<(), OtherKind> {
    let due = |kind| matches!(kind, FileKind::Sample | FileKind::Goniometric(_) | FileKind::Folder);
    match OtherKind::find(Path::new(name_or_path), "a measured sample", due) {
        Some(other) => Err(other),
        None => Ok(()),
    }
}

/// Why this is no draft.
pub fn no_draft(error: impl Into<Failure>, path: &Path) -> Failure {
    or_other_kind(error, path, "a weave draft (WIF)", |kind| kind == FileKind::Draft)
}

/// Why a file could not be read: it is of none of the kinds that are due, or the error itself.
pub fn or_other_kind(
    error: impl Into<Failure>,
    path: &Path,
    expected: &'static str,
    due: impl Fn(FileKind) -> bool,
) -> Failure {
    match OtherKind::find(path, expected, due) {
        Some(other) => other.into(),
        None => error.into(),
    }
}
