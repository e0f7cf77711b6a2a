use super::{Effort, IncidentGrid, RadianceFactorGrid, RadianceFactorTable, SurfaceGrid, Yarn, YarnError};
use crate::geometry::Vec3;
use crate::optics::fresnel;
use crate::transport::{Ledger, LedgerEntry, Purpose, Stream, Walk};
use ndarray::Array5;
use rand::RngExt;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Three-point Gauss–Legendre rule on −1..1.
const GAUSS: [(f64, f64); 3] = [
    (-0.774_596_669_241_483_4, 5.0 / 9.0),
    (0.0, 8.0 / 9.0),
    (0.774_596_669_241_483_4, 5.0 / 9.0),
];

/// The yarn's BSSRDF, tallied from one entry patch at azimuth 0 over which entry points are jittered; rotation takes it
/// to every other patch. Stored are fractions of the flux incident on the patch.
#[derive(Clone, Debug)]
pub struct Bssrdf {
    incident: IncidentGrid,
    surface: SurfaceGrid,
    radius_mm: f64,
    /// Upper edges of the cells of z > 0, mm; the same below 0, and one overflow cell at either end.
    z_edges_mm: Vec<f64>,
    /// Axes: wavelength, traced direction, exit azimuth, z (overflow first and last), exit cell.
    fraction: Array5<f64>,
}

impl Bssrdf {
    pub fn incident(&self) -> &IncidentGrid {
        &self.incident
    }

    pub fn surface(&self) -> &SurfaceGrid {
        &self.surface
    }

    pub fn z_edges_mm(&self) -> &[f64] {
        &self.z_edges_mm
    }

    /// Axes: wavelength, traced direction, exit azimuth, z (overflow first and last), exit cell.
    pub fn fractions(&self) -> &Array5<f64> {
        &self.fraction
    }

    /// S = F_out/(∫cosθ dω ΔB F_in), 1/(sr mm²): mean over the cell of radiance at B per flux entering at A. `None` in
    /// the overflow cells, which have no area.
    pub fn value(&self, wavelength: usize, traced: usize, azimuth: usize, z: usize, exit: usize) -> Option<f64> {
        let half = self.z_edges_mm.len();
        if z == 0 || z > 2 * half {
            return None;
        }
        let i = if z > half { z - half - 1 } else { half - z };
        let length = self.z_edges_mm[i] - if i == 0 { 0.0 } else { self.z_edges_mm[i - 1] };
        let area = self.radius_mm * TAU / self.surface.azimuths as f64 * length;
        let solid = self.surface.exit.projected_solid_angle(exit);
        Some(self.fraction[[wavelength, traced, azimuth, z, exit]] / (solid * area))
    }

    /// Fraction of the incident flux that the table says is scattered; the ledger's `scattered` to rounding.
    pub fn scattered(&self, wavelength: usize, traced: usize) -> f64 {
        self.fraction.slice(ndarray::s![wavelength, traced, .., .., ..]).sum()
    }

    /// Fraction in the z overflow cells: leaves farther down the yarn than the table's last edge.
    pub fn overflow(&self, wavelength: usize, traced: usize) -> f64 {
        let last = self.fraction.dim().3 - 1;
        [0, last]
            .iter()
            .map(|&z| self.fraction.slice(ndarray::s![wavelength, traced, .., z, ..]).sum())
            .sum()
    }
}

/// Result of tracing the patch from every incident direction.
#[derive(Clone, Debug)]
pub struct BssrdfRun {
    pub bssrdf: Bssrdf,
    /// f* as the sum of the BSSRDF over the lit surface.
    pub table: RadianceFactorTable,
    /// Ledger of [wavelength][traced direction].
    pub ledgers: Vec<Vec<LedgerEntry>>,
}

/// One term of f* = Σ S cosθ ΔA: cell (tilt, azimuth) of f* takes `weight` times the fraction that direction `traced`
/// sends to exit azimuth `azimuth`, seen in the mirrors.
struct Term {
    cell: usize,
    azimuth: usize,
    /// Index into [`mirror_images`].
    mirrors: usize,
    weight: f64,
}

/// Result of one direction at one wavelength.
struct Patch {
    /// azimuth × z × exit, mean of the batches.
    fraction: Vec<f64>,
    /// azimuth × exit of each batch, z summed.
    flat: Vec<Vec<f64>>,
    ledgers: Vec<Ledger>,
}

