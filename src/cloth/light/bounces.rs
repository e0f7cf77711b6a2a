use super::{Connected, Integrator, LitBatch, LitViews, Scene, Segments, ViewPaths, YarnToYarn};
use crate::cloth::System;
use crate::geometry::Vec3;
use crate::yarn::{YarnError, YarnResponse};
use rayon::prelude::*;
use std::iter::zip;

/// Integrator of interreflections: light that travels from yarn to yarn by their f*. It gives all light at the views
/// except what the first yarn scatters straight to them.
#[derive(Clone, Debug)]
pub struct Bounces<'a> {
    scene: Scene<'a>,
    segments: Segments,
    /// Largest number of yarns met after the first.
    most: usize,
    particles: usize,
    rays: usize,
}

/// Size of the segments of yarn and squares of the backing within which the entry point is ignored, in radii of the
/// thinner yarn. Much smaller than the distance light travels along a yarn, and than the width of light transmitted by
/// yarns.
const SEGMENT_RADII: f64 = 0.125;
const SQUARE_RADII: f64 = 0.25;

/// Upper limit of camera rays per view and batch: each vertex of a ray takes memory for every wavelength.
const MOST_RAYS: usize = 4096;
const CROSSINGS_OF_PLAIN: usize = 4;

impl<'a> Bounces<'a> {
    /// `most`: largest number of yarns after the first; `particles`: per beam and batch; `rays`: per view and batch for
    /// a plain weave.
    pub fn new(scene: Scene<'a>, most: usize, particles: usize, rays: usize) -> Self {
        let radii_mm = scene.yarns.map(|yarn| yarn.cylinder.radius_mm());
        let radius_mm = radii_mm[0].min(radii_mm[1]);
        // Keeps the number of rays per segment of yarn as in a plain weave, so that particles find one equally often.
        let crossings = [System::Warp, System::Weft].map(|system| scene.cloth.yarns(system));
        let cells = (crossings[0] * crossings[1]).div_ceil(CROSSINGS_OF_PLAIN);
        Self {
            scene,
            segments: Segments::new(scene.cloth, SEGMENT_RADII * radius_mm, SQUARE_RADII * radius_mm),
            most,
            particles,
            rays: rays.saturating_mul(cells).min(MOST_RAYS),
        }
    }
}

impl Integrator for Bounces<'_> {
    fn brightness(
        &self,
        responses: &[YarnResponse],
        lit: &[LitViews],
        batch: usize,
    ) -> Result<Vec<LitBatch>, YarnError> {
        let scatter = zip(self.scene.yarns, responses)
            .map(|(yarn, response)| response.sampler(yarn))
            .collect::<Result<Vec<_>, _>>()?;
        let [Some(warp), Some(weft)] = [scatter.first(), scatter.last()] else {
            return Ok(Vec::new());
        };
        let light = YarnToYarn {
            scene: self.scene,
            scatter: [warp, weft],
            most: self.most,
        };
        let mut views: Vec<Vec3> = Vec::new();
        for view in lit.iter().flat_map(|lit| lit.cones.views()) {
            if !views.contains(view) {
                views.push(*view);
            }
        }
        let paths: Vec<ViewPaths> = views
            .par_iter()
            .map(|view| ViewPaths::new(&light, &self.segments, view, direction_number(view), batch, self.rays))
            .collect();
        let between = |LitViews { beam, cones, .. }: &LitViews| {
            let paths_of = |view: &Vec3| zip(&views, &paths).find(|(known, _)| *known == view);
            let connected = Connected {
                segments: &self.segments,
                paths: (cones.views().iter())
                    .filter_map(paths_of)
                    .map(|(_, paths)| paths)
                    .collect(),
                cones,
                sunlit: true,
            };
            let (beta, ledger) = light.between(beam, &connected, batch, self.particles);
            LitBatch { beta, ledger }
        };
        Ok(lit.par_iter().map(between).collect())
    }
}

/// Number of a view, which depends on its direction alone and not on what else the rig measures.
fn direction_number(view: &Vec3) -> usize {
    let [x, y] = [view.x, view.y].map(|c| (c * 1e6).round() as isize as usize & 0xff_ffff);
    x << 24 | y
}
