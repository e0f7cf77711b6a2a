use super::entrance::Entrance;
use super::flights::{Flights, Lanes3, LanesOf, Mask, Step, refract};
use super::lane_math::LANES;
use super::path::{ENTRY_COORDINATES, Entry, Exit};
use super::plain::Plain;
use super::roulette::Roulette;
use super::spectral::Spectral;
use super::stream::LaneStream;
use super::weights::Weights;
use super::{Interior, Ledger, Shape};
use crate::geometry::Vec3;
use rand_xoshiro::{Xoshiro256PlusPlus, rand_core::Rng};

/// Consecutive paths drawn for the same hero, so that its phase table stays in the first-level cache: at most
/// `RUN_LENGTH_AT_MOST`, and few enough that a batch has at least `ROUNDS` rounds over all heroes.
const RUN_LENGTH_AT_MOST: usize = 16;
const ROUNDS: usize = 8;
/// New paths start once this many lanes are idle: a write to a single lane stalls the vector loads that follow it.
const IDLE: u32 = 2;

/// Totals of a trace. Exits are passed to the sink one by one and are not stored.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Traced {
    /// Sum of the paths' ledgers at each wavelength of the interior, in units of the incident flux of one path.
    pub ledgers: Vec<Ledger>,
    /// Scattering events of all paths together.
    pub scatterings: u64,
}

/// The transport kernel: paths through one body, each for all the wavelengths of its interior.
///
/// A path is drawn for its hero wavelength: free flights from the hero's scattering coefficient, scattering angles from
/// its phase function. Its weight at wavelength λ is the balance heuristic over all heroes (Veach & Guibas 1995; Wilkie
/// et al. 2014), n ρ_λ / Σ_h c_h ρ_h/P_h, times exp(−μ_a L). Here c_h is the number of paths of hero h in a round of n
/// paths, and ρ_λ the product of μ_s e^(−μ_s s) p(θ) along the path. With one wavelength this is an ordinary random
/// walk.
///
/// The light that crosses the body on its first flight is scored as an expected value; the path itself is drawn
/// conditionally on not crossing, an event of probability P_h. At every later hit of the surface from inside, the
/// transmitted part is scored as an expected value and the reflected part continues (all of it under total internal
/// reflection). A path ends only when its weight is 0 or Russian roulette ends it.
#[derive(Clone, Copy, Debug)]
pub struct Walk<'a, S> {
    pub shape: &'a S,
    pub interior: &'a Interior<'a>,
    pub roulette: Roulette,
}