/// Traces the BSSRDF and sums it to f* at `tilts` tilts. `z_cells` counts both halves, without overflow; its edges lie at
/// R, 2R, 4R, … `done` is told the paths of each finished piece of work.
pub fn trace_bssrdf(
    yarn: &Yarn,
    incident: IncidentGrid,
    surface: SurfaceGrid,
    tilts: usize,
    z_cells: usize,
    effort: Effort,
    done: &(dyn Fn(u64) + Sync),
) -> Result<BssrdfRun, YarnError> {
    if z_cells < 2 || !z_cells.is_multiple_of(2) {
        return Err(YarnError::Count {
            quantity: "z cells",
            expected: "an even number, 2 or more",
            found: z_cells,
        });
    }
    let grid = RadianceFactorGrid::new(tilts, surface)?;
    let wavelengths = yarn.wavelengths();
    let radius_mm = yarn.cylinder.radius_mm();
    let z_edges_mm: Vec<f64> = (0..z_cells / 2).map(|k| radius_mm * 2f64.powi(k as i32)).collect();
    let exits = surface.exit.cells();
    let shape = (wavelengths, incident.traced(), surface.azimuths, z_cells + 2, exits);
    let solid_angle: Vec<f64> = (0..exits).map(|e| surface.exit.projected_solid_angle(e)).collect();
    let mut fraction = Array5::zeros(shape);
    let mut table = RadianceFactorTable::zeros(grid, wavelengths, effort.batches);
    let mut ledgers = Vec::with_capacity(wavelengths);
    for wavelength in 0..wavelengths {
        let patches: Vec<Patch> = (0..incident.traced())
            .into_par_iter()
            .map(|direction| {
                let patch = trace_patch(yarn, &incident, &surface, &z_edges_mm, effort, direction, wavelength);
                done((effort.batches * effort.paths_per_batch) as u64);
                patch
            })
            .collect();
        let terms = terms(&grid, &incident, yarn.medium.host_index()[wavelength]);
        table.batches.par_iter_mut().enumerate().for_each(|(batch, values)| {
            let mut sum = vec![0.0; grid.cells()];
            for (patch, terms) in patches.iter().zip(&terms) {
                let seen = mirror_images(&patch.flat[batch], &surface);
                for term in terms {
                    let from = &seen[term.mirrors][term.azimuth * exits..(term.azimuth + 1) * exits];
                    let to = &mut sum[term.cell * exits..(term.cell + 1) * exits];
                    to.iter_mut().zip(from).for_each(|(t, f)| *t += term.weight * f);
                }
            }
            for (c, value) in sum.into_iter().enumerate() {
                values[c * wavelengths + wavelength] = value / solid_angle[c % exits];
            }
        });
        let mut entries = Vec::with_capacity(patches.len());
        for (direction, patch) in patches.into_iter().enumerate() {
            let mut target = fraction.slice_mut(ndarray::s![wavelength, direction, .., .., ..]);
            target.iter_mut().zip(&patch.fraction).for_each(|(t, f)| *t = *f);
            entries.push(LedgerEntry::from_batches(&patch.ledgers));
        }
        ledgers.push(entries);
    }
    Ok(BssrdfRun {
        bssrdf: Bssrdf {
            incident,
            surface,
            radius_mm,
            z_edges_mm,
            fraction,
        },
        table,
        ledgers,
    })
}

