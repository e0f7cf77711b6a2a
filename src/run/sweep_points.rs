//! Points of a sweep: the chain of a report at other values of the study's keys.

use super::readings::readings_of;
use super::shared_rays::SharedRays;
use super::{Plan, RunError, Simulator, SpectralCurves, Stage, check_memory, report_geometries};
use crate::compare::{Channel, Channels, Compared, Comparison, Inputs, Propagation, Role, Source, reference};
use crate::fit::{Axis, Design, FitError};
use crate::report::{SweepPoint, SweepTable, SweptValue};
use crate::rig::Geometry;
use crate::sample::{Chosen, Reading};
use crate::study::{MethodChoice, ShadeWith, Study};
use sha2::{Digest, Sha256};

/// Where errors say that a varied key comes from.
const OPTION: &str = "--vary";

/// A sweep with every value checked.
pub struct SweepPlan {
    base: Plan,
    chosen: Chosen,
    geometries: Vec<Geometry>,
    points: Vec<Vec<f64>>,
    /// Keys, incidences and digest, without points.
    outline: SweepTable,
}

impl SweepPlan {
    /// Checks keys and values of every point against the rows of the study's keys before any work. All points have the
    /// study's seed, so that they share their random numbers and differ by their parameters.
    ///
    /// # Errors
    /// A key that is unknown or takes no number, a value out of its range, or values that no cloth has.
    pub fn new(study: Study, chosen: Chosen, axes: Vec<Axis>, design: Design) -> Result<Self, RunError> {
        let mut stepped = Vec::with_capacity(axes.len());
        for axis in axes {
            if let Some(found) = without_effect(&axis.key) {
                return Err(FitError::Design {
                    expected: "keys that the model depends on",
                    found,
                }
                .into());
            }
            let axis = match Study::whole_steps(&axis.key, OPTION)? {
                Some(step) => axis.in_steps_of(step),
                None => axis,
            };
            for value in axis.extremes() {
                // Alone, so that the value itself is named; combinations are checked below.
                study.with_number(&axis.key, value, OPTION)?;
            }
            stepped.push(axis);
        }
        let points = design.points(&stepped, study.seed)?;
        let keys: Vec<String> = stepped.into_iter().map(|axis| axis.key).collect();
        for point in &points {
            varied(&study, &keys, point)?;
        }
        let base = Plan::with_sample(study, chosen)?;
        let geometries = report_geometries(&base);
        let mut theta_i_deg: Vec<f64> = geometries.iter().map(|geometry| geometry.theta_i_deg).collect();
        theta_i_deg.sort_by(f64::total_cmp);
        theta_i_deg.dedup();
        let digest = digest(&base, &geometries, &keys, &points)?;
        Ok(Self {
            base,
            chosen,
            geometries,
            outline: SweepTable {
                keys,
                theta_i_deg,
                digest,
                points: Vec::new(),
            },
            points,
        })
    }

