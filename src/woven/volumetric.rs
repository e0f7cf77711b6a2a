use super::air::{Air, Caught, Past, Queue, Survival};
use super::{Beam, ClothBatch, ClothFraction, Detector, YarnSurface};
use crate::cloth::{System, Tubes};
use crate::geometry::Vec3;
use crate::optics::fresnel;
use crate::transport::{Entry, Fraction, Interior, Ledger, Purpose, Roulette, Shape, Stream, Walk};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::cell::RefCell;

/// The yarns of one system as a body: a point in one of them is in it until it leaves that one.
#[derive(Clone, Copy, Debug)]
pub struct Inside<'a> {
    pub tubes: &'a Tubes,
    pub system: System,
}

impl Shape for Inside<'_> {
    const SIDE_BY_SIDE: bool = false;

    fn distance(&self, position: [f64; 3], direction: [f64; 3], limit_mm: f64) -> f64 {
        let distance = self.tubes.inside_distance(self.system, position, direction, limit_mm);
        if distance < limit_mm { distance } else { f64::INFINITY }
    }

    fn surface(&self, position: [f64; 3], _: [f64; 3]) -> [[f64; 3]; 2] {
        let (on_surface, normal) = self.tubes.surface(self.system, position);
        [on_surface, normal]
    }
}

/// Light traced through the medium of every yarn it meets: refraction at each surface, scattering inside, and on to the
/// next yarn, with no f* between. The kernel is that of a single yarn.
#[derive(Clone, Copy, Debug)]
pub struct Volumetric<'a> {
    pub tubes: &'a Tubes,
    /// Media of warp and weft, with the same wavelengths.
    pub interiors: [&'a Interior<'a>; 2],
    /// Reflectance, at each wavelength, of a rough plane under the cloth.
    pub backing: Option<&'a [f64]>,
    pub roulette: Roulette,
    /// What becomes of light that the yarns reflect on its way in.
    pub surface: YarnSurface,
    pub seed: u64,
}

/// Streams of one batch: the air's, then one for each walk.
const STREAMS_OF_WAVELENGTH: usize = 1 << 24;

impl Volumetric<'_> {
    /// Batch number `batch` of `particles` particles. `first` is the number of the first of the interiors' wavelengths in the
    /// study's grid.
    pub fn batch<D: Detector>(
        &self,
        beam: &Beam,
        detector: &D,
        first: usize,
        batch: usize,
        particles: usize,
    ) -> ClothBatch {
        let mut stream_number = first * STREAMS_OF_WAVELENGTH;
        let mut next = || {
            stream_number += 1;
            Stream::open(self.seed, Purpose::Woven, beam.number, batch, stream_number)
        };
        let wavelengths = self.interiors[0].wavelengths();
        let air = RefCell::new(Air::new(
            self.tubes,
            self.backing,
            detector,
            Caught::All,
            Survival::MeanWeight,
            next(),
            wavelengths,
        ));
        air.borrow_mut().shine(beam, particles);
        while !air.borrow().is_empty() {
            for (system, interior) in [System::Warp, System::Weft].into_iter().zip(self.interiors) {
                let waiting = air.borrow_mut().take(system);
                self.through(system, interior, waiting, &air, next());
            }
            let mut landed = air.borrow_mut().take_landed();
            let rows = landed.weights.chunks_exact_mut(wavelengths);
            for (landing, weights) in landed.arrivals.iter().zip(rows) {
                air.borrow_mut().send_back(landing, weights);
            }
        }
        air.into_inner().batch(particles)
    }

    /// Takes what waits at the yarns of a system through them.
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
                tubes: self.tubes,
                system,
            },
            interior,
            roulette: self.roulette,
        };
        let mut coming = waiting.arrivals.iter().zip(waiting.weights.chunks_exact(wavelengths));
        // What is lost the walk's ledger holds.
        let goes_on = self.surface != YarnSurface::Lost;
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
                    air.borrow_mut().reflect(&self.surface, arrival, &reflected);
                }
                Entry {
                    position: arrival.hit.position,
                    normal,
                    omega_in,
                }
            },
            |exit| {
                air.borrow_mut()
                    .launch(exit.position, exit.direction, exit.weights, Past::NONE)
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

/// There are as many entries as paths; this one is never asked for.
const NOWHERE: Entry = Entry {
    position: Vec3::new(0.0, 0.0, 0.0),
    normal: Vec3::new(0.0, 0.0, 1.0),
    omega_in: Vec3::new(0.0, 0.0, 1.0),
};
