use super::interior::{GROUP, attenuation};
use super::lane_math::{ln, sin_cos_turns, unit};
use super::lattice::Lattice;
use super::stream::LaneStream;
use super::{Interior, Ledger, Shape, TransportError};
use crate::geometry::Vec3;
use crate::optics::fresnel::{self, Interface};
use rand_xoshiro::{Xoshiro256PlusPlus, rand_core::Rng};

/// Paths that fly side by side.
const LANES: usize = 16;

/// Coordinates of a path's point of the lattice that are left for the entry: two of the place, two of the direction.
pub const ENTRY_COORDINATES: usize = 4;
/// Those, the hero's and the first flight's.
const COORDINATES: usize = ENTRY_COORDINATES + 1;

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
/// In place of an infinite flight, so that no product with a coefficient of 0 arises.
const FAR_MM: f64 = 1e300;

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
    /// Traces `paths` paths of light that `entry` lets in (its argument is a point of [0, 1)⁴, evenly spread over the
    /// paths), hands every exit to `sink` and returns the sum of the paths' ledgers at each wavelength. The ledger of one
    /// wavelength alone closes to rounding; of more, in the mean.
    pub fn trace<T: Copy>(
        &self,
        stream: Xoshiro256PlusPlus,
        paths: usize,
        entry: impl FnMut(&[f64; ENTRY_COORDINATES]) -> Entry<T>,
        sink: impl FnMut(&Exit<'_, T>),
    ) -> Vec<Ledger> {
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512vl")
            {
                // SAFETY: the processor has just been found to have every feature the function is compiled for, the only
                // thing asked of its caller; the function itself is safe code.
                return unsafe { self.trace_avx512(stream, paths, entry, sink) };
            }
            if is_x86_feature_detected!("avx2") {
                // SAFETY: as above.
                return unsafe { self.trace_avx2(stream, paths, entry, sink) };
            }
        }
        self.trace_lanes(stream, paths, entry, sink)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl")]
    fn trace_avx512<T: Copy>(
        &self,
        stream: Xoshiro256PlusPlus,
        paths: usize,
        entry: impl FnMut(&[f64; ENTRY_COORDINATES]) -> Entry<T>,
        sink: impl FnMut(&Exit<'_, T>),
    ) -> Vec<Ledger> {
        self.trace_lanes(stream, paths, entry, sink)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn trace_avx2<T: Copy>(
        &self,
        stream: Xoshiro256PlusPlus,
        paths: usize,
        entry: impl FnMut(&[f64; ENTRY_COORDINATES]) -> Entry<T>,
        sink: impl FnMut(&Exit<'_, T>),
    ) -> Vec<Ledger> {
        self.trace_lanes(stream, paths, entry, sink)
    }

    /// Compiled once for each instruction set, always to the same bits: nothing is contracted or reordered.
    #[inline(always)]
    fn trace_lanes<T: Copy>(
        &self,
        mut stream: Xoshiro256PlusPlus,
        paths: usize,
        entry: impl FnMut(&[f64; ENTRY_COORDINATES]) -> Entry<T>,
        sink: impl FnMut(&Exit<'_, T>),
    ) -> Vec<Ledger> {
        let mut state = State::new(self, &mut stream, paths, entry, sink);
        for lane in 0..LANES {
            state.refill(lane);
        }
        let mut step = Step::default();
        while state.active.contains(&true) {
            state.flights.fly(self.shape, 1.0 / self.interior.index(), &mut step);
            state.meet(&step);
            state.flights.turn(&step);
            for lane in 0..LANES {
                if state.ended[lane] {
                    state.refill(lane);
                }
            }
        }
        state.sums.ledgers(self.interior.wavelengths(), state.reflected)
    }
}

/// What one step of every lane found.
#[derive(Default)]
struct Step {
    /// 1 where a particle was met, 0 at the surface; a number, to be as wide as the others.
    scatters: [u64; LANES],
    /// Share that the surface lets out; 0 where a particle was met.
    transmittance: [f64; LANES],
    distance: [f64; LANES],
    normal: [[f64; LANES]; 3],
    cos_i: [f64; LANES],
    cos_t: [f64; LANES],
    for_angle: [f64; LANES],
    for_azimuth: [f64; LANES],
}

/// Sums over paths at every wavelength.
struct Sums {
    ballistic: Vec<[f64; GROUP]>,
    scattered: Vec<[f64; GROUP]>,
    absorbed: Vec<[f64; GROUP]>,
    roulette: Vec<[f64; GROUP]>,
}

impl Sums {
    fn ledgers(&self, wavelengths: usize, reflected: f64) -> Vec<Ledger> {
        let of = |sums: &[[f64; GROUP]], w: usize| sums[w / GROUP][w % GROUP];
        (0..wavelengths)
            .map(|w| Ledger {
                reflected,
                ballistic: of(&self.ballistic, w),
                scattered: of(&self.scattered, w),
                absorbed: of(&self.absorbed, w),
                roulette: of(&self.roulette, w),
            })
            .collect()
    }
}

/// Where the paths under way are, side by side.
struct Flights {
    lanes: LaneStream<LANES>,
    position: [[f64; LANES]; 3],
    direction: [[f64; LANES]; 3],
    cos_theta: [f64; LANES],
    /// 1/μ_s of the hero.
    mean_free_path: [f64; LANES],
    /// The next flight is drawn from `preset` + `drawn` × an even number: the first from the lattice, later ones at random.
    preset: [f64; LANES],
    drawn: [f64; LANES],
    /// In mm: of the path so far, and since the weights were last worked out.
    length: [f64; LANES],
    since: [f64; LANES],
}

impl Flights {
    /// Every lane to its next particle or to the surface.
    #[inline(always)]
    fn fly<S: Shape>(&mut self, shape: &S, inverse_index: f64, step: &mut Step) {
        let mut flight = [0.0; LANES];
        for i in 0..LANES {
            flight[i] = unit(self.lanes.next(i));
        }
        for i in 0..LANES {
            step.for_angle[i] = unit(self.lanes.next(i));
        }
        for i in 0..LANES {
            step.for_azimuth[i] = unit(self.lanes.next(i));
        }
        for i in 0..LANES {
            let random = self.preset[i] + self.drawn[i] * flight[i];
            flight[i] = -ln(1.0 - random) * self.mean_free_path[i];
        }
        for i in 0..LANES {
            let flight = flight[i];
            let p = [self.position[0][i], self.position[1][i], self.position[2][i]];
            let d = [self.direction[0][i], self.direction[1][i], self.direction[2][i]];
            let distance = shape.distance(p, d);
            let scatters = flight < distance;
            let length = if scatters { flight } else { distance };
            let moved = [p[0] + d[0] * length, p[1] + d[1] * length, p[2] + d[2] * length];
            let [on, normal] = shape.surface(moved, d);
            let cos_i = (d[0] * normal[0] + d[1] * normal[1] + d[2] * normal[2])
                .max(0.0)
                .min(1.0);
            let Interface { reflectance, cos_t } = fresnel::interface(cos_i, inverse_index);
            self.position[0][i] = if scatters { moved[0] } else { on[0] };
            self.position[1][i] = if scatters { moved[1] } else { on[1] };
            self.position[2][i] = if scatters { moved[2] } else { on[2] };
            step.normal[0][i] = normal[0];
            step.normal[1][i] = normal[1];
            step.normal[2][i] = normal[2];
            let length = if length < FAR_MM { length } else { FAR_MM };
            self.length[i] += length;
            self.since[i] += length;
            self.preset[i] = 0.0;
            self.drawn[i] = 1.0;
            step.scatters[i] = u64::from(scatters);
            step.distance[i] = distance;
            step.transmittance[i] = if scatters { 0.0 } else { 1.0 - reflectance };
            step.cos_i[i] = cos_i;
            step.cos_t[i] = cos_t;
        }
    }

    /// New directions: mirrored at the surface, turned by a particle.
    #[inline(always)]
    fn turn(&mut self, step: &Step) {
        for i in 0..LANES {
            let d = [self.direction[0][i], self.direction[1][i], self.direction[2][i]];
            let turned = scatter(d, self.cos_theta[i], step.for_azimuth[i]);
            let twice = 2.0 * step.cos_i[i];
            let scatters = step.scatters[i] == 1;
            for axis in 0..3 {
                let mirrored = d[axis] - step.normal[axis][i] * twice;
                self.direction[axis][i] = if scatters { turned[axis] } else { mirrored };
            }
        }
    }
}

/// The paths under way.
struct State<'a, S, T, E, K> {
    walk: &'a Walk<'a, S>,
    entry: E,
    sink: K,
    flights: Flights,
    lattice: Lattice<COORDINATES>,
    /// Paths not yet begun.
    left: usize,
    next_hero: usize,
    reflected: f64,
    sums: Sums,
    /// What Fresnel and roulette have left, the same at every wavelength.
    common: [f64; LANES],
    /// Roulette begins below this weight.
    floor: [f64; LANES],
    hero: [usize; LANES],
    events: [u32; LANES],
    reflections: [u32; LANES],
    scattered: [bool; LANES],
    /// On its first flight.
    first: [bool; LANES],
    active: [bool; LANES],
    ended: [bool; LANES],
    tag: [Option<T>; LANES],
    /// Balance heuristic, up to a factor between evaluations.
    share: Vec<[f64; GROUP]>,
    /// 1/P of each wavelength as a hero.
    inverse_reach: Vec<[f64; GROUP]>,
    /// exp(−μ_a L) at the last evaluation.
    survived: Vec<[f64; GROUP]>,
    weights: Vec<[f64; GROUP]>,
}

impl<'a, S, T, E, K> State<'a, S, T, E, K>
where
    S: Shape,
    T: Copy,
    E: FnMut(&[f64; ENTRY_COORDINATES]) -> Entry<T>,
    K: FnMut(&Exit<'_, T>),
{
    fn new(walk: &'a Walk<'a, S>, stream: &mut Xoshiro256PlusPlus, paths: usize, entry: E, sink: K) -> Self {
        let groups = walk.interior.groups();
        let zeros = || vec![[0.0; GROUP]; groups];
        let per_lane = || vec![[0.0; GROUP]; groups * LANES];
        Self {
            walk,
            entry,
            sink,
            flights: Flights {
                lanes: LaneStream::open(stream),
                position: [[0.0; LANES]; 3],
                direction: [[0.0; LANES], [0.0; LANES], [1.0; LANES]],
                cos_theta: [0.0; LANES],
                mean_free_path: [1.0; LANES],
                preset: [0.0; LANES],
                drawn: [0.0; LANES],
                length: [0.0; LANES],
                since: [0.0; LANES],
            },
            lattice: Lattice::open(stream),
            left: paths,
            next_hero: (stream.next_u64() % walk.interior.wavelengths() as u64) as usize,
            reflected: 0.0,
            sums: Sums {
                ballistic: zeros(),
                scattered: zeros(),
                absorbed: zeros(),
                roulette: zeros(),
            },
            common: [0.0; LANES],
            floor: [0.0; LANES],
            hero: [0; LANES],
            events: [0; LANES],
            reflections: [0; LANES],
            scattered: [false; LANES],
            first: [false; LANES],
            active: [false; LANES],
            ended: [false; LANES],
            tag: [None; LANES],
            share: per_lane(),
            inverse_reach: per_lane(),
            survived: per_lane(),
            weights: zeros(),
        }
    }

    /// Begins the next path in a lane, or puts the lane to rest.
    #[inline(always)]
    fn refill(&mut self, lane: usize) {
        self.ended[lane] = false;
        self.active[lane] = false;
        while self.left > 0 && !self.active[lane] {
            self.left -= 1;
            self.begin(lane);
        }
    }

    #[inline(always)]
    fn begin(&mut self, lane: usize) {
        let Walk {
            shape,
            interior,
            roulette,
        } = self.walk;
        let [for_flight, coordinates @ ..] = self.lattice.next();
        let entry = (self.entry)(&coordinates);
        let hero = self.next_hero;
        self.next_hero = if hero + 1 == interior.wavelengths() {
            0
        } else {
            hero + 1
        };
        let cos_in = entry.normal.dot(&entry.omega_in).clamp(0.0, 1.0);
        let outside = fresnel::interface(cos_in, interior.index());
        self.reflected += outside.reflectance;
        let entering = 1.0 - outside.reflectance;
        if entering <= 0.0 {
            return;
        }
        let direction = refract(
            &-entry.omega_in,
            &entry.normal,
            cos_in,
            outside.cos_t,
            1.0 / interior.index(),
        );
        // Straight through: an expected value.
        let chord = shape.distance(entry.position.into(), direction.into());
        let there = entry.position + direction * chord;
        let [position, normal] = shape.surface(there.into(), direction.into()).map(Vec3::from);
        let cos_i = direction.dot(&normal).clamp(0.0, 1.0);
        let inside = fresnel::interface(cos_i, 1.0 / interior.index());
        let transmittance = if chord < f64::INFINITY {
            1.0 - inside.reflectance
        } else {
            0.0
        };
        let chord = chord.min(FAR_MM);
        let groups = interior.groups();
        let lane_groups = lane * groups..(lane + 1) * groups;
        let inverse_reach = &mut self.inverse_reach[lane_groups.clone()];
        let mut total = 0.0;
        for g in 0..groups {
            let unscattered = attenuation(&interior.mu_s()[g], chord);
            let unabsorbed = attenuation(&interior.mu_a()[g], chord);
            let taken = &interior.taken()[g];
            for i in 0..GROUP {
                let straight = entering * transmittance * unscattered[i];
                let leaving = straight * unabsorbed[i];
                self.weights[g][i] = leaving;
                self.sums.ballistic[g][i] += leaving;
                self.sums.absorbed[g][i] += straight - leaving;
                let reach = (1.0 - transmittance) + transmittance * (1.0 - unscattered[i]);
                inverse_reach[g][i] = if reach > 0.0 { taken[i] / reach } else { 0.0 };
            }
            total += inverse_reach[g].iter().sum::<f64>();
        }
        if transmittance > 0.0 {
            (self.sink)(&Exit {
                position,
                normal,
                direction: refract(&direction, &-normal, cos_i, inside.cos_t, interior.index()),
                weights: &self.weights.as_flattened()[..interior.wavelengths()],
                scattered: false,
                length_mm: chord,
                tag: entry.tag,
            });
        }
        let inverse = inverse_reach[hero / GROUP][hero % GROUP];
        if inverse <= 0.0 {
            return;
        }
        let even = interior.wavelengths() as f64 / total;
        for g in 0..groups {
            for i in 0..GROUP {
                self.share[lane * groups + g][i] = even * interior.taken()[g][i];
                self.survived[lane * groups + g][i] = 1.0;
            }
        }
        for axis in 0..3 {
            self.flights.position[axis][lane] = entry.position[axis];
            self.flights.direction[axis][lane] = direction[axis];
        }
        self.flights.mean_free_path[lane] = 1.0 / interior.mu_s_of(hero);
        self.flights.preset[lane] = for_flight / inverse;
        self.flights.drawn[lane] = 0.0;
        self.flights.length[lane] = 0.0;
        self.flights.since[lane] = 0.0;
        self.common[lane] = entering;
        self.floor[lane] = roulette.threshold * entering;
        self.hero[lane] = hero;
        self.events[lane] = 0;
        self.reflections[lane] = 0;
        self.scattered[lane] = false;
        self.first[lane] = true;
        self.active[lane] = true;
        self.tag[lane] = Some(entry.tag);
    }

    /// Deals with what each lane met: a particle's angle, or light that leaves.
    #[inline(always)]
    fn meet(&mut self, step: &Step) {
        let interior = self.walk.interior;
        let groups = interior.groups();
        let (mut scatterers, mut hits) = ([0; LANES], [0; LANES]);
        let (mut scatterers_count, mut hits_count) = (0, 0);
        for i in 0..LANES {
            scatterers[scatterers_count] = i;
            scatterers_count += usize::from(self.active[i] & (step.scatters[i] == 1));
            hits[hits_count] = i;
            hits_count += usize::from(self.active[i] & (step.scatters[i] == 0));
        }
        for &i in &scatterers[..scatterers_count] {
            let share = &mut self.share[i * groups..(i + 1) * groups];
            self.flights.cos_theta[i] = interior.scatter(self.hero[i], step.for_angle[i], share);
            self.scattered[i] = true;
            self.first[i] = false;
            self.reflections[i] = 0;
            self.events[i] += 1;
            if self.events[i] == EVENTS_AT_MOST {
                let largest = self.evaluate(i);
                self.play_roulette(i, largest, 1.0);
            }
        }
        for &i in &hits[..hits_count] {
            self.events[i] += 1;
            self.reflections[i] += 1;
            if step.distance[i] == f64::INFINITY {
                // Neither a particle nor a surface ahead: what is left is absorbed on the way to infinity.
                self.evaluate(i);
                add(&mut self.sums.absorbed, &self.weights, 1.0);
                self.ended[i] = true;
                continue;
            }
            // What crosses on the first flight has already left.
            let transmittance = if self.first[i] { 0.0 } else { step.transmittance[i] };
            self.first[i] = false;
            if transmittance > 0.0 {
                let largest = self.evaluate(i);
                self.leave(i, step, transmittance);
                self.play_roulette(
                    i,
                    largest * (1.0 - transmittance),
                    (1.0 - transmittance) / transmittance,
                );
            } else if self.events[i] >= EVENTS_AT_MOST || self.reflections[i] >= REFLECTIONS_IN_A_ROW {
                let largest = self.evaluate(i);
                self.play_roulette(i, largest, 1.0);
            }
        }
    }

    /// Works out `weights`, what the path carries at each wavelength, counts what was absorbed since the last time, and
    /// returns the largest weight.
    #[inline(always)]
    fn evaluate(&mut self, lane: usize) -> f64 {
        let interior = self.walk.interior;
        let groups = interior.groups();
        let lane_groups = lane * groups..(lane + 1) * groups;
        let share = &mut self.share[lane_groups.clone()];
        let since = self.flights.since[lane];
        if interior.wavelengths() > 1 {
            let inverse_reach = &self.inverse_reach[lane_groups.clone()];
            let own = interior.mu_s_of(self.hero[lane]);
            let mut total = [0.0; GROUP];
            for g in 0..groups {
                let relative = interior.mu_s()[g].map(|mu_s| mu_s - own);
                let factor = attenuation(&relative, since);
                for i in 0..GROUP {
                    share[g][i] *= factor[i];
                    total[i] += share[g][i] * inverse_reach[g][i];
                }
            }
            let balance = interior.wavelengths() as f64 / total.iter().sum::<f64>();
            for group in share.iter_mut() {
                for i in 0..GROUP {
                    // A wavelength that is out of the race stays out, before its share becomes a slow denormal number.
                    let balanced = group[i] * balance;
                    group[i] = if balanced > 1e-250 { balanced } else { 0.0 };
                }
            }
        }
        let common = self.common[lane];
        let survived = &mut self.survived[lane_groups];
        let mut largest = [0.0f64; GROUP];
        for g in 0..groups {
            let factor = attenuation(&interior.mu_a()[g], since);
            for i in 0..GROUP {
                let carried = common * share[g][i];
                let before = carried * survived[g][i];
                survived[g][i] *= factor[i];
                let weight = carried * survived[g][i];
                self.sums.absorbed[g][i] += before - weight;
                self.weights[g][i] = weight;
                largest[i] = largest[i].max(weight);
            }
        }
        self.flights.since[lane] = 0.0;
        self.events[lane] = 0;
        largest.iter().fold(0.0, |a, &b| a.max(b))
    }

    /// Lets the transmitted part out; `weights` is then what left.
    #[inline(always)]
    fn leave(&mut self, lane: usize, step: &Step, transmittance: f64) {
        let interior = self.walk.interior;
        for group in &mut self.weights {
            group.iter_mut().for_each(|weight| *weight *= transmittance);
        }
        let sum = if self.scattered[lane] {
            &mut self.sums.scattered
        } else {
            &mut self.sums.ballistic
        };
        add(sum, &self.weights, 1.0);
        self.common[lane] *= 1.0 - transmittance;
        let of =
            |components: &[[f64; LANES]; 3]| Vec3::new(components[0][lane], components[1][lane], components[2][lane]);
        let (normal, direction) = (of(&step.normal), of(&self.flights.direction));
        if let Some(tag) = self.tag[lane] {
            (self.sink)(&Exit {
                position: of(&self.flights.position),
                normal,
                direction: refract(
                    &direction,
                    &-normal,
                    step.cos_i[lane],
                    step.cos_t[lane],
                    interior.index(),
                ),
                weights: &self.weights.as_flattened()[..interior.wavelengths()],
                scattered: self.scattered[lane],
                length_mm: self.flights.length[lane],
                tag,
            });
        }
    }

    /// Ends the path or not. It carries `factor` × `weights`, the `largest` of which decides.
    #[inline(always)]
    fn play_roulette(&mut self, lane: usize, largest: f64, factor: f64) {
        if largest <= 0.0 {
            self.ended[lane] = true;
            return;
        }
        if largest >= self.floor[lane] && self.reflections[lane] < REFLECTIONS_IN_A_ROW {
            return;
        }
        self.reflections[lane] = 0;
        let survival = self.walk.roulette.survival;
        if unit(self.flights.lanes.next(lane)) < survival {
            add(&mut self.sums.roulette, &self.weights, factor * (1.0 - 1.0 / survival));
            self.common[lane] /= survival;
        } else {
            add(&mut self.sums.roulette, &self.weights, factor);
            self.ended[lane] = true;
        }
    }
}

#[inline(always)]
fn add(sums: &mut [[f64; GROUP]], weights: &[[f64; GROUP]], factor: f64) {
    for (sum, weight) in sums.iter_mut().zip(weights) {
        for i in 0..GROUP {
            sum[i] += factor * weight[i];
        }
    }
}

/// Direction behind an interface. `normal` points back to the side `direction` comes from; `ratio` = n_i/n_t.
#[inline(always)]
fn refract(direction: &Vec3, normal: &Vec3, cos_i: f64, cos_t: f64, ratio: f64) -> Vec3 {
    (direction * ratio + normal * (ratio * cos_i - cos_t)).normalize()
}

/// Turns a direction by the angle of cosine `cos_theta` to the side at `turns` of a full turn.
#[inline(always)]
fn scatter([dx, dy, dz]: [f64; 3], cos_theta: f64, turns: f64) -> [f64; 3] {
    let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
    let (sin, cos) = sin_cos_turns(turns);
    let (x, y) = (sin_theta * cos, sin_theta * sin);
    // Orthonormal basis without a branch on the direction (Duff et al. 2017).
    let sign = 1.0f64.copysign(dz);
    let a = -1.0 / (sign + dz);
    let b = dx * dy * a;
    let turned = [
        dx * cos_theta + (1.0 + sign * dx * dx * a) * x + b * y,
        dy * cos_theta + sign * b * x + (sign + dy * dy * a) * y,
        dz * cos_theta - sign * dx * x - dy * y,
    ];
    // One Newton step keeps the length at 1 over any number of turns.
    let scale = 1.5 - 0.5 * (turned[0] * turned[0] + turned[1] * turned[1] + turned[2] * turned[2]);
    turned.map(|c| c * scale)
}
