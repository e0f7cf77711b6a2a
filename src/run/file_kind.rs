use crate::artefact;
use crate::formats::{self, Format};
use crate::study::Study;
use crate::text::{Foreign, Heading, foreign, heading};
use std::fmt;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Kind of a file, recognised by its content alone, for the message to a user who gave one where another is expected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    Study,
    Artefact(artefact::ArtefactKind),
    /// Readings of a sample as CSV, or a folder with `sample.toml` and `data.csv`.
    Sample,
    /// `sample.toml` by itself.
    SampleDescription,
    Goniometric(Format),
    Draft,
    /// A table over wavelength.
    Spectra,
    /// The document of `check --json`.
    Check,
    /// `report.json`.
    Report,
    /// `result.json`, from which a report is drawn again.
    Result,
    /// `curves.csv` of a report.
    Curves,
    /// `energy.csv` of a report or beside the curves of `measure`.
    Energy,
    /// Not read by this program, but often given.
    Foreign(Foreign),
    Folder,
}

/// Bytes of the largest text that is read whole to recognise its kind.
const MOST_TEXT: u64 = 16 << 20;

/// What `result.json` begins with.
const RESULT_BEGINNING: &[u8] = br#"{"format":"specval result""#;

impl FileKind {
    /// The kind of the file or folder; `None` where it is not known, or cannot be read.
    pub fn of(path: &Path) -> Option<Self> {
        if path.is_dir() {
            let sample = ["sample.toml", "data.csv"].iter().all(|name| path.join(name).is_file());
            return Some(if sample { Self::Sample } else { Self::Folder });
        }
        // To open a pipe is to wait for ever.
        if !path.is_file() {
            return None;
        }
        if let Some(kind) = artefact::ArtefactKind::of(path) {
            return Some(Self::Artefact(kind));
        }
        let mut bytes = Vec::new();
        File::open(path).ok()?.take(MOST_TEXT).read_to_end(&mut bytes).ok()?;
        if bytes.starts_with(RESULT_BEGINNING) {
            return Some(Self::Result);
        }
        let text = std::str::from_utf8(&bytes).ok();
        let known = text.and_then(of_text);
        let known = known.or_else(|| foreign(&bytes).map(Self::Foreign));
        known.or_else(|| match formats::format_of(path) {
            // Square brackets alone, as in a study that cannot be read.
            Ok(Format::WIF) => None,
            Ok(Format::CSV) => text.and_then(of_titles).or(Some(Self::Sample)),
            Ok(format) => Some(Self::Goniometric(format)),
            Err(_) => text.and_then(of_titles),
        })
    }

    /// What to do with such a file.
    fn remedy(self) -> &'static str {
        match self {
            Self::Study => "run it with `specval report STUDY`, `trace`, `measure` or `check`",
            Self::Artefact(artefact::ArtefactKind::Artefact) => {
                "change its absorption with `specval reabsorb`, or name the study it was made from"
            }
            Self::Artefact(artefact::ArtefactKind::Shard) => "add shards with `specval merge`",
            Self::Artefact(artefact::ArtefactKind::State) => "go on from it with --resume of the command that left it",
            Self::Sample => {
                "compare with it by `specval report --measured SAMPLE`, or test it with `specval check --sample SAMPLE`"
            }
            Self::SampleDescription => "name its folder as the sample: `specval report --measured DIR`",
            Self::Goniometric(_) => {
                "see it with `specval inspect FILE`, or compare with it by `specval report --measured FILE`"
            }
            Self::Draft => "see it with `specval weave FILE`, or name it as `weave` in `[cloth]` of a study",
            Self::Spectra => {
                "see its colours with `specval colour FILE`, or name it in a study as a dye, an index or a backing"
            }
            Self::Check => "compare with it by `specval check --against FILE`",
            Self::Report => "its study is in `provenance.study`; `specval init` writes a study file",
            Self::Result => "draw its report again with `specval report --from RESULT`",
            Self::Curves => {
                "give the sample's own readings; of the model, `specval measure` writes such readings, and `specval \
                 report` writes these curves"
            }
            Self::Energy => {
                "see it with `specval inspect FILE`; `specval trace` and `specval measure` write such ledgers"
            }
            Self::Foreign(foreign) => foreign.remedy,
            Self::Folder => "name a file in it",
        }
    }
}

