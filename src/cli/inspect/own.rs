//! Files of this program itself: studies, traces, shards, states and documents of reports and checks.

use super::super::{Failure, Terminal};
use super::series::Series;
use serde::Serialize;
use serde_json::Value;
use specval::artefact::{ArrayInfo, ArtefactKind, Reader};
use specval::study::Study;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A table of `report.json` or `check --json` that is a document of another kind, or none.
#[derive(Debug, thiserror::Error)]
#[error("{}: expected {expected}, found {found}; take a sound copy, or write it again", path.display())]
struct NoDocument {
    path: PathBuf,
    expected: &'static str,
    found: String,
}

#[derive(Serialize)]
struct StudyFacts {
    format: &'static str,
    wavelength_nm: Series,
    theta_i_deg: Series,
    theta_v_deg: Series,
    sample: String,
    batches: u32,
    /// Paths of each direction of the ledger, and of each tilt of the yarn response.
    paths: [u64; 2],
    seed: u64,
}

pub fn study(study: &Study, terminal: &Terminal) -> Result<(), Failure> {
    let facts = StudyFacts {
        format: "study",
        wavelength_nm: Series::new(study.spectrum.wavelengths()),
        theta_i_deg: Series::new(study.rig.incidences_deg.clone()),
        theta_v_deg: Series::new(study.rig.views_deg()),
        sample: study.measured.sample.clone(),
        batches: study.trace.batches,
        paths: [study.trace.paths_bssrdf, study.trace.paths_direct],
        seed: study.seed,
    };
    terminal.result(&facts, |of| {
        format!(
            "format       study, run by `specval report`, `trace`, `measure` and `check`\nwavelengths  {} \
             nm\ntheta_i      {} deg\ntheta_v      {} deg, below 0 on the light's side of the normal\nsample       \
             {}\nbatches      {}, in all {} paths a direction of the ledger and {} a tilt of the yarn \
             response\nseed         {}\n",
            of.wavelength_nm.words(),
            of.theta_i_deg.words(),
            of.theta_v_deg.words(),
            of.sample,
            of.batches,
            of.paths[0],
            of.paths[1],
            of.seed
        )
    })
}

#[derive(Serialize)]
struct Stored {
    format: &'static str,
    /// Of the program that wrote it.
    version: String,
    sha256: String,
    seed: Value,
    arrays: Vec<ArrayInfo>,
    /// Study and inputs that it was made from.
    identity: Value,
}

/// A file of arrays, whose checksum is tested.
pub fn artefact(path: &Path, kind: ArtefactKind, terminal: &Terminal) -> Result<(), Failure> {
    let reader = Reader::open(path, kind)?;
    let identity = reader.identity().value().clone();
    let stored = Stored {
        format: match kind {
            ArtefactKind::Artefact => "trace",
            ArtefactKind::Shard => "shard",
            ArtefactKind::State => "state",
        },
        version: reader.version().to_owned(),
        sha256: reader.sha256(),
        seed: identity.get("seed").cloned().unwrap_or(Value::Null),
        arrays: reader.arrays().cloned().collect(),
        identity,
    };
    terminal.result(&stored, |of| {
        let what = match kind {
            ArtefactKind::Artefact => "trace, whose absorption `specval reabsorb` changes",
            ArtefactKind::Shard => "shard of a trace, added to the others by `specval merge`",
            ArtefactKind::State => "state of an unfinished run, gone on from with --resume of the command that left it",
        };
        let mut text = format!(
            "format       {what}\nversion      {}\nchecksum     {}, as it should be\nseed         {}\n",
            of.version, of.sha256, of.seed
        );
        for array in &of.arrays {
            let shape: Vec<String> = array.shape.iter().map(usize::to_string).collect();
            let unit = if array.unit.is_empty() { "no unit" } else { &array.unit };
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{:<28} {} of {unit}, over {}",
                array.name,
                shape.join(" x "),
                array.axes
            );
        }
        text
    })
}

#[derive(Serialize)]
struct Document {
    format: &'static str,
    /// Name, and how many entries it has or what it says.
    entries: Vec<(String, String)>,
}

/// `report.json`, or the document of `check --json`.
pub fn document(path: &Path, format: &'static str, terminal: &Terminal) -> Result<(), Failure> {
    let refuse = |found: String| NoDocument {
        path: path.to_owned(),
        expected: "a document in JSON",
        found,
    };
    let text = std::fs::read_to_string(path).map_err(|e| refuse(e.to_string()))?;
    let value: Value = serde_json::from_str(&text).map_err(|e| refuse(e.to_string()))?;
    let Value::Object(entries) = value else {
        return Err(refuse("no object at its beginning".into()).into());
    };
    let words = |value: &Value| match value {
        Value::Array(list) => format!("list of {}", list.len()),
        Value::Object(map) => format!(
            "{} entries: {}",
            map.len(),
            map.keys().cloned().collect::<Vec<_>>().join(", ")
        ),
        other => other.to_string(),
    };
    let document = Document {
        format,
        entries: entries
            .iter()
            .map(|(name, value)| (name.clone(), words(value)))
            .collect(),
    };
    terminal.result(&document, |of| {
        let mut text = match of.format {
            "check" => "format       result of a check, compared with by `specval check --against`\n".to_owned(),
            "result" => "format       result of a report, drawn again by `specval report --from`\n".to_owned(),
            _ => "format       document of a report; angles are degrees, wavelengths nm, brightness factors \
                  dimensionless\n"
                .to_owned(),
        };
        for (name, words) in &of.entries {
            let _ = writeln!(text, "{name:<20} {words}");
        }
        text
    })
}

#[derive(Serialize)]
struct Rows {
    format: &'static str,
    columns: Vec<String>,
    rows: usize,
}

/// `curves.csv` or `energy.csv`.
pub fn table(path: &Path, format: &'static str, terminal: &Terminal) -> Result<(), Failure> {
    let refuse = |error: csv::Error| NoDocument {
        path: path.to_owned(),
        expected: "a table as specval writes it",
        found: error.to_string(),
    };
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_path(path)
        .map_err(refuse)?;
    let columns = reader.headers().map_err(refuse)?.iter().map(str::to_owned).collect();
    let rows = reader.records().collect::<Result<Vec<_>, _>>().map_err(refuse)?.len();
    let found = Rows { format, columns, rows };
    terminal.result(&found, |of| {
        let what = match of.format {
            "curves" => {
                "curves of a report: brightness factors, dimensionless, 1 for the perfect diffuser; angles in degrees"
            }
            _ => "energy ledger: fractions of the incident light, each with its standard error; wavelengths in nm",
        };
        format!(
            "format       {what}\nrows         {}\ncolumns      {}\n",
            of.rows,
            of.columns.join(" ")
        )
    })
}
