use super::FitError;
use crate::cloth::Cloth;
use crate::cloth::light::{Beam, RadianceMoments, Scene, Volumetric, YarnSurface};
use crate::rig::{Geometry, number_of, omega_in, omega_out};
use crate::yarn::{LengthBins, Yarn};
use ndarray::{Array2, Array3, Array4, Axis};
use rayon::prelude::*;

/// Effort and resolution of [`BetaTables`].
#[derive(Clone, Debug, PartialEq)]
pub struct TableEffort {
    /// Particles for each incidence and node, in all batches.
    pub particles: usize,
    /// Batches, of which the scatter gives standard errors.
    pub batches: usize,
    /// Azimuths of the cloth over which a batch averages; 1 keeps the cloth at its azimuth.
    pub azimuths: usize,
    /// Largest degree of the polynomials that expand the reflected radiance.
    pub order: usize,
}

/// Scattering of both yarns at one wavelength, with the absorption that paths are traced with.
pub struct ScatteringNode {
    /// Warp and weft, each at this wavelength alone.
    pub yarns: [Yarn; 2],
    /// Reflectance of the backing, if there is one.
    pub backing: Option<f64>,
    /// Absorption of both media, 1/mm.
    pub mu_a_per_mm: f64,
}

/// Brightness factor of the light that the yarns scatter, at each geometry, as a function of the absorption of both
/// yarns: the Laplace transform of the distribution of path lengths.
///
/// Absorption multiplies the weight of a path by exp(−μ_a L) and changes nothing else, so one trace serves every
/// absorption, and β of a geometry is smooth and monotone in it up to Monte Carlo noise. Lengths are binned as for
/// [`crate::yarn::Reabsorption`], which re-weights in the same way.
#[derive(Clone, Debug, PartialEq)]
pub struct BetaTables {
    /// β of each bin at the traced absorption: `[batch][node][geometry][bin]`.
    pub amounts: Array4<f64>,
    /// Mean path length of each bin, mm: `[node][bin]`.
    pub mean_mm: Array2<f64>,
    /// Absorption that paths were traced with, 1/mm, of each node.
    pub traced_mu_a_per_mm: Vec<f64>,
    pub bins: LengthBins,
}

/// Length bins: from a tenth of a typical free path of opaque yarns to far more than white yarns need.
const FIRST_MM: f64 = 0.003;
const LAST_MM: f64 = 20.0;
const BINS: usize = 36;

