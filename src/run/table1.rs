//! Table 1 of a report, and what has to be said of it.

use super::{Plan, RunError, Sweep};
use crate::compare::{ColourRatios, Comparison, RatioRanges, Role, Table1, Table1Row, Table1Source};
use crate::report::{Notice, RatioOf, SampleNote, TableRatio};
use crate::sample::{PublishedRatios, published_ratios};
use crate::study::Study;

/// The rows; `model` are the ratios at the study's own parameters.
pub(super) fn rows(
    plan: &Plan,
    model: &ColourRatios,
    sweep: &Sweep,
    orders: &[ColourRatios; 2],
    (comparison, samples): (&Comparison, &[SampleNote]),
    notices: &mut Vec<Notice>,
) -> Result<Vec<Table1Row>, RunError> {
    // The preprint's own ratios say nothing of another cloth.
    let Study {
        medium,
        yarn,
        weft,
        cloth,
        ..
    } = &plan.study;
    let built_in = Study::default();
    let is_preprint =
        (medium, yarn, weft, cloth) == (&built_in.medium, &built_in.yarn, &built_in.weft, &built_in.cloth);
    let published = is_preprint.then(published_ratios).transpose()?;
    let measured = comparison
        .colour_ratios
        .iter()
        .filter(|ratios| ratios.source == ratios.sample);
    let mut sources: Vec<Table1Source> = measured
        .map(|of| Table1Source {
            id: of.source.clone(),
            ratios: &of.ratios,
            errors_stated: samples
                .iter()
                .any(|note| note.id == of.source && note.uncertainty_stated),
        })
        .collect();
    notices.push(Notice::Sweep {
        media: sweep.ratios.len(),
        paths: sweep.paths,
        batches: sweep.batches,
    });
    notices.extend(sources.iter().filter_map(|of| no_ratio(RatioOf::Sample, of.ratios)));
    notices.extend(no_ratio(RatioOf::Model, model));
    sources.push(Table1Source {
        id: Role::Model.id().into(),
        ratios: model,
        errors_stated: true,
    });
    let media = || std::iter::once(model).chain(&sweep.ratios);
    let without = media().filter(|ratios| ratios.red_is_zero).count();
    if without > 0 {
        notices.push(Notice::MediaWithoutRatio {
            without,
            media: media().count(),
        });
    }
    let range = RatioRanges::of(media());
    if let (Some(range), Some(PublishedRatios { model, .. })) = (&range, published) {
        let beside = |ratio, range, preprint| Notice::SweepRange { ratio, range, preprint };
        notices.push(beside(
            TableRatio::BlueOverRed,
            range.blue_over_red(),
            model.blue_over_red,
        ));
        notices.push(beside(
            TableRatio::GreenOverRed,
            range.green_over_red(),
            model.green_over_red,
        ));
    }
    let table = Table1 {
        published,
        sources,
        range,
        orders,
    };
    Ok(table.rows())
}

/// That there is no ratio to red.
fn no_ratio(of: RatioOf, ratios: &ColourRatios) -> Option<Notice> {
    ratios.red_is_zero.then_some(Notice::NoRatio {
        of,
        red: ratios.red.value,
        red_se: ratios.red.se,
    })
}
