use super::outer_surface::{OuterSurface, Passage, mirrored};
use super::yarn_to_yarn::YarnToYarn;
use super::{Beam, Detector, YarnSurface};
use crate::cloth::Hit;
use crate::geometry::Vec3;
use crate::optics::fresnel::Interface;
use crate::transport::{Purpose, Stream};
use rand::{Rng, RngExt};

/// Light that only smooth interfaces deflect (specular paths). The path is the same at all wavelengths; the weights
/// follow from its lengths in warp and weft when it reaches the detector.
pub(super) struct SpecularPaths<'a> {
    light: &'a YarnToYarn<'a>,
    surfaces: [OuterSurface; 2],
    /// Whether the outer surface reflects specularly; otherwise reflected light is spread by fibres, or lost.
    mirrors: bool,
}

struct Ray {
    position: Vec3,
    direction: Vec3,
    /// Fraction of the light that the outer surfaces left.
    weight: f64,
    length_mm: [f64; 2],
    yarns: usize,
}

impl<'a> SpecularPaths<'a> {
    pub fn new(light: &'a YarnToYarn<'a>) -> Self {
        Self {
            light,
            surfaces: light.surfaces(),
            mirrors: light.scene.surface == YarnSurface::Smooth,
        }
    }

    /// Light scored by `detector`, as a fraction of the beam: `[bin][wavelength]`.
    pub fn caught<D: Detector>(&self, beam: &Beam, detector: &D, batch: usize, particles: usize) -> Vec<Vec<f64>> {
        let light = self.light;
        let mut rng = Stream::open(light.scene.seed, Purpose::Straight, beam.number, batch, 0);
        let mut caught = vec![vec![0.0; light.wavelengths()]; detector.bins()];
        for origin in beam.origins(light.scene.cloth, particles, &mut rng) {
            let direction = -beam.omega_in;
            let Some(hit) = light.scene.cloth.first_hit(origin, direction) else {
                continue;
            };
            let outside = self.surfaces[hit.yarn.system.index()].outside(&hit, &direction);
            let ray = |direction, share: f64| Ray {
                position: hit.position,
                direction,
                weight: share / particles as f64,
                length_mm: [0.0; 2],
                yarns: 1,
            };
            if self.mirrors {
                let mirrored = ray(mirrored(&hit, &direction), outside.reflectance);
                self.follow(mirrored, detector, &mut caught, &mut rng);
            }
            let mut refracted = ray(direction, 1.0 - outside.reflectance);
            if self.through(&mut refracted, &hit, &outside, &mut rng) {
                self.follow(refracted, detector, &mut caught, &mut rng);
            }
        }
        caught
    }

    /// Traces a ray until it leaves the cloth, and scores it. At each surface it is reflected with a probability equal
    /// to the reflectance.
    fn follow<D: Detector>(&self, mut ray: Ray, detector: &D, caught: &mut [Vec<f64>], rng: &mut impl Rng) {
        let light = self.light;
        while let Some(hit) = light.scene.cloth.first_hit(ray.position, ray.direction) {
            if ray.yarns > light.most {
                return;
            }
            ray.yarns += 1;
            ray.position = hit.position;
            let outside = self.surfaces[hit.yarn.system.index()].outside(&hit, &ray.direction);
            if !self.mirrors {
                ray.weight *= 1.0 - outside.reflectance;
            } else if rng.random::<f64>() < outside.reflectance {
                ray.direction = mirrored(&hit, &ray.direction);
                continue;
            }
            if !self.through(&mut ray, &hit, &outside, rng) {
                return;
            }
        }
        detector.find(&ray.direction, 0.0, |bin, share| {
            let [warp, weft] = light.scene.yarns.map(|yarn| yarn.medium.extinction_per_mm());
            for (sum, (warp, weft)) in caught[bin].iter_mut().zip(warp.zip(weft)) {
                let depth = warp * ray.length_mm[0] + weft * ray.length_mm[1];
                *sum += share * ray.weight * (-depth).exp();
            }
        });
    }

    /// Traces a ray through the yarn it meets; false if no light leaves.
    fn through(&self, ray: &mut Ray, hit: &Hit, outside: &Interface, rng: &mut impl Rng) -> bool {
        let k = hit.yarn.system.index();
        let Some(Passage {
            position,
            direction,
            length_mm,
        }) = self.surfaces[k].passage(self.light.scene.cloth, hit, &ray.direction, outside, rng)
        else {
            return false;
        };
        (ray.position, ray.direction) = (position, direction);
        ray.length_mm[k] += length_mm;
        true
    }
}
