//! From a simulation to the result of a report. Nothing is traced here: see [`Sweep`] and [`super::light_orders`].

use super::curves::{channels, directions};
use super::notices::{another_cloth, more_paths, not_compared, of_reference, study_fallbacks};
use super::readings::{count, readings_of};
use super::{Plan, RunError, Simulation, Sweep, energy_rows, grazing_gains, grazing_notice, table1};
use crate::cloth::Weave;
use crate::colour::{ColourSystem, Convention};
use crate::compare::{
    self, Channels, ColourRatios, Compared, Comparison, Inputs, Propagation, Role, Source, Table1Name, Table1Row,
    reference,
};
use crate::report::{self as shown, Fallback, InputDigest, Notice, Provenance, ReportData, SampleNote};
use crate::rig::Geometry;
use crate::sample::{Reading, Sample};
use crate::shading::{Basis, classical_model};
use crate::study::MethodChoice;

/// What a report is asked for beside its study.
#[derive(Clone, Debug)]
pub struct Request<'a> {
    /// Ids of the classical models, [`crate::shading::DEFAULT_MODELS`] by default.
    pub classical: &'a [&'a str],
    /// Samples beside the study's, compared at its geometries.
    pub samples: &'a [Sample],
    /// For the provenance, word by word.
    pub command: Vec<String>,
    /// Notices of the run so far; they come first in the result.
    pub notices: Vec<Notice>,
}

/// Paths a tilt below which verdicts are withheld. Of 64 the normalisation was 4.3 ± 0.3 and of 300 2.9 ± 0.4 where it
/// is 2.7: few paths miss the rare bright ones, and their spread tells nothing of those.
const LEAST_PATHS: usize = 300;

