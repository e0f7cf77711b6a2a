use super::{
    Convention, EffortNote, InputDigest, Provenance, ReadingCount, ReportData, ReportError, SampleNote, Table1Row,
};
use crate::compare::{HueComparison, Normalisation, Peak, Rmse, RmseRatio};
use serde::Serialize;

/// `report.json`: metrics and provenance. Curves and energy have tables of their own.
#[derive(Serialize)]
struct Document<'a> {
    wavelengths_nm: &'a [f64],
    colour_convention: &'a str,
    table1: &'a [Table1Row],
    conventions: &'a [Convention],
    normalisation: &'a Option<Normalisation>,
    rmse: &'a [Rmse],
    peaks: &'a [Peak],
    rmse_ratios: &'a [RmseRatio],
    sample: &'a SampleNote,
    readings: &'a ReadingCount,
    hue: &'a Option<HueComparison>,
    provenance: Origin<'a>,
}

/// [`Provenance`] with its fallbacks and notices in words.
#[derive(Serialize)]
struct Origin<'a> {
    version: &'a str,
    command: &'a [String],
    study: &'a serde_json::Value,
    seed: u64,
    inputs: &'a [InputDigest],
    effort: &'a EffortNote,
    fallbacks: Vec<String>,
    notices: Vec<String>,
}

impl<'a> Origin<'a> {
    fn of(provenance: &'a Provenance) -> Self {
        Self {
            version: &provenance.version,
            command: &provenance.command,
            study: &provenance.study,
            seed: provenance.seed,
            inputs: &provenance.inputs,
            effort: &provenance.effort,
            fallbacks: provenance.fallbacks.iter().map(ToString::to_string).collect(),
            notices: provenance.notices.iter().map(ToString::to_string).collect(),
        }
    }
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
        peaks: &data.peaks,
        rmse_ratios: &data.rmse_ratios,
        sample: &data.sample,
        readings: &data.readings,
        hue: &data.hue,
        provenance: Origin::of(&data.provenance),
    };
    Ok(serde_json::to_string_pretty(&document)? + "\n")
}
