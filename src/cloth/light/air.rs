use super::{Beam, ClothBatch, ClothFraction, ClothLedger, Detector, YarnSurface};
use crate::cloth::{Cloth, Hit, System};
use crate::fault::{self, Fault};
use crate::geometry::Vec3;
use rand::{Rng, RngExt};

/// Incidence of light on the outer surface of a yarn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arrival {
    pub hit: Hit,
    /// Unit vector towards the origin of the light.
    pub omega_in: Vec3,
    pub history: History,
}

impl Arrival {
    /// Cosine of the angle of incidence.
    pub fn cos_in(&self) -> f64 {
        self.hit.frame.normal.dot(&self.omega_in).clamp(0.0, 1.0)
    }
}

/// History of light since it entered the cloth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct History {
    /// Number of yarns met so far.
    pub yarns: usize,
    pub spread: Spread,
    /// Path length inside yarns so far, mm, where paths go through media; 0 otherwise.
    pub length_mm: f64,
}

/// The last event that gave light a direction with a density (not a delta).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Spread {
    /// None: only smooth interfaces have deflected the light (specular path).
    Never,
    /// Scattering by a medium or by the backing.
    Scattered,
    /// Reflection by the fibres of a yarn's surface, with no deflection since.
    ByFibres,
    /// Reflection by fibres, then deflection by smooth interfaces.
    ByFibresBefore,
}

impl History {
    pub const NONE: Self = Self {
        yarns: 0,
        spread: Spread::Never,
        length_mm: 0.0,
    };

    /// History after passing one more yarn without scattering, deflected only by its surfaces.
    pub fn through_yarn(self) -> Self {
        let spread = match self.spread {
            Spread::ByFibres => Spread::ByFibresBefore,
            spread => spread,
        };
        Self {
            yarns: self.yarns + 1,
            spread,
            ..self
        }
    }

    /// History after one more yarn, which spread the light.
    pub fn spread_by_yarn(self, spread: Spread) -> Self {
        Self {
            yarns: self.yarns + 1,
            spread,
            ..self
        }
    }
}

/// Selects the light that the detector scores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Caught {
    All,
    /// Only light spread by fibres and then deflected by smooth interfaces. All other light is connected to the views
    /// (next-event estimation) or traced as specular paths.
    TurnedAfterFibres,
}

/// Particles waiting at the yarns of one system, and their weights at every wavelength.
#[derive(Default)]
pub(super) struct Queue {
    pub arrivals: Vec<Arrival>,
    pub weights: Vec<f32>,
}

/// Particles waiting at the backing, and their weights at every wavelength.
#[derive(Default)]
pub(super) struct Landed {
    pub arrivals: Vec<BackingHit>,
    pub weights: Vec<f64>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct BackingHit {
    pub position: Vec3,
    /// Unit vector towards the origin of the light.
    pub omega_in: Vec3,
    pub history: History,
}

/// Survival probability of Russian roulette for a particle that leaves a yarn and meets another, where it is below 1.
/// The particle carries all the light that left in that direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Survival {
    /// Mean of the weights over wavelengths. The expected number of particles never exceeds the number launched, into
    /// however many parts the light of each is split.
    MeanWeight,
    /// Largest of the weights. No weight of a survivor exceeds 1 or its former value. The expected number of particles
    /// is at most the remaining light summed over wavelengths: more particles, but less noise at wavelengths that
    /// travel farther than others. Efficient where every yarn connects light to the views.
    LargestWeight,
}

/// The air between and around the yarns: traces light that leaves a yarn to the next yarn, or out of the cloth.
pub(super) struct Air<'a, D, R> {
    cloth: &'a Cloth,
    /// Reflectance of a Lambertian plane directly under the cloth, at each wavelength.
    backing: Option<&'a [f64]>,
    detector: &'a D,
    rng: R,
    wavelengths: usize,
    queues: [Queue; 2],
    landed: Landed,
    /// Ledger sums over particles, for each wavelength.
    sums: Vec<ClothLedger>,
    catching: Caught,
    survival: Survival,
    caught: Vec<Vec<f64>>,
    light_above: bool,
}

