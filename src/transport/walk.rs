use super::angles::Angle;
use super::entrance::Entrance;
use super::flights::{Flights, LANES, Lanes3, Step, refract};
use super::spectral::Spectral;
use super::stream::LaneStream;
use super::{Interior, Ledger, Shape, TransportError};
use crate::geometry::Vec3;
use rand_xoshiro::{Xoshiro256PlusPlus, rand_core::Rng};

/// Even numbers that an entry is made of. The first is stratified over the paths of a batch.
pub const ENTRY_COORDINATES: usize = 4;

/// Unbiased end of a path: below `threshold` of the weight it entered with, at every wavelength, a path survives with
/// probability `survival` and is then worth 1/`survival` times as much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roulette {
    threshold: f64,
    survival: f64,
}

impl Roulette {
    pub fn new(threshold: f64, survival: f64) -> Result<Self, TransportError> {
        for (quantity, found, top) in [
            ("roulette threshold", threshold, 1.0),
            ("roulette survival", survival, 1.0),
        ] {
            if !(found > 0.0 && found < top) {
                return Err(TransportError::Domain {
                    quantity,
                    expected: "a fraction between 0 and 1, exclusive",
                    found,
                    remedy: "take the default by leaving it out of [trace]",
                });
            }
        }
        Ok(Self { threshold, survival })
    }
}

impl Default for Roulette {
    fn default() -> Self {
        Self {
            threshold: 0.1,
            survival: 0.2,
        }
    }
}

/// Reflections in a row, with no particle between them, after which roulette is played whatever the weight. Light that
/// entered at a grazing angle, or that total reflection traps in a body that hardly scatters, loses next to nothing in
/// each and would go round without end.
const REFLECTIONS_IN_A_ROW: u32 = 10_000;
/// Events after which the weights are worked out even if nothing leaves, so that products stay within range and trapped
/// light meets roulette.
const EVENTS_AT_MOST: u32 = 32;
/// Paths in a row with the same hero, whose phase table then stays in the nearest cache: at most this many, and few enough
/// for every hero to have so many turns in a batch.
const PATHS_OF_A_HERO: usize = 16;
const TURNS_OF_A_HERO: usize = 8;

/// Where and whence light meets the body.
#[derive(Clone, Copy, Debug)]
pub struct Entry<T> {
    pub position: Vec3,
    /// Outward unit normal.
    pub normal: Vec3,
    /// Unit vector towards the light, above the surface.
    pub omega_in: Vec3,
    /// Handed on to every exit of the path.
    pub tag: T,
}

/// A part of a path's light that leaves the body.
#[derive(Clone, Copy, Debug)]
pub struct Exit<'w, T> {
    pub position: Vec3,
    /// Outward unit normal.
    pub normal: Vec3,
    /// Unit direction outside, away from the body.
    pub direction: Vec3,
    /// Fraction of the path's incident flux at each wavelength of the interior.
    pub weights: &'w [f64],
    /// Whether it met a particle; if not it is ballistic, and its direction a delta.
    pub scattered: bool,
    /// Length of the path inside, mm.
    pub length_mm: f64,
    pub tag: T,
}

/// The transport kernel: paths through one body, each for all the wavelengths of its interior.
///
/// A path is drawn for one of them, its hero: flights from the hero's scattering coefficient, angles from its phase
/// function. What it is worth at wavelength λ is the balance heuristic over all heroes (Veach & Guibas 1995; Wilkie et al.
/// 2014): n ρ_λ / Σ_h ρ_h/P_h, with ρ_λ the product of μ_s e^(−μ_s s) p(θ) along the path, times exp(−μ_a L). With one
/// wavelength this is the plain walk. The light that crosses the body on its first flight leaves as an expected value and
/// the path is drawn under the condition, of probability P_h, that it does something else; at every later inner hit
/// the transmitted part leaves as an expected value and the rest flies on, total internal reflection included.
/// Nothing ends a path but an empty weight and roulette.
#[derive(Clone, Copy, Debug)]
pub struct Walk<'a, S> {
    pub shape: &'a S,
    pub interior: &'a Interior<'a>,
    pub roulette: Roulette,
}