impl<S: Shape> Walk<'_, S> {
    /// Traces `paths` paths, each with an incident flux of 1 at every wavelength, and passes every exit to `sink`.
    /// `entry` maps uniform random numbers in [0, 1) to an entry point and direction; the first number is stratified
    /// over the paths. The ledger closes to rounding.
    pub fn trace(
        &self,
        stream: Xoshiro256PlusPlus,
        paths: usize,
        entry: impl FnMut(&[f64; ENTRY_COORDINATES]) -> Entry,
        sink: impl FnMut(&Exit<'_>),
    ) -> Traced {
        let (mut entry, mut sink) = (entry, sink);
        self.dispatch(
            stream,
            paths,
            Ends {
                incident: None,
                entry: &mut entry,
                sink: &mut sink,
            },
        )
    }

    /// Traces one path for each row of `incident`, which holds the path's incident flux at each wavelength of the
    /// interior. Amounts in the ledger and exits include that flux: they are relative to a flux of 1, not to the path's
    /// own. `entry` is called in the order of the rows.
    pub fn trace_incident(
        &self,
        stream: Xoshiro256PlusPlus,
        incident: &[f32],
        entry: impl FnMut(&[f64; ENTRY_COORDINATES]) -> Entry,
        sink: impl FnMut(&Exit<'_>),
    ) -> Traced {
        let (mut entry, mut sink) = (entry, sink);
        self.dispatch(
            stream,
            incident.len() / self.interior.wavelengths(),
            Ends {
                incident: Some(incident),
                entry: &mut entry,
                sink: &mut sink,
            },
        )
    }

    fn dispatch(&self, stream: Xoshiro256PlusPlus, paths: usize, ends: Ends<'_>) -> Traced {
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("fma")
            {
                // SAFETY: the checks above found every feature the function is compiled for. The call has no other
                // precondition; the function itself is safe code.
                return unsafe { self.trace_avx512(stream, paths, ends) };
            }
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                // SAFETY: as above.
                return unsafe { self.trace_avx2(stream, paths, ends) };
            }
        }
        self.trace_lanes(stream, paths, ends)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,fma")]
    fn trace_avx512(&self, stream: Xoshiro256PlusPlus, paths: usize, ends: Ends<'_>) -> Traced {
        self.trace_lanes(stream, paths, ends)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn trace_avx2(&self, stream: Xoshiro256PlusPlus, paths: usize, ends: Ends<'_>) -> Traced {
        self.trace_lanes(stream, paths, ends)
    }

    /// Compiled once for each instruction set. Results have the same bits on all: the compiler neither contracts nor
    /// reorders floating-point operations.
    #[inline(always)]
    fn trace_lanes(&self, stream: Xoshiro256PlusPlus, paths: usize, ends: Ends<'_>) -> Traced {
        if self.interior.wavelengths() == 1 {
            State::<S, Plain<'_>>::new(self, stream, paths, ends).run()
        } else {
            State::<S, Spectral<'_>>::new(self, stream, paths, ends).run()
        }
    }
}

/// Source of the paths and sink of their exits. Not generic, so that the kernel is compiled once for all tallies.
struct Ends<'a> {
    incident: Option<&'a [f32]>,
    entry: &'a mut dyn FnMut(&[f64; ENTRY_COORDINATES]) -> Entry,
    sink: &'a mut dyn FnMut(&Exit<'_>),
}

/// State of the paths being traced.
struct State<'a, 'e, S, W> {
    walk: &'a Walk<'a, S>,
    ends: Ends<'e>,
    entrance: Entrance,
    /// Index into the heroes of a round, consecutive paths for each hero, and paths of the present hero started so far.
    next_hero: usize,
    run_length: usize,
    paths_in_run: usize,
    flights: Flights,
    weights: W,
    scatterings: u64,
    entries: [Entry; LANES],
    /// Index of each lane's path among all paths.
    numbers: [usize; LANES],
}

