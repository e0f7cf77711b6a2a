use super::curves::{channels, directions};
use super::light::bounces;
use super::readings::{count, incidences_of, readings};
use super::{Plan, Progress, RunError, Simulation, SpectralCurves, energy_rows, grazing_gains, grazing_notice};
use crate::cloth::Weave;
use crate::cloth::light::Integrator;
use crate::colour::{ColourSystem, Convention};
use crate::compare::{
    self, Channel, Channels, ColourRatios, Comparison, CurvePoint, HueComparison, Inputs, Propagation, Source,
    model_colour_ratios, reference,
};
use crate::report::{self as shown, Provenance, ReportData, SampleNote, Table1Name, Table1Row};
use crate::rig::{CameraBatch, Geometry};
use crate::sample::{Kind, Reading, Uncertainty, published_ratios};
use crate::shading::{Classical, ShadingModel};
use crate::study::{MediumSection, MethodChoice, NumberOrTable};
use crate::yarn::{DirectTracer, Effort, YarnResponse};

/// Least effort of a point of the sweep: batches, and the share of the study's paths.
const SWEEP_BATCHES: usize = 4;
const SWEEP_PATHS_SHARE: u64 = 20;

fn normal_place(geometries: &[Geometry]) -> usize {
    geometries
        .iter()
        .position(|g| *g == Geometry::NORMAL)
        .unwrap_or(geometries.len())
}

