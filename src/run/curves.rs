use super::Plan;
use crate::colour::ColourSystem;
use crate::compare::{Channels, ColourRatios, CompareError, Geometry, model_colour_ratios};
use crate::geometry::Vec3;
use crate::rig::{omega_in, omega_out};
use crate::transport::Estimate;

/// The cloth's brightness factors, as the virtual rig measures them.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectralCurves {
    pub geometries: Vec<Geometry>,
    /// Diffuse part, `[batch][geometry][wavelength]`. Each batch has its own f* and its own camera rays, so the spread of
    /// the batches holds both errors.
    pub diffuse: Vec<Vec<Vec<f64>>>,
    /// Gloss at each geometry, the same at every wavelength.
    pub gloss: Vec<f64>,
}

impl SpectralCurves {
    /// `diffuse` is `[batch][geometry][wavelength]`.
    pub fn new(plan: &Plan, geometries: Vec<Geometry>, diffuse: Vec<Vec<Vec<f64>>>) -> Self {
        let gloss = geometries.iter().map(|g| gloss(plan, *g)).collect();
        Self {
            geometries,
            diffuse,
            gloss,
        }
    }

    /// Each batch's β in r, g, b and y: `[batch][geometry]`.
    pub fn channels(&self, colour: &ColourSystem, with_gloss: bool) -> Vec<Vec<Channels>> {
        self.diffuse
            .iter()
            .map(|batch| {
                batch
                    .iter()
                    .zip(&self.gloss)
                    .map(|(beta, &gloss)| {
                        let gloss = if with_gloss { gloss } else { 0.0 };
                        let total: Vec<f64> = beta.iter().map(|b| b + gloss).collect();
                        channels(colour, &total)
                    })
                    .collect()
            })
            .collect()
    }

    /// Ratios of the diffuse part at a geometry, such as those of Table 1.
    ///
    /// # Errors
    /// Fewer than two batches, or values that are not finite.
    pub fn diffuse_ratios(&self, colour: &ColourSystem, geometry: usize) -> Result<ColourRatios, CompareError> {
        let batches = self.diffuse.iter().map(|batch| channels(colour, &batch[geometry]));
        model_colour_ratios(&batches.collect::<Vec<_>>())
    }

    /// Mean and standard error of the total β at a geometry and wavelength.
    pub fn estimate(&self, geometry: usize, wavelength: usize) -> Estimate {
        let diffuse = Estimate::from_batches(self.diffuse.iter().map(|b| b[geometry][wavelength]));
        Estimate {
            value: diffuse.value + self.gloss[geometry],
            se: diffuse.se,
        }
    }
}

/// β of one spectrum in r, g, b and luminance y.
pub(super) fn channels(colour: &ColourSystem, beta: &[f64]) -> Channels {
    let xyz = colour.xyz(beta);
    let [r, g, b] = colour.linear_rgb(xyz).0;
    [r, g, b, xyz.y]
}

/// Unit vectors towards light and viewer in the cloth's coordinates.
pub(crate) fn directions(plan: &Plan, geometry: Geometry) -> (Vec3, Vec3) {
    let azimuth_deg = plan.study.cloth.azimuth_deg;
    (
        omega_in(geometry.theta_i_deg, azimuth_deg),
        omega_out(geometry.theta_v_deg, azimuth_deg),
    )
}

/// β of the gloss about the cloth's normal; 0 where the yarns have their own gloss.
pub(crate) fn gloss(plan: &Plan, geometry: Geometry) -> f64 {
    if plan.study.specular.surface.is_of_yarns() {
        return 0.0;
    }
    let (omega_in, omega_out) = directions(plan, geometry);
    plan.specular.brdf(&omega_in, &omega_out).brightness_factor().0
}
