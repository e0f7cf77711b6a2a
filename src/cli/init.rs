use super::{Failure, Terminal};
use serde::Serialize;
use specval::report::OutputFolder;
use specval::study::Study;
use std::fs::File;
use std::io::{self, Write};
use std::path::PathBuf;

/// The study written is the built-in one: every key with its meaning, unit, range and default.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder for study.toml; made where it is missing.
    #[arg(value_name = "DIR", default_value = ".")]
    folder: PathBuf,
}

#[derive(Debug, thiserror::Error)]
enum InitError {
    #[error("{}: exists already and is left as it is; name another folder or move the file", path.display())]
    Exists { path: PathBuf },
    #[error("{}: cannot be written; name a folder you may write to", path.display())]
    NotWritable {
        path: PathBuf,
        #[source]
        cause: io::Error,
    },
}

#[derive(Serialize)]
struct Written {
    study: PathBuf,
}

pub fn run(arguments: &Arguments, terminal: &Terminal) -> Result<(), Failure> {
    let folder = OutputFolder::prepare(&arguments.folder)?;
    let path = folder.path().join("study.toml");
    let mut file = File::create_new(&path).map_err(|cause| match cause.kind() {
        io::ErrorKind::AlreadyExists => InitError::Exists { path: path.clone() },
        _ => InitError::NotWritable {
            path: path.clone(),
            cause,
        },
    })?;
    if let Err(cause) = file.write_all(Study::commented_toml().as_bytes()) {
        // Half a study must not stay; the first error is the one to tell.
        let _ = std::fs::remove_file(&path);
        return Err(InitError::NotWritable { path, cause }.into());
    }
    terminal.result(&Written { study: path }, |written| {
        format!(
            "{0} written; run it with `specval report {0}`\n",
            written.study.display()
        )
    })
}