/// Shades, measures, compares: everything after the tracing. `command` goes into the provenance.
pub fn report(
    plan: &Plan,
    simulation: &Simulation,
    command: Vec<String>,
    notices: Vec<String>,
    progress: Progress,
) -> Result<ReportData, RunError> {
    let mut notices = notices;
    notices.extend(grazing_notice(&grazing_gains(plan)?));
    notices.extend(plan.notices());
    notices.extend(plan.colour_notices()?);
    let mut fallbacks = Vec::new();
    let curves = &simulation.curves;
    let normal = normal_place(&curves.geometries);
    if normal + 1 == curves.geometries.len() && curves.geometries.len() > 1 {
        fallbacks.push("the rig has no normal incidence and view; it was added for the model's rows of Table 1".into());
    }
    if plan
        .different_yarns()
        .any(|yarn| yarn.estimator_in_use() != yarn.estimator)
    {
        fallbacks.push(
            "the host is dispersive: wavelengths part at the surface and cannot share paths; the independent estimator was \
             used"
                .into(),
        );
    }
    if plan.weft.is_some() {
        notices.push("warp and weft differ: the energy ledger and the sweep are of the warp's yarn".into());
    }
    let cloth = &plan.study.cloth;
    if cloth.method == MethodChoice::RadianceFactor
        && (cloth.warp_flattening != 1.0 || cloth.weft_flattening != 1.0 || cloth.radius_variation > 0.0)
    {
        fallbacks.push(
            "yarns are elliptical or of varying radius: f* is that of the round yarn of the mean radius; the volumetric method has \
             their shape"
                .into(),
        );
    }
    if plan.study.specular.surface.is_of_yarns() {
        fallbacks.push(
            "the yarns shine by themselves: the model has no gloss about the cloth's normal, the classical shading has"
                .into(),
        );
    }
    let measured = readings(plan, &curves.geometries)?;
    let model = curves.channels(&plan.colour, true);
    let white = channels(&plan.colour, &vec![1.0; plan.grid.len()]);
    let propagation = Propagation::new(&model, &measured)?;
    let mut count = count(plan, &curves.geometries, &measured, propagation.model_mean());
    notices.extend(plan.sample.notices().iter().cloned());
    let mut hue = None;
    let comparison = match reference(&curves.geometries, &measured).and_then(|place| Some((place, measured[place]?))) {
        Some((place, reading)) => {
            let shading = Classical::new(reading.beta, plan.specular)?;
            let classical: Vec<Channels> = curves
                .geometries
                .iter()
                .map(|g| {
                    let (omega_in, omega_out) = directions(plan, *g);
                    shading.eval(&omega_in, &omega_out, &white)
                })
                .collect();
            hue = compare::hue(&propagation, place, &plan.colour);
            let comparison = Comparison::new(&Inputs {
                geometries: &curves.geometries,
                model_batches: &model,
                classical: &classical,
                measured: &measured,
            })?;
            count.normalised_at = comparison.normalisation.map(|_| comparison.reference);
            fallbacks.extend(of_reference(&comparison));
            Some(comparison)
        }
        None if plan.sample.published_ratios().is_some() => {
            fallbacks.push(format!(
                "sample {} has published ratios and no readings: no classical model, no normalisation, no verdict",
                plan.sample.name()
            ));
            None
        }
        None => {
            fallbacks.push(format!(
                "sample {} has no reading at any geometry of the study's [rig]: nothing is compared; its incidences are {} degrees: \
                 set `rig.incidences_deg` to these, or `rig.geometries = \"auto\"` with the built-in angles",
                plan.sample.name(),
                incidences_of(&plan.sample)
            ));
            None
        }
    };
    if let Some(words) = hue.as_ref().and_then(another_cloth) {
        notices.push(words);
    }
    if let Some(comparison) = &comparison
        && comparison.rmse_ratios.iter().any(|ratio| ratio.too_few_paths)
    {
        notices.push(
            "too few paths: the model's luminance is known to no better than a quarter of its value, so verdicts are withheld; take more \
             --paths"
                .into(),
        );
    }
    let energy = energy_rows(plan.grid.nm(), &plan.incident, &simulation.ledgers);
    notices.extend(shown::ledger_notice(&energy));
    notices.extend(more_paths(
        plan.direct_effort.paths_per_batch * simulation.effort.batches,
        &diffuse_ratios(&plan.colour, curves, normal)?,
    ));
    let sweep = sweep(plan, simulation.effort.batches, &mut notices, progress)?;
    let orders = orders(plan, simulation.effort.batches)?;
    let mut table1 = table1(plan, curves, normal, &sweep, comparison.as_ref(), &mut notices)?;
    for (name, ratios) in [Table1Name::ModelDirect, Table1Name::ModelAllBounces]
        .into_iter()
        .zip(&orders)
    {
        table1.push(Table1Row::estimated(name, ratios));
    }
    let mut conventions = Vec::new();
    for convention in Convention::all() {
        let name = convention.to_string();
        let colour = ColourSystem::new(&plan.grid, convention)?;
        conventions.push(shown::Convention {
            convention: name,
            rows: vec![Table1Row::estimated(
                Table1Name::Model,
                &diffuse_ratios(&colour, curves, normal)?,
            )],
        });
    }
    if plan.sample.is_rgb() {
        notices.push(
            "the sample is RGB, not spectral: its ratios have one convention, its own, and its luminance is the study's \
             RGB space's luminance of its RGB"
                .into(),
        );
    }
    if let Weave::Custom(_) = plan.cloth_spec.weave {
        let draft = &plan.study.cloth.weave;
        fallbacks.push(format!(
            "of the draft {draft} the interlacement alone is taken: warp and weft have the study's yarns, and colours, spacings \
             and thicknesses of the file are left out"
        ));
    }
    let comparison = comparison.as_ref();
    Ok(ReportData {
        wavelengths_nm: plan.grid.nm().to_vec(),
        colour_convention: plan.colour.convention().to_string(),
        curves: match comparison {
            Some(comparison) => comparison.curves.clone(),
            None => model_curves(curves, &model, &measured)?,
        },
        table1,
        conventions,
        energy,
        normalisation: comparison.and_then(|c| c.normalisation),
        rmse: comparison.map(|c| c.rmse.clone()).unwrap_or_default(),
        peaks: comparison.map(|c| c.peaks.clone()).unwrap_or_default(),
        rmse_ratios: comparison.map(|c| c.rmse_ratios.clone()).unwrap_or_default(),
        sample: sample_note(plan, &mut fallbacks),
        readings: count,
        hue,
        approximations: None,
        provenance: Provenance {
            version: env!("CARGO_PKG_VERSION").into(),
            command,
            study: serde_json::to_value(&plan.study).map_err(shown::ReportError::from)?,
            seed: plan.study.seed,
            inputs: plan.inputs.clone(),
            effort: simulation.effort.clone(),
            fallbacks,
            notices,
        },
    })
}

