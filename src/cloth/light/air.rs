use super::{Beam, ClothBatch, ClothFraction, ClothLedger, Detector, YarnSurface};
use crate::cloth::{Cloth, Hit, System};
use crate::fault::{self, Fault};
use crate::geometry::Vec3;
use rand::{Rng, RngExt};

/// Light on its way to a yarn that it has met.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arrival {
    pub hit: Hit,
    /// Unit vector towards where it comes from.
    pub omega_in: Vec3,
    pub history: History,
}

impl Arrival {
    /// Cosine of the angle of incidence.
    pub fn cos_in(&self) -> f64 {
        self.hit.frame.normal.dot(&self.omega_in).clamp(0.0, 1.0)
    }
}

/// What light has been through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct History {
    /// Yarns it has met.
    pub yarns: usize,
    pub spread: Spread,
}

/// What last gave light a direction that had a density.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Spread {
    /// Nothing: smooth surfaces alone have turned it.
    Never,
    /// Particles of a medium, or the backing.
    Scattered,
    /// The fibres of a yarn's surface, and nothing has turned it since.
    ByFibres,
    /// Fibres, and surfaces since.
    ByFibresBefore,
}

impl History {
    pub const NONE: Self = Self {
        yarns: 0,
        spread: Spread::Never,
    };

    /// After one more yarn, through whose surfaces alone it went on.
    pub fn through_yarn(self) -> Self {
        let spread = match self.spread {
            Spread::ByFibres => Spread::ByFibresBefore,
            spread => spread,
        };
        Self {
            yarns: self.yarns + 1,
            spread,
        }
    }

    /// After one more yarn that spread it.
    pub fn spread_by_yarn(self, spread: Spread) -> Self {
        Self {
            yarns: self.yarns + 1,
            spread,
        }
    }
}

/// Which light the detector is to catch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Caught {
    All,
    /// What fibres have spread and surfaces turned since: all else is shown to views, or is followed as rays.
    TurnedAfterFibres,
}

/// Particles that wait at the yarns of one system, and what each carries at every wavelength.
#[derive(Default)]
pub(super) struct Queue {
    pub arrivals: Vec<Arrival>,
    pub weights: Vec<f32>,
}

/// Particles that wait at the backing.
#[derive(Default)]
pub(super) struct Landed {
    pub arrivals: Vec<BackingHit>,
    pub weights: Vec<f64>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct BackingHit {
    pub position: Vec3,
    /// Unit vector towards where it comes from.
    pub omega_in: Vec3,
    pub history: History,
}

/// With what probability one particle goes on for all of the light that leaves a yarn one way and meets another, if it is below 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Survival {
    /// The mean of its weights over the wavelengths: at most as many particles are then under way as came in, however many parts
    /// the light of each is split into.
    MeanWeight,
    /// The largest of them: no weight of one that goes on is above 1, or above what it was. As each weighs 1 at one wavelength, at most as many are
    /// under way as what is left of the light at all wavelengths adds up to. More particles for less noise of a wavelength that
    /// goes farther than others; worth it where light is shown to views at every yarn.
    LargestWeight,
}

/// The air between and around the yarns: takes light that leaves a yarn to the next, or out of the cloth.
pub(super) struct Air<'a, D, R> {
    cloth: &'a Cloth,
    /// Reflectance of a perfectly rough plane right under the cloth, at each wavelength.
    backing: Option<&'a [f64]>,
    detector: &'a D,
    rng: R,
    wavelengths: usize,
    queues: [Queue; 2],
    landed: Landed,
    /// Sums over particles, by wavelength.
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

    /// Sends so many particles of a beam.
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

    /// Those that wait at a system's yarns, who then no longer wait.
    pub fn take(&mut self, system: System) -> Queue {
        std::mem::take(&mut self.queues[system.index()])
    }

    /// Those that wait at the backing, who then no longer wait.
    pub fn take_landed(&mut self) -> Landed {
        std::mem::take(&mut self.landed)
    }

    pub fn is_empty(&self) -> bool {
        self.queues.iter().all(|queue| queue.arrivals.is_empty()) && self.landed.arrivals.is_empty()
    }

    /// Follows light that leaves a yarn, or the backing.
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
            // As it will be read back.
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

    /// Sends on what the surface of a yarn reflects, `weights`, of light that met it.
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

    /// The backing lies at the height of the cloth's lowest points.
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

    /// Sends light back from the backing, a perfect diffuser of its reflectance; the rest is absorbed. Leaves in `weights` what it
    /// sends back.
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
        self.detector.find(direction, |bin, share| {
            caught[bin]
                .iter_mut()
                .zip(weights)
                .for_each(|(sum, weight)| *sum += share * weight);
        });
    }

    /// Counts light that is followed no further, at every wavelength.
    pub fn keep(&mut self, kept: ClothFraction, weights: impl Iterator<Item = f64>) {
        for (sums, weight) in self.sums.iter_mut().zip(weights) {
            sums[kept] += weight;
        }
    }

    /// As fractions of a beam of so many particles.
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
