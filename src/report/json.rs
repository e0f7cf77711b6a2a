use super::{ConventionRatios, EffortNote, InputDigest, Provenance, ReadingCount, ReportData, ReportError, SampleNote};
use crate::compare::{HueComparison, Peak, PropagatedEstimate, Rmse, RmseRatio, SourceId, Table1Row};
use serde::{Serialize, Serializer};

/// `report.json`: metrics and provenance. Curves and energy have tables of their own.
#[derive(Serialize)]
struct Document<'a> {
    wavelengths_nm: &'a [f64],
    colour_convention: &'a str,
    table1: &'a [Table1Row],
    conventions: &'a [ConventionRatios],
    normalisation: Option<Factors<'a>>,
    /// To the samples after the first, by sample.
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "as_map")]
    normalisation_to_others: Vec<(&'a SourceId, Factors<'a>)>,
    rmse: &'a [Rmse],
    peaks: &'a [Peak],
    rmse_ratios: &'a [RmseRatio],
    sample: &'a SampleNote,
    #[serde(skip_serializing_if = "<[SampleNote]>::is_empty")]
    more_samples: &'a [SampleNote],
    readings: &'a ReadingCount,
    hue: &'a Option<HueComparison>,
    provenance: ReportOrigin<'a>,
}

/// Coefficients to one sample, by source.
#[derive(Serialize)]
struct Factors<'a>(#[serde(serialize_with = "as_map")] Vec<(&'a SourceId, &'a PropagatedEstimate)>);

fn as_map<S: Serializer, T: Serialize>(entries: &[(&SourceId, T)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(entries.iter().map(|(id, value)| (id, value)))
}

impl<'a> Factors<'a> {
    /// None where nothing is normalised to this sample.
    fn of(data: &'a ReportData, sample: &SourceId) -> Option<Self> {
        let all = data
            .normalisation
            .iter()
            .filter(|coefficient| coefficient.sample == *sample);
        let factors: Vec<_> = all
            .map(|coefficient| (&coefficient.source, &coefficient.factor))
            .collect();
        (!factors.is_empty()).then_some(Self(factors))
    }
}

/// [`Provenance`] with its fallbacks and notices as sentences.
#[derive(Serialize)]
struct ReportOrigin<'a> {
    version: &'a str,
    command: &'a [String],
    study: &'a serde_json::Value,
    seed: u64,
    inputs: &'a [InputDigest],
    effort: &'a EffortNote,
    fallbacks: Vec<String>,
    notices: Vec<String>,
}

impl<'a> ReportOrigin<'a> {
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
    let (sample, more_samples) = data.samples.split_first().ok_or(ReportError::NoSample)?;
    let others = more_samples
        .iter()
        .filter_map(|sample| Some((&sample.id, Factors::of(data, &sample.id)?)))
        .collect();
    let document = Document {
        wavelengths_nm: &data.wavelengths_nm,
        colour_convention: &data.colour_convention,
        table1: &data.table1,
        conventions: &data.conventions,
        normalisation: Factors::of(data, &sample.id),
        normalisation_to_others: others,
        rmse: &data.rmse,
        peaks: &data.peaks,
        rmse_ratios: &data.rmse_ratios,
        sample,
        more_samples,
        readings: &data.readings,
        hue: &data.hue,
        provenance: ReportOrigin::of(&data.provenance),
    };
    Ok(serde_json::to_string_pretty(&document)? + "\n")
}
