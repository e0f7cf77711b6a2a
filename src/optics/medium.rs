use num_complex::Complex64;

use super::quadrature::gauss_legendre;
use super::{Mie, OpticsError, Phase, PhaseTable, Property, percus_yevick};
use crate::fault::{self, Fault};
use crate::spectrum::{Spectrum, WavelengthGrid};

/// Largest volume fraction of equal spheres: the densest packing is π/√18 = 0.7405.
const PACKING_LIMIT: f64 = 0.74;
/// Greatest accepted difference between the asymmetry parameters of a phase table and of its series.
const G_TOLERANCE: f64 = 1e-6;
const FIRST_NODES: usize = 257;
const LAST_NODES: usize = 65_537;
/// Largest number of panels of the integrals over the structure factor.
const MOST_PANELS: usize = 1 << 16;

/// Treatment of interference between neighbouring particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interference {
    /// Each particle scatters independently.
    Independent,
    /// dC/dΩ times the Percus–Yevick structure factor of hard spheres of the particles' own diameter.
    PercusYevick,
}

/// Equal spheres dispersed in a host.
#[derive(Clone, Debug, PartialEq)]
pub struct MediumSpec {
    /// Refractive index of the host, > 0.
    pub host_index: Spectrum,
    /// Real part of the particles' refractive index, > 0, absolute (not relative to the host).
    pub particle_index: Spectrum,
    /// Imaginary part κ of the particles' refractive index, ≥ 0 (absorbing), absolute.
    pub particle_kappa: Spectrum,
    /// Absorption coefficient the host adds to that of the particles, ≥ 0, 1/mm of the medium.
    pub host_mu_a_per_mm: Spectrum,
    /// Diameter of the particles, > 0, nm.
    pub particle_diameter_nm: f64,
    /// Volume fraction of the particles, 0..0.74.
    pub volume_fraction: f64,
    pub interference: Interference,
}

/// A scattering and absorbing medium at the wavelengths of one grid.
#[derive(Clone, Debug)]
pub struct Medium {
    grid: WavelengthGrid,
    host_index: Vec<f64>,
    mu_s_per_mm: Vec<f64>,
    mu_a_per_mm: Vec<f64>,
    g: Vec<f64>,
    phases: Vec<Phase>,
}

impl Medium {
    /// Coefficients and phase tables from the Mie series, all wavelengths with one node count, doubled until every
    /// table's asymmetry parameter is within 1e-6 of the exact one.
    ///
    /// # Errors
    /// As [`Medium::with_phase_nodes`]; also spheres so large that 65537 nodes do not resolve their phase function.
    pub fn new(spec: &MediumSpec, grid: &WavelengthGrid) -> Result<Self, OpticsError> {
        let spheres = spheres(spec, grid)?;
        let mut nodes = FIRST_NODES;
        loop {
            let phases = phases(&spheres, nodes)?;
            let gaps = spheres.iter().zip(&phases).map(|(s, p)| (s, (p.g() - s.g).abs()));
            match gaps.max_by(|a, b| a.1.total_cmp(&b.1)) {
                Some((_, difference)) if difference <= G_TOLERANCE => {
                    let phases = faulty(&spheres, phases)?;
                    return Ok(assemble(grid, &spheres, phases));
                }
                Some((sphere, difference)) if nodes >= LAST_NODES => {
                    return Err(OpticsError::PhaseUnresolved {
                        wavelength_nm: sphere.wavelength_nm,
                        nodes,
                        difference,
                        diameter_nm: spec.particle_diameter_nm,
                    });
                }
                _ => nodes = 2 * nodes - 1,
            }
        }
    }

    /// The same with a given number of nodes a table and no check of their resolution.
    ///
    /// # Errors
    /// Names the quantity, its unit and range: diameter ≤ 0, volume fraction outside 0..0.74, index ≤ 0, κ or μ_a < 0,
    /// a spectrum that does not cover the grid, a size parameter outside the domain of [`Mie`], too few nodes.
    pub fn with_phase_nodes(spec: &MediumSpec, grid: &WavelengthGrid, nodes: usize) -> Result<Self, OpticsError> {
        let spheres = spheres(spec, grid)?;
        let phases = phases(&spheres, nodes)?;
        Ok(assemble(grid, &spheres, phases))
    }

