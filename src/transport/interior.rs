use super::TransportError;
use super::angles::{Angles, Turns, common_tables};
use crate::optics::Phase;
use std::f64::consts::PI;

/// Wavelengths side by side.
pub(super) const GROUP: usize = 16;

/// A quantity at a group of wavelengths: of one path in single precision, summed over paths in double.
pub(super) type Single = [f32; GROUP];
pub(super) type Double = [f64; GROUP];

/// Turns, in a round, of the wavelength that scatters most and of the one that scatters least.
const TURNS_OF_MOST: usize = 5;
const TURNS_OF_LEAST: usize = 2;
/// How far products of density ratios may grow or shrink before the weights are worked out, well within single precision.
const RANGE: f64 = 1e28;

/// Scattering and absorption inside a body at one wavelength.
#[derive(Clone, Copy, Debug)]
pub struct Coefficients<'a> {
    /// Scattering coefficient, 1/mm.
    pub mu_s: f64,
    /// Absorption coefficient, 1/mm.
    pub mu_a: f64,
    pub phase: &'a Phase,
}

/// Optical properties inside a body at all the wavelengths that share paths. They share them because they have one
/// index of refraction, hence one direction behind the surface.
#[derive(Clone, Debug)]
pub struct Interior<'a> {
    index: f64,
    wavelengths: usize,
    /// 1/mm, padded with 0.
    mu_s: Vec<Single>,
    mu_a: Vec<Single>,
    /// 1 for a wavelength, 0 for an empty place.
    taken: Vec<Single>,
    /// How many turns each wavelength takes as the hero of paths, in a round, and whose turns they are.
    turns: Vec<Single>,
    heroes: Vec<usize>,
    /// 1/μ_s of each wavelength, mm, and μ_a of the first, 1/mm.
    mean_free_path: Vec<f64>,
    first_mu_a: f64,
    angles: Angles<'a>,
    density: Density<'a>,
    scatterings_at_most: u64,
}

