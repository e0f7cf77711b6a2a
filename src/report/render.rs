//! A result as the files of its report.

use super::charts::{self, CHARTS, Outline};
use super::error::ReportError;
use super::json::report_json;
use super::result::ReportData;
use super::result_file::{RESULT, result_json};
use super::tables::{approximations_csv, curves_csv, energy_csv, locality_csv, table1_csv, table1_markdown};
use crate::output::NamedFile;
use rayon::prelude::*;
use std::collections::HashSet;

/// Names of the tables and documents of [`render`].
const TABLES: [&str; 6] = [
    "table1.csv",
    "table1.md",
    "curves.csv",
    "energy.csv",
    "report.json",
    RESULT,
];
/// Those of a result with [`super::Approximations`].
const APPROXIMATIONS: [&str; 2] = ["approximations.csv", "locality.csv"];

/// Names of the files that [`render`] makes of a result of this outline.
pub fn file_names(outline: &Outline) -> Vec<String> {
    let approximations = APPROXIMATIONS.iter().filter(|_| outline.approximations);
    let tables = TABLES.iter().chain(approximations).map(|name| (*name).to_owned());
    let pictures = CHARTS.iter().flat_map(|chart| (chart.names)(outline));
    tables
        .chain(pictures.flat_map(|picture| charts::file_names(&picture)))
        .collect()
}

/// Every name that a file of a report may have.
pub fn known_names() -> HashSet<String> {
    /// More than a sample's geometries are thinned to.
    const MANY: usize = 500;
    let every = Outline {
        incidences: MANY,
        approximations: true,
    };
    file_names(&every).into_iter().collect()
}

/// Every file of the report, tables first.
pub fn render(data: &ReportData) -> Result<Vec<NamedFile>, ReportError> {
    let file = |name: &str, bytes| NamedFile {
        name: name.to_owned(),
        bytes,
    };
    let contents = [
        table1_csv(data)?,
        table1_markdown(data).into_bytes(),
        curves_csv(data)?,
        energy_csv(data)?,
        report_json(data)?.into_bytes(),
        result_json(data)?,
    ];
    let tables = TABLES.into_iter().zip(contents);
    let mut files: Vec<NamedFile> = tables.map(|(name, bytes)| file(name, bytes)).collect();
    let pictures: Vec<Vec<NamedFile>> = CHARTS
        .par_iter()
        .map(|chart| (chart.files)(data))
        .collect::<Result<_, _>>()?;
    files.extend(pictures.into_iter().flatten());
    if let Some(approximations) = &data.approximations {
        files.push(file(APPROXIMATIONS[0], approximations_csv(approximations)?));
        files.push(file(APPROXIMATIONS[1], locality_csv(approximations)?));
    }
    Ok(files)
}