impl BetaTables {
    /// Traces the cloth at the geometries' incidences. What the yarns' `surface` reflects has no length, so absorption
    /// leaves it as it is. The same seed gives the same random numbers, whatever the cloth
    /// and its media are.
    ///
    /// # Errors
    /// [`FitError`] if a medium cannot be traced.
    pub fn trace(
        cloth: &Cloth,
        surface: YarnSurface,
        nodes: &[ScatteringNode],
        geometries: &[Geometry],
        azimuth_deg: f64,
        effort: &TableEffort,
        seed: u64,
    ) -> Result<Self, FitError> {
        let bins = LengthBins::logarithmic(FIRST_MM, LAST_MM, BINS)?;
        let mut incidences: Vec<f64> = Vec::new();
        for geometry in geometries {
            if !incidences.contains(&geometry.theta_i_deg) {
                incidences.push(geometry.theta_i_deg);
            }
        }
        let views_of = |incidence: usize| {
            let theta_i_deg = incidences[incidence];
            let lit = move |geometry: &&Geometry| geometry.theta_i_deg == theta_i_deg;
            geometries.iter().filter(lit).map(|geometry| geometry.theta_v_deg)
        };
        let azimuths = effort.azimuths.max(1);
        let particles = effort.particles.div_ceil(effort.batches * azimuths);
        let tasks: Vec<[usize; 4]> = (0..effort.batches)
            .flat_map(|batch| (0..nodes.len()).map(move |node| [batch, node]))
            .flat_map(|[batch, node]| (0..incidences.len()).map(move |i| [batch, node, i]))
            .flat_map(|[batch, node, i]| (0..azimuths).map(move |azimuth| [batch, node, i, azimuth]))
            .collect();
        let trace = |&[batch, node, incidence, azimuth]: &[usize; 4]| -> Result<Vec<f64>, FitError> {
            let ScatteringNode { yarns, backing, .. } = &nodes[node];
            let backing = backing.map(|reflectance| [reflectance]);
            let scene = Scene {
                cloth,
                yarns: [&yarns[0], &yarns[1]],
                backing: backing.as_ref().map(|reflectance| &reflectance[..]),
                surface,
                seed,
            };
            // Batches take azimuths between those of the others.
            let turn = match azimuths {
                1 => 0.0,
                _ => 180.0 * (azimuth as f64 + (batch as f64 + 0.5) / effort.batches as f64) / azimuths as f64,
            };
            let beam = Beam {
                omega_in: omega_in(incidences[incidence], azimuth_deg + turn),
                number: number_of(incidences[incidence]) * azimuths + azimuth,
            };
            let turned = azimuth_deg + turn;
            let views = views_of(incidence).map(|theta| omega_out(theta, turned)).collect();
            let moments = RadianceMoments::new(effort.order, bins.clone(), turned, views);
            let caught = Volumetric::new(scene, particles)?.batch(&beam, &moments, batch).caught;
            Ok(caught.into_iter().flatten().collect())
        };
        let caught: Vec<Vec<f64>> = tasks.par_iter().map(trace).collect::<Result<_, _>>()?;
        let moments = RadianceMoments::new(effort.order, bins.clone(), 0.0, Vec::new());
        let weights: Vec<Vec<f64>> = (geometries.iter())
            .map(|geometry| moments.weights(geometry.theta_v_deg))
            .collect();
        let mut amounts = Array4::zeros((effort.batches, nodes.len(), geometries.len(), bins.bins()));
        let mut lengths: Array3<f64> = Array3::zeros((nodes.len(), bins.bins(), 2));
        for ([batch, node, incidence, _], caught) in tasks.iter().zip(&caught) {
            let lit = |(_, geometry): &(usize, &Geometry)| geometry.theta_i_deg == incidences[*incidence];
            for (view, (g, _)) in geometries.iter().enumerate().filter(lit).enumerate() {
                let weights = &weights[g];
                for bin in 0..bins.bins() {
                    let beta: f64 = (weights.iter().enumerate())
                        .map(|(k, weight)| weight * caught[moments.place(k, bin)])
                        .sum();
                    let [connected, length] = moments.places_of_view(view, bin);
                    amounts[[*batch, *node, g, bin]] += (beta + caught[connected]) / azimuths as f64;
                    // Lengths are taken from the connected light, which is never negative.
                    lengths[[*node, bin, 0]] += caught[connected];
                    lengths[[*node, bin, 1]] += caught[length];
                }
            }
        }
        let mut mean_mm = Array2::zeros((nodes.len(), bins.bins()));
        for ((node, bin), mean) in mean_mm.indexed_iter_mut() {
            let [amount, moment] = [0, 1].map(|k| lengths[[node, bin, k]]);
            *mean = bins.length_within(bin, if amount > 0.0 { moment / amount } else { f64::NAN });
        }
        Ok(Self {
            amounts,
            mean_mm,
            traced_mu_a_per_mm: nodes.iter().map(|node| node.mu_a_per_mm).collect(),
            bins,
        })
    }

    /// Factor of each bin of a node for another absorption, 1/mm.
    pub fn transmittance(&self, node: usize, mu_a_per_mm: f64) -> impl Iterator<Item = f64> + '_ {
        let change = mu_a_per_mm - self.traced_mu_a_per_mm[node];
        let means = self.mean_mm.index_axis(Axis(0), node);
        (0..self.bins.bins()).map(move |bin| self.bins.transmittance(bin, means[bin], change))
    }

    /// β of a node at each geometry for an absorption in 1/mm: `[batch][geometry]`.
    pub fn beta(&self, node: usize, mu_a_per_mm: f64) -> Array2<f64> {
        let factors: ndarray::Array1<f64> = self.transmittance(node, mu_a_per_mm).collect();
        let [batches, _, geometries, _] = *self.amounts.shape() else {
            return Array2::zeros((0, 0));
        };
        Array2::from_shape_fn((batches, geometries), |(batch, g)| {
            let row = self.amounts.slice(ndarray::s![batch, node, g, ..]);
            row.dot(&factors)
        })
    }
}
