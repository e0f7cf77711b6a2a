use super::{Plan, RunError};
use crate::compare::Channels;
use crate::report::ReadingCount;
use crate::rig::Geometry;
use crate::sample::{ANGLE_TOLERANCE_DEG, Reading, Sample};

/// Most geometries of a sample that a report measures, and number of incidences to which a larger sample is thinned.
const MOST_GEOMETRIES: usize = 500;
const MOST_INCIDENCES: usize = 10;

/// Geometries that a report measures: the sample's own, or the rig's where the study sets them or the sample is a table
/// with values there; and normal incidence and view in any case.
pub fn report_geometries(plan: &Plan) -> Vec<Geometry> {
    let mut geometries = match takes_the_samples(plan) {
        true => thinned(plan.sample.geometries().map(geometry).collect()),
        false => plan.geometries(),
    };
    if !geometries.contains(&Geometry::NORMAL) {
        geometries.push(Geometry::NORMAL);
    }
    geometries
}

fn geometry((theta_i_deg, theta_v_deg): (f64, f64)) -> Geometry {
    Geometry {
        theta_i_deg,
        theta_v_deg,
    }
}

pub(super) fn takes_the_samples(plan: &Plan) -> bool {
    let sample = &plan.sample;
    let has_values = |theta_i: &f64| {
        plan.rig
            .views_deg()
            .iter()
            .any(|theta_v| sample.covers(*theta_i, *theta_v))
    };
    plan.study.rig.takes_the_samples()
        && sample.geometries().next().is_some()
        && !(sample.is_table() && plan.rig.incidences_deg().iter().all(has_values))
}

/// Evenly spaced incidences and views of a sample with too many.
fn thinned(geometries: Vec<Geometry>) -> Vec<Geometry> {
    if geometries.len() <= MOST_GEOMETRIES {
        return geometries;
    }
    let curves: Vec<&[Geometry]> = geometries.chunk_by(|a, b| a.theta_i_deg == b.theta_i_deg).collect();
    let kept = curves.len().min(MOST_INCIDENCES);
    let place = |k: usize| {
        if kept > 1 {
            k * (curves.len() - 1) / (kept - 1)
        } else {
            0
        }
    };
    let views = MOST_GEOMETRIES / kept;
    (0..kept)
        .flat_map(|k| {
            let curve = curves[place(k)];
            curve.iter().step_by(curve.len().div_ceil(views)).copied()
        })
        .collect()
}

/// The study's sample at the geometries.
pub(super) fn readings(plan: &Plan, geometries: &[Geometry]) -> Result<Vec<Option<Reading>>, RunError> {
    readings_of(&plan.sample, plan, geometries)
}

/// Any sample at the geometries, in the study's colour convention.
pub(super) fn readings_of(
    sample: &Sample,
    plan: &Plan,
    geometries: &[Geometry],
) -> Result<Vec<Option<Reading>>, RunError> {
    let convention = plan.colour.convention();
    let reading = |g: &Geometry| sample.reading(g.theta_i_deg, g.theta_v_deg, convention);
    Ok(geometries.iter().map(reading).collect::<Result<_, _>>()?)
}

/// How many readings of the sample are compared, and why the others are not. `model` is the mean of the model at each
/// geometry.
pub(super) fn count(
    plan: &Plan,
    geometries: &[Geometry],
    measured: &[Option<Reading>],
    model: &[Channels],
) -> ReadingCount {
    let sample = &plan.sample;
    let angles = sample.angles_read();
    let of_sample: Vec<Geometry> = sample.geometries().map(geometry).collect();
    let mut count = ReadingCount {
        total: of_sample.len() + sample.readings_outside_plane(),
        outside_plane: sample.readings_outside_plane(),
        combined: angles.combined,
        moved: angles.moved,
        largest_move_deg: angles.largest_deg,
        tolerance_deg: ANGLE_TOLERANCE_DEG,
        geometries_of_sample: takes_the_samples(plan),
        ..ReadingCount::default()
    };
    let mut fates = vec![Fate::OutsideRig; of_sample.len()];
    for ((geometry, reading), model) in geometries.iter().zip(measured).zip(model) {
        let Some(reading) = reading else { continue };
        let fate = match reading.interpolated {
            true => Fate::Interpolated,
            false if model[3] == 0.0 => Fate::NoModelValue,
            false => Fate::Used,
        };
        for place in taken(&of_sample, *geometry, reading.interpolated) {
            fates[place] = fates[place].max(fate);
        }
    }
    for (fate, geometry) in std::iter::zip(fates, of_sample) {
        match fate {
            Fate::Used => count.used += 1,
            Fate::Interpolated => count.interpolated += 1,
            Fate::NoModelValue => count.no_model_value += 1,
            Fate::OutsideRig => {
                count.outside_rig += 1;
                if count.examples_outside_rig.len() < ReadingCount::EXAMPLES {
                    count.examples_outside_rig.push(geometry);
                }
            }
        }
    }
    count
}

/// Use of a reading; where several apply, the last of these counts.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Fate {
    OutsideRig,
    NoModelValue,
    Interpolated,
    Used,
}

/// Indices of the readings that give the value at a geometry: the nearest one, or those on either side of an
/// interpolated view.
fn taken(of_sample: &[Geometry], at: Geometry, interpolated: bool) -> Vec<usize> {
    let off = |place: &usize| of_sample[*place].theta_v_deg - at.theta_v_deg;
    let curve = |place: &usize| (of_sample[*place].theta_i_deg - at.theta_i_deg).abs() <= ANGLE_TOLERANCE_DEG;
    let places = || (0..of_sample.len()).filter(curve);
    let nearest = |of: &dyn Fn(f64) -> bool| {
        let side = places().filter(|place| of(off(place)));
        side.min_by(|a, b| off(a).abs().total_cmp(&off(b).abs()))
    };
    let found = match interpolated {
        true => [nearest(&|off| off <= 0.0), nearest(&|off| off >= 0.0)],
        false => [nearest(&|_| true), None],
    };
    found.into_iter().flatten().collect()
}

/// The first ten of the sample's incidences, degrees.
pub(super) fn first_incidences(sample: &Sample) -> Vec<f64> {
    let mut incidences: Vec<f64> = sample.geometries().map(|(theta_i, _)| theta_i).collect();
    incidences.dedup();
    incidences.truncate(10);
    incidences
}
