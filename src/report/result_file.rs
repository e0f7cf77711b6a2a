//! The result as a file, from which `report --from` draws the report again.

use super::{ReportData, ReportError};
use crate::input::read_file;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Name of the file in a report's folder.
pub const RESULT: &str = "result.json";

const FORMAT: &str = "specval result";
/// Rises with every change after which an older program would read the file wrong.
const VERSION: u32 = 2;
/// Size of the largest file that is read, bytes: forty times the default study's.
const MOST_BYTES: u64 = 128 << 20;

#[derive(Serialize)]
struct Written<'a> {
    format: &'static str,
    format_version: u32,
    result: &'a ReportData,
}

#[derive(Deserialize)]
struct Head {
    format: Option<String>,
    format_version: Option<u32>,
}

#[derive(Deserialize)]
struct Body {
    result: ReportData,
}

/// `result.json`: all of the result on one line. Numbers are the shortest that read back exactly; one that is not known
/// is null.
pub fn result_json(data: &ReportData) -> Result<Vec<u8>, ReportError> {
    let mut bytes = serde_json::to_vec(&Written {
        format: FORMAT,
        format_version: VERSION,
        result: data,
    })?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// The file of a result that is named by itself or by the report's folder.
pub fn result_path(path: &Path) -> PathBuf {
    match path.is_dir() {
        true => path.join(RESULT),
        false => path.to_owned(),
    }
}

/// A result read back.
#[derive(Clone, Debug, PartialEq)]
pub struct FinishedResult {
    pub data: ReportData,
    /// Whether the file is, to the byte, the one that this program writes of the result.
    pub is_unchanged: bool,
}

/// Reads a file of [`result_json`], or the one in a report's folder.
///
/// # Errors
/// A file that cannot be read, is larger than 128 MiB, is no result, or is of another version.
pub fn read_result(path: &Path) -> Result<FinishedResult, ReportError> {
    let path = result_path(path);
    let refused = |found: String, remedy: &'static str| ReportError::NoResult {
        path: path.clone(),
        found,
        remedy,
    };
    let bytes = read_file(&path, MOST_BYTES).map_err(|error| refused(error.to_string(), REMEDY))?;
    let head: Head = serde_json::from_slice(&bytes).map_err(|error| refused(error.to_string(), REMEDY))?;
    if head.format.as_deref() != Some(FORMAT) {
        return Err(refused("another document".into(), REMEDY));
    }
    if head.format_version != Some(VERSION) {
        let found = head
            .format_version
            .map_or("no version".into(), |v| format!("version {v}"));
        return Err(refused(
            found,
            "read it with the program that wrote it, or run its study again (`specval report STUDY`)",
        ));
    }
    let Body { result } = serde_json::from_slice(&bytes).map_err(|error| refused(error.to_string(), REMEDY))?;
    Ok(FinishedResult {
        is_unchanged: result_json(&result).is_ok_and(|own| own == bytes),
        data: result,
    })
}

const REMEDY: &str = "name the result.json of a report, or its folder";
