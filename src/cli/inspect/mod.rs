//! What a file holds.

mod goniometric;
mod others;
mod own;
mod series;

use super::{Failure, Terminal, in_words, study};
use specval::formats::{self, AngleUnit, Component, Format, Goniometric, ReadOptions, Scatter, Side};
use specval::run::FileKind;
use specval::sample::Sample;
use specval::spectrum::SpectraFile;
use std::path::{Path, PathBuf};

/// What some formats leave open.
#[derive(Debug, clap::Args)]
pub struct Inspection {
    /// The file holds transmission; for Integra and ASTM files, which do not say.
    #[arg(long, conflicts_with = "reflection")]
    transmission: bool,
    /// The file holds reflection, whatever its name.
    #[arg(long)]
    reflection: bool,
    /// Angles of an ASTM file are in degrees, not radians.
    #[arg(long)]
    degrees: bool,
    /// Factor from a UTIA file's numbers to 1/sr.
    #[arg(long, value_name = "FACTOR", value_parser = factor, allow_negative_numbers = true)]
    scale: Option<f64>,
}

/// Which components of a file are meant.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct ChosenComponent {
    /// Reflection or transmission alone. Where a format holds one of them and nothing is said, reflection is taken if
    /// there is any.
    #[arg(long, value_name = "KIND", value_parser = scatter_of)]
    pub scatter: Option<Scatter>,
    /// Light from the front or from the back alone: the front is the side of the normal, +z. Where a format does not
    /// state the side and nothing is said, the front is taken.
    #[arg(long, value_name = "SIDE", value_parser = side_of)]
    pub side: Option<Side>,
}

impl From<ChosenComponent> for specval::sample::Chosen {
    fn from(typed: ChosenComponent) -> Self {
        Self {
            scatter: typed.scatter,
            side: typed.side,
        }
    }
}

/// --scatter or --side where there is nothing to choose from.
#[derive(Debug, thiserror::Error)]
#[error("--scatter, --side: expected a goniometric file whose components they choose from, found {0}; leave them out")]
pub struct NothingToChoose(pub &'static str);

impl ChosenComponent {
    /// Refuses a choice where there is none.
    pub fn refuse_for(&self, found: &'static str) -> Result<(), NothingToChoose> {
        match (self.scatter, self.side) {
            (None, None) => Ok(()),
            _ => Err(NothingToChoose(found)),
        }
    }

    fn holds(&self, component: &Component) -> bool {
        self.scatter.is_none_or(|scatter| component.scatter == scatter)
            && self.side.is_none_or(|side| component.side == side)
    }
}

pub(super) fn scatter_of(text: &str) -> Result<Scatter, String> {
    match text {
        "reflection" => Ok(Scatter::Reflection),
        "transmission" => Ok(Scatter::Transmission),
        _ => Err("expected reflection or transmission".into()),
    }
}

fn side_of(text: &str) -> Result<Side, String> {
    match text {
        "front" => Ok(Side::Front),
        "back" => Ok(Side::Back),
        _ => Err("expected front or back".into()),
    }
}

pub(super) fn scatter_word(scatter: Scatter) -> &'static str {
    match scatter {
        Scatter::Reflection => "reflection",
        Scatter::Transmission => "transmission",
    }
}

fn factor(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("expected a number above 0".into()),
    }
}

impl Inspection {
    /// Reads a goniometric file; of another file it says what that is.
    pub fn read(&self, path: &Path) -> Result<Goniometric, Failure> {
        let due = |kind| matches!(kind, FileKind::Goniometric(_) | FileKind::Sample);
        let read = formats::read(path, &self.options());
        read.map_err(|error| study::or_other_kind(error, path, "a goniometric file", due))
    }

    fn options(&self) -> ReadOptions {
        let scatter = match (self.transmission, self.reflection) {
            (true, _) => Some(Scatter::Transmission),
            (_, true) => Some(Scatter::Reflection),
            _ => None,
        };
        ReadOptions {
            scatter,
            angle_unit: self.degrees.then_some(AngleUnit::Degrees),
            scale: self.scale,
        }
    }
}

/// What the file is, its angles, wavelengths, counts, units, symmetry and provenance, the directional-hemispherical
/// reflectance of each incidence, and warnings: of goniometric files of any format, samples (CSV files, folders and
/// built-in names), weave drafts and tables of spectra. Of other files it says which command shows them.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// File or sample.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[command(flatten)]
    chosen: ChosenComponent,
    #[command(flatten)]
    reading: Inspection,
}

pub fn run(arguments: &Arguments, terminal: &Terminal) -> Result<(), Failure> {
    let path = &arguments.file;
    let name = path.to_string_lossy();
    let is_built_in = Sample::built_in_names().any(|known| known == name);
    let kind = FileKind::of(path);
    let draft = || matches!(formats::format_of(path), Ok(Format::WIF));
    let is_goniometric = match kind {
        Some(FileKind::Goniometric(_)) => true,
        Some(FileKind::Sample) => !path.is_dir(),
        None => !is_built_in && !draft(),
        _ => false,
    };
    if !is_goniometric {
        let refused = arguments.chosen.refuse_for("a file of another kind");
        refused.map_err(|error| format!("{}: {error}", in_words(path)))?;
    }
    match kind {
        Some(FileKind::Draft) => others::draft(path, terminal),
        Some(FileKind::Spectra) => others::spectra(&SpectraFile::read(path)?, terminal),
        Some(FileKind::Sample) if path.is_dir() => others::sample(&Sample::load(&name)?, terminal),
        Some(FileKind::Study) => own::study(&study::read(path)?, terminal),
        Some(FileKind::Artefact(kind)) => own::artefact(path, kind, terminal),
        Some(FileKind::Report) => own::document(path, "report", terminal),
        Some(FileKind::Check) => own::document(path, "check", terminal),
        Some(FileKind::Result) => own::document(path, "result", terminal),
        Some(FileKind::Curves) => own::table(path, "curves", terminal),
        Some(FileKind::Energy) => own::table(path, "energy", terminal),
        None if is_built_in => others::sample(&Sample::load(&name)?, terminal),
        None if draft() => others::draft(path, terminal),
        _ => match arguments.reading.read(path) {
            Ok(data) => goniometric::show(path, data, &arguments.chosen, terminal),
            // Tables of spectra have no mark of their own.
            Err(error) => match SpectraFile::read(path) {
                Ok(spectra) => others::spectra(&spectra, terminal),
                Err(_) => Err(error),
            },
        },
    }
}