impl<'a, D: Detector, R: Rng> Air<'a, D, R> {
    pub fn new(
        cloth: &'a Cloth,
        backing: Option<&'a [f64]>,
        detector: &'a D,
        catching: Caught,
        survival: Survival,
        rng: R,
        wavelengths: usize,
    ) -> Self {
        Self {
            cloth,
            backing,
            detector,
            rng,
            wavelengths,
            queues: Default::default(),
            landed: Landed::default(),
            sums: vec![ClothLedger::default(); wavelengths],
            catching,
            survival,
            caught: vec![vec![0.0; wavelengths]; detector.bins()],
            light_above: true,
        }
    }

    /// Launches a number of particles of a beam.
    pub fn launch_beam(&mut self, beam: &Beam, particles: usize) {
        let omega_in = beam.omega_in;
        self.light_above = omega_in.z > 0.0;
        for origin in beam.origins(self.cloth, particles, &mut self.rng) {
            match self.cloth.first_hit(origin, -omega_in) {
                Some(hit) => {
                    let arrival = Arrival {
                        hit,
                        omega_in,
                        history: History::NONE,
                    };
                    self.queue(arrival, std::iter::repeat_n(1.0, self.wavelengths));
                }
                None if self.backing.is_some() => {
                    self.land(
                        origin,
                        -omega_in,
                        std::iter::repeat_n(1.0, self.wavelengths),
                        History::NONE,
                    );
                }
                None => self
                    .sums
                    .iter_mut()
                    .for_each(|sums| sums[ClothFraction::ThroughGaps] += 1.0),
            }
        }
    }

    /// Removes and returns the particles waiting at a system's yarns.
    pub fn take(&mut self, system: System) -> Queue {
        std::mem::take(&mut self.queues[system.index()])
    }

    /// Removes and returns the particles waiting at the backing.
    pub fn take_landed(&mut self) -> Landed {
        std::mem::take(&mut self.landed)
    }

    pub fn is_empty(&self) -> bool {
        self.queues.iter().all(|queue| queue.arrivals.is_empty()) && self.landed.arrivals.is_empty()
    }

    /// Traces light that leaves a yarn or the backing to the next yarn, to the backing, or out of the cloth.
    pub fn launch(&mut self, origin: Vec3, direction: Vec3, weights: &[f64], history: History) {
        let Some(hit) = self.cloth.first_hit(origin, direction) else {
            if self.backing.is_some() && (direction.z > 0.0) != self.light_above {
                self.land(origin, direction, weights.iter().copied(), history);
            } else {
                self.escape(&direction, weights, history);
            }
            return;
        };
        let survival = match self.survival {
            Survival::MeanWeight => weights.iter().sum::<f64>() / self.wavelengths as f64,
            Survival::LargestWeight => weights.iter().copied().fold(0.0, f64::max),
        }
        .min(1.0);
        let survives = self.rng.random::<f64>() < survival;
        let worth = if survives { 1.0 / survival } else { 0.0 };
        for (sums, weight) in self.sums.iter_mut().zip(weights) {
            // Rounded to single precision, as the queue stores it.
            let goes_on = if survives {
                f64::from((worth * weight) as f32)
            } else {
                0.0
            };
            sums[ClothFraction::SamplingNet] += weight - goes_on;
        }
        if survives {
            let arrival = Arrival {
                hit,
                omega_in: -direction,
                history,
            };
            self.queue(arrival, weights.iter().map(|weight| (worth * weight) as f32));
        }
    }

