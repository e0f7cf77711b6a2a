use super::Plan;
use super::curves::directions;
use crate::cloth::System;
use crate::compare::Geometry;
use crate::fault::{self, Fault};
use crate::geometry::Bilinear;
use crate::rig::{Interaction, brightness_factor, view_cell};
use crate::transport::{Purpose, Stream};
use crate::yarn::{ResponseWeights, WeightTally, YarnResponse};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// What the camera sees of the cloth in one batch, at every geometry: weights of the cells of the f* tables. They depend
/// on the weave, the rig and the axes of the tables alone, so one batch of camera rays shades with the tables of many
/// media. All incidences of a view share its rays, and a view has the same rays whatever else the rig measures.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraBatch {
    wavelengths: usize,
    geometries: Vec<Sight>,
}

/// The cloth at one geometry.
#[derive(Clone, Debug, PartialEq)]
struct Sight {
    cos_i: f64,
    /// Of each of [`Plan::different_yarns`].
    weights: Vec<ResponseWeights>,
}

impl CameraBatch {
    /// Sends the rays of batch number `batch`.
    pub fn trace(plan: &Plan, geometries: &[Geometry], batch: usize) -> Self {
        let mut views: BTreeMap<usize, Vec<(usize, Geometry)>> = BTreeMap::new();
        for (place, geometry) in geometries.iter().enumerate() {
            views.entry(stream_of(*geometry)).or_default().push((place, *geometry));
        }
        let views: Vec<(usize, Vec<(usize, Geometry)>)> = views.into_iter().collect();
        let tallies = || {
            plan.different_yarns()
                .map(|_| WeightTally::new(plan.factor_grid))
                .collect()
        };
        let mut seen: Vec<(usize, Sight)> = views
            .par_iter()
            .map_init(tallies, |tallies: &mut Vec<WeightTally>, (stream, at_view)| {
                see(plan, *stream, at_view, batch, tallies)
            })
            .flatten_iter()
            .collect();
        seen.sort_unstable_by_key(|&(place, ..)| place);
        Self {
            wavelengths: plan.grid.len(),
            geometries: seen.into_iter().map(|(_, sight)| sight).collect(),
        }
    }

    /// Diffuse β at [geometry][wavelength] of yarns that scatter by `responses`, one for each of [`Plan::different_yarns`]: one
    /// batch on the study's grid, at the study's wavelengths.
    pub fn shade(&self, responses: &[YarnResponse]) -> Vec<Vec<f64>> {
        self.geometries
            .par_iter()
            .map(|Sight { cos_i, weights }| {
                let mut beta = vec![0.0; self.wavelengths];
                for (weights, response) in weights.iter().zip(responses) {
                    let of_yarn = weights.contract(response);
                    beta.iter_mut().zip(of_yarn).for_each(|(sum, b)| *sum += b);
                }
                let lost = if fault::active(Fault::SunlitLoss) { 0.97 } else { 1.0 };
                beta.iter_mut()
                    .for_each(|b| *b = brightness_factor(lost * *b, *cos_i).0);
                beta
            })
            .collect()
    }
}

/// Number of a view's random stream: its angle in millionths of a degree.
pub(crate) fn stream_of(geometry: Geometry) -> usize {
    (geometry.theta_v_deg * 1e6).round() as isize as usize
}

/// Weights of one view's geometries in the cloth's mean radiance per irradiance normal to the beam: L = Σ f* E⊥ V over
/// camera rays, nothing behind a gap. Do not multiply by the cosine of the light: f* includes it.
fn see(
    plan: &Plan,
    stream: usize,
    at_view: &[(usize, Geometry)],
    batch: usize,
    tallies: &mut [WeightTally],
) -> Vec<(usize, Sight)> {
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
                let of_yarn = match point.hit.system() {
                    System::Warp => 0,
                    System::Weft => tallies.len() - 1,
                };
                if let Some(light) = point.light(&plan.cloth, &omega_in) {
                    tallies[of_yarn].add(&light, seen);
                }
            }
            let cos_i = geometry.theta_i_deg.to_radians().cos();
            let second = if fault::active(Fault::DoubleCosine) { cos_i } else { 1.0 };
            let weights = tallies.iter_mut().map(|tally| tally.drain(share * second)).collect();
            (place, Sight { cos_i, weights })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::Study;

    #[test]
    fn a_view_has_the_same_rays_whatever_else_the_rig_measures() {
        let mut study = Study::default();
        study.rig.pixels_per_side = 6;
        let plan = Plan::new(study).unwrap();
        let geometry = |theta_i_deg, theta_v_deg| Geometry {
            theta_i_deg,
            theta_v_deg,
        };
        let all = [geometry(30.0, 50.0), geometry(0.0, -20.0), geometry(60.0, 50.0)];
        let together = CameraBatch::trace(&plan, &all, 3);
        for (place, alone) in all.iter().enumerate() {
            let alone = CameraBatch::trace(&plan, std::slice::from_ref(alone), 3);
            assert!(together.geometries[place] == alone.geometries[0], "{place}");
        }
        assert!(together.geometries != CameraBatch::trace(&plan, &all, 4).geometries);
    }

    /// f* = 1 everywhere at one wavelength and 2 at another gives β = π times the part of the cell seen and lit, or somewhat
    /// more where the cosine of the tilt is interpolated, and twice that.
    #[test]
    fn wavelengths_do_not_mix() {
        let plan = Plan::new(Study::default()).unwrap();
        let normal = Geometry {
            theta_i_deg: 0.0,
            theta_v_deg: 0.0,
        };
        let camera = CameraBatch::trace(&plan, &[normal], 0);
        let response = YarnResponse::from_fn(plan.factor_grid, plan.grid.len(), |[.., wavelength]| match wavelength {
            4 => 1.0,
            9 => 2.0,
            _ => 0.0,
        });
        let beta = &camera.shade(&[response])[0];
        // The plain weave at 1.8 diameters covers 0.802 of the cell, 2.52 / π, and what is seen from the light is lit.
        assert!((2.4..2.6).contains(&beta[4]) && beta[9] == 2.0 * beta[4]);
        assert_eq!(beta.iter().filter(|b| **b != 0.0).count(), 2);
    }
}