impl<S: Shape> Walk<'_, S> {
    /// Traces `paths` paths of light that `entry` lets in (from numbers even in [0, 1), the first of them stratified
    /// over the paths), hands every exit to `sink` and returns the sum of the paths' ledgers at each wavelength. The ledger of one
    /// wavelength alone closes to rounding; of more, in the mean.
    pub fn trace<T: Copy>(
        &self,
        stream: Xoshiro256PlusPlus,
        paths: usize,
        entry: impl FnMut(&[f64; ENTRY_COORDINATES]) -> Entry<T>,
        sink: impl FnMut(&Exit<'_, T>),
    ) -> Vec<Ledger> {
        let (mut entry, mut sink) = (entry, sink);
        let ends: Ends<'_, T> = Ends {
            entry: &mut entry,
            sink: &mut sink,
        };
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("fma")
            {
                // SAFETY: the processor has just been found to have every feature the function is compiled for, the only
                // thing asked of its caller; the function itself is safe code.
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
    fn trace_avx512<T: Copy>(&self, stream: Xoshiro256PlusPlus, paths: usize, ends: Ends<'_, T>) -> Vec<Ledger> {
        self.trace_lanes(stream, paths, ends)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn trace_avx2<T: Copy>(&self, stream: Xoshiro256PlusPlus, paths: usize, ends: Ends<'_, T>) -> Vec<Ledger> {
        self.trace_lanes(stream, paths, ends)
    }

    /// Compiled once for each instruction set, always to the same bits: nothing is contracted or reordered.
    #[inline(always)]
    fn trace_lanes<T: Copy>(&self, stream: Xoshiro256PlusPlus, paths: usize, ends: Ends<'_, T>) -> Vec<Ledger> {
        let mut state = State::new(self, stream, paths, ends);
        let mut step = Step::default();
        while state.refill() {
            state.flights.fly(self.shape, 1.0 / self.interior.index(), &mut step);
            state.meet(&step);
            state.flights.turn(&step);
        }
        state.spectral.ledgers(state.reflected)
    }
}

/// Where paths come from and where their exits go. Not generic, so that the kernel is compiled once for all tallies.
struct Ends<'a, T> {
    entry: &'a mut dyn FnMut(&[f64; ENTRY_COORDINATES]) -> Entry<T>,
    sink: &'a mut dyn FnMut(&Exit<'_, T>),
}

/// The paths under way.
struct State<'a, 'e, S, T> {
    walk: &'a Walk<'a, S>,
    ends: Ends<'e, T>,
    entrance: Entrance<T>,
    /// Heroes take turns.
    next_hero: usize,
    paths_of_a_hero: usize,
    hero_paths: usize,
    flights: Flights,
    spectral: Spectral,
    reflected: f64,
    /// What Fresnel and roulette have left, the same at every wavelength.
    common: [f64; LANES],
    /// Roulette begins below this weight.
    floor: [f64; LANES],
    hero: [usize; LANES],
    /// Since the weights were last worked out, and since the last particle.
    events: [u32; LANES],
    reflections: [u32; LANES],
    scattered: [bool; LANES],
    /// On its first flight.
    first: [bool; LANES],
    active: [bool; LANES],
    tag: [Option<T>; LANES],
}

impl<'a, 'e, S: Shape, T: Copy> State<'a, 'e, S, T> {
    fn new(walk: &'a Walk<'a, S>, mut stream: Xoshiro256PlusPlus, paths: usize, ends: Ends<'e, T>) -> Self {
        let lanes = LaneStream::open(&mut stream);
        let next_hero = (stream.next_u64() % walk.interior.wavelengths() as u64) as usize;
        Self {
            walk,
            ends,
            entrance: Entrance::new(stream, paths),
            flights: Flights::new(lanes),
            next_hero,
            paths_of_a_hero: (paths / (TURNS_OF_A_HERO * walk.interior.wavelengths())).clamp(1, PATHS_OF_A_HERO),
            hero_paths: 0,
            spectral: Spectral::new(walk.interior),
            reflected: 0.0,
            common: [0.0; LANES],
            floor: [0.0; LANES],
            hero: [0; LANES],
            events: [0; LANES],
            reflections: [0; LANES],
            scattered: [false; LANES],
            first: [false; LANES],
            active: [false; LANES],
            tag: [None; LANES],
        }
    }