/// Shades, compares and collects what a report says of a simulation.
///
/// # Errors
/// An unknown classical model, or colours that the wavelengths do not carry.
pub fn report(
    plan: &Plan,
    simulation: &Simulation,
    sweep: &Sweep,
    orders: &[ColourRatios; 2],
    request: Request,
) -> Result<ReportData, RunError> {
    let Request {
        classical,
        samples,
        command,
        mut notices,
    } = request;
    let samples: Vec<&Sample> = std::iter::once(&plan.sample).chain(samples).collect();
    notices.extend(grazing_notice(&grazing_gains(plan)?));
    notices.extend(plan.notices());
    notices.extend(plan.colour_notices()?);
    if plan.weft.is_some() {
        notices.push(Notice::WarpAndWeftDiffer);
    }
    let of_samples = samples.iter().flat_map(|sample| sample.notices());
    notices.extend(of_samples.cloned().map(Notice::from));
    let curves = &simulation.curves;
    let mut fallbacks = study_fallbacks(plan, &curves.geometries);
    let mut measured = Vec::new();
    for sample in &samples {
        measured.push(readings_of(sample, plan, &curves.geometries)?);
    }
    let model = curves.channels(&plan.colour, true);
    let propagation = Propagation::new(&model, &measured[0])?;
    let mut readings = count(plan, &curves.geometries, &measured[0], propagation.model_mean());
    let notes = SampleNote::of_all(&samples);
    let model_source = Source::numbered(Role::Model, 0, "model");
    let sample_sources: Vec<Source> = notes.iter().map(|note| note.source_of(notes.len())).collect();
    let models = [Compared::new(&model_source, &model)];
    let has_reading = |of: &Compared<Option<Reading>>| of.values.iter().any(Option::is_some);
    let compared: Vec<Compared<Option<Reading>>> = std::iter::zip(&sample_sources, &measured)
        .map(|(source, values)| Compared::new(source, values))
        .filter(has_reading)
        .collect();
    let mut hue = None;
    let mut shaded = Vec::new();
    let place = reference(&curves.geometries, &measured[0]);
    if let Some((place, reading)) = place.and_then(|place| Some((place, measured[0][place]?))) {
        shaded = shadings(plan, simulation, classical, &reading)?;
        if !plan.sample.is_luminance() {
            hue = compare::hue(&propagation, place, &plan.colour);
        }
    }
    let shadings: Vec<Compared<Channels>> = shaded
        .iter()
        .map(|(source, values)| Compared::new(source, values))
        .collect();
    let mut comparison = Comparison::new(&Inputs {
        geometries: &curves.geometries,
        models: &models,
        classical: &shadings,
        measured: &compared,
    })?;
    if place.is_some() {
        fallbacks.extend(of_reference(&comparison));
    }
    for (sample, values) in std::iter::zip(&samples, &measured) {
        if values.iter().all(Option::is_none) {
            fallbacks.push(not_compared(sample));
        }
    }
    let mut coefficients = comparison.normalisation.iter();
    let of_first = coefficients.find(|coefficient| coefficient.sample == notes[0].id);
    readings.normalised_at = of_first.map(|coefficient| coefficient.at);
    notices.extend(hue.as_ref().and_then(another_cloth));
    let paths = plan.direct_effort.paths_per_batch * simulation.effort.batches;
    if propagation.model_mean().iter().flatten().all(|beta| *beta == 0.0) {
        notices.push(Notice::NoModelLight);
    } else if comparison.rmse_ratios.iter().any(|ratio| ratio.too_few_paths) {
        notices.push(Notice::VerdictsWithheld);
    } else if plan.study.cloth.method == MethodChoice::RadianceFactor && paths < LEAST_PATHS {
        comparison.withhold_verdicts();
        notices.push(Notice::FewPaths {
            paths,
            least: LEAST_PATHS,
        });
    }
    let energy = energy_rows(plan.grid.nm(), &plan.incident, &simulation.ledgers);
    notices.extend(shown::ledger_notice(&energy));
    let places = curves.geometries.len();
    let normal = curves
        .geometries
        .iter()
        .position(|g| *g == Geometry::NORMAL)
        .unwrap_or(places);
    let ratios = curves.diffuse_ratios(&plan.colour, normal)?;
    notices.extend(more_paths(paths, &ratios));
    let table1 = table1::rows(plan, &ratios, sweep, orders, (&comparison, &notes), &mut notices)?;
    let mut conventions = Vec::new();
    for convention in Convention::all() {
        let name = convention.to_string();
        let colour = ColourSystem::new(&plan.grid, convention)?;
        let ratios = curves.diffuse_ratios(&colour, normal)?;
        conventions.push(shown::ConventionRatios {
            convention: name,
            rows: vec![Table1Row::estimated(
                Table1Name::Source(model_source.id.clone()),
                &ratios,
            )],
        });
    }
    if samples.iter().any(|sample| sample.is_rgb()) {
        notices.push(Notice::RgbSample);
    }
    if let Weave::Custom(_) = plan.cloth_spec.weave {
        fallbacks.push(Fallback::InterlacementAlone {
            draft: plan.study.cloth.weave.clone(),
        });
    }
    if notes.iter().any(|note| !note.uncertainty_stated) {
        fallbacks.push(Fallback::UncertaintyNotStated);
    }
    let more_inputs = samples[1..].iter().map(|sample| InputDigest {
        name: format!("sample {}", sample.name()),
        sha256: sample.digest().to_owned(),
    });
    Ok(ReportData {
        wavelengths_nm: plan.grid.nm().to_vec(),
        colour_convention: plan.colour.convention().to_string(),
        sources: comparison.sources,
        curves: comparison.curves,
        table1,
        conventions,
        energy,
        normalisation: comparison.normalisation,
        rmse: comparison.rmse,
        peaks: comparison.peaks,
        rmse_ratios: comparison.rmse_ratios,
        samples: notes,
        readings,
        hue,
        approximations: None,
        provenance: Provenance {
            version: env!("CARGO_PKG_VERSION").into(),
            command,
            study: serde_json::to_value(&plan.study).map_err(shown::ReportError::from)?,
            seed: plan.study.seed,
            inputs: plan.inputs.iter().cloned().chain(more_inputs).collect(),
            effort: simulation.effort.clone(),
            fallbacks,
            notices,
        },
    })
}

/// The classical models of a reading at every geometry. The first has the id of its role, the others have their own.
fn shadings(
    plan: &Plan,
    simulation: &Simulation,
    ids: &[&str],
    reading: &Reading,
) -> Result<Vec<(Source, Vec<Channels>)>, RunError> {
    let white = channels(&plan.colour, &vec![1.0; plan.grid.len()]);
    let basis = Basis {
        normal: reading.beta,
        specular: plan.specular,
    };
    let shading = |(place, id): (usize, &&str)| {
        let model = classical_model(id)?;
        let shading = model.of(&basis)?;
        let values = simulation.curves.geometries.iter().map(|&geometry| {
            let (omega_in, omega_out) = directions(plan, geometry);
            shading.eval(&omega_in, &omega_out, &white)
        });
        let source = Source {
            id: if place == 0 { Role::Classical.id() } else { model.id }.into(),
            role: Role::Classical,
            label: if ids.len() == 1 { "classical model" } else { model.label }.into(),
        };
        Ok((source, values.collect()))
    };
    ids.iter().enumerate().map(shading).collect()
}
