use super::{Failure, Options, Replace, Terminal, claim, in_words};
use serde::Serialize;
use specval::output::{make_folder, write_whole};
use specval::study::Study;
use std::path::{Path, PathBuf};

/// The study written is the built-in one: every key with its meaning, unit, range and default.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder for study.toml, made where it is missing; - prints the study.
    #[arg(value_name = "DIR", default_value = ".")]
    folder: PathBuf,
    /// Print every key as a row of a table in Markdown, in place of the study.
    #[arg(long, conflicts_with = "folder")]
    keys: bool,
    #[command(flatten)]
    replace: Replace,
}

#[derive(Serialize)]
struct Keys {
    markdown: String,
}

#[derive(Serialize)]
struct Written {
    study: String,
}

pub fn run(arguments: &Arguments, options: &Options) -> Result<(), Failure> {
    if arguments.keys {
        return Terminal::new(options).result(
            &Keys {
                markdown: Study::page_of_keys(),
            },
            |keys| keys.markdown.clone(),
        );
    }
    let path = if arguments.folder == Path::new("-") {
        arguments.folder.clone()
    } else {
        make_folder(&arguments.folder)?;
        arguments.folder.join("study.toml")
    };
    let (places, terminal) = claim(&[&path], &[], &arguments.replace, options)?;
    write_whole(&places[0], Study::commented_toml().as_bytes())?;
    terminal.result(&Written { study: in_words(&path) }, |written| {
        match written.study.as_str() {
            "-" => "the study is on stdout; run it with `specval report -`, which reads it from stdin\n".to_owned(),
            file => format!("{file} written; run it with `specval report {file}`\n"),
        }
    })
}
