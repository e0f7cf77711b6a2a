use super::{Interaction, PixelSamples, brightness_factor, view_cell};
use crate::cloth::light::{Integrator, LitBatch, LitViews, Scene};
use crate::cloth::{Cloth, System};
use crate::fault::{self, Fault};
use crate::geometry::{Bilinear, Vec3};
use crate::transport::{Purpose, Stream};
use crate::yarn::{ResponseWeights, WeightTally, YarnError, YarnResponse, YarnResponseGrid};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Direct light as in the preprint: L = f* E⊥ V at the ends of camera rays, with V the visibility of the light past
/// other yarns (0 or 1).
#[derive(Clone, Copy, Debug)]
pub struct Direct<'a> {
    cloth: &'a Cloth,
    /// Axes of f*.
    grid: YarnResponseGrid,
    /// Number of different f*: one, or two for warp and weft.
    responses: usize,
    pixels: PixelSamples,
    seed: u64,
}

/// One batch of camera rays: weights of the cells of the f* tables, by beam and view. They depend only on the weave,
/// the rig and the axes of the tables, so one batch can be shaded with the tables of many media.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraBatch {
    /// Weights at `[beam][view]`.
    seen: Vec<Vec<SeenCloth>>,
}

/// The cloth as seen from one view in one beam.
#[derive(Clone, Debug, PartialEq)]
struct SeenCloth {
    cos_i: f64,
    /// Weights for each f*.
    weights: Vec<ResponseWeights>,
}

/// A beam that illuminates a view: index of the beam, index of the view among that beam's views, and the beam.
type LitBy<'a> = (usize, usize, &'a LitViews);

impl<'a> Direct<'a> {
    /// `responses`: number of different f* on `grid`, one, or two for warp and weft.
    pub fn new(scene: &Scene<'a>, responses: usize, grid: YarnResponseGrid, pixels: PixelSamples) -> Self {
        Self {
            cloth: scene.cloth,
            grid,
            responses,
            pixels,
            seed: scene.seed,
        }
    }

    /// Traces the camera rays of batch `batch`. All beams share the rays of a view, and the rays of a view do not
    /// depend on what else is measured.
    pub fn look(&self, lit: &[LitViews], batch: usize) -> CameraBatch {
        let mut views: BTreeMap<usize, Vec<LitBy>> = BTreeMap::new();
        for (beam, lit) in lit.iter().enumerate() {
            for (view, number) in lit.numbers.iter().enumerate() {
                views.entry(*number).or_default().push((beam, view, lit));
            }
        }
        let views: Vec<(usize, Vec<LitBy>)> = views.into_iter().collect();
        let tallies = || -> Vec<WeightTally> { (0..self.responses).map(|_| WeightTally::new(self.grid)).collect() };
        let mut all: Vec<([usize; 2], SeenCloth)> = views
            .par_iter()
            .map_init(tallies, |tallies, (number, lit)| self.see(*number, lit, batch, tallies))
            .flatten_iter()
            .collect();
        all.sort_unstable_by_key(|(place, _)| *place);
        let mut seen: Vec<Vec<SeenCloth>> = lit.iter().map(|_| Vec::new()).collect();
        for ([beam, _], cloth) in all {
            seen[beam].push(cloth);
        }
        CameraBatch { seen }
    }

    /// Weights of one view for the cloth's mean radiance per irradiance normal to each beam. This is the mean over
    /// camera rays; rays through gaps contribute 0. Do not multiply by the cosine of incidence: f* includes it.
    fn see(
        &self,
        number: usize,
        lit: &[LitBy],
        batch: usize,
        tallies: &mut [WeightTally],
    ) -> Vec<([usize; 2], SeenCloth)> {
        let Some(omega_out) = lit.first().map(|(_, view, lit)| lit.cones.views()[*view]) else {
            return Vec::new();
        };
        let mut rng = Stream::open(self.seed, Purpose::Camera, number, batch, 0);
        let exit_grid = self.grid.surface().exit();
        let mut points: Vec<(Interaction, Bilinear)> = Vec::with_capacity(self.pixels.count());
        view_cell(self.cloth, &omega_out, &self.pixels, &mut rng, |interaction| {
            points.extend(interaction.map(|point| (point, exit_grid.bilinear(&point.omega_out_local))));
        });
        let share = 1.0 / self.pixels.count() as f64;
        let in_beam = |&(beam, view, lit): &LitBy| {
            let omega_in: Vec3 = lit.beam.omega_in;
            for (point, seen) in &points {
                let of_yarn = match point.hit.yarn.system {
                    System::Warp => 0,
                    System::Weft => tallies.len() - 1,
                };
                if let Some(light) = point.light(self.cloth, &omega_in) {
                    tallies[of_yarn].add(&light, seen);
                }
            }
            let cos_i = omega_in.z;
            let second = if fault::active(Fault::DoubleCosine) { cos_i } else { 1.0 };
            let weights = tallies.iter_mut().map(|tally| tally.drain(share * second)).collect();
            ([beam, view], SeenCloth { cos_i, weights })
        };
        lit.iter().map(in_beam).collect()
    }
}

impl CameraBatch {
    /// Diffuse β at `[beam][view][wavelength]` for yarns with the given responses; number and grid must be those of
    /// [`Direct`].
    pub fn shade(&self, responses: &[YarnResponse]) -> Vec<Vec<Vec<f64>>> {
        let wavelengths = responses.first().map_or(0, YarnResponse::wavelengths);
        let of_view = |SeenCloth { cos_i, weights }: &SeenCloth| {
            let mut beta = vec![0.0; wavelengths];
            for (weights, response) in weights.iter().zip(responses) {
                let of_yarn = weights.contract(response);
                beta.iter_mut().zip(of_yarn).for_each(|(sum, b)| *sum += b);
            }
            let lost = if fault::active(Fault::SunlitLoss) { 0.97 } else { 1.0 };
            beta.iter_mut()
                .for_each(|b| *b = brightness_factor(lost * *b, *cos_i).0);
            beta
        };
        let of_beam = |views: &Vec<SeenCloth>| views.par_iter().map(of_view).collect();
        self.seen.par_iter().map(of_beam).collect()
    }
}

impl Integrator for Direct<'_> {
    fn brightness(
        &self,
        responses: &[YarnResponse],
        lit: &[LitViews],
        batch: usize,
    ) -> Result<Vec<LitBatch>, YarnError> {
        let shaded = self.look(lit, batch).shade(responses).into_iter();
        let of_beam = |beta| LitBatch {
            beta,
            ledger: Vec::new(),
        };
        Ok(shaded.map(of_beam).collect())
    }
}