fn trace_patch(
    yarn: &Yarn,
    incident: &IncidentGrid,
    surface: &SurfaceGrid,
    z_edges_mm: &[f64],
    effort: Effort,
    direction: usize,
    wavelength: usize,
) -> Patch {
    let local = incident.traced_direction(direction);
    let walk = Walk {
        shape: &yarn.cylinder,
        interior: yarn.interior(wavelength),
        roulette: yarn.roulette,
    };
    let (exits, z_cells) = (surface.exit.cells(), 2 * z_edges_mm.len() + 2);
    let width = TAU / surface.azimuths as f64;
    let n = effort.paths_per_batch;
    let mut fraction = vec![0.0; surface.azimuths * z_cells * exits];
    let mut flat = Vec::with_capacity(effort.batches);
    let mut ledgers = Vec::with_capacity(effort.batches);
    for batch in 0..effort.batches {
        let mut rng = Stream::open(effort.seed, Purpose::Bssrdf, direction, batch, wavelength);
        let mut sum = vec![0.0; fraction.len()];
        let mut ledger = Ledger::default();
        for path in 0..n {
            let azimuth = width * ((path as f64 + rng.random::<f64>()) / n as f64 - 0.5);
            let position = yarn.cylinder.at(azimuth);
            let frame = yarn.cylinder.frame(&position);
            let omega_in = frame.to_world(&local);
            ledger.add(&walk.run(&mut rng, &position, &frame.normal, &omega_in, |exit| {
                if exit.scattered {
                    let turn = exit.normal.x.atan2(exit.normal.z) / width + 0.5;
                    let a = (turn.floor() as isize).rem_euclid(surface.azimuths as isize) as usize;
                    let half = z_edges_mm.partition_point(|&edge| edge <= exit.position.y.abs());
                    let z = if exit.position.y < 0.0 {
                        z_edges_mm.len() - half
                    } else {
                        z_edges_mm.len() + 1 + half
                    };
                    let out = yarn.cylinder.frame(&exit.position).to_local(&exit.direction);
                    sum[(a * z_cells + z) * exits + surface.exit.cell(&out)] += exit.weight;
                }
            }));
        }
        let scale = 1.0 / n as f64;
        let mut batch_flat = vec![0.0; surface.azimuths * exits];
        let rows = sum.chunks_exact(exits).zip(fraction.chunks_exact_mut(exits));
        for (row, (values, total)) in rows.enumerate() {
            let flat_row = &mut batch_flat[row / z_cells * exits..][..exits];
            for ((value, total), flat) in values.iter().zip(total).zip(flat_row) {
                *flat += value * scale;
                *total += value * scale / effort.batches as f64;
            }
        }
        flat.push(batch_flat);
        ledgers.push(ledger.scaled(scale));
    }
    Patch {
        fraction,
        flat,
        ledgers,
    }
}

/// An (azimuth, exit) table as it is, with the tangent reversed, with the axis reversed, and with both. Azimuth itself is
/// left as it is.
fn mirror_images(flat: &[f64], surface: &SurfaceGrid) -> [Vec<f64>; 4] {
    let exits = surface.exit.cells();
    std::array::from_fn(|mirrors| {
        let from: Vec<usize> = (0..exits)
            .map(|e| surface.exit.mirrored(e, mirrors & 1 != 0, mirrors & 2 != 0))
            .collect();
        flat.chunks_exact(exits)
            .flat_map(|row| from.iter().map(|&e| row[e]))
            .collect()
    })
}

/// The terms of f* by traced direction. Between incident directions it is the distribution of the light that got in
/// which is interpolated, since Fresnel's transmittance, taken exactly, falls off too steeply towards grazing.
fn terms(grid: &RadianceFactorGrid, incident: &IncidentGrid, index: f64) -> Vec<Vec<Term>> {
    let around = grid.surface().azimuths;
    let width = TAU / around as f64;
    let entered = |cosine: f64| 1.0 - fresnel::reflectance(cosine, index);
    let mut terms: Vec<Vec<Term>> = (0..incident.traced()).map(|_| Vec::new()).collect();
    for tilt in 0..grid.tilts() {
        let (sin_psi, cos_psi) = grid.tilt(tilt).sin_cos();
        for patch in 0..around {
            // Weight of each direction and mirror in this patch, which shares its edges with the table's azimuth cells;
            // the light stands at azimuth 0.
            let mut weights = vec![[0.0; 4]; incident.traced()];
            for (node, gauss_weight) in GAUSS {
                let alpha = width * (patch as f64 + 0.5 + 0.5 * node);
                let omega_in = Vec3::new(-alpha.sin() * cos_psi, sin_psi, alpha.cos() * cos_psi);
                if omega_in.z <= 0.0 {
                    continue;
                }
                let flux = 0.5 * gauss_weight * omega_in.z * entered(omega_in.z);
                for corner in incident.corners(&omega_in) {
                    let at_node = entered(incident.traced_direction(corner.traced).z);
                    let mirrors = usize::from(corner.mirror_tangent) + 2 * usize::from(corner.mirror_axis);
                    weights[corner.traced][mirrors] += corner.weight * flux / at_node;
                }
            }
            for (direction, weights) in weights.into_iter().enumerate() {
                for (mirrors, weight) in weights.into_iter().enumerate().filter(|(_, w)| *w != 0.0) {
                    for target in 0..grid.azimuths() {
                        let apart = (target + around - patch) % around;
                        terms[direction].push(Term {
                            cell: tilt * grid.azimuths() + target,
                            azimuth: if mirrors & 1 != 0 {
                                (around - apart) % around
                            } else {
                                apart
                            },
                            mirrors,
                            weight,
                        });
                    }
                }
            }
        }
    }
    terms
}
