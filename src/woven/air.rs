use super::{ClothBatch, ClothLedger, Detector, YarnSurface};
use crate::cloth::{System, TubeHit, Tubes};
use crate::geometry::Vec3;
use rand::{Rng, RngExt};

/// Light on its way to a yarn that it has met.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arrival {
    pub hit: TubeHit,
    /// Unit vector towards where it comes from.
    pub omega_in: Vec3,
    /// Straight from the beam: neither a yarn nor the backing has sent it here.
    pub sunlit: bool,
}

impl Arrival {
    /// Cosine of the angle of incidence.
    pub fn cos_in(&self) -> f64 {
        self.hit.frame.normal.dot(&self.omega_in).clamp(0.0, 1.0)
    }
}

/// Particles that wait at the yarns of one system, and what each carries at every wavelength.
#[derive(Default)]
pub(super) struct Queue {
    pub arrivals: Vec<Arrival>,
    pub weights: Vec<f32>,
}

/// The air between and around the yarns: takes light that leaves a yarn to the next, or out of the cloth.
pub(super) struct Air<'a, D, R> {
    tubes: &'a Tubes,
    /// Reflectance of a perfectly rough plane right under the cloth, at each wavelength.
    backing: Option<&'a [f64]>,
    detector: &'a D,
    rng: R,
    wavelengths: usize,
    queues: [Queue; 2],
    /// Sums over particles, by wavelength, in the order of [`ClothLedger::fractions`].
    sums: Vec<[f64; ClothLedger::FRACTIONS]>,
    caught: Vec<Vec<f64>>,
    /// What the backing sends back of the light in hand.
    sent_back: Vec<f64>,
    /// Whether the detector is to catch light whose last direction was drawn from a density too, or only what a smooth surface
    /// or the backing sent on.
    catch_spread: bool,
    light_above: bool,
}

const REFLECTED: usize = 0;
const THROUGH_YARNS: usize = 1;
const THROUGH_GAPS: usize = 2;
const ABSORBED: usize = 3;
const GAMES: usize = 4;

impl<'a, D: Detector, R: Rng> Air<'a, D, R> {
    pub fn new(
        tubes: &'a Tubes,
        backing: Option<&'a [f64]>,
        detector: &'a D,
        catch_spread: bool,
        rng: R,
        wavelengths: usize,
    ) -> Self {
        Self {
            tubes,
            backing,
            sent_back: vec![0.0; wavelengths],
            detector,
            rng,
            wavelengths,
            queues: Default::default(),
            sums: vec![[0.0; ClothLedger::FRACTIONS]; wavelengths],
            caught: vec![vec![0.0; wavelengths]; detector.bins()],
            catch_spread,
            light_above: true,
        }
    }

    /// Sends `particles` particles of a beam, evenly spread over the cell of the cloth's plane: strata along x in order, along
    /// y at the golden ratio's multiples.
    pub fn shine(&mut self, omega_in: &Vec3, particles: usize) {
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        self.light_above = omega_in.z > 0.0;
        let [cell_x, cell_y] = self.tubes.cell_mm();
        let away = omega_in * (2.0 * self.tubes.top_mm() / omega_in.z.abs());
        let shift: f64 = self.rng.random();
        for k in 0..particles {
            let x = (k as f64 + self.rng.random::<f64>()) / particles as f64;
            let y = (shift + GOLDEN * k as f64).fract();
            let origin = Vec3::new(x * cell_x, y * cell_y, 0.0) + away;
            match self.tubes.first_hit(origin, -omega_in) {
                Some(hit) => self.queue(hit, *omega_in, true, std::iter::repeat_n(1.0, self.wavelengths)),
                None if self.backing.is_some() => {
                    let all = vec![1.0; self.wavelengths];
                    self.meet_backing(origin, -omega_in, &all);
                }
                None => self.sums.iter_mut().for_each(|sums| sums[THROUGH_GAPS] += 1.0),
            }
        }
    }

    /// Those that wait at a system's yarns, who then no longer wait.
    pub fn take(&mut self, system: System) -> Queue {
        std::mem::take(&mut self.queues[place(system)])
    }

    pub fn is_empty(&self) -> bool {
        self.queues.iter().all(|queue| queue.arrivals.is_empty())
    }