    /// A medium given by its coefficients (1/mm) and phase functions, one each a wavelength of the grid.
    ///
    /// # Errors
    /// A list of another length than the grid; an index ≤ 0; a coefficient < 0 or not finite.
    pub fn from_coefficients(
        grid: &WavelengthGrid,
        host_index: Vec<f64>,
        mu_s_per_mm: Vec<f64>,
        mu_a_per_mm: Vec<f64>,
        phases: Vec<Phase>,
    ) -> Result<Self, OpticsError> {
        for (quantity, found) in [
            ("host index", host_index.len()),
            ("mu_s", mu_s_per_mm.len()),
            ("mu_a", mu_a_per_mm.len()),
            ("phase functions", phases.len()),
        ] {
            if found != grid.len() {
                let expected = grid.len();
                return Err(OpticsError::Length {
                    quantity,
                    expected,
                    found,
                });
            }
        }
        for (i, &nm) in grid.nm().iter().enumerate() {
            positive(Property::HostIndex, "host index", nm, host_index[i])?;
            not_negative(Property::VolumeFraction, "mu_s in 1/mm", nm, mu_s_per_mm[i])?;
            not_negative(Property::HostAbsorption, "mu_a in 1/mm", nm, mu_a_per_mm[i])?;
        }
        Ok(Self {
            grid: grid.clone(),
            host_index,
            mu_s_per_mm,
            mu_a_per_mm,
            g: phases.iter().map(Phase::g).collect(),
            phases,
        })
    }

    /// Wavelength grid of all spectra.
    pub fn grid(&self) -> &WavelengthGrid {
        &self.grid
    }

    /// Refractive index of the host, one a wavelength.
    pub fn host_index(&self) -> &[f64] {
        &self.host_index
    }

    /// Scattering coefficient, 1/mm.
    pub fn mu_s_per_mm(&self) -> &[f64] {
        &self.mu_s_per_mm
    }

    /// Absorption coefficient, 1/mm.
    pub fn mu_a_per_mm(&self) -> &[f64] {
        &self.mu_a_per_mm
    }

    /// Extinction coefficient at each wavelength, μ_s + μ_a, 1/mm.
    pub fn extinction_per_mm(&self) -> impl Iterator<Item = f64> {
        self.mu_s_per_mm.iter().zip(&self.mu_a_per_mm).map(|(s, a)| s + a)
    }

    /// Asymmetry parameter: mean cosine of the scattering angle.
    pub fn g(&self) -> &[f64] {
        &self.g
    }

    /// Phase function at wavelength `i` of the grid.
    pub fn phase(&self, i: usize) -> &Phase {
        &self.phases[i]
    }

    /// Whether the host's index changes over the grid, so that refracted directions differ from one wavelength to
    /// another.
    pub fn is_dispersive(&self) -> bool {
        self.host_index.iter().any(|n| *n != self.host_index[0])
    }
}

/// Solution at one wavelength of a spec.
struct Sphere {
    wavelength_nm: f64,
    host_index: f64,
    mie: Mie,
    /// Size parameter.
    x: f64,
    /// Volume fraction of the structure factor, if there is one.
    interfering: Option<f64>,
    mu_s_per_mm: f64,
    mu_a_per_mm: f64,
    g: f64,
}

impl Sphere {
    /// Any multiple of the phase function.
    fn density(&self, cos_theta: f64) -> f64 {
        self.mie.unpolarised(cos_theta) * self.structure(cos_theta)
    }

