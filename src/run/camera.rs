use super::Plan;
use super::curves::directions;
use crate::compare::Geometry;
use crate::geometry::Bilinear;
use crate::rig::{Interaction, brightness_factor, view_cell};
use crate::transport::{Purpose, Stream};
use crate::yarn::{FactorWeights, WeightTally};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// What the camera sees of the cloth in one batch, at every geometry: weights of the cells of the f* table. They depend
/// on the weave, the rig and the axes of the table alone, so one batch of camera rays shades with the tables of many
/// media. All incidences of a view share its rays, and a view has the same rays whatever else the rig measures.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraBatch {
    wavelengths: usize,
    /// cosθ_i and the weights, by geometry.
    geometries: Vec<(f64, FactorWeights)>,
}

impl CameraBatch {
    /// Sends the rays of batch number `batch`.
    pub fn trace(plan: &Plan, geometries: &[Geometry], batch: usize) -> Self {
        let mut views: BTreeMap<usize, Vec<(usize, Geometry)>> = BTreeMap::new();
        for (place, geometry) in geometries.iter().enumerate() {
            views.entry(stream_of(*geometry)).or_default().push((place, *geometry));
        }
        let views: Vec<(usize, Vec<(usize, Geometry)>)> = views.into_iter().collect();
        let mut seen: Vec<(usize, f64, FactorWeights)> = views
            .par_iter()
            .map_init(
                || WeightTally::new(plan.factor_grid),
                |tally, (stream, at_view)| see(plan, *stream, at_view, batch, tally),
            )
            .flatten_iter()
            .collect();
        seen.sort_unstable_by_key(|&(place, ..)| place);
        Self {
            wavelengths: plan.grid.len(),
            geometries: seen.into_iter().map(|(_, cos_i, weights)| (cos_i, weights)).collect(),
        }
    }

    /// Diffuse β at [geometry][wavelength] of the yarn whose f* is `table`: one batch on the study's grid, wavelength
    /// fastest, at the study's wavelengths.
    pub fn shade(&self, table: &[f64]) -> Vec<Vec<f64>> {
        self.geometries
            .par_iter()
            .map(|(cos_i, weights)| {
                let mut beta = weights.contract(table, self.wavelengths);
                beta.iter_mut().for_each(|b| *b = brightness_factor(*b, *cos_i).0);
                beta
            })
            .collect()
    }
}

/// Number of a view's random stream: its angle in millionths of a degree.
fn stream_of(geometry: Geometry) -> usize {
    (geometry.theta_v_deg * 1e6).round() as isize as usize
}

/// Weights of one view's geometries in the cloth's mean radiance per irradiance normal to the beam: L = Σ f* E⊥ V over
/// camera rays, nothing behind a gap. No cosine is owed: f* holds it.
fn see(
    plan: &Plan,
    stream: usize,
    at_view: &[(usize, Geometry)],
    batch: usize,
    tally: &mut WeightTally,
) -> Vec<(usize, f64, FactorWeights)> {
    let Some((_, omega_out)) = at_view.first().map(|(_, geometry)| directions(plan, *geometry)) else {
        return Vec::new();
    };
    let mut rng = Stream::open(plan.study.seed, Purpose::Camera, stream, batch, 0);
    let exit_grid = plan.factor_grid.surface().exit();
    let mut points: Vec<(Interaction, Bilinear)> = Vec::with_capacity(plan.pixels.count());
    view_cell(&plan.cloth, &omega_out, &plan.pixels, &mut rng, |interaction| {
        points.extend(interaction.map(|point| (point, exit_grid.bilinear(&point.omega_out_local))));
    });
    let share = 1.0 / plan.pixels.count() as f64;
    at_view
        .iter()
        .map(|&(place, geometry)| {
            let (omega_in, _) = directions(plan, geometry);
            for (point, seen) in &points {
                if let Some(light) = point.light(&plan.cloth, &omega_in) {
                    tally.add(&light, seen);
                }
            }
            (place, geometry.theta_i_deg.to_radians().cos(), tally.drain(share))
        })
        .collect()
}