impl<'a, 'e, S: Shape, W: Weights<'e>> State<'a, 'e, S, W> {
    #[inline(always)]
    fn new(walk: &'a Walk<'a, S>, mut stream: Xoshiro256PlusPlus, paths: usize, ends: Ends<'e>) -> Self {
        let (lanes, entering) = (LaneStream::open(&mut stream), LaneStream::open(&mut stream));
        let next_hero = (stream.next_u64() % walk.interior.heroes().len() as u64) as usize;
        let nowhere = Entry {
            position: Vec3::zeros(),
            normal: Vec3::z(),
            omega_in: Vec3::z(),
        };
        Self {
            walk,
            entrance: Entrance::new(entering, paths),
            flights: Flights::new(lanes),
            next_hero,
            run_length: (paths / (ROUNDS * walk.interior.heroes().len())).clamp(1, RUN_LENGTH_AT_MOST),
            paths_in_run: 0,
            weights: W::new(walk.interior, ends.incident),
            ends,
            scatterings: 0,
            entries: [nowhere; LANES],
            numbers: [0; LANES],
        }
    }

    #[inline(always)]
    fn run(mut self) -> Traced {
        let Walk { shape, interior, .. } = self.walk;
        let inverse_index = 1.0 / interior.index();
        let mut step = Step::default();
        loop {
            if self.flights.alive.count_ones() + IDLE <= LANES as u32 {
                self.refill();
            }
            if self.flights.alive == 0 {
                break;
            }
            self.flights.fly(*shape, inverse_index, interior.angles(), &mut step);
            self.meet(&step);
            self.flights.turn(&step);
        }
        Traced {
            ledgers: self.weights.ledgers(),
            scatterings: self.scatterings,
        }
    }

    /// Starts paths in idle lanes until every lane is busy or no path is left.
    #[inline(always)]
    fn refill(&mut self) {
        let idle = !self.flights.alive & (Mask::MAX >> (Mask::BITS - LANES as u32));
        for lane in LanesOf(idle) {
            while self.flights.alive & (1 << lane) == 0 {
                if self.entrance.waiting() == 0 {
                    let (shape, interior) = (self.walk.shape, self.walk.interior);
                    self.entrance.fill(shape, interior.index(), &mut self.ends.entry);
                    self.weights.prepare(interior, &self.entrance);
                }
                match self.entrance.next() {
                    Some(place) => self.begin(lane, place),
                    None => return,
                }
            }
        }
    }

    #[inline(always)]
    fn begin(&mut self, lane: usize, place: usize) {
        let interior = self.walk.interior;
        let heroes = interior.heroes();
        let hero = heroes[self.next_hero];
        self.paths_in_run += 1;
        if self.paths_in_run == self.run_length {
            self.paths_in_run = 0;
            self.next_hero = if self.next_hero + 1 == heroes.len() {
                0
            } else {
                self.next_hero + 1
            };
        }
        let of = &self.entrance;
        let reach = self.weights.begin(interior, of, place, lane, hero);
        if of.reflectance[place] >= 1.0 {
            return;
        }
        self.entries[lane] = of.entries[place];
        self.numbers[lane] = of.number[place];
        if of.transmittance[place] > 0.0 {
            (self.ends.sink)(&Exit {
                path: of.number[place],
                position: vector(&of.far_position, place),
                normal: vector(&of.far_normal, place),
                direction: vector(&of.far_direction, place),
                weights: self.weights.crossing(),
                scattered: false,
                length_mm: of.chord_mm[place],
                entry: of.entries[place].position,
                omega_in: of.entries[place].omega_in,
            });
        }
        let flights = &mut self.flights;
        for axis in 0..3 {
            flights.position[axis][lane] = of.position[axis][place];
            flights.direction[axis][lane] = of.direction[axis][place];
        }
        flights.hero[lane] = hero as f64;
        flights.mean_free_path[lane] = interior.mean_free_path()[hero];
        flights.preset[lane] = of.for_flight[place] * reach;
        flights.length[lane] = 0.0;
        flights.scattered[lane] = 0;
        flights.reflections[lane] = 0;
        flights.alive |= Mask::from(reach > 0.0) << lane;
    }

    /// Applies the event of each lane to its weights and passes light that leaves to the sink.
    #[inline(always)]
    fn meet(&mut self, step: &Step) {
        let Walk { interior, roulette, .. } = self.walk;
        self.scatterings += u64::from(step.scattering.count_ones());
        let (flights, sink) = (&self.flights, &mut self.ends.sink);
        let (entries, numbers) = (&self.entries, &self.numbers);
        let tell = |lane: usize, weights: &[f64]| {
            let (normal, direction) = (vector(&step.normal, lane), vector(&flights.direction, lane));
            let outside = refract(
                direction.into(),
                (-normal).into(),
                step.cos_i[lane],
                step.cos_t[lane],
                interior.index(),
            );
            sink(&Exit {
                path: numbers[lane],
                position: vector(&flights.position, lane),
                normal,
                direction: outside.into(),
                weights,
                scattered: flights.scattered[lane] == 1,
                length_mm: flights.length[lane],
                entry: entries[lane].position,
                omega_in: entries[lane].omega_in,
            });
        };
        self.flights.alive = self.weights.meet(interior, roulette, flights, step, tell);
    }
}

