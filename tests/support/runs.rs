//! What runs of the program print, and that they succeed or are refused.

use crate::command::specval;
use serde_json::Value;
use std::path::Path;
use std::process::Output;

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The output of a run that succeeds.
pub fn succeed(folder: &Path, arguments: &[&str]) -> Output {
    let output = specval(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    output
}

/// What a run that succeeds prints.
pub fn printed(folder: &Path, arguments: &[&str]) -> String {
    String::from_utf8(succeed(folder, arguments).stdout).unwrap()
}

/// The document that a run prints with `--json`.
pub fn json(folder: &Path, arguments: &[&str]) -> Value {
    let output = succeed(folder, &[arguments, &["--json"]].concat());
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The message of a run that refuses its input: exit code 2, nothing on stdout, no panic.
pub fn refusal(folder: &Path, arguments: &[&str]) -> String {
    let output = specval(folder, arguments);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    assert!(
        message.starts_with("error: ") && !message.contains("panicked"),
        "{message}"
    );
    message
}
