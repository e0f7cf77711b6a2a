use super::air::{Air, Arrival, BackingHit, Caught, History, Survival};
use super::outer_surface::OuterSurface;
use super::specular::SpecularPaths;
use super::view_paths::{Seen, Segments, ViewPaths};
use super::yarn_to_yarn::{Parts, YarnToYarn};
use super::{Beam, ClothBatch, ClothFraction, ClothLedger, Detector, ViewCones, YarnSurface};
use crate::cloth::System;
use crate::fault::{self, Fault};
use crate::geometry::Vec3;
use crate::shading::FibreGloss;
use crate::transport::{Purpose, Stream};
use crate::yarn::{Meeting, Yarn, YarnSampler, kept_by_straight_yarn};
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::PI;

/// Next-event estimation: connects light travelling from yarn to yarn to the vertices of the views' paths.
pub struct Connected<'a> {
    pub segments: &'a Segments,
    /// Paths of each view.
    pub paths: Vec<&'a ViewPaths>,
    /// Cones about the same views.
    pub cones: &'a ViewCones,
    /// Whether direct shading already includes the light of the beam that a straight yarn scatters straight to a view;
    /// it is then left out here.
    pub sunlit: bool,
}

/// Sums of light towards one view.
struct ViewSum<'a> {
    paths: &'a ViewPaths,
    /// Unit vector towards the view.
    towards: Vec3,
    /// Radiance at each wavelength, summed over particles and rays, in 1/(mm² sr).
    sum: Vec<f64>,
    /// Light reflected by fibres towards the view, as a fraction of the particles' light per steradian, summed over
    /// particles.
    gloss: Vec<f64>,
}

/// Number of specular paths traced for each particle: they cost a tenth of a particle, and few of them reach a
/// detector.
const STRAIGHT: usize = 8;