    /// Launches the light reflected by a yarn's outer surface; `weights` are those of the reflected light.
    pub fn reflect(&mut self, surface: &YarnSurface, arrival: &Arrival, weights: &[f64]) {
        let Arrival { hit, omega_in, history } = arrival;
        match surface {
            YarnSurface::Lost => self.keep(ClothFraction::ReflectionDropped, weights.iter().copied()),
            YarnSurface::Smooth => {
                let direction = hit.frame.normal * (2.0 * arrival.cos_in()) - omega_in;
                self.launch(hit.position, direction, weights, history.through_yarn());
            }
            YarnSurface::Fibres(gloss) => {
                let numbers = [self.rng.random(), self.rng.random()];
                let local = gloss.draw(&hit.frame.to_local(omega_in), numbers);
                let history = history.spread_by_yarn(Spread::ByFibres);
                self.launch(hit.position, hit.frame.to_world(&local), weights, history);
            }
        }
    }

    /// Adds light to the queue of the backing, a plane at the height of the cloth's lowest points.
    fn land(&mut self, origin: Vec3, direction: Vec3, weights: impl Iterator<Item = f64>, history: History) {
        let height = if self.light_above { -1.0 } else { 1.0 } * self.cloth.top_mm();
        let position = origin + direction * ((height - origin.z) / direction.z).max(0.0);
        self.landed.arrivals.push(BackingHit {
            position,
            omega_in: -direction,
            history,
        });
        self.landed.weights.extend(weights);
    }

    /// Reflects light from the backing, a Lambertian surface; the rest is absorbed. On return `weights` are those of
    /// the reflected light.
    pub fn send_back(&mut self, landing: &BackingHit, weights: &mut [f64]) {
        let reflectance = self.backing.unwrap_or_default().iter();
        for ((weight, sums), reflectance) in weights.iter_mut().zip(&mut self.sums).zip(reflectance) {
            let back = *weight * reflectance;
            sums[ClothFraction::Absorbed] += *weight - back;
            *weight = back;
        }
        let up = if self.light_above { 1.0 } else { -1.0 };
        let (sin2, around): (f64, f64) = (self.rng.random(), self.rng.random::<f64>() * std::f64::consts::TAU);
        let sin = sin2.sqrt();
        let diffuse = Vec3::new(sin * around.cos(), sin * around.sin(), up * (1.0 - sin2).sqrt());
        let history = History {
            spread: Spread::Scattered,
            ..landing.history
        };
        self.launch(landing.position, diffuse, weights, history);
    }

    fn queue(&mut self, arrival: Arrival, weights: impl Iterator<Item = f32>) {
        let queue = &mut self.queues[arrival.hit.yarn.system.index()];
        queue.arrivals.push(arrival);
        queue.weights.extend(weights);
    }

    fn escape(&mut self, direction: &Vec3, weights: &[f64], history: History) {
        let side = if (direction.z > 0.0) == self.light_above {
            ClothFraction::Reflected
        } else {
            ClothFraction::ThroughYarns
        };
        let counted = if fault::active(Fault::ClothLoss) { 0.99 } else { 1.0 };
        for (sums, weight) in self.sums.iter_mut().zip(weights) {
            sums[side] += counted * weight;
        }
        if self.catching == Caught::TurnedAfterFibres && history.spread != Spread::ByFibresBefore {
            return;
        }
        let caught = &mut self.caught;
        self.detector.find(direction, history.length_mm, |bin, share| {
            caught[bin]
                .iter_mut()
                .zip(weights)
                .for_each(|(sum, weight)| *sum += share * weight);
        });
    }

    /// Adds light that is not traced further to a fraction of the ledger, at every wavelength.
    pub fn keep(&mut self, kept: ClothFraction, weights: impl Iterator<Item = f64>) {
        for (sums, weight) in self.sums.iter_mut().zip(weights) {
            sums[kept] += weight;
        }
    }

    /// Results as fractions of a beam of `particles` particles.
    pub fn batch(self, particles: usize) -> ClothBatch {
        let share = 1.0 / particles as f64;
        let ledger = self.sums.iter();
        let ledger = ledger.map(|sums| ClothLedger::new(|fraction| sums[fraction] * share));
        let mut caught = self.caught;
        caught.iter_mut().flatten().for_each(|sum| *sum *= share);
        ClothBatch {
            ledger: ledger.collect(),
            caught,
        }
    }
}