#[inline(always)]
fn vector(of: &Lanes3, lane: usize) -> Vec3 {
    Vec3::new(of[0][lane], of[1][lane], of[2][lane])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{Phase, PhaseTable};
    use crate::transport::{Coefficients, Cylinder, Purpose, Stream};

    /// Bits of all exits and ledgers of a trace with one or three wavelengths, run by `trace`: one of the compiled
    /// versions of the kernel.
    fn traced(
        wavelengths: usize,
        trace: impl Fn(&Walk<'_, Cylinder>, Xoshiro256PlusPlus, Ends<'_>) -> Traced,
    ) -> Vec<u64> {
        let phase = Phase::Table(PhaseTable::from_density(91, |c| 0.2 + (1.0 + c).powi(2)).unwrap());
        let coefficients: Vec<Coefficients<'_>> = (0..wavelengths)
            .map(|w| Coefficients {
                mu_s: 20.0 / (1 + w) as f64,
                mu_a: 0.3 * (1 + w) as f64,
                phase: &phase,
            })
            .collect();
        let cylinder = Cylinder::new(0.1).unwrap();
        let walk = Walk {
            shape: &cylinder,
            interior: &Interior::new(1.5, &coefficients).unwrap(),
            roulette: Roulette::default(),
        };
        let mut entry = |[azimuth, ..]: &[f64; ENTRY_COORDINATES]| {
            let position = cylinder.at(*azimuth);
            Entry {
                position,
                normal: cylinder.frame(&position).normal,
                omega_in: Vec3::z(),
            }
        };
        let mut bits = Vec::new();
        let mut sink = |exit: &Exit<'_>| {
            let numbers = exit.position.iter().chain(&exit.direction).chain(exit.weights);
            bits.extend(numbers.map(|x| x.to_bits()));
        };
        let ends = Ends {
            incident: None,
            entry: &mut entry,
            sink: &mut sink,
        };
        let traced = trace(&walk, Stream::open(1, Purpose::Validation, 0, 0, 0), ends);
        let fractions = traced.ledgers.iter().flat_map(Ledger::amounts);
        bits.extend(fractions.map(f64::to_bits));
        bits.push(traced.scatterings);
        bits
    }

    /// Incident weights of 1 reproduce `trace` bit for bit. For other weights the ledger sums to the incident flux at
    /// each wavelength.
    #[test]
    fn incident_weights_are_carried_through() {
        const PATHS: usize = 300;
        for wavelengths in [1, 3] {
            let plain = traced(wavelengths, |walk, stream, Ends { entry, sink, .. }| {
                walk.trace(stream, PATHS, entry, sink)
            });
            let ones = vec![1.0; PATHS * wavelengths];
            let incident = traced(wavelengths, |walk, stream, Ends { entry, sink, .. }| {
                walk.trace_incident(stream, &ones, entry, sink)
            });
            assert!(plain == incident);
            let rows: Vec<f32> = (0..PATHS * wavelengths).map(|i| (i % 7) as f32 * 0.25).collect();
            traced(wavelengths, |walk, stream, Ends { entry, sink, .. }| {
                let traced = walk.trace_incident(stream, &rows, entry, sink);
                for (w, ledger) in traced.ledgers.iter().enumerate() {
                    let came: f32 = rows.iter().skip(w).step_by(wavelengths).sum();
                    let accounted: f64 = ledger.amounts().iter().sum();
                    assert!((accounted - f64::from(came)).abs() < 1e-9, "{accounted} of {came}");
                }
                traced
            });
        }
    }

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        const PATHS: usize = 500;
        for wavelengths in [1, 3] {
            let portable = traced(wavelengths, |walk, stream, ends| walk.trace_lanes(stream, PATHS, ends));
            let detected = traced(wavelengths, |walk, stream, Ends { entry, sink, .. }| {
                walk.trace(stream, PATHS, entry, sink)
            });
            assert!(portable.len() > 500 && portable == detected);
            #[cfg(target_arch = "x86_64")]
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                // SAFETY: the condition above checked the features.
                let avx2 = traced(wavelengths, |walk, stream, ends| unsafe {
                    walk.trace_avx2(stream, PATHS, ends)
                });
                assert!(portable == avx2);
            }
        }
    }
}