    /// The table before the first point.
    pub fn outline(&self) -> &SweepTable {
        &self.outline
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    pub fn base(&self) -> &Plan {
        &self.base
    }

    /// The model at a point. Rays are kept from point to point where they serve both.
    ///
    /// # Errors
    /// Values that no cloth has together, with the key.
    pub fn point(&self, number: usize, rays: &mut Option<SharedRays>) -> Result<SweepPoint, RunError> {
        let parameters = &self.points[number];
        let study = varied(&self.base.study, &self.outline.keys, parameters)?;
        let plan = Plan::with_sample(study, self.chosen)?;
        check_memory(&plan.study, Stage::Views)?;
        let geometries = &self.geometries;
        let batches = plan.direct_effort.batches;
        let direct_alone = plan.study.cloth.method == MethodChoice::RadianceFactor
            && plan.study.trace.shade_with == ShadeWith::Direct
            && !plan.light_goes_on();
        let diffuse = if direct_alone {
            let kept = rays.take().filter(|rays| rays.serve(&plan, geometries, batches));
            let kept = kept.unwrap_or_else(|| SharedRays::new(&plan, geometries, batches));
            let diffuse = kept.shade(&plan.direct_tracers(plan.direct_effort)?, plan.grid.len());
            *rays = Some(kept);
            diffuse
        } else {
            let simulator = Simulator::new(&plan, geometries.clone())?;
            (0..batches)
                .map(|batch| Ok(simulator.light(batch)?.0))
                .collect::<Result<_, RunError>>()?
        };
        let curves = SpectralCurves::new(&plan, geometries.clone(), diffuse);
        let measured = readings_of(&plan.sample, &plan, geometries)?;
        self.compared(number, &plan, &curves, &measured)
    }

    fn compared(
        &self,
        number: usize,
        plan: &Plan,
        curves: &SpectralCurves,
        measured: &[Option<Reading>],
    ) -> Result<SweepPoint, RunError> {
        let model = curves.channels(&plan.colour, true);
        let normal = curves
            .geometries
            .iter()
            .position(|geometry| *geometry == Geometry::NORMAL);
        let ratios = curves.diffuse_ratios(&plan.colour, normal.unwrap_or(0))?;
        let none = SweptValue {
            value: f64::NAN,
            se: f64::NAN,
        };
        let ratio = |value: f64, se: f64| {
            if ratios.red_is_zero {
                none
            } else {
                SweptValue { value, se }
            }
        };
        let mean = Propagation::new(&model, measured)?.model_mean().to_vec();
        let mut point = SweepPoint {
            point: number,
            parameters: self.points[number].clone(),
            blue_over_red: ratio(ratios.blue_over_red.value, ratios.blue_over_red.se),
            green_over_red: ratio(ratios.green_over_red.value, ratios.green_over_red.se),
            coefficient: none,
            misfit_absolute: f64::NAN,
            misfit_normalised: f64::NAN,
            rmse: vec![none; self.outline.theta_i_deg.len()],
            relative_se: relative_se(&model, &mean),
        };
        if reference(&curves.geometries, measured).is_none() {
            return Ok(point);
        }
        let [source, sample] = [Role::Model, Role::Measured].map(|role| Source::numbered(role, 0, role.id()));
        let comparison = Comparison::new(&Inputs {
            geometries: &curves.geometries,
            models: &[Compared::new(&source, &model)],
            classical: &[],
            measured: &[Compared::new(&sample, measured)],
        })?;
        point.misfit_absolute = misfit(&mean, measured, 1.0);
        if let Some(of) = comparison.normalisation.iter().find(|of| of.source == source.id) {
            point.coefficient = SweptValue {
                value: of.factor.value,
                se: of.factor.se,
            };
            point.misfit_normalised = misfit(&mean, measured, of.factor.value);
        }
        for of in comparison
            .rmse
            .iter()
            .filter(|of| of.source == source.id && of.channel == Channel::Y)
        {
            let place = self
                .outline
                .theta_i_deg
                .iter()
                .position(|theta| *theta == of.theta_i_deg);
            if let Some(place) = place {
                point.rmse[place] = SweptValue {
                    value: of.rmse.value,
                    se: of.rmse.se,
                };
            }
        }
        Ok(point)
    }
}

/// Why a key changes no point, if it does not: the geometries are the same at all of them.
fn without_effect(key: &str) -> Option<String> {
    let angles = [
        "rig.incidences_deg",
        "rig.view_min_deg",
        "rig.view_max_deg",
        "rig.view_step_deg",
    ];
    let is_of = |section: &str| key.starts_with(section);
    let of_others = is_of("sweep.") || is_of("check.") || key == "trace.paths_bssrdf";
    (of_others || angles.contains(&key)).then(|| format!("{key}, which no point depends on"))
}

/// The study with the values of a point at the keys.
fn varied(study: &Study, keys: &[String], point: &[f64]) -> Result<Study, RunError> {
    let mut varied = study.clone();
    for (key, value) in std::iter::zip(keys, point) {
        varied = varied.with_number(key, *value, OPTION)?;
    }
    Ok(varied)
}

/// Root mean square of (factor · model − measured) / standard uncertainty over r, g and b of the readings that have one.
fn misfit(model: &[Channels], measured: &[Option<Reading>], factor: f64) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for (model, reading) in std::iter::zip(model, measured) {
        let Some(reading) = reading else { continue };
        let se = reading.se();
        for channel in (0..3).filter(|channel| se[*channel] > 0.0) {
            sum += ((factor * model[channel] - reading.beta[channel]) / se[channel]).powi(2);
            count += 1;
        }
    }
    (sum / f64::from(count)).sqrt()
}

/// Largest standard error of the mean luminance over the geometries, relative to it.
fn relative_se(batches: &[Vec<Channels>], mean: &[Channels]) -> f64 {
    const Y: usize = 3;
    let n = batches.len() as f64;
    let of = |(place, mean): (usize, &Channels)| {
        let squares = batches.iter().map(|batch| (batch[place][Y] - mean[Y]).powi(2));
        (squares.sum::<f64>() / (n * (n - 1.0))).sqrt() / mean[Y]
    };
    mean.iter().enumerate().map(of).fold(0.0, f64::max)
}

fn digest(base: &Plan, geometries: &[Geometry], keys: &[String], points: &[Vec<f64>]) -> Result<String, RunError> {
    let mut hash = Sha256::new();
    hash.update(env!("CARGO_PKG_VERSION"));
    hash.update(base.study.to_toml()?);
    for input in &base.inputs {
        hash.update(&input.name);
        hash.update(&input.sha256);
    }
    for geometry in geometries {
        hash.update(geometry.theta_i_deg.to_le_bytes());
        hash.update(geometry.theta_v_deg.to_le_bytes());
    }
    keys.iter().for_each(|key| hash.update(format!("{key} ")));
    points
        .iter()
        .flatten()
        .for_each(|value| hash.update(value.to_le_bytes()));
    Ok(hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}
