use super::inspect::{Chosen, Reading, scatter_word};
use super::{Failure, Options, Replace, claim, in_words};
use serde::Serialize;
use specval::formats::{self, Encoding, Format, Scatter, WriteOptions};
use specval::output::write_whole;
use std::path::{Path, PathBuf};
use std::slice;

/// Writes the same data in another format. What the format cannot hold is resampled or left out, and told on stderr.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Goniometric file of any format.
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// File to write; without --to its extension says in which format.
    #[arg(value_name = "OUT")]
    output: PathBuf,
    /// Format to write: csv, ddr, sdr, ssdd, ssdd-binary, astm, merl, rgl or klems.
    #[arg(long, value_name = "FORMAT", value_parser = target_of)]
    to: Option<Target>,
    #[command(flatten)]
    chosen: Chosen,
    #[command(flatten)]
    replace: Replace,
    #[command(flatten)]
    reading: Reading,
}

#[derive(Debug, thiserror::Error)]
pub(super) enum ConvertError {
    #[error(
        "{}: expected an extension that names a format (csv, ddr, ddt, sdr, sdt, ssdd, astm, binary, bsdf, xml), found none \
         of them; say --to FORMAT", path.display()
    )]
    Extension { path: PathBuf },
    #[error(
        "{}: expected {asked}, as --scatter says, found an extension of {by_name}; name the file .{extension}, or leave --scatter out",
        path.display()
    )]
    Scatter {
        path: PathBuf,
        by_name: &'static str,
        asked: &'static str,
        extension: &'static str,
    },
}

#[derive(Serialize)]
struct Converted {
    output: String,
    format: &'static str,
    bytes: usize,
    /// What is in the file.
    components: Vec<String>,
    notices: Vec<String>,
}

/// A format to write, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Target {
    pub(super) format: Format,
    pub(super) encoding: Encoding,
}

impl From<Format> for Target {
    fn from(format: Format) -> Self {
        Self {
            format,
            encoding: Encoding::default(),
        }
    }
}

pub(super) fn target_of(name: &str) -> Result<Target, String> {
    let name = name.to_ascii_lowercase();
    if name == "ssdd-binary" {
        return Ok(Target {
            format: Format::Ssdd,
            encoding: Encoding::Binary,
        });
    }
    let known = Format::ALL.into_iter().find(|format| format.name() == name);
    known
        .map(Target::from)
        .ok_or_else(|| "expected csv, ddr, sdr, ssdd, ssdd-binary, astm, merl, rgl or klems".into())
}

/// What the extension of a file to be written says: its format and, in Integra's files, its kind.
pub(super) fn by_extension(path: &Path) -> (Option<Format>, Option<Scatter>) {
    let extension = path
        .extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_ascii_lowercase();
    match extension.as_str() {
        "csv" => (Some(Format::Csv), None),
        "ddr" => (Some(Format::Ddr), Some(Scatter::Reflection)),
        "ddt" => (Some(Format::Ddr), Some(Scatter::Transmission)),
        "sdr" => (Some(Format::Sdr), Some(Scatter::Reflection)),
        "sdt" => (Some(Format::Sdr), Some(Scatter::Transmission)),
        "ssdd" => (Some(Format::Ssdd), None),
        "astm" => (Some(Format::Astm), None),
        "binary" => (Some(Format::Merl), None),
        "bsdf" => (Some(Format::Rgl), None),
        "xml" => (Some(Format::RadianceXml), None),
        _ => (None, None),
    }
}

pub fn run(arguments: &Arguments, options: &Options) -> Result<(), Failure> {
    let output = &arguments.output;
    let (by_name, scatter) = by_extension(output);
    if let (Some(by_name), Some(asked)) = (scatter, arguments.chosen.scatter)
        && by_name != asked
    {
        let extension = match (
            output
                .extension()
                .is_some_and(|e| e.to_string_lossy().starts_with(['s', 'S'])),
            asked,
        ) {
            (true, Scatter::Reflection) => "sdr",
            (true, Scatter::Transmission) => "sdt",
            (false, Scatter::Reflection) => "ddr",
            (false, Scatter::Transmission) => "ddt",
        };
        let path = output.clone();
        let (by_name, asked) = (scatter_word(by_name), scatter_word(asked));
        return Err(ConvertError::Scatter {
            path,
            by_name,
            asked,
            extension,
        }
        .into());
    }
    let Target { format, encoding } = arguments
        .to
        .or(by_name.map(Target::from))
        .ok_or_else(|| ConvertError::Extension { path: output.clone() })?;
    let inputs = slice::from_ref(&arguments.input);
    let (places, terminal) = claim(&[output], inputs, &arguments.replace, options)?;
    let data = arguments.reading.read(&arguments.input)?;
    for warning in &data.warnings {
        terminal.notice(warning);
    }
    let options = WriteOptions {
        scatter: arguments.chosen.scatter.or(scatter),
        side: arguments.chosen.side,
        encoding,
    };
    let written = formats::write(&data, format, &options)?;
    write_whole(&places[0], &written.bytes)?;
    for notice in &written.notices {
        terminal.notice(notice);
    }
    let converted = Converted {
        output: in_words(output),
        format: format.name(),
        bytes: written.bytes.len(),
        components: written.components.clone(),
        notices: data.warnings.iter().chain(&written.notices).cloned().collect(),
    };
    terminal.result(&converted, |c| {
        let components = c.components.join("; ");
        format!(
            "{} bytes of {} written to {}: {components}\n",
            c.bytes, c.format, c.output
        )
    })
}