/// μ_s p(θ) of every wavelength, up to a factor that is the same for all.
#[derive(Clone, Debug)]
enum Density<'a> {
    /// At the nodes that all tables share, one after the other; all the groups at each.
    Rows(Vec<Single>),
    /// From the phase functions themselves, times these factors.
    Functions(Vec<(&'a Phase, f64)>),
}

impl<'a> Interior<'a> {
    /// `index` is that of the host relative to the outside.
    ///
    /// # Errors
    /// No wavelength, an index that is not above 0, a coefficient that is negative or not finite.
    pub fn new(index: f64, wavelengths: &[Coefficients<'a>]) -> Result<Self, TransportError> {
        let domain = |quantity, expected, found, remedy| TransportError::Domain {
            quantity,
            expected,
            found,
            remedy,
        };
        if !(index > 0.0 && index.is_finite()) {
            return Err(domain(
                "index of the host",
                "a finite number > 0",
                index,
                "set [medium] host_index",
            ));
        }
        if wavelengths.is_empty() {
            return Err(domain(
                "wavelengths of a path",
                "1 or more",
                0.0,
                "give the medium a wavelength",
            ));
        }
        for c in wavelengths {
            for (quantity, found) in [("mu_s", c.mu_s), ("mu_a", c.mu_a)] {
                if !(found >= 0.0 && found.is_finite()) {
                    return Err(domain(
                        quantity,
                        "a finite coefficient ≥ 0, 1/mm",
                        found,
                        "check the medium's indices, diameter and volume fraction",
                    ));
                }
            }
        }
        let phases: Vec<&Phase> = wavelengths.iter().map(|c| c.phase).collect();
        let turns = turns(wavelengths);
        let heroes = turns
            .iter()
            .enumerate()
            .flat_map(|(hero, &turns)| std::iter::repeat_n(hero, turns));
        Ok(Self {
            index,
            wavelengths: wavelengths.len(),
            mu_s: grouped(wavelengths.iter().map(|c| c.mu_s as f32)),
            mu_a: grouped(wavelengths.iter().map(|c| c.mu_a as f32)),
            taken: grouped(wavelengths.iter().map(|_| 1.0)),
            heroes: heroes.collect(),
            turns: grouped(turns.iter().map(|&turns| turns as f32)),
            mean_free_path: wavelengths.iter().map(|c| 1.0 / c.mu_s).collect(),
            first_mu_a: wavelengths[0].mu_a,
            angles: Angles::new(&phases),
            density: Density::new(&phases, wavelengths),
            scatterings_at_most: scatterings_at_most(wavelengths),
        })
    }

    /// How many wavelengths share a path.
    pub fn wavelengths(&self) -> usize {
        self.wavelengths
    }

    pub fn index(&self) -> f64 {
        self.index
    }

    pub(super) fn mu_s(&self) -> &[Single] {
        &self.mu_s
    }

    pub(super) fn mu_a(&self) -> &[Single] {
        &self.mu_a
    }

    pub(super) fn first_mu_a(&self) -> f64 {
        self.first_mu_a
    }

    pub(super) fn taken(&self) -> &[Single] {
        &self.taken
    }

    pub(super) fn turns(&self) -> &[Single] {
        &self.turns
    }

    pub(super) fn heroes(&self) -> &[usize] {
        &self.heroes
    }

    pub(super) fn mean_free_path(&self) -> &[f64] {
        &self.mean_free_path
    }

    pub(super) fn angles(&self) -> &Angles<'a> {
        &self.angles
    }

    /// After so many scatterings the weights must be worked out before their products leave the range of numbers.
    pub(super) fn scatterings_at_most(&self) -> u64 {
        self.scatterings_at_most
    }

    /// Multiplies each wavelength's `share` by its μ_s p(θ) over that of the hero.
    #[inline(always)]
    pub(super) fn weigh(&self, hero: usize, turns: &Turns, lane: usize, share: &mut [Single]) {
        match &self.density {
            Density::Rows(rows) => {
                let first = turns.interval[lane] as usize * share.len();
                let (low, high) = rows[first..first + 2 * share.len()].split_at(share.len());
                let place = turns.place[lane] as f32;
                let (group, within) = (hero / GROUP, hero % GROUP);
                let inverse = 1.0 / between(low[group][within], high[group][within], place);
                for ((share, low), high) in share.iter_mut().zip(low).zip(high) {
                    *share = weighed(*share, *low, *high, place, inverse);
                }
            }
            Density::Functions(functions) => {
                let cos_theta = turns.cos_theta[lane];
                let (phase, factor) = functions[hero];
                let inverse = 1.0 / (factor * phase.pdf(cos_theta));
                let places = share.as_flattened_mut().iter_mut().zip(functions);
                places.for_each(|(share, (phase, factor))| *share *= (factor * phase.pdf(cos_theta) * inverse) as f32);
            }
        }
    }
}

impl<'a> Density<'a> {
    fn new(phases: &[&'a Phase], wavelengths: &[Coefficients<'_>]) -> Self {
        // Keeps the factors near 1.
        let largest = wavelengths.iter().map(|c| c.mu_s).fold(f64::MIN_POSITIVE, f64::max);
        let factors = wavelengths.iter().map(|c| 4.0 * PI * c.mu_s / largest);
        match common_tables(phases) {
            Some((nodes, tables)) => {
                let factors: Vec<f64> = factors.collect();
                let row = |node: usize| {
                    let densities = tables.iter().zip(&factors);
                    grouped(densities.map(move |(t, f)| (f * t.density()[node]) as f32))
                };
                Self::Rows((0..nodes).flat_map(row).collect())
            }
            None => Self::Functions(phases.iter().copied().zip(factors).collect()),
        }
    }
}

#[inline(always)]
fn between(low: f32, high: f32, place: f32) -> f32 {
    low + place * (high - low)
}

/// Values in, values out, so that the compiler knows the rows to be apart and uses vectors.
#[inline(always)]
fn weighed(share: Single, low: Single, high: Single, place: f32, inverse: f32) -> Single {
    let mut result = share;
    for i in 0..GROUP {
        result[i] = share[i] * (between(low[i], high[i], place) * inverse);
    }
    result
}

/// Every wavelength has a turn. Those that scatter most and least have more: all others are helped by the paths of neighbours
/// on both sides, these of one side only.
fn turns(wavelengths: &[Coefficients<'_>]) -> Vec<usize> {
    let mut turns = vec![1; wavelengths.len()];
    let by_mu_s = |a: &usize, b: &usize| wavelengths[*a].mu_s.total_cmp(&wavelengths[*b].mu_s);
    if wavelengths.len() > 2 {
        (0..wavelengths.len())
            .max_by(by_mu_s)
            .into_iter()
            .for_each(|most| turns[most] = TURNS_OF_MOST);
        (0..wavelengths.len())
            .min_by(by_mu_s)
            .into_iter()
            .for_each(|least| turns[least] = TURNS_OF_LEAST);
    }
    turns
}

/// As many factors of the largest ratio between two wavelengths' μ_s p(θ) as stay within [`RANGE`].
fn scatterings_at_most(wavelengths: &[Coefficients<'_>]) -> u64 {
    const ANGLES: usize = 1000;
    let ratio = (0..=ANGLES)
        .map(|i| {
            let t = i as f64 / ANGLES as f64;
            let cos_theta = 1.0 - 2.0 * t * t;
            let densities = wavelengths.iter().map(|c| c.mu_s * c.phase.pdf(cos_theta));
            let (least, most) = densities
                .filter(|&density| density > 0.0)
                .fold((f64::MAX, f64::MIN_POSITIVE), |(least, most), d| {
                    (least.min(d), most.max(d))
                });
            most / least
        })
        .fold(1.0, f64::max);
    (RANGE.ln() / ratio.ln()).max(1.0) as u64
}

/// Groups of values, the last filled up with 0.
fn grouped<T: Copy + Default>(values: impl Iterator<Item = T>) -> Vec<[T; GROUP]> {
    let values: Vec<T> = values.collect();
    let group = |part: &[T]| std::array::from_fn(|i| part.get(i).copied().unwrap_or_default());
    values.chunks(GROUP).map(group).collect()
}
