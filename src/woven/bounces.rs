use super::air::{Air, Arrival};
use super::{Beam, ClothBatch, ClothLedger, Detector, ViewCones, YarnSurface};
use crate::cloth::{System, Tubes};
use crate::geometry::Vec3;
use crate::optics::fresnel::{self, Interface};
use crate::shading::FibreGloss;
use crate::transport::{Purpose, Stream};
use crate::yarn::{Yarn, YarnScatter, kept_by_straight_yarn};
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::PI;

/// Light scattered from yarn to yarn by their radiance factors.
///
/// A particle that meets a yarn is, in part, reflected by its surface; the part that crosses without meeting a particle of the
/// medium goes on through the smooth tube, refracted at each side; of the rest, the yarn's f* says how much leaves where on the
/// section and in what direction. What a yarn makes of light is thus that of a beam wider than the yarn, and leaves over the place
/// along the yarn where it came in.
pub struct Bounces<'a> {
    pub tubes: &'a Tubes,
    /// Of warp and weft, with the same wavelengths.
    pub yarns: [&'a Yarn; 2],
    pub scatter: [&'a YarnScatter; 2],
    /// Reflectance, at each wavelength, of a rough plane under the cloth.
    pub backing: Option<&'a [f64]>,
    /// What becomes of light that the yarns reflect on its way in.
    pub surface: YarnSurface,
    /// Yarns that light may go on to after the first it met; what would go on further counts as absorbed.
    pub most: usize,
    pub seed: u64,
}

/// What goes towards one viewer.
struct Seen {
    /// Unit vector.
    towards: Vec3,
    /// Per steradian, at each wavelength, summed over particles.
    flux: Vec<f64>,
}

/// Inner hits that ballistic light is followed for; what has not left by then scatters.
const INNER_HITS: usize = 16;
/// Below this nothing is left to follow.
const NOTHING: f64 = 1e-6;

impl Bounces<'_> {
    /// Batch number `batch` of `particles` particles, whose light `detector` catches as it leaves.
    pub fn batch<D: Detector>(&self, beam: &Beam, detector: &D, batch: usize, particles: usize) -> ClothBatch {
        self.trace(beam, detector, true, &mut [], batch, particles)
    }

    /// What views see of light that was not scattered by the first yarn that the beam met and by no other, and of what that yarn
    /// scatters beyond a straight one: the brightness factor
    /// at [view][wavelength]; and the ledger of all light. Light scattered last, or reflected by fibres, is worked out for each view from
    /// `particles` particles; light that a smooth surface sends on last has no density in direction, and is caught in the cones, from
    /// `straight` times as many.
    pub fn between(
        &self,
        beam: &Beam,
        cones: &ViewCones,
        batch: usize,
        particles: usize,
        straight: usize,
    ) -> (Vec<Vec<f64>>, Vec<ClothLedger>) {
        let wavelengths = self.yarns[0].medium.grid().len();
        let mut views: Vec<Seen> = (cones.views().iter())
            .map(|&towards| Seen {
                towards,
                flux: vec![0.0; wavelengths],
            })
            .collect();
        self.trace(beam, &Nothing, false, &mut views, batch, particles);
        let ClothBatch { caught, ledger } = self.trace(beam, cones, false, &mut [], batch, straight * particles);
        let of_view = |(k, (seen, caught)): (usize, (Seen, Vec<f64>))| {
            let per_flux = PI / (seen.towards.z.abs() * particles as f64);
            let per_caught = PI / cones.projected_solid_angle(k);
            let both = seen.flux.iter().zip(caught);
            both.map(|(flux, caught)| flux * per_flux + caught * per_caught)
                .collect()
        };
        (views.into_iter().zip(caught).enumerate().map(of_view).collect(), ledger)
    }

    /// `views` ask for light that has been to another yarn before.
    fn trace<D: Detector>(
        &self,
        beam: &Beam,
        detector: &D,
        catch_spread: bool,
        views: &mut [Seen],
        batch: usize,
        particles: usize,
    ) -> ClothBatch {
        // Two traces of a batch share no numbers.
        let first = 2 * usize::from(views.is_empty());
        let stream = |number| Stream::open(self.seed, Purpose::Bounces, beam.number, batch, first + number);
        let wavelengths = self.yarns[0].medium.grid().len();
        let mut air = Air::new(self.tubes, self.backing, detector, catch_spread, stream(0), wavelengths);
        let mut rng = stream(1);
        let mut parts = Parts::new(wavelengths);
        air.shine(&beam.omega_in, particles);
        let mut visited = 0;
        while !air.is_empty() {
            // Both before either is followed: what a warp sends to a weft has been to one yarn more.
            let waiting = [System::Warp, System::Weft].map(|system| air.take(system));
            for (waiting, (yarn, scatter)) in waiting.into_iter().zip(self.yarns.into_iter().zip(self.scatter)) {
                for (arrival, weights) in waiting.arrivals.iter().zip(waiting.weights.chunks_exact(wavelengths)) {
                    if visited > self.most {
                        air.keep(weights.iter().map(|w| [f64::from(*w), 0.0]));
                        continue;
                    }
                    let entry = enter(yarn, arrival, weights, &mut parts);
                    if let YarnSurface::Fibres(gloss) = &self.surface {
                        self.show_gloss(gloss, arrival, &parts.out, views);
                    }
                    air.reflect(&self.surface, arrival, &parts.out);
                    self.cross(yarn, arrival, &entry, &mut parts, &mut air);
                    if !arrival.sunlit {
                        self.show(scatter, arrival, &parts.inside, views, &mut rng);
                    } else if !views.is_empty() {
                        // Shading in the sun has the straight yarn's share already.
                        straight_yarn(yarn, arrival, weights, &mut parts.out);
                        for (straight, inside) in parts.out.iter_mut().zip(&parts.inside) {
                            *straight = inside - *straight;
                        }
                        self.show(scatter, arrival, &parts.out, views, &mut rng);
                    }
                    self.scatter(scatter, arrival, &mut parts, &mut air, &mut rng);
                }
            }
            visited += 1;
        }
        air.batch(particles)
    }

    /// Sends on what crosses the yarn of the light inside; leaves in `parts.inside` what does not.
    fn cross<D: Detector>(
        &self,
        yarn: &Yarn,
        arrival: &Arrival,
        entry: &Interface,
        parts: &mut Parts,
        air: &mut Air<'_, D, Xoshiro256PlusPlus>,
    ) {
        let (hit, omega_in) = (&arrival.hit, arrival.omega_in);
        let (medium, index) = (&yarn.medium, middle_index(yarn));
        let mut normal = hit.frame.normal;
        parts.straight.copy_from_slice(&parts.inside);
        let mut position = hit.position;
        let mut direction = refracted(&-omega_in, &normal, arrival.cos_in(), entry.cos_t, 1.0 / index);
        for _ in 0..INNER_HITS {
            let length_mm =
                self.tubes
                    .inside_distance(hit.yarn.system, position.into(), direction.into(), f64::INFINITY);
            if !length_mm.is_finite() {
                return;
            }
            let extinction = medium
                .mu_s_per_mm()
                .iter()
                .zip(medium.mu_a_per_mm())
                .map(|(s, a)| s + a);
            let mut most = 0.0f64;
            for (straight, extinction) in parts.straight.iter_mut().zip(extinction) {
                *straight *= (-extinction * length_mm).exp();
                most = most.max(*straight);
            }
            if most < NOTHING {
                return;
            }
            let (on_surface, outward) = self
                .tubes
                .surface(hit.yarn.system, (position + direction * length_mm).into());
            (position, normal) = (on_surface.into(), outward.into());
            let cos_i = direction.dot(&normal).clamp(0.0, 1.0);
            let surface = fresnel::interface(cos_i, 1.0 / index);
            if surface.reflectance < 1.0 {
                let transmittance = 1.0 - surface.reflectance;
                let rows = parts.inside.iter_mut().zip(&mut parts.straight).zip(&mut parts.out);
                for ((inside, straight), out) in rows {
                    *out = transmittance * *straight;
                    *straight -= *out;
                    *inside -= *out;
                }
                let leaving = refracted(&direction, &-normal, cos_i, surface.cos_t, index);
                air.launch(position, leaving, &parts.out, false);
            }
            direction -= normal * (2.0 * cos_i);
        }
    }

    /// Adds to what the views see of the light that fibres reflect.
    fn show_gloss(&self, gloss: &FibreGloss, arrival: &Arrival, reflected: &[f64], views: &mut [Seen]) {
        let hit = &arrival.hit;
        let omega_in = hit.frame.to_local(&arrival.omega_in);
        for Seen { towards, flux } in views {
            let density = gloss.density(&omega_in, &hit.frame.to_local(towards));
            if density > 0.0 && self.tubes.first_hit(hit.position, *towards).is_none() {
                for (sum, reflected) in flux.iter_mut().zip(reflected) {
                    *sum += density * reflected;
                }
            }
        }
    }

    /// Adds to what the views see of the light inside that is about to leave, at a point of the section drawn for each view among
    /// those that face it.
    fn show(
        &self,
        scatter: &YarnScatter,
        arrival: &Arrival,
        inside: &[f64],
        views: &mut [Seen],
        rng: &mut Xoshiro256PlusPlus,
    ) {
        let hit = &arrival.hit;
        let meeting = scatter.meet(&hit.frame.to_local(&arrival.omega_in));
        for Seen { towards: view, flux } in views {
            let towards = hit.frame.to_local(view);
            let facing = towards.x.atan2(towards.z);
            let (sin, cos) = (facing + PI * (rng.random::<f64>() - 0.5)).sin_cos();
            let normal = Vec3::new(sin, 0.0, cos);
            let outward = hit.frame.to_world(&normal);
            let position: Vec3 = self
                .tubes
                .beside(hit.yarn.system, hit.position.into(), outward.into())
                .into();
            if self.tubes.first_hit(position, *view).is_some() {
                continue;
            }
            let densities = scatter.density(&meeting, &normal, &towards);
            for ((sum, weight), density) in flux.iter_mut().zip(inside).zip(densities) {
                // Evenly over half the way round.
                *sum += PI * weight * density;
            }
        }
    }

    fn scatter<D: Detector>(
        &self,
        scatter: &YarnScatter,
        arrival: &Arrival,
        parts: &mut Parts,
        air: &mut Air<'_, D, Xoshiro256PlusPlus>,
        rng: &mut Xoshiro256PlusPlus,
    ) {
        let hit = &arrival.hit;
        let meeting = scatter.meet(&hit.frame.to_local(&arrival.omega_in));
        let numbers = [rng.random(), rng.random(), rng.random(), rng.random()];
        let Some(leaving) = scatter.draw(&meeting, numbers) else {
            air.keep(parts.inside.iter().map(|inside| [*inside, 0.0]));
            return;
        };
        for ((out, inside), worth) in parts.out.iter_mut().zip(&parts.inside).zip(scatter.worth(&leaving)) {
            *out = inside * worth;
        }
        // The draw is worth the albedo in the mean only.
        let rows = parts.out.iter().zip(&parts.inside).zip(scatter.albedo(&meeting));
        air.keep(rows.map(|((out, inside), albedo)| [inside * (1.0 - albedo), inside * albedo - out]));
        let outward = hit.frame.to_world(&leaving.normal);
        let position = self.tubes.beside(hit.yarn.system, hit.position.into(), outward.into());
        air.launch(
            position.into(),
            hit.frame.to_world(&leaving.direction),
            &parts.out,
            true,
        );
    }
}

