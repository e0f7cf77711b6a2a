use super::TransportError;
use super::angles::{Angles, Deflections, common_tables};
use crate::optics::Phase;
use std::f64::consts::PI;

/// Wavelengths processed together in vector instructions.
pub(super) const GROUP: usize = 16;

/// A quantity at a group of wavelengths: single precision for one path, double precision for sums over paths.
pub(super) type Single = [f32; GROUP];
pub(super) type Double = [f64; GROUP];

/// Paths per round for the wavelength with the largest μ_s and for that with the smallest; 1 for all others.
const PATHS_OF_MOST: usize = 5;
const PATHS_OF_LEAST: usize = 2;
/// Factor by which products of density ratios may grow or shrink between evaluations of the weights, well within the
/// range of single precision.
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

/// Optical properties inside a body at all the wavelengths that share paths. Wavelengths can share paths only if their
/// host index is the same, so that the surface refracts them into the same direction.
#[derive(Clone, Debug)]
pub struct Interior<'a> {
    index: f64,
    wavelengths: usize,
    /// 1/mm, padded with 0.
    mu_s: Vec<Single>,
    mu_a: Vec<Single>,
    /// 1 for a wavelength, 0 for padding.
    taken: Vec<Single>,
    /// Number of paths per round with each wavelength as hero, and the hero of each path of a round.
    paths_per_round: Vec<Single>,
    heroes: Vec<usize>,
    /// 1/μ_s of each wavelength, mm; μ_a of the first wavelength, 1/mm.
    mean_free_path: Vec<f64>,
    first_mu_a: f64,
    angles: Angles<'a>,
    density: Density<'a>,
    scatterings_at_most: u64,
}

/// μ_s p(θ) of every wavelength, up to a factor that is the same for all.
#[derive(Clone, Debug)]
enum Density<'a> {
    /// Tables on common nodes: for each node in order, all groups of wavelengths.
    Rows(Vec<Single>),
    /// Phase functions, each evaluated and multiplied by its factor.
    Functions(Vec<(&'a Phase, f64)>),
}

impl<'a> Interior<'a> {
    /// `index` is the refractive index of the host relative to the outside; coefficients are in 1/mm.
    ///
    /// # Errors
    /// [`TransportError::Domain`] if there is no wavelength, if the index is not finite and above 0, or if a
    /// coefficient is negative or not finite.
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
        let paths_per_round = paths_per_round(wavelengths);
        let heroes = paths_per_round
            .iter()
            .enumerate()
            .flat_map(|(hero, &paths_per_round)| std::iter::repeat_n(hero, paths_per_round));
        Ok(Self {
            index,
            wavelengths: wavelengths.len(),
            mu_s: grouped(wavelengths.iter().map(|c| c.mu_s as f32)),
            mu_a: grouped(wavelengths.iter().map(|c| c.mu_a as f32)),
            taken: grouped(wavelengths.iter().map(|_| 1.0)),
            heroes: heroes.collect(),
            paths_per_round: grouped(paths_per_round.iter().map(|&paths_per_round| paths_per_round as f32)),
            mean_free_path: wavelengths.iter().map(|c| 1.0 / c.mu_s).collect(),
            first_mu_a: wavelengths[0].mu_a,
            angles: Angles::new(&phases),
            density: Density::new(&phases, wavelengths),
            scatterings_at_most: scatterings_at_most(wavelengths),
        })
    }

    /// Number of wavelengths that share a path.
    pub fn wavelengths(&self) -> usize {
        self.wavelengths
    }

    /// Refractive index of the host relative to the outside.
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

    pub(super) fn paths_per_round(&self) -> &[Single] {
        &self.paths_per_round
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

    /// Number of scattering events after which the weights must be evaluated, so that products of density ratios stay
    /// within the range of single precision.
    pub(super) fn scatterings_at_most(&self) -> u64 {
        self.scatterings_at_most
    }

    /// Multiplies each wavelength's `share` by the ratio of its μ_s p(θ) to that of the hero.
    #[inline(always)]
    pub(super) fn weigh(&self, hero: usize, deflection: &Deflections, lane: usize, share: &mut [Single]) {
        match &self.density {
            Density::Rows(rows) => {
                let first = deflection.interval[lane] as usize * share.len();
                let (low, high) = rows[first..first + 2 * share.len()].split_at(share.len());
                let place = deflection.place[lane] as f32;
                let (group, within) = (hero / GROUP, hero % GROUP);
                let inverse = 1.0 / between(low[group][within], high[group][within], place);
                for ((share, low), high) in share.iter_mut().zip(low).zip(high) {
                    *share = weighed(*share, *low, *high, place, inverse);
                }
            }
            Density::Functions(functions) => {
                let cos_theta = deflection.cos_theta[lane];
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

/// Takes and returns values, so that the compiler can rule out overlapping rows and use vector instructions.
#[inline(always)]
fn weighed(share: Single, low: Single, high: Single, place: f32, inverse: f32) -> Single {
    let mut result = share;
    for i in 0..GROUP {
        result[i] = share[i] * (between(low[i], high[i], place) * inverse);
    }
    result
}

/// Paths per round with each wavelength as hero. The wavelengths with the largest and smallest μ_s get more: others
/// also gain from paths of heroes with μ_s on both sides of theirs, these two from one side only.
fn paths_per_round(wavelengths: &[Coefficients<'_>]) -> Vec<usize> {
    let mut paths_per_round = vec![1; wavelengths.len()];
    let by_mu_s = |a: &usize, b: &usize| wavelengths[*a].mu_s.total_cmp(&wavelengths[*b].mu_s);
    if wavelengths.len() > 2 {
        (0..wavelengths.len())
            .max_by(by_mu_s)
            .into_iter()
            .for_each(|most| paths_per_round[most] = PATHS_OF_MOST);
        (0..wavelengths.len())
            .min_by(by_mu_s)
            .into_iter()
            .for_each(|least| paths_per_round[least] = PATHS_OF_LEAST);
    }
    paths_per_round
}

/// Largest number of scattering events whose density ratios, each at its largest over all angles, stay within
/// [`RANGE`].
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

/// Groups of values, the last padded with 0.
fn grouped<T: Copy + Default>(values: impl Iterator<Item = T>) -> Vec<[T; GROUP]> {
    let values: Vec<T> = values.collect();
    let group = |part: &[T]| std::array::from_fn(|i| part.get(i).copied().unwrap_or_default());
    values.chunks(GROUP).map(group).collect()
}