    /// Begins paths in the lanes that have none. False once no lane has any.
    #[inline(always)]
    fn refill(&mut self) -> bool {
        let (idle, count) = chosen(|lane| !self.active[lane]);
        for &lane in &idle[..count] {
            while !self.active[lane] {
                let (shape, index) = (self.walk.shape, self.walk.interior.index());
                let place = self.entrance.next(shape, index, &mut self.ends.entry);
                match place {
                    Some(place) => self.begin(lane, place),
                    None => break,
                }
            }
        }
        self.active.contains(&true)
    }

    #[inline(always)]
    fn begin(&mut self, lane: usize, place: usize) {
        let interior = self.walk.interior;
        let hero = self.next_hero;
        self.hero_paths += 1;
        if self.hero_paths == self.paths_of_a_hero {
            self.hero_paths = 0;
            self.next_hero = if hero + 1 == interior.wavelengths() {
                0
            } else {
                hero + 1
            };
        }
        let of = &self.entrance;
        self.reflected += of.reflectance[place];
        let entering = 1.0 - of.reflectance[place];
        let Some(tag) = of.tag[place] else {
            return;
        };
        if entering <= 0.0 {
            return;
        }
        let transmittance = of.transmittance[place];
        let chord_mm = of.chord_mm[place];
        let inverse_reach = self
            .spectral
            .begin(interior, lane, hero, entering, transmittance, chord_mm);
        if transmittance > 0.0 {
            (self.ends.sink)(&Exit {
                position: vector(&of.far_position, place),
                normal: vector(&of.far_normal, place),
                direction: vector(&of.far_direction, place),
                weights: self.spectral.weights(),
                scattered: false,
                length_mm: chord_mm,
                tag,
            });
        }
        let flights = &mut self.flights;
        for axis in 0..3 {
            flights.position[axis][lane] = of.position[axis][place];
            flights.direction[axis][lane] = of.direction[axis][place];
        }
        flights.mean_free_path[lane] = 1.0 / interior.mu_s()[hero];
        flights.preset[lane] = of.for_flight[place] / inverse_reach;
        flights.drawn[lane] = 0.0;
        flights.length[lane] = 0.0;
        flights.since[lane] = 0.0;
        self.common[lane] = entering;
        self.floor[lane] = self.walk.roulette.threshold * entering;
        self.hero[lane] = hero;
        self.events[lane] = 0;
        self.reflections[lane] = 0;
        self.scattered[lane] = false;
        self.first[lane] = true;
        self.active[lane] = inverse_reach > 0.0;
        self.tag[lane] = Some(tag);
    }