    fn structure(&self, cos_theta: f64) -> f64 {
        // q d = 2 k d sin(θ/2) with k d = 2x in the host.
        let qd = 4.0 * self.x * (0.5 * (1.0 - cos_theta)).max(0.0).sqrt();
        self.interfering.map_or(1.0, |fraction| percus_yevick(qd, fraction))
    }
}

fn spheres(spec: &MediumSpec, grid: &WavelengthGrid) -> Result<Vec<Sphere>, OpticsError> {
    let (diameter_nm, fraction) = (spec.particle_diameter_nm, spec.volume_fraction);
    if !(diameter_nm.is_finite() && diameter_nm > 0.0) {
        return Err(OpticsError::domain(
            Property::ParticleDiameter,
            "particle diameter in nm",
            "a number > 0",
            diameter_nm,
            "give the diameter, not the radius, of one particle",
        ));
    }
    if !(0.0..PACKING_LIMIT).contains(&fraction) {
        return Err(OpticsError::domain(
            Property::VolumeFraction,
            "volume fraction",
            format!("within 0..{PACKING_LIMIT}, dimensionless"),
            fraction,
            "equal spheres cannot be packed more densely; divide a percentage by 100",
        ));
    }
    let [host, particle, kappa, host_mu_a] = [
        &spec.host_index,
        &spec.particle_index,
        &spec.particle_kappa,
        &spec.host_mu_a_per_mm,
    ]
    .map(|spectrum| spectrum.on(grid));
    let (host, particle, kappa, host_mu_a) = (host?, particle?, kappa?, host_mu_a?);
    let mut spheres = Vec::with_capacity(grid.len());
    for (i, &nm) in grid.nm().iter().enumerate() {
        let n_host = positive(Property::HostIndex, "host index", nm, host.values()[i])?;
        let n = positive(Property::ParticleIndex, "particle index", nm, particle.values()[i])?;
        let k = not_negative(Property::ParticleAbsorption, "particle kappa", nm, kappa.values()[i])?;
        let added = not_negative(Property::HostAbsorption, "host mu_a in 1/mm", nm, host_mu_a.values()[i])?;
        let in_host = if fault::active(Fault::VacuumSize) { 1.0 } else { n_host };
        let x = std::f64::consts::PI * diameter_nm * in_host / nm;
        let of_kappa = if fault::active(Fault::KappaAbsolute) {
            1.0
        } else {
            n_host
        };
        let mie = Mie::sphere(Complex64::new(n / n_host, k / of_kappa), x).map_err(|source| OpticsError::At {
            wavelength_nm: nm,
            source: Box::new(source),
        })?;
        let q = mie.efficiencies();
        // N C = 6f/(πd³) Q πd²/4, per mm.
        let per_mm = 1.5 * fraction / (diameter_nm * 1e-6);
        spheres.push(Sphere {
            wavelength_nm: nm,
            host_index: n_host,
            mie,
            x,
            interfering: (spec.interference == Interference::PercusYevick).then_some(fraction),
            mu_s_per_mm: per_mm
                * q.q_sca
                * if fault::active(Fault::ScatteringHigh) {
                    1.01
                } else {
                    1.0
                },
            mu_a_per_mm: per_mm * q.q_abs + added,
            g: q.g,
        });
    }
    if spec.interference == Interference::PercusYevick {
        for sphere in &mut spheres {
            interfere(sphere);
        }
    }
    Ok(spheres)
}

/// Multiplies μ_s by the mean of S over the phase function, and takes g of the product.
fn interfere(sphere: &mut Sphere) {
    let rule = gauss_legendre(16);
    // S oscillates in q d = 4x sin(θ/2) with a period of about 2π, and its peaks are sharper the denser the medium.
    let mut panels = 4 + sphere.x.ceil() as usize;
    let mut integrals = integrals(sphere, &rule, panels);
    loop {
        panels *= 2;
        let finer = self::integrals(sphere, &rule, panels);
        let change = finer
            .iter()
            .zip(&integrals)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        integrals = finer;
        if change <= 1e-11 * integrals[0] || panels > MOST_PANELS {
            break;
        }
    }
    let [alone, together, forward] = integrals;
    if together > 0.0 {
        sphere.mu_s_per_mm *= together / alone;
        sphere.g = forward / together;
    }
}

