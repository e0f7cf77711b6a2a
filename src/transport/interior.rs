use super::TransportError;
use super::lane_math;
use crate::optics::{Phase, PhaseTable};
use std::f64::consts::PI;

/// Wavelengths are kept in groups of this many, the rest of the last group empty, so that loops over them are whole
/// vectors.
pub(super) const GROUP: usize = 8;

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
    phases: Vec<&'a Phase>,
    /// 1/mm, padded with 0.
    mu_s: Vec<[f64; GROUP]>,
    mu_a: Vec<[f64; GROUP]>,
    /// 1 for a wavelength, 0 for an empty place.
    taken: Vec<[f64; GROUP]>,
    density: Density,
}

/// μ_s p(θ) of every wavelength, up to a factor that is the same for all.
#[derive(Clone, Debug)]
enum Density {
    /// One wavelength: a ratio of densities is never needed.
    Single,
    /// At the nodes that all tables share; each row holds every wavelength.
    Rows { groups: usize, rows: Vec<[f64; GROUP]> },
    /// From the phase functions themselves, times these factors.
    Functions { scale: Vec<f64> },
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
        let mu_s = padded(wavelengths.iter().map(|c| c.mu_s));
        Ok(Self {
            index,
            density: Density::new(&phases, wavelengths),
            phases,
            mu_s,
            mu_a: padded(wavelengths.iter().map(|c| c.mu_a)),
            taken: padded(wavelengths.iter().map(|_| 1.0)),
        })
    }

    /// How many wavelengths share a path.
    pub fn wavelengths(&self) -> usize {
        self.phases.len()
    }

    pub fn index(&self) -> f64 {
        self.index
    }

    pub(super) fn groups(&self) -> usize {
        self.mu_s.len()
    }

    pub(super) fn mu_s(&self) -> &[[f64; GROUP]] {
        &self.mu_s
    }

    pub(super) fn mu_a(&self) -> &[[f64; GROUP]] {
        &self.mu_a
    }

    pub(super) fn taken(&self) -> &[[f64; GROUP]] {
        &self.taken
    }

    pub(super) fn mu_s_of(&self, wavelength: usize) -> f64 {
        self.mu_s[wavelength / GROUP][wavelength % GROUP]
    }

    /// Draws cos θ from the phase function of wavelength `hero` and multiplies each wavelength's `share` by its
    /// μ_s p(θ).
    #[inline(always)]
    pub(super) fn scatter(&self, hero: usize, u: f64, share: &mut [[f64; GROUP]]) -> f64 {
        match (&self.density, self.phases[hero]) {
            (Density::Rows { groups, rows }, Phase::Table(table)) => {
                let (cos_theta, k) = table.sample_in_interval(u);
                let w = table.place_in_interval(k, cos_theta);
                let low = &rows[k * groups..(k + 1) * groups];
                let high = &rows[(k + 1) * groups..(k + 2) * groups];
                for ((share, low), high) in share.iter_mut().zip(low).zip(high) {
                    for i in 0..GROUP {
                        share[i] *= low[i] + w * (high[i] - low[i]);
                    }
                }
                cos_theta
            }
            (Density::Functions { scale }, phase) => {
                let cos_theta = phase.sample(u);
                for (wavelength, (phase, scale)) in self.phases.iter().zip(scale).enumerate() {
                    share[wavelength / GROUP][wavelength % GROUP] *= scale * phase.pdf(cos_theta);
                }
                cos_theta
            }
            (_, phase) => phase.sample(u),
        }
    }
}

impl Density {
    fn new(phases: &[&Phase], wavelengths: &[Coefficients<'_>]) -> Self {
        if phases.len() == 1 {
            return Self::Single;
        }
        // Keeps products over many scatterings near 1.
        let largest = wavelengths.iter().map(|c| c.mu_s).fold(f64::MIN_POSITIVE, f64::max);
        let scale: Vec<f64> = wavelengths.iter().map(|c| 4.0 * PI * c.mu_s / largest).collect();
        let tables: Vec<&PhaseTable> = phases
            .iter()
            .filter_map(|phase| match phase {
                Phase::Table(table) => Some(table),
                Phase::HenyeyGreenstein(_) => None,
            })
            .collect();
        let nodes = tables.first().map_or(0, |table| table.density().len());
        if tables.len() < phases.len() || tables.iter().any(|table| table.density().len() != nodes) {
            return Self::Functions { scale };
        }
        let rows = (0..nodes).flat_map(|node| {
            padded(
                tables
                    .iter()
                    .zip(&scale)
                    .map(|(table, scale)| scale * table.density()[node]),
            )
        });
        Self::Rows {
            groups: phases.len().div_ceil(GROUP),
            rows: rows.collect(),
        }
    }
}

fn padded(values: impl Iterator<Item = f64>) -> Vec<[f64; GROUP]> {
    let values: Vec<f64> = values.collect();
    values
        .chunks(GROUP)
        .map(|chunk| std::array::from_fn(|i| chunk.get(i).copied().unwrap_or(0.0)))
        .collect()
}

/// exp(−μ x) of every wavelength.
#[inline(always)]
pub(super) fn attenuation(mu: &[f64; GROUP], x: f64) -> [f64; GROUP] {
    let mut result = [0.0; GROUP];
    for i in 0..GROUP {
        result[i] = lane_math::exp(-mu[i] * x);
    }
    result
}
