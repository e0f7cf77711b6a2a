//! The program, run in a folder.

use std::path::Path;
use std::process::{Command, Output};

pub fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specval"));
    command.current_dir(folder).args(arguments);
    command
}

pub fn specval(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().unwrap()
}
