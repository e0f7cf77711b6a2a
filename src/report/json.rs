use super::{
    Convention, Estimate, Metric, Provenance, ReportData, ReportError, RmseRatio, SampleNote, Source, Table1Row,
};
use serde::Serialize;
use std::collections::BTreeMap;

/// `report.json`: metrics and provenance. Curves and energy have tables of their own.
#[derive(Serialize)]
struct Document<'a> {
    wavelengths_nm: &'a [f64],
    colour_convention: &'a str,
    table1: &'a [Table1Row],
    conventions: &'a [Convention],
    normalisation: &'a BTreeMap<Source, Estimate>,
    rmse: &'a [Metric],
    relative_rmse: &'a [Metric],
    peak_angle_deg: &'a [Metric],
    rmse_ratio: &'a [RmseRatio],
    sample: &'a SampleNote,
    provenance: &'a Provenance,
}

/// The JSON document of the report, indented, ending in a line feed. Numbers are the shortest that read back exactly.
pub fn report_json(data: &ReportData) -> Result<String, ReportError> {
    let document = Document {
        wavelengths_nm: &data.wavelengths_nm,
        colour_convention: &data.colour_convention,
        table1: &data.table1,
        conventions: &data.conventions,
        normalisation: &data.normalisation,
        rmse: &data.rmse,
        relative_rmse: &data.relative_rmse,
        peak_angle_deg: &data.peak_angle_deg,
        rmse_ratio: &data.rmse_ratio,
        sample: &data.sample,
        provenance: &data.provenance,
    };
    Ok(serde_json::to_string_pretty(&document)? + "\n")
}
