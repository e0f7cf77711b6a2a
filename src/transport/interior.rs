use super::TransportError;
use super::angles::{Angle, Angles, common_tables};
use crate::optics::Phase;
use std::f64::consts::PI;

/// Rows of wavelengths are padded to whole vectors of this many.
const LANE_GROUP: usize = 8;

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
    mu_s: Vec<f64>,
    mu_a: Vec<f64>,
    /// 1 for a wavelength, 0 for an empty place.
    taken: Vec<f64>,
    angles: Angles<'a>,
    density: Density<'a>,
}

/// μ_s p(θ) of every wavelength, up to a factor that is the same for all.
#[derive(Clone, Debug)]
enum Density<'a> {
    /// One wavelength: a ratio of densities is never needed.
    Single,
    /// At the nodes that all tables share; each row holds every wavelength.
    Rows(Vec<f64>),
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
        Ok(Self {
            index,
            wavelengths: wavelengths.len(),
            mu_s: padded(wavelengths.iter().map(|c| c.mu_s)),
            mu_a: padded(wavelengths.iter().map(|c| c.mu_a)),
            taken: padded(wavelengths.iter().map(|_| 1.0)),
            angles: Angles::new(&phases),
            density: Density::new(&phases, wavelengths),
        })
    }

    /// How many wavelengths share a path.
    pub fn wavelengths(&self) -> usize {
        self.wavelengths
    }

    pub fn index(&self) -> f64 {
        self.index
    }

    /// Wavelengths and empty places to a multiple of 8.
    pub(super) fn width(&self) -> usize {
        self.mu_s.len()
    }

    pub(super) fn mu_s(&self) -> &[f64] {
        &self.mu_s
    }

    pub(super) fn mu_a(&self) -> &[f64] {
        &self.mu_a
    }

    pub(super) fn taken(&self) -> &[f64] {
        &self.taken
    }

    pub(super) fn angles(&self) -> &Angles<'a> {
        &self.angles
    }

    /// Multiplies each wavelength's `share` by its μ_s p(θ).
    #[inline(always)]
    pub(super) fn weigh(&self, angle: &Angle, share: &mut [f64]) {
        match &self.density {
            Density::Single => {}
            Density::Rows(rows) => {
                let width = share.len();
                let low = &rows[angle.interval * width..(angle.interval + 1) * width];
                let high = &rows[(angle.interval + 1) * width..(angle.interval + 2) * width];
                for ((share, low), high) in share.iter_mut().zip(low).zip(high) {
                    *share *= low + angle.place * (high - low);
                }
            }
            Density::Functions(functions) => {
                let places = share.iter_mut().zip(functions);
                places.for_each(|(share, (phase, factor))| *share *= factor * phase.pdf(angle.cos_theta));
            }
        }
    }
}

impl<'a> Density<'a> {
    fn new(phases: &[&'a Phase], wavelengths: &[Coefficients<'_>]) -> Self {
        if phases.len() == 1 {
            return Self::Single;
        }
        // Keeps products over many scatterings near 1.
        let largest = wavelengths.iter().map(|c| c.mu_s).fold(f64::MIN_POSITIVE, f64::max);
        let factors = wavelengths.iter().map(|c| 4.0 * PI * c.mu_s / largest);
        match common_tables(phases) {
            Some((nodes, tables)) => {
                let factors: Vec<f64> = factors.collect();
                let row = |node: usize| padded(tables.iter().zip(&factors).map(move |(t, f)| f * t.density()[node]));
                Self::Rows((0..nodes).flat_map(row).collect())
            }
            None => Self::Functions(phases.iter().copied().zip(factors).collect()),
        }
    }
}

fn padded(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.resize(values.len().next_multiple_of(LANE_GROUP), 0.0);
    values
}
