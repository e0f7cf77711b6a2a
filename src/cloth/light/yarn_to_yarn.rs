use super::air::{Air, Arrival, Spread};
use super::outer_surface::{OuterSurface, Passage};
use super::{ClothFraction, Detector, Scene};
use crate::geometry::Vec3;
use crate::optics::fresnel::Interface;
use crate::yarn::{Meeting, Yarn, YarnSampler};
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;

/// Light scattered from yarn to yarn by their responses f*.
///
/// Light that meets a yarn is split three ways. Part is reflected by the outer surface. Part crosses the smooth tube
/// unscattered, refracted at entry and exit. The rest is scattered: the yarn transfer gives the azimuth of exit on the
/// section for the azimuth of entry, and f* gives the exit direction; it leaves at the position along the yarn where it
/// entered.
pub struct YarnToYarn<'a> {
    pub scene: Scene<'a>,
    /// Samplers of warp and weft.
    pub scatter: [&'a YarnSampler; 2],
    /// Largest number of yarns met after the first; light beyond it is cut and recorded in the ledger.
    pub most: usize,
}

impl YarnToYarn<'_> {
    pub(super) fn wavelengths(&self) -> usize {
        self.scene.wavelengths()
    }

    pub(super) fn surfaces(&self) -> [OuterSurface; 2] {
        self.scene.yarns.map(OuterSurface::new)
    }

    /// Launches the light inside that crosses the yarn unscattered; on return `parts.inside` is the rest.
    pub(super) fn cross<D: Detector>(
        &self,
        (yarn, outer): (&Yarn, &OuterSurface),
        arrival: &Arrival,
        entry: &Interface,
        parts: &mut Parts,
        air: &mut Air<'_, D, Xoshiro256PlusPlus>,
        rng: &mut Xoshiro256PlusPlus,
    ) {
        let (hit, direction) = (&arrival.hit, -arrival.omega_in);
        let Some(Passage {
            position,
            direction,
            length_mm,
        }) = outer.passage(self.scene.cloth, hit, &direction, entry, rng)
        else {
            return;
        };
        let extinction = yarn.medium.extinction_per_mm();
        for ((inside, out), extinction) in parts.inside.iter_mut().zip(&mut parts.out).zip(extinction) {
            *out = *inside * (-extinction * length_mm).exp();
            *inside -= *out;
        }
        air.launch(position, direction, &parts.out, arrival.history.through_yarn());
    }

    pub(super) fn scatter<D: Detector>(
        &self,
        (yarn, scatter, meeting): (&Yarn, &YarnSampler, &Meeting),
        arrival: &Arrival,
        parts: &mut Parts,
        air: &mut Air<'_, D, Xoshiro256PlusPlus>,
        rng: &mut Xoshiro256PlusPlus,
    ) {
        let hit = &arrival.hit;
        let numbers = [rng.random(), rng.random(), rng.random()];
        let absorbs = || yarn.medium.mu_a_per_mm().iter().map(|mu_a| *mu_a > 0.0);
        let Some(leaving) = scatter.sample(meeting, numbers) else {
            let inside = || parts.inside.iter().zip(absorbs());
            air.keep(
                ClothFraction::Absorbed,
                inside().map(|(inside, absorbs)| if absorbs { *inside } else { 0.0 }),
            );
            air.keep(
                ClothFraction::BouncesCut,
                inside().map(|(inside, absorbs)| if absorbs { 0.0 } else { *inside }),
            );
            return;
        };
        for ((out, inside), worth) in parts.out.iter_mut().zip(&parts.inside).zip(scatter.worth(&leaving)) {
            *out = inside * worth;
        }
        // The weights after the draw equal the albedo only in the mean. A medium that does not absorb has an albedo of
        // 1, whatever the noise of the table.
        let albedo = scatter.albedo(meeting).iter().zip(absorbs());
        let kept = parts.inside.iter().zip(albedo);
        let kept = kept.map(|(inside, (albedo, absorbs))| if absorbs { inside * (1.0 - albedo) } else { 0.0 });
        air.keep(ClothFraction::Absorbed, kept.clone());
        let light = parts.inside.iter().zip(&parts.out).zip(kept);
        air.keep(
            ClothFraction::SamplingNet,
            light.map(|((inside, out), kept)| inside - kept - out),
        );
        let outward = hit.frame.to_world(&leaving.normal);
        let position = self
            .scene
            .cloth
            .beside(hit.yarn.system, hit.position.into(), outward.into());
        air.launch(
            position.into(),
            hit.frame.to_world(&leaving.direction),
            &parts.out,
            arrival.history.spread_by_yarn(Spread::Scattered),
        );
    }
}

/// Weights of one particle at every wavelength: inside and not ballistic, and leaving.
pub(super) struct Parts {
    pub inside: Vec<f64>,
    pub out: Vec<f64>,
}

impl Parts {
    pub fn new(wavelengths: usize) -> Self {
        Self {
            inside: vec![0.0; wavelengths],
            out: vec![0.0; wavelengths],
        }
    }

    /// Splits light that meets a yarn into the part its surface reflects, `out`, and the part that enters, `inside`.
    pub fn enter(&mut self, outer: &OuterSurface, arrival: &Arrival, weights: &[f32]) -> Interface {
        let entry = outer.outside(&arrival.hit, &-arrival.omega_in);
        for ((inside, out), weight) in self.inside.iter_mut().zip(&mut self.out).zip(weights) {
            *out = entry.reflectance * f64::from(*weight);
            *inside = f64::from(*weight) - *out;
        }
        entry
    }
}

/// A detector without bins.
pub(super) struct Nothing;

impl Detector for Nothing {
    fn bins(&self) -> usize {
        0
    }

    fn find(&self, _: &Vec3, _: f64, _: impl FnMut(usize, f64)) {}
}