/// The model's own curves, not normalised, for want of a measurement.
fn model_curves(
    curves: &SpectralCurves,
    model: &[Vec<Channels>],
    measured: &[Option<Reading>],
) -> Result<Vec<CurvePoint>, RunError> {
    let propagation = Propagation::new(model, measured)?;
    let mut points = Vec::new();
    for channel in Channel::ALL {
        for (j, geometry) in curves.geometries.iter().enumerate() {
            let beta = propagation.estimate(|model, _| model[j][channel as usize]);
            points.push(CurvePoint {
                theta_i_deg: geometry.theta_i_deg,
                theta_v_deg: geometry.theta_v_deg,
                source: Source::Model,
                channel,
                beta: beta.value,
                se: beta.se,
                interpolated: false,
            });
        }
    }
    Ok(points)
}

/// What is not as the preprint's normalisation, in words; none for normal incidence and view.
fn of_reference(comparison: &Comparison) -> Option<String> {
    let Geometry {
        theta_i_deg,
        theta_v_deg,
    } = comparison.reference;
    if comparison.normalisation.is_none() {
        return Some(
            "the model or the sample has no light where it would be normalised: values are compared as they are".into(),
        );
    }
    (comparison.reference != Geometry::NORMAL).then(|| {
        format!(
            "the sample has no reading with light at normal incidence and view: normalisation, the classical shading and the sample's row \
             of Table 1 are of the nearest one, incidence {theta_i_deg} and view {theta_v_deg} degrees"
        )
    })
}

/// That model and sample plainly differ in hue.
fn another_cloth(hue: &HueComparison) -> Option<String> {
    hue.plainly_different.then(|| {
        format!(
            "model and sample plainly differ in colour: hue {:.0} against {:.0} degrees, chroma {:.0} against {:.0} (CIE Lab at equal \
             luminance): the verdicts compare two different cloths; give the study the sample's dye (`medium.dye`)",
            hue.model_hue_deg, hue.measured_hue_deg, hue.model_chroma.value, hue.measured_chroma.value
        )
    })
}

fn sample_note(plan: &Plan, fallbacks: &mut Vec<String>) -> SampleNote {
    let of = plan.sample.description();
    let kind = match of.kind {
        Some(Kind::Measured) => "measured",
        Some(Kind::Fit) => "fit of a measurement",
        Some(Kind::Synthetic) => "synthetic",
        None => "not stated",
    };
    let uncertainty = match plan.sample.uncertainty() {
        Uncertainty::Columns => "standard errors from its own columns".to_owned(),
        Uncertainty::Relative(share) => format!("{:.3} % standard uncertainty", share * 100.0).replace(".000", ""),
        Uncertainty::NotStated => {
            fallbacks.push("the sample states no uncertainty: its standard errors are taken as 0".into());
            "uncertainty not stated".to_owned()
        }
    };
    let colour = of
        .colour
        .as_deref()
        .map(|words| format!("; {words}"))
        .unwrap_or_default();
    SampleNote {
        name: of.name.clone(),
        kind: kind.into(),
        source: of.source.clone(),
        licence: of.licence.clone(),
        uncertainty_stated: plan.sample.uncertainty() != Uncertainty::NotStated,
        caption: format!("{uncertainty}{colour}"),
    }
}

fn diffuse_ratios(colour: &ColourSystem, curves: &SpectralCurves, normal: usize) -> Result<ColourRatios, RunError> {
    let batches: Vec<Channels> = curves
        .diffuse
        .iter()
        .map(|batch| channels(colour, &batch[normal]))
        .collect();
    Ok(model_colour_ratios(&batches)?)
}

/// Share of the study's paths and particles that tell light between the yarns in Table 1, and their batches.
const ORDERS_SHARE: u64 = 4;
const ORDERS_BATCHES: usize = 8;