impl fmt::Display for FileKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Study => f.write_str("a study"),
            Self::Artefact(artefact::ArtefactKind::Artefact) => f.write_str("the artefact of a trace"),
            Self::Artefact(artefact::ArtefactKind::Shard) => f.write_str("a shard of a trace"),
            Self::Artefact(artefact::ArtefactKind::State) => f.write_str("the state of an unfinished run"),
            Self::Sample => f.write_str("a measured sample"),
            Self::SampleDescription => f.write_str("the description of a sample (sample.toml)"),
            Self::Goniometric(format) => write!(f, "a goniometric file ({format})"),
            Self::Draft => f.write_str("a weave draft (WIF)"),
            Self::Spectra => f.write_str("a table of spectra"),
            Self::Check => f.write_str("the document of `specval check --json`"),
            Self::Report => f.write_str("the document of a report (report.json)"),
            Self::Result => f.write_str("the result of a report (result.json)"),
            Self::Curves => f.write_str("the curves of a report (curves.csv)"),
            Self::Energy => f.write_str("an energy ledger (energy.csv)"),
            Self::Foreign(foreign) => f.write_str(foreign.what),
            Self::Folder => f.write_str("a folder"),
        }
    }
}

/// A file of another kind than is due.
#[derive(Debug, thiserror::Error)]
#[error("{}: expected {expected}, found {found}; {}", path.display(), found.remedy())]
pub struct OtherKind {
    path: std::path::PathBuf,
    expected: &'static str,
    found: FileKind,
}

impl OtherKind {
    /// Why a file could not be read, if the reason is that it is none of the kinds that are due. `expected` says those
    /// in words.
    pub fn find(path: &Path, expected: &'static str, due: impl Fn(FileKind) -> bool) -> Option<Self> {
        let found = FileKind::of(path).filter(|found| !due(*found))?;
        Some(Self {
            path: path.to_owned(),
            expected,
            found,
        })
    }
}

fn of_text(text: &str) -> Option<FileKind> {
    let text = text.trim_start_matches('\u{feff}');
    if text.trim_start().starts_with('{') {
        let document: serde_json::Value = serde_json::from_str(text).ok()?;
        let has = |key| document.get(key).is_some();
        return match () {
            () if has("gates") && has("subject") => Some(FileKind::Check),
            () if has("provenance") && has("table1") => Some(FileKind::Report),
            () => None,
        };
    }
    if text.lines().any(|line| line.trim().eq_ignore_ascii_case("[wif]")) {
        return Some(FileKind::Draft);
    }
    toml::from_str(text).ok().and_then(|table| of_toml(&table))
}

/// By the titles of columns.
fn of_titles(text: &str) -> Option<FileKind> {
    /// Lines that a preamble before them has at most.
    const LINES: usize = 200;
    let has = |line: &str, titles: &[&str]| titles.iter().all(|title| line.split(',').any(|cell| cell == *title));
    text.lines().take(LINES).find_map(|line| match heading(line)? {
        _ if has(line, &["absorbed", "absorbed_se", "residual"]) => Some(FileKind::Energy),
        _ if has(line, &["source", "channel", "beta", "se"]) => Some(FileKind::Curves),
        Heading::Plane | Heading::Sphere => Some(FileKind::Sample),
        Heading::Spectra => Some(FileKind::Spectra),
    })
}

/// A study has sections of a study, a description the keys of one.
fn of_toml(table: &toml::Table) -> Option<FileKind> {
    let has = |key: &&str| table.contains_key(*key);
    if ["name", "source", "licence"].iter().all(has) {
        Some(FileKind::SampleDescription)
    } else if table.keys().any(|key| Study::has_at_top(key)) {
        Some(FileKind::Study)
    } else {
        None
    }
}