    /// Follows light that leaves a yarn. Where it meets another, one particle goes on for all of it, with a probability equal
    /// to the mean of its weights if that is below 1: then at most as many particles are under way as came in, however many
    /// parts the light of each is split into. `spread` if the direction was drawn from a density that views may have been shown:
    /// by particles of the medium or by fibres, not by a smooth surface or the backing.
    pub fn launch(&mut self, origin: Vec3, direction: Vec3, weights: &[f64], spread: bool) {
        let Some(hit) = self.tubes.first_hit(origin, direction) else {
            if self.backing.is_some() && (direction.z > 0.0) != self.light_above {
                self.meet_backing(origin, direction, weights);
            } else {
                self.escape(&direction, weights, spread);
            }
            return;
        };
        let mean = weights.iter().sum::<f64>() / self.wavelengths as f64;
        let survival = mean.min(1.0);
        let survives = self.rng.random::<f64>() < survival;
        let worth = if survives { 1.0 / survival } else { 0.0 };
        for (sums, weight) in self.sums.iter_mut().zip(weights) {
            // As it will be read back.
            let goes_on = if survives {
                f64::from((worth * weight) as f32)
            } else {
                0.0
            };
            sums[GAMES] += weight - goes_on;
        }
        if survives {
            self.queue(
                hit,
                -direction,
                false,
                weights.iter().map(|weight| (worth * weight) as f32),
            );
        }
    }

    /// Sends on what the surface of a yarn reflects, `weights`, of light that met it.
    pub fn reflect(&mut self, surface: &YarnSurface, arrival: &Arrival, weights: &[f64]) {
        let Arrival { hit, omega_in, .. } = arrival;
        match surface {
            YarnSurface::Lost => self.keep(weights.iter().map(|weight| [*weight, 0.0])),
            YarnSurface::Smooth => {
                let normal = hit.frame.normal;
                let direction = normal * (2.0 * arrival.cos_in()) - omega_in;
                self.launch(hit.position, direction, weights, false);
            }
            YarnSurface::Fibres(gloss) => {
                let numbers = [self.rng.random(), self.rng.random()];
                let local = gloss.draw(&hit.frame.to_local(omega_in), numbers);
                self.launch(hit.position, hit.frame.to_world(&local), weights, true);
            }
        }
    }

    /// The backing lies at the height of the cloth's lowest points and sends light back as a perfect diffuser of its reflectance;
    /// the rest is absorbed.
    fn meet_backing(&mut self, origin: Vec3, direction: Vec3, weights: &[f64]) {
        let Some(reflectance) = self.backing else {
            return;
        };
        let up = if self.light_above { 1.0 } else { -1.0 };
        let height = -up * self.tubes.top_mm();
        let position = origin + direction * ((height - origin.z) / direction.z).max(0.0);
        let mut sent_back = std::mem::take(&mut self.sent_back);
        for ((back, weight), (sums, reflectance)) in sent_back
            .iter_mut()
            .zip(weights)
            .zip(self.sums.iter_mut().zip(reflectance))
        {
            *back = weight * reflectance;
            sums[ABSORBED] += weight - *back;
        }
        let (sin2, around): (f64, f64) = (self.rng.random(), self.rng.random::<f64>() * std::f64::consts::TAU);
        let sin = sin2.sqrt();
        let diffuse = Vec3::new(sin * around.cos(), sin * around.sin(), up * (1.0 - sin2).sqrt());
        // No density is worked out for the views, so the cones catch it.
        self.launch(position, diffuse, &sent_back, false);
        self.sent_back = sent_back;
    }

    fn queue(&mut self, hit: TubeHit, omega_in: Vec3, sunlit: bool, weights: impl Iterator<Item = f32>) {
        let queue = &mut self.queues[place(hit.yarn.system)];
        queue.arrivals.push(Arrival { hit, omega_in, sunlit });
        queue.weights.extend(weights);
    }

    fn escape(&mut self, direction: &Vec3, weights: &[f64], spread: bool) {
        let side = if (direction.z > 0.0) == self.light_above {
            REFLECTED
        } else {
            THROUGH_YARNS
        };
        for (sums, weight) in self.sums.iter_mut().zip(weights) {
            sums[side] += weight;
        }
        if spread && !self.catch_spread {
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

    /// Counts light that a yarn kept, and what its games of chance took, at every wavelength.
    pub fn keep(&mut self, kept: impl Iterator<Item = [f64; 2]>) {
        for (sums, [absorbed, games]) in self.sums.iter_mut().zip(kept) {
            sums[ABSORBED] += absorbed;
            sums[GAMES] += games;
        }
    }

    /// As fractions of a beam of so many particles.
    pub fn batch(self, particles: usize) -> ClothBatch {
        let share = 1.0 / particles as f64;
        let ledger = self.sums.iter();
        let ledger = ledger.map(|sums| ClothLedger::from_fractions(sums.map(|sum| sum * share)));
        let mut caught = self.caught;
        caught.iter_mut().flatten().for_each(|sum| *sum *= share);
        ClothBatch {
            ledger: ledger.collect(),
            caught,
        }
    }
}

fn place(system: System) -> usize {
    match system {
        System::Warp => 0,
        System::Weft => 1,
    }
}
