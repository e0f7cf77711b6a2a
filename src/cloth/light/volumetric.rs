use super::air::{Air, Caught, History, Queue, Survival};
use super::{Beam, ClothBatch, ClothFraction, Detector, Integrator, LitBatch, LitViews, Scene, YarnSurface};
use crate::cloth::{Cloth, System};
use crate::fault::{self, Fault};
use crate::geometry::Vec3;
use crate::optics::fresnel;
use crate::transport::{Entry, Fraction, Interior, Ledger, Purpose, Shape, Stream, Walk};
use crate::yarn::{Estimator, Sharing, YarnError, YarnResponse};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use std::cell::RefCell;
use std::f64::consts::PI;

/// The yarns of one system as a body for the kernel: a path inside a yarn stays in that yarn until it leaves.
#[derive(Clone, Copy, Debug)]
pub struct Inside<'a> {
    pub cloth: &'a Cloth,
    pub system: System,
}

impl Shape for Inside<'_> {
    const SIDE_BY_SIDE: bool = false;

    fn distance(&self, position: [f64; 3], direction: [f64; 3], limit_mm: f64) -> f64 {
        let distance = self.cloth.inside_distance(self.system, position, direction, limit_mm);
        if distance < limit_mm { distance } else { f64::INFINITY }
    }

    fn surface(&self, position: [f64; 3], _: [f64; 3]) -> [[f64; 3]; 2] {
        let (on_surface, normal) = self.cloth.surface(self.system, position);
        [on_surface, normal]
    }
}

/// Volumetric integrator: traces light through the medium of every yarn it meets, with refraction at each surface and
/// scattering inside, without f*. The kernel is that of a single yarn.
pub struct Volumetric<'a> {
    scene: Scene<'a>,
    /// Groups of wavelengths that share paths, in the media of warp and weft.
    groups: Vec<[Sharing<'a>; 2]>,
    particles: usize,
}

/// Number of random streams of one wavelength in one batch: one for the air, then one for each trace through yarns.
const STREAMS_OF_WAVELENGTH: usize = 1 << 24;

impl<'a> Volumetric<'a> {
    /// `particles`: number per beam and batch.
    ///
    /// # Errors
    /// [`YarnError`] if paths cannot be traced in a medium.
    pub fn new(scene: Scene<'a>, particles: usize) -> Result<Self, YarnError> {
        // Paths cross both media, so if one medium requires independent paths, both get them.
        let shared = (scene.yarns.iter()).all(|yarn| yarn.estimator_in_use() == Estimator::Shared);
        let estimator = if shared {
            Estimator::Shared
        } else {
            Estimator::Independent
        };
        let [warp, weft] = scene.yarns;
        let both = std::iter::zip(warp.sharing_by(estimator)?, weft.sharing_by(estimator)?);
        Ok(Self {
            scene,
            groups: both.map(|(warp, weft)| [warp, weft]).collect(),
            particles,
        })
    }

    /// Traces batch `batch` of a beam at all wavelengths.
    pub fn batch<D: Detector>(&self, beam: &Beam, detector: &D, batch: usize) -> ClothBatch {
        let mut all = ClothBatch {
            ledger: Vec::new(),
            caught: vec![Vec::new(); detector.bins()],
        };
        for group in &self.groups {
            let part = self.of_group(group, beam, detector, batch);
            all.ledger.extend(part.ledger);
            all.caught
                .iter_mut()
                .zip(part.caught)
                .for_each(|(all, more)| all.extend(more));
        }
        all
    }