impl YarnToYarn<'_> {
    /// Traces batch `batch` of `particles` particles; `detector` scores their light as it leaves the cloth.
    pub fn batch<D: Detector>(&self, beam: &Beam, detector: &D, batch: usize, particles: usize) -> ClothBatch {
        self.trace(beam, detector, None, batch, particles)
    }

    /// Brightness factor at `[view][wavelength]` of all light except what the first yarn scatters straight to the view
    /// as a straight yarn would; and the ledger of all light. Scattered light is connected to the vertices of the
    /// view's camera rays, light reflected by fibres to the view at the point of reflection. Light last deflected by a
    /// smooth interface has no density in direction, so it is counted in the cones.
    pub fn between(
        &self,
        beam: &Beam,
        onlookers: &Connected,
        batch: usize,
        particles: usize,
    ) -> (Vec<Vec<f64>>, Vec<ClothLedger>) {
        let Connected {
            segments,
            paths,
            cones,
            sunlit,
        } = onlookers;
        let mut views: Vec<ViewSum> = (paths.iter().zip(cones.views()))
            .map(|(paths, view)| ViewSum {
                paths,
                towards: *view,
                sum: vec![0.0; self.wavelengths()],
                gloss: vec![0.0; self.wavelengths()],
            })
            .collect();
        let watched = Some((*segments, *sunlit, &mut views[..]));
        let ClothBatch { ledger, caught } = self.trace(beam, *cones, watched, batch, particles);
        let straight = self.straight(beam, *cones, batch, particles);
        let cell_mm2 = self.scene.cloth.cell_mm().iter().product::<f64>();
        let of_view = |(k, view): (usize, ViewSum)| -> Vec<f64> {
            let gain = if fault::active(Fault::BetweenGain) { 1.1 } else { 1.0 };
            let per_radiance = gain * PI * cell_mm2 / (view.paths.rays * particles) as f64;
            let per_gloss = PI / (view.towards.z.abs() * particles as f64);
            let per_caught = PI / cones.projected_solid_angle(k);
            let mut beta = self.bare_backing(beam, segments, view.paths);
            for (w, beta) in beta.iter_mut().enumerate() {
                *beta += view.sum[w] * per_radiance + view.gloss[w] * per_gloss;
                *beta += (caught[k][w] + straight[k][w]) * per_caught;
            }
            beta
        };
        (views.into_iter().enumerate().map(of_view).collect(), ledger)
    }

    /// Light scored by `detector` that only smooth interfaces deflect (specular paths), as a fraction of the beam:
    /// `[bin][wavelength]`.
    pub fn straight<D: Detector>(&self, beam: &Beam, detector: &D, batch: usize, particles: usize) -> Vec<Vec<f64>> {
        SpecularPaths::new(self).caught(beam, detector, batch, STRAIGHT * particles)
    }

    /// Brightness factor of the backing where both beam and view reach it without meeting a yarn.
    fn bare_backing(&self, beam: &Beam, segments: &Segments, paths: &ViewPaths) -> Vec<f64> {
        let Some(reflectance) = self.scene.backing else {
            return vec![0.0; self.wavelengths()];
        };
        let lit = |position: Vec3| self.scene.cloth.first_hit(position, beam.omega_in).is_none();
        let bare = paths.bare(segments).filter(|end| lit(end.position)).count();
        let share = bare as f64 / paths.rays as f64;
        reflectance.iter().map(|reflectance| share * reflectance).collect()
    }

    fn trace<D: Detector>(
        &self,
        beam: &Beam,
        detector: &D,
        mut views: Option<(&Segments, bool, &mut [ViewSum])>,
        batch: usize,
        particles: usize,
    ) -> ClothBatch {
        let stream = |number| Stream::open(self.scene.seed, Purpose::Bounces, beam.number, batch, number);
        let wavelengths = self.wavelengths();
        let catching = match views {
            Some(_) => Caught::TurnedAfterFibres,
            None => Caught::All,
        };
        let survival = Survival::LargestWeight;
        let mut air = Air::new(
            self.scene.cloth,
            self.scene.backing,
            detector,
            catching,
            survival,
            stream(0),
            wavelengths,
        );
        let mut rng = stream(1);
        let mut parts = Parts::new(wavelengths);
        let surfaces = self.surfaces();
        air.launch_beam(beam, particles);
        while !air.is_empty() {
            for (k, system) in [System::Warp, System::Weft].into_iter().enumerate() {
                let (yarn, outer, scatter) = (self.scene.yarns[k], &surfaces[k], self.scatter[k]);
                let waiting = air.take(system);
                for (arrival, weights) in waiting.arrivals.iter().zip(waiting.weights.chunks_exact(wavelengths)) {
                    if arrival.history.yarns > self.most {
                        air.keep(ClothFraction::BouncesCut, weights.iter().copied().map(f64::from));
                        continue;
                    }
                    let entry = parts.enter(outer, arrival, weights);
                    if let (YarnSurface::Fibres(gloss), Some((_, _, views))) = (&self.scene.surface, &mut views) {
                        self.show_gloss(gloss, arrival, &parts.out, views);
                    }
                    air.reflect(&self.scene.surface, arrival, &parts.out);
                    self.cross((yarn, outer), arrival, &entry, &mut parts, &mut air, &mut rng);
                    let meeting = scatter.meet(&arrival.hit.frame.to_local(&arrival.omega_in));
                    if let Some((segments, sunlit, views)) = &mut views {
                        if arrival.history == History::NONE {
                            parts.out.fill(0.0);
                            if *sunlit {
                                straight_yarn(yarn, outer, arrival, weights, &mut parts.out);
                            }
                            for (beyond, inside) in parts.out.iter_mut().zip(&parts.inside) {
                                *beyond = inside - *beyond;
                            }
                        }
                        self.show((scatter, &meeting), arrival, &parts, segments, views, &mut rng);
                    }
                    self.scatter((yarn, scatter, &meeting), arrival, &mut parts, &mut air, &mut rng);
                }
            }
            let mut landed = air.take_landed();
            for (landing, weights) in (landed.arrivals.iter()).zip(landed.weights.chunks_exact_mut(wavelengths)) {
                air.send_back(landing, weights);
                if let Some((segments, _, views)) = &mut views {
                    self.show_backing(landing, weights, segments, views, &mut rng);
                }
            }
        }
        air.batch(particles)
    }

    /// Connects light reflected by fibres to the views.
    fn show_gloss(&self, gloss: &FibreGloss, arrival: &Arrival, reflected: &[f64], views: &mut [ViewSum]) {
        let hit = &arrival.hit;
        let omega_in = hit.frame.to_local(&arrival.omega_in);
        for view in views {
            let density = gloss.density(&omega_in, &hit.frame.to_local(&view.towards));
            if density > 0.0 && self.scene.cloth.first_hit(hit.position, view.towards).is_none() {
                for (sum, reflected) in view.gloss.iter_mut().zip(reflected) {
                    *sum += density * reflected;
                }
            }
        }
    }

    /// Connects the light inside a yarn to each view, at one vertex chosen among all those of the view on this segment
    /// of the yarn. For light straight from the beam, direct shading already includes what a straight yarn scatters
    /// straight to the view: `parts.out` is the rest.
    fn show(
        &self,
        (scatter, meeting): (&YarnSampler, &Meeting),
        arrival: &Arrival,
        parts: &Parts,
        segments: &Segments,
        views: &mut [ViewSum],
        rng: &mut Xoshiro256PlusPlus,
    ) {
        let frame = &arrival.hit.frame;
        let place = segments.of_yarn(self.scene.cloth, &arrival.hit);
        let show = |sum: &mut [f64], seen: Option<Seen>, leaving: &[f64]| {
            let Some(Seen { end, weights, of_ends }) = seen else {
                return;
            };
            if arrival.history.yarns.saturating_add(end.yarns) > self.most {
                return;
            }
            let normal = frame.to_local(&end.normal);
            let across = normal.x.hypot(normal.z);
            let normal = Vec3::new(normal.x / across, 0.0, normal.z / across);
            let towards = frame.to_local(&end.towards);
            let radiance = scatter.radiance(meeting, &normal, &towards);
            let share = of_ends * end.per_surface;
            for (((sum, leaving), weight), radiance) in sum.iter_mut().zip(leaving).zip(weights).zip(radiance) {
                *sum += share * f64::from(*weight) * leaving * radiance;
            }
        };
        for ViewSum { paths, sum, .. } in views {
            if arrival.history == History::NONE {
                show(sum, paths.at(place, false, rng.random()), &parts.out);
                show(sum, paths.at(place, true, rng.random()), &parts.inside);
            } else {
                show(sum, paths.at_any(place, rng.random()), &parts.inside);
            }
        }
    }

    /// Connects light reflected by the backing to the views, except where both beam and view reach it without meeting a
    /// yarn.
    fn show_backing(
        &self,
        landing: &BackingHit,
        sent_back: &[f64],
        segments: &Segments,
        views: &mut [ViewSum],
        rng: &mut Xoshiro256PlusPlus,
    ) {
        let place = segments.of_backing(&landing.position);
        for ViewSum { paths, sum, .. } in views {
            let Some(Seen { end, weights, of_ends }) = paths.at_any(place, rng.random()) else {
                continue;
            };
            if landing.history.yarns + end.yarns > self.most.saturating_add(1)
                || (landing.history == History::NONE && end.yarns == 0)
            {
                continue;
            }
            let share = of_ends * end.per_surface / PI;
            for ((sum, sent_back), weight) in sum.iter_mut().zip(sent_back).zip(weights) {
                *sum += share * f64::from(*weight) * sent_back;
            }
        }
    }
}

/// Weights of the light neither reflected nor ballistic in a straight yarn, in which f* was traced. A bent yarn
/// differs: its surfaces are inclined to each other, so light that a straight yarn transmits can be totally reflected
/// and then scattered.
fn straight_yarn(yarn: &Yarn, outer: &OuterSurface, arrival: &Arrival, weights: &[f32], inside: &mut [f64]) {
    let local = arrival.hit.frame.to_local(&arrival.omega_in);
    let surface = outer.outside(&arrival.hit, &-arrival.omega_in);
    for (w, (inside, weight)) in inside.iter_mut().zip(weights).enumerate() {
        *inside = f64::from(*weight) * kept_by_straight_yarn(yarn, w, &surface, local.y / outer.index);
    }
}