/// Ratios of the model with direct light alone, and with all light between the yarns. After `traced` batches, fewer than the
/// study has, there are fewer here too.
fn orders(plan: &Plan, traced: usize) -> Result<[ColourRatios; 2], RunError> {
    let batches = ORDERS_BATCHES.min(plan.direct_effort.batches);
    let study = &plan.study.trace;
    let scaled = |paths: u64| {
        let paths = paths / ORDERS_SHARE * traced.min(plan.direct_effort.batches) as u64;
        (paths / plan.direct_effort.batches as u64).max(batches as u64)
    };
    let effort = Effort::new(plan.study.seed, batches, scaled(study.paths_direct))?;
    let tracers = plan
        .different_yarns()
        .map(|yarn| DirectTracer::new(yarn, plan.factor_grid, effort, None))
        .collect::<Result<Vec<_>, _>>()?;
    let particles = scaled(study.particles).div_ceil(batches as u64) as usize;
    let (camera, between) = (plan.direct(), bounces(plan, usize::MAX, particles));
    let beams = plan.beams(&[Geometry::NORMAL]);
    let wavelengths = plan.grid.len();
    let [mut direct, mut all] = [Vec::new(), Vec::new()];
    for batch in 0..batches {
        let responses: Vec<YarnResponse> = tracers.iter().map(|tracer| tracer.batch(batch).response).collect();
        let sunlit = camera.brightness(&responses, beams.lit(), batch)?;
        let goes_on = between.brightness(&responses, beams.lit(), batch)?;
        direct.push(beams.sum(&sunlit, wavelengths));
        all.push(beams.sum(sunlit.iter().chain(&goes_on), wavelengths));
    }
    let ratios = |diffuse| {
        diffuse_ratios(
            &plan.colour,
            &SpectralCurves::new(plan, vec![Geometry::NORMAL], diffuse),
            0,
        )
    };
    Ok([ratios(direct)?, ratios(all)?])
}

/// Ratios of the model with each of the sweep's values alone in place of the study's, in the yarns of the warp where the weft's
/// are of another medium. After `traced` batches, fewer than
/// the study has, there are fewer paths here in proportion: a run that was short of time is short of it here too.
fn sweep(
    plan: &Plan,
    traced: usize,
    notices: &mut Vec<String>,
    progress: Progress,
) -> Result<Vec<ColourRatios>, RunError> {
    let base = &plan.study.medium;
    let of = &plan.study.sweep;
    let mut media: Vec<MediumSection> = Vec::new();
    let mut vary = |values: &[f64], own: Option<f64>, set: fn(&mut MediumSection, f64)| {
        for &value in values.iter().filter(|v| Some(**v) != own) {
            let mut medium = base.clone();
            set(&mut medium, value);
            media.push(medium);
        }
    };
    vary(&of.kappa_peak, Some(base.kappa_peak), |m, v| m.kappa_peak = v);
    vary(&of.volume_fraction, Some(base.volume_fraction), |m, v| {
        m.volume_fraction = v
    });
    vary(&of.particle_diameter_nm, Some(base.particle_diameter_nm), |m, v| {
        m.particle_diameter_nm = v
    });
    vary(&of.particle_index, base.particle_index.number(), |m, v| {
        m.particle_index = NumberOrTable::Number(v)
    });
    let batches = SWEEP_BATCHES.min(plan.direct_effort.batches);
    let paths = plan.study.trace.paths_direct / SWEEP_PATHS_SHARE;
    let paths = match plan.direct_effort.batches {
        study if traced < study => paths / study as u64 * traced as u64,
        _ => paths,
    };
    let effort = Effort::new(plan.study.seed, batches, paths.max(1))?;
    notices.push(format!(
        "sweep: {} media, each with {} paths a tilt in {} batches",
        media.len(),
        effort.batches * effort.paths_per_batch,
        effort.batches
    ));
    let (camera, beams) = (plan.direct(), plan.beams(&[Geometry::NORMAL]));
    let seen: Vec<CameraBatch> = (0..effort.batches)
        .map(|batch| camera.look(beams.lit(), batch))
        .collect();
    let share = 1.0 / media.len().max(1) as f64;
    media
        .iter()
        .map(|medium| {
            let warp = plan.yarn_of(medium)?;
            let tracers = std::iter::once(&warp)
                .chain(&plan.weft)
                .map(|yarn| DirectTracer::new(yarn, plan.factor_grid, effort, None))
                .collect::<Result<Vec<_>, _>>()?;
            let diffuse = std::iter::zip(0.., &seen)
                .map(|(batch, seen)| {
                    let responses: Vec<YarnResponse> = tracers.iter().map(|t| t.batch(batch).response).collect();
                    seen.shade(&responses).into_iter().flatten().collect()
                })
                .collect();
            let curves = SpectralCurves::new(plan, vec![Geometry::NORMAL], diffuse);
            progress(share);
            diffuse_ratios(&plan.colour, &curves, 0)
        })
        .collect()
}