    fn of_group<D: Detector>(
        &self,
        [warp, weft]: &[Sharing<'_>; 2],
        beam: &Beam,
        detector: &D,
        batch: usize,
    ) -> ClothBatch {
        let Scene {
            cloth, backing, seed, ..
        } = self.scene;
        let (first, wavelengths) = (warp.first, warp.interior.wavelengths());
        let mut stream_number = first * STREAMS_OF_WAVELENGTH;
        let mut next = || {
            stream_number += 1;
            Stream::open(seed, Purpose::Woven, beam.number, batch, stream_number)
        };
        let air = RefCell::new(Air::new(
            cloth,
            backing.map(|values| &values[first..first + wavelengths]),
            detector,
            Caught::All,
            Survival::MeanWeight,
            next(),
            wavelengths,
        ));
        air.borrow_mut().launch_beam(beam, self.particles);
        while !air.borrow().is_empty() {
            for (system, sharing) in [(System::Warp, warp), (System::Weft, weft)] {
                let waiting = air.borrow_mut().take(system);
                self.through(system, &sharing.interior, waiting, &air, next());
            }
            let mut landed = air.borrow_mut().take_landed();
            let rows = landed.weights.chunks_exact_mut(wavelengths);
            for (landing, weights) in landed.arrivals.iter().zip(rows) {
                air.borrow_mut().send_back(landing, weights);
            }
        }
        air.into_inner().batch(self.particles)
    }

    /// Traces the particles waiting at the yarns of a system through these yarns.
    fn through<D: Detector>(
        &self,
        system: System,
        interior: &Interior<'_>,
        waiting: Queue,
        air: &RefCell<Air<'_, D, Xoshiro256PlusPlus>>,
        stream: Xoshiro256PlusPlus,
    ) {
        let wavelengths = interior.wavelengths();
        let walk = Walk {
            shape: &Inside {
                cloth: self.scene.cloth,
                system,
            },
            interior,
            roulette: self.scene.yarns[0].roulette,
        };
        let mut coming = waiting.arrivals.iter().zip(waiting.weights.chunks_exact(wavelengths));
        // Discarded reflections are already in the ledger of the trace.
        let goes_on = self.scene.surface != YarnSurface::Lost;
        let mut reflected = vec![0.0; wavelengths];
        let traced = walk.trace_incident(
            stream,
            &waiting.weights,
            |_| {
                let Some((arrival, weights)) = coming.next() else {
                    return NOWHERE;
                };
                let (normal, omega_in) = (arrival.hit.frame.normal, arrival.omega_in);
                if goes_on {
                    let reflectance = fresnel::reflectance(arrival.cos_in(), interior.index());
                    for (reflected, weight) in reflected.iter_mut().zip(weights) {
                        *reflected = reflectance * f64::from(*weight);
                    }
                    air.borrow_mut().reflect(&self.scene.surface, arrival, &reflected);
                }
                Entry {
                    position: arrival.hit.position,
                    normal,
                    omega_in,
                }
            },
            |exit| {
                let before = waiting.arrivals[exit.path].history;
                let history = History {
                    length_mm: before.length_mm + exit.length_mm,
                    ..History::NONE
                };
                air.borrow_mut()
                    .launch(exit.position, exit.direction, exit.weights, history)
            },
        );
        let ledgers = traced.ledgers.iter();
        let mut air = air.borrow_mut();
        air.keep(
            ClothFraction::Absorbed,
            ledgers.clone().map(|ledger| ledger[Fraction::Absorbed]),
        );
        air.keep(ClothFraction::SamplingNet, ledgers.clone().map(Ledger::sampling_net));
        if !goes_on {
            air.keep(
                ClothFraction::ReflectionDropped,
                ledgers.map(|ledger| ledger[Fraction::Reflected]),
            );
        }
    }
}

/// Placeholder: there are as many entries as paths, so this one is never used.
const NOWHERE: Entry = Entry {
    position: Vec3::new(0.0, 0.0, 0.0),
    normal: Vec3::new(0.0, 0.0, 1.0),
    omega_in: Vec3::new(0.0, 0.0, 1.0),
};

impl Integrator for Volumetric<'_> {
    fn brightness(&self, _: &[YarnResponse], lit: &[LitViews], batch: usize) -> Result<Vec<LitBatch>, YarnError> {
        let of_beam = |LitViews { beam, cones, .. }: &LitViews| {
            let ClothBatch { ledger, mut caught } = self.batch(beam, cones, batch);
            for (k, caught) in caught.iter_mut().enumerate() {
                let lost = if fault::active(Fault::ApertureLoss) { 0.97 } else { 1.0 };
                let factor = lost * PI / cones.projected_solid_angle(k);
                caught.iter_mut().for_each(|c| *c *= factor);
            }
            LitBatch { beta: caught, ledger }
        };
        Ok(lit.par_iter().map(of_beam).collect())
    }
}