    /// Deals with what each lane met: a particle's angle, or light that leaves.
    #[inline(always)]
    fn meet(&mut self, step: &Step) {
        let interior = self.walk.interior;
        let (scatterers, count) = chosen(|lane| self.active[lane] & (step.scatters[lane] == 1));
        let mut angles = [Angle::default(); LANES];
        for &lane in &scatterers[..count] {
            angles[lane] = interior.angles().draw(self.hero[lane], step.for_angle[lane]);
            self.flights.cos_theta[lane] = angles[lane].cos_theta;
            self.scattered[lane] = true;
            self.reflections[lane] = 0;
        }
        for &lane in &scatterers[..count] {
            self.spectral.scatter(interior, lane, &angles[lane]);
        }
        for lane in 0..LANES {
            self.events[lane] += 1;
            self.reflections[lane] += u32::from(step.scatters[lane] == 0);
        }
        // What crosses on the first flight has already left.
        let (leaving, count) = chosen(|lane| {
            self.active[lane]
                & (step.scatters[lane] == 0)
                & (step.transmittance[lane] > 0.0)
                & (step.distance[lane] < f64::INFINITY)
                & !self.first[lane]
        });
        for &lane in &leaving[..count] {
            let transmittance = step.transmittance[lane];
            let largest = self.evaluate(lane);
            self.spectral.leave(transmittance, self.scattered[lane]);
            self.common[lane] *= 1.0 - transmittance;
            self.tell(lane, step);
            let kept = (1.0 - transmittance) / transmittance;
            self.play_roulette(lane, step, largest * (1.0 - transmittance), kept);
        }
        let (overdue, count) = chosen(|lane| {
            self.active[lane]
                & ((self.events[lane] >= EVENTS_AT_MOST)
                    | (self.reflections[lane] >= REFLECTIONS_IN_A_ROW)
                    | ((step.scatters[lane] == 0) & (step.distance[lane] == f64::INFINITY)))
        });
        for &lane in &overdue[..count] {
            let largest = self.evaluate(lane);
            if step.scatters[lane] == 0 && step.distance[lane] == f64::INFINITY {
                // Neither a particle nor a surface ahead: what is left is absorbed on the way to infinity.
                self.spectral.absorb();
                self.active[lane] = false;
            } else {
                self.play_roulette(lane, step, largest, 1.0);
            }
        }
        for lane in 0..LANES {
            self.first[lane] = false;
        }
    }

    #[inline(always)]
    fn evaluate(&mut self, lane: usize) -> f64 {
        let since = self.flights.since[lane];
        self.flights.since[lane] = 0.0;
        self.events[lane] = 0;
        let interior = self.walk.interior;
        self.spectral
            .evaluate(interior, lane, self.hero[lane], self.common[lane], since)
    }

    /// Tells the sink of light that leaves.
    #[inline(always)]
    fn tell(&mut self, lane: usize, step: &Step) {
        let Some(tag) = self.tag[lane] else {
            return;
        };
        let (normal, direction) = (vector(&step.normal, lane), vector(&self.flights.direction, lane));
        let outside = refract(
            direction.into(),
            (-normal).into(),
            step.cos_i[lane],
            step.cos_t[lane],
            self.walk.interior.index(),
        );
        (self.ends.sink)(&Exit {
            position: vector(&self.flights.position, lane),
            normal,
            direction: outside.into(),
            weights: self.spectral.weights(),
            scattered: self.scattered[lane],
            length_mm: self.flights.length[lane],
            tag,
        });
    }

    /// Ends the path or not. It carries `factor` × the weights, the `largest` of which decides.
    #[inline(always)]
    fn play_roulette(&mut self, lane: usize, step: &Step, largest: f64, factor: f64) {
        let Roulette { survival, .. } = self.walk.roulette;
        let plays = (largest < self.floor[lane]) | (self.reflections[lane] >= REFLECTIONS_IN_A_ROW);
        let survives = step.for_roulette[lane] < survival;
        let worth = if survives { 1.0 / survival } else { 0.0 };
        let worth = if plays { worth } else { 1.0 };
        self.spectral.take(factor * (1.0 - worth));
        self.common[lane] *= worth;
        self.reflections[lane] = if plays { 0 } else { self.reflections[lane] };
        self.active[lane] = worth * largest > 0.0;
    }
}

/// The lanes of which something holds, without a branch on it.
#[inline(always)]
fn chosen(holds: impl Fn(usize) -> bool) -> ([usize; LANES], usize) {
    let (mut lanes, mut count) = ([0; LANES], 0);
    for lane in 0..LANES {
        lanes[count] = lane;
        count += usize::from(holds(lane));
    }
    (lanes, count)
}

#[inline(always)]
fn vector(of: &Lanes3, lane: usize) -> Vec3 {
    Vec3::new(of[0][lane], of[1][lane], of[2][lane])
}