/// Weights of one particle at every wavelength: inside and not ballistic, ballistic so far, and on the way out.
struct Parts {
    inside: Vec<f64>,
    straight: Vec<f64>,
    out: Vec<f64>,
}

impl Parts {
    fn new(wavelengths: usize) -> Self {
        Self {
            inside: vec![0.0; wavelengths],
            straight: vec![0.0; wavelengths],
            out: vec![0.0; wavelengths],
        }
    }
}

/// Splits light that meets a yarn: what its surface reflects, `parts.out`, and what goes in, `parts.inside`.
fn enter(yarn: &Yarn, arrival: &Arrival, weights: &[f32], parts: &mut Parts) -> Interface {
    let entry = fresnel::interface(arrival.cos_in(), middle_index(yarn));
    for ((inside, out), weight) in parts.inside.iter_mut().zip(&mut parts.out).zip(weights) {
        *out = entry.reflectance * f64::from(*weight);
        *inside = f64::from(*weight) - *out;
    }
    entry
}

/// Dispersion of the host parts ballistic light of different wavelengths; it goes along the way of the middle one.
fn middle_index(yarn: &Yarn) -> f64 {
    let hosts = yarn.medium.host_index();
    hosts[hosts.len() / 2]
}

/// Of light that meets a straight yarn, what is neither reflected nor ballistic: f* was traced in one. In a bent one
/// surfaces lean towards each other, and light that a straight one lets through is totally reflected and scatters after all.
fn straight_yarn(yarn: &Yarn, arrival: &Arrival, weights: &[f32], inside: &mut [f64]) {
    let index = middle_index(yarn);
    let local = arrival.hit.frame.to_local(&arrival.omega_in);
    let surface = fresnel::interface(local.z.clamp(0.0, 1.0), index);
    for (w, (inside, weight)) in inside.iter_mut().zip(weights).enumerate() {
        *inside = f64::from(*weight) * kept_by_straight_yarn(yarn, w, &surface, local.y / index);
    }
}

/// Catches nothing.
struct Nothing;

impl Detector for Nothing {
    fn bins(&self) -> usize {
        0
    }

    fn find(&self, _: &Vec3, _: impl FnMut(usize, f64)) {}
}

/// Unit direction behind an interface whose `normal` points back to where the light comes from; `ratio` = n_i/n_t.
fn refracted(direction: &Vec3, normal: &Vec3, cos_i: f64, cos_t: f64, ratio: f64) -> Vec3 {
    (direction * ratio + normal * (ratio * cos_i - cos_t)).normalize()
}