/// ∫p, ∫pS and ∫pS cos θ over the sphere, up to one factor, by a composite rule in t = sin(θ/2), dΩ = 8π t dt.
fn integrals(sphere: &Sphere, rule: &[(f64, f64)], panels: usize) -> [f64; 3] {
    let mut sums = [0.0; 3];
    let half = 0.5 / panels as f64;
    for panel in 0..panels {
        let middle = (2 * panel + 1) as f64 * half;
        for &(node, weight) in rule {
            let t = middle + half * node;
            let cos = 1.0 - 2.0 * t * t;
            let alone = half * weight * t * sphere.mie.unpolarised(cos);
            let together = alone * sphere.structure(cos);
            sums[0] += alone;
            sums[1] += together;
            sums[2] += together * cos;
        }
    }
    sums
}

fn phases(spheres: &[Sphere], nodes: usize) -> Result<Vec<Phase>, OpticsError> {
    let table = |sphere: &Sphere| {
        // A matched sphere scatters nothing: any phase function will do, and an isotropic one has its g of 0.
        let table = if sphere.mie.efficiencies().q_sca > 0.0 {
            PhaseTable::from_density(nodes, |cos| sphere.density(cos))?
        } else {
            PhaseTable::from_density(nodes, |_| 1.0)?
        };
        Ok(Phase::Table(table))
    };
    spheres.iter().map(table).collect()
}

/// The tables as the named fault would have them, behind the refinement, which refuses tables whose g is not the
/// sphere's.
fn faulty(spheres: &[Sphere], phases: Vec<Phase>) -> Result<Vec<Phase>, OpticsError> {
    let one_polarisation = fault::active(Fault::OnePolarisation);
    if !one_polarisation && !fault::active(Fault::InterferenceUnused) {
        return Ok(phases);
    }
    let table = |(sphere, phase): (&Sphere, Phase)| {
        let nodes = match &phase {
            Phase::Table(table) if sphere.mie.efficiencies().q_sca > 0.0 => table.density().len(),
            _ => return Ok(phase),
        };
        let density = |cos: f64| match one_polarisation {
            true => sphere.mie.amplitudes(cos).0.norm_sqr() * sphere.structure(cos),
            false => sphere.mie.unpolarised(cos),
        };
        Ok(Phase::Table(PhaseTable::from_density(nodes, density)?))
    };
    spheres.iter().zip(phases).map(table).collect()
}

fn assemble(grid: &WavelengthGrid, spheres: &[Sphere], phases: Vec<Phase>) -> Medium {
    let each = |f: fn(&Sphere) -> f64| spheres.iter().map(f).collect();
    Medium {
        grid: grid.clone(),
        host_index: each(|s| s.host_index),
        mu_s_per_mm: each(|s| s.mu_s_per_mm),
        mu_a_per_mm: each(|s| s.mu_a_per_mm),
        g: each(|s| s.g),
        phases,
    }
}

fn positive(of: Property, quantity: &str, wavelength_nm: f64, found: f64) -> Result<f64, OpticsError> {
    if found.is_finite() && found > 0.0 {
        return Ok(found);
    }
    let quantity = format!("{quantity} at {wavelength_nm} nm");
    Err(OpticsError::domain(
        of,
        quantity,
        "a number > 0",
        found,
        "glass and fibres have 1.3 to 1.9",
    ))
}

fn not_negative(of: Property, quantity: &str, wavelength_nm: f64, found: f64) -> Result<f64, OpticsError> {
    if found.is_finite() && found >= 0.0 {
        return Ok(found);
    }
    let quantity = format!("{quantity} at {wavelength_nm} nm");
    Err(OpticsError::domain(
        of,
        quantity,
        "a number >= 0",
        found,
        "0 means that nothing is lost; gain is not modelled",
    ))
}
