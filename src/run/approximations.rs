use super::curves::{channels, directions};
use super::readings::report_geometries;
use super::{Plan, Progress, RunError, Simulator, SpectralCurves, Stage, check_memory};
use crate::compare::{Channel, Channels};
use crate::report::{ApproximationRow, Approximations, LocalityRow};
use crate::rig::Geometry;
use crate::sample::Reading;
use crate::shading::{Basis, DEFAULT_MODELS, classical_model};
use crate::study::{BounceLimit, MethodChoice, Study, StudyError};
use crate::transport::Estimate;
use crate::yarn::{Yarn, scattered_beyond};
use std::iter::zip;

/// The study with this method and these bounces.
fn variant(study: &Study, method: MethodChoice, bounces: BounceLimit) -> Study {
    let mut study = study.clone();
    study.cloth.method = method;
    study.cloth.bounces = bounces;
    study
}

/// The methods that are compared.
const VARIANTS: [(MethodChoice, BounceLimit); 3] = [
    (MethodChoice::Volumetric, BounceLimit::ALL),
    (MethodChoice::RadianceFactor, BounceLimit::Most(0)),
    (MethodChoice::RadianceFactor, BounceLimit::ALL),
];

/// [`check_memory`] of what [`approximations`] simulates.
///
/// # Errors
/// As [`check_memory`].
pub fn check_approximations(study: &Study) -> Result<(), StudyError> {
    for (method, bounces) in VARIANTS {
        check_memory(&variant(study, method, bounces), Stage::Views)?;
    }
    Ok(())
}

/// What each approximation of the light in the cloth costs, with the study's effort for each.
pub fn approximations(plan: &Plan, progress: Progress) -> Result<Approximations, RunError> {
    let geometries = report_geometries(plan);
    let of = |geometry: usize| geometries[geometry].theta_i_deg;
    let simulated = |method, bounces| -> Result<Vec<Vec<Channels>>, RunError> {
        let plan = Plan::with_sample(variant(&plan.study, method, bounces), plan.chosen)?;
        let simulator = Simulator::new(&plan, geometries.clone())?;
        let mut diffuse = Vec::new();
        for batch in 0..plan.direct_effort.batches {
            diffuse.push(simulator.batch(batch)?.diffuse);
            progress(1.0 / (3 * plan.direct_effort.batches) as f64);
        }
        Ok(SpectralCurves::new(&plan, geometries.clone(), diffuse).channels(&plan.colour, true))
    };
    let [volumetric, direct, all] = VARIANTS.map(|(method, bounces)| simulated(method, bounces));
    let (volumetric, direct, all) = (volumetric?, direct?, all?);
    let mut readings: Vec<Option<Reading>> = Vec::new();
    for g in &geometries {
        readings.push(
            plan.sample
                .reading(g.theta_i_deg, g.theta_v_deg, plan.colour.convention())?,
        );
    }
    let white = channels(&plan.colour, &vec![1.0; plan.grid.len()]);
    let normal = geometries.iter().position(|g| *g == Geometry::NORMAL);
    let normal = normal.and_then(|normal| readings[normal].as_ref());
    let preprint = classical_model(DEFAULT_MODELS[0])?;
    let classical = normal
        .map(|reading| {
            preprint.of(&Basis {
                normal: reading.beta,
                specular: plan.specular,
            })
        })
        .transpose()?;
    let mut rows = Vec::new();
    let mut incidences: Vec<f64> = geometries.iter().map(|g| g.theta_i_deg).collect();
    incidences.sort_by(f64::total_cmp);
    incidences.dedup();
    for theta_i_deg in incidences {
        let views: Vec<usize> = (0..geometries.len()).filter(|&g| of(g) == theta_i_deg).collect();
        let share = 1.0 / views.len() as f64;
        for channel in Channel::ALL {
            let c = channel as usize;
            let traced = |batches: &[Vec<Channels>]| {
                let of_batch = |batch: &Vec<Channels>| views.iter().map(|&g| share * batch[g][c]).sum::<f64>();
                Estimate::from_batches(batches.iter().map(of_batch))
            };
            let shaded = classical.as_ref().zip(normal).map(|(shading, normal)| {
                let of_view = |&g: &usize| {
                    let (omega_in, omega_out) = directions(plan, geometries[g]);
                    share * shading.eval(&omega_in, &omega_out, &white)[c]
                };
                // Its one measured value is the same at every view.
                Estimate {
                    value: views.iter().map(of_view).sum(),
                    se: normal.se()[c],
                }
            });
            let read: Option<Vec<&Reading>> = views.iter().map(|&g| readings[g].as_ref()).collect();
            // Errors of readings are taken as independent of each other.
            let read = read.map(|read| Estimate {
                value: read.iter().map(|reading| share * reading.beta[c]).sum(),
                se: read
                    .iter()
                    .map(|reading| (share * reading.se()[c]).powi(2))
                    .sum::<f64>()
                    .sqrt(),
            });
            let reference = traced(&volumetric);
            let sources = [
                ("classical", shaded),
                ("direct", Some(traced(&direct))),
                ("all-bounces", Some(traced(&all))),
                ("volumetric", Some(reference)),
                ("measured", read),
            ];
            for (source, mean) in sources {
                let Some(Estimate { value, se }) = mean else { continue };
                let ratio = value / reference.value;
                let relative = match source {
                    "volumetric" => 0.0,
                    _ => (se / value).hypot(reference.se / reference.value),
                };
                rows.push(ApproximationRow {
                    theta_i_deg,
                    channel,
                    source: source.into(),
                    mean_beta: value,
                    mean_beta_se: se,
                    over_volumetric: ratio,
                    over_volumetric_se: (ratio * relative).abs(),
                });
            }
        }
    }
    Ok(Approximations {
        rows,
        locality: locality(&plan.yarn, plan.cloth_spec.weft_spacing_mm, plan.study.seed)?,
    })
}

/// Fractions of the scattered light of a beam across a straight yarn, by how far along it they leave.
fn locality(yarn: &Yarn, spacing_mm: f64, seed: u64) -> Result<Vec<LocalityRow>, RunError> {
    let distances_mm = [0.5 * spacing_mm, spacing_mm, 8.0 * yarn.cylinder.radius_mm()];
    let beyond = scattered_beyond(yarn, distances_mm, seed)?;
    let row = |(&wavelength_nm, [half, whole, eight]): (&f64, [Estimate; 3])| LocalityRow {
        wavelength_nm,
        beyond_half_spacing: half.value,
        beyond_half_spacing_se: half.se,
        beyond_spacing: whole.value,
        beyond_spacing_se: whole.se,
        beyond_8_radii: eight.value,
        beyond_8_radii_se: eight.se,
    };
    Ok(zip(yarn.medium.grid().nm(), beyond).map(row).collect())
}
