use super::inspect::{ChosenComponent, Inspection, scatter_word};
use super::notice::worded;
use super::{Failure, Options, Replace, claim, in_words};
use serde::Serialize;
use specval::formats::registry;
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
    #[arg(long, value_name = "FORMAT", value_parser = target_of, help = format!("Format to write: {}", targets()))]
    to: Option<OutputFormat>,
    #[command(flatten)]
    chosen: ChosenComponent,
    #[command(flatten)]
    replace: Replace,
    #[command(flatten)]
    reading: Inspection,
}

#[derive(Debug, thiserror::Error)]
pub(super) enum ConvertError {
    #[error(
        "{}: expected an extension that names a format ({}), found none of them; say --to FORMAT",
        path.display(), registry::extensions().map(|(extension, ..)| extension).collect::<Vec<_>>().join(", ")
    )]
    Extension { path: PathBuf },
    #[error(
        "{}: expected {asked}, as --scatter says, found an extension of {by_name}; name the file .{extension}, or \
         leave --scatter out",
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
pub(super) struct OutputFormat {
    pub(super) format: Format,
    pub(super) encoding: Encoding,
}

impl From<Format> for OutputFormat {
    fn from(format: Format) -> Self {
        Self {
            format,
            encoding: Encoding::default(),
        }
    }
}

/// Names of what can be written, as a list.
pub(super) fn targets() -> String {
    registry::any_of(&registry::targets().map(|(name, ..)| name).collect::<Vec<_>>())
}

pub(super) fn target_of(name: &str) -> Result<OutputFormat, String> {
    let name = name.to_ascii_lowercase();
    let written = registry::targets().map(|(known, format, encoding)| (known, OutputFormat { format, encoding }));
    // Those that are read alone are refused with the reason.
    let all = registry::all()
        .iter()
        .map(|known| (known.format.name(), known.format.into()));
    written
        .chain(all)
        .find(|(known, _)| *known == name)
        .map(|(_, target)| target)
        .ok_or_else(|| format!("expected {}", targets()))
}

/// What the extension of a file to be written says: its format and, in Integra's files, its kind.
pub(super) fn by_extension(path: &Path) -> (Option<Format>, Option<Scatter>) {
    let extension = path
        .extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_ascii_lowercase();
    match registry::extensions().find(|(known, ..)| *known == extension) {
        Some((_, format, scatter)) => (Some(format), scatter),
        None => (None, None),
    }
}

pub fn run(arguments: &Arguments, options: &Options) -> Result<(), Failure> {
    let output = &arguments.output;
    let (by_format, scatter) = by_extension(output);
    if let (Some(by_name), Some(asked)) = (scatter, arguments.chosen.scatter)
        && by_name != asked
    {
        // Formats that state one kind by an extension have one for the other.
        let mut of_format = registry::extensions().filter(|(_, format, _)| Some(*format) == by_format);
        let other = of_format.find(|(.., scatter)| *scatter == Some(asked));
        let extension = other.map_or("", |(extension, ..)| extension);
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
    let OutputFormat { format, encoding } = arguments
        .to
        .or(by_format.map(OutputFormat::from))
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
    let writing = terminal.busy("converting");
    let written = formats::write(&data, format, &options);
    writing.finish();
    let written = written.map_err(|error| format!("{}: {error}", in_words(&arguments.input)))?;
    write_whole(&places[0], &written.bytes)?;
    for notice in &written.notices {
        terminal.notice(notice);
    }
    let converted = Converted {
        output: in_words(output),
        format: format.name(),
        bytes: written.bytes.len(),
        components: written.components.clone(),
        notices: worded(&data.warnings).chain(worded(&written.notices)).collect(),
    };
    terminal.result(&converted, |c| {
        let components = c.components.join("; ");
        format!(
            "{} bytes of {} written to {}: {components}\n",
            c.bytes, c.format, c.output
        )
    })
}