fn table1(
    plan: &Plan,
    curves: &SpectralCurves,
    normal: usize,
    sweep: &[ColourRatios],
    comparison: Option<&Comparison>,
    notices: &mut Vec<String>,
) -> Result<Vec<Table1Row>, RunError> {
    let published = published_ratios()?;
    // The preprint's own ratios say nothing of a cloth of another dye.
    let preprint = plan.study.medium.dye == MediumSection::default().dye;
    let model = diffuse_ratios(&plan.colour, curves, normal)?;
    let mut rows = Vec::new();
    if preprint {
        rows.push(Table1Row::bare(
            Table1Name::Published,
            published.real.blue_over_red[0],
            published.real.green_over_red[0],
        ));
    }
    let measured = comparison.and_then(|c| c.colour_ratios.iter().find(|r| r.source == Source::Measured));
    if let Some(measured) = measured {
        let mut row = Table1Row::estimated(Table1Name::Measured, &measured.ratios);
        if plan.sample.uncertainty() == Uncertainty::NotStated {
            (row.blue_over_red_se, row.green_over_red_se) = (None, None);
        }
        rows.push(row);
        notices.extend(no_ratio("the sample", &measured.ratios));
    }
    rows.push(Table1Row::estimated(Table1Name::Model, &model));
    notices.extend(no_ratio("the model", &model));
    let with_ratio: Vec<&ColourRatios> = std::iter::once(&model)
        .chain(sweep)
        .filter(|r| !r.red_is_zero)
        .collect();
    let without = sweep.len() + 1 - with_ratio.len();
    if without > 0 {
        notices.push(format!(
            "{without} of the {} media of the sweep and the study have no ratio to red, which is as good as 0: they are not in the model's \
             range",
            sweep.len() + 1
        ));
    }
    let Some(first) = with_ratio.first() else {
        return Ok(rows);
    };
    let (mut low, mut high) = (**first, **first);
    for ratios in with_ratio {
        for (end, better) in [(&mut low, -1.0), (&mut high, 1.0)] {
            if better * (ratios.blue_over_red.value - end.blue_over_red.value) > 0.0 {
                end.blue_over_red = ratios.blue_over_red;
            }
            if better * (ratios.green_over_red.value - end.green_over_red.value) > 0.0 {
                end.green_over_red = ratios.green_over_red;
            }
        }
    }
    rows.push(Table1Row::estimated(Table1Name::ModelLow, &low));
    rows.push(Table1Row::estimated(Table1Name::ModelHigh, &high));
    for (name, [from, to], [low, high]) in [
        (
            "blue/red",
            published.model.blue_over_red,
            [low.blue_over_red.value, high.blue_over_red.value],
        ),
        (
            "green/red",
            published.model.green_over_red,
            [low.green_over_red.value, high.green_over_red.value],
        ),
    ] {
        let covered = if low <= from && high >= to {
            "covers"
        } else {
            "does not cover"
        };
        if preprint {
            notices.push(format!(
                "the sweep's {name} range {low:.4}..{high:.4} {covered} the preprint's {from}..{to}"
            ));
        }
    }
    Ok(rows)
}

/// What it would take to know BLUE/RED of the model well, where it is not, after so many `paths` a tilt.
fn more_paths(paths: usize, ratios: &ColourRatios) -> Option<String> {
    /// Relative standard error at which a ratio tells cloths apart.
    const WELL: f64 = 0.05;
    let error = ratios.blue_over_red.se / ratios.blue_over_red.value.abs();
    let times = (error / WELL).powi(2);
    (!ratios.red_is_zero && error.is_finite() && times > 1.0).then(|| {
        format!(
            "BLUE/RED of the model has a standard error of {:.1} %: for 5 % it takes about {times:.1} times the paths of this run, {:.0} a \
             tilt in place of {paths}, and as many times the tracing time",
            100.0 * error,
            paths as f64 * times
        )
    })
}

/// Why there is no ratio to red.
fn no_ratio(whose: &str, ratios: &ColourRatios) -> Option<String> {
    ratios.red_is_zero.then(|| {
        format!(
            "red of {whose}, {:.2e} with standard error {:.1e}, is as good as 0 beside its other components: no ratio to it is shown",
            ratios.red.value, ratios.red.se
        )
    })
}
