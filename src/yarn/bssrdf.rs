use super::radiance_factor::{FactorCells, LightSide};
use super::{Effort, IncidentGrid, RadianceFactorGrid, Sharing, SurfaceGrid, Yarn, YarnError, add_scaled};
use crate::fault::{self, Fault};
use crate::geometry::{CellFinder, Sectors};
use crate::transport::{Entry, Ledger, Purpose, Stream};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Directions whose shares of f* are held at once before they are added in their order.
const HELD_DIRECTIONS: usize = 8;

/// Axes of a BSSRDF table: traced incident direction × exit azimuth × z × exit cell × wavelength, wavelength fastest. The
/// entry patch lies at azimuth 0; rotation takes it to every other. An incident direction stands for its cell of the
/// hemisphere. Values are fractions of the flux incident on the patch.
#[derive(Clone, Debug, PartialEq)]
pub struct BssrdfGrid {
    incident: IncidentGrid,
    surface: SurfaceGrid,
    radius_mm: f64,
    /// Upper edges of the cells of z > 0, mm; the same below 0, and one overflow cell at either end.
    z_edges_mm: Vec<f64>,
    wavelengths: usize,
}

impl BssrdfGrid {
    /// `z_cells` counts both halves, without overflow; its edges lie at R, 2R, 4R, …
    pub fn new(yarn: &Yarn, incident: IncidentGrid, surface: SurfaceGrid, z_cells: usize) -> Result<Self, YarnError> {
        if z_cells < 2 || !z_cells.is_multiple_of(2) {
            return Err(YarnError::Count {
                quantity: "z cells",
                expected: "an even number, 2 or more",
                found: z_cells,
            });
        }
        let radius_mm = yarn.cylinder.radius_mm();
        Ok(Self {
            incident,
            surface,
            radius_mm,
            z_edges_mm: (0..z_cells / 2).map(|k| radius_mm * 2f64.powi(k as i32)).collect(),
            wavelengths: yarn.wavelengths(),
        })
    }

    pub fn incident(&self) -> &IncidentGrid {
        &self.incident
    }

    pub fn surface(&self) -> &SurfaceGrid {
        &self.surface
    }

    pub fn z_edges_mm(&self) -> &[f64] {
        &self.z_edges_mm
    }

    /// Lengths of the axes in their order.
    pub fn shape(&self) -> [usize; 5] {
        [
            self.incident.traced(),
            self.surface.azimuths,
            2 * self.z_edges_mm.len() + 2,
            self.surface.exit.cells(),
            self.wavelengths,
        ]
    }

    fn values_per_direction(&self) -> usize {
        self.shape()[1..].iter().product()
    }

    /// S per fraction, 1/(sr mm²): S = F_out/(∫cosθ dω ΔB F_in), mean over the cell of radiance at B per flux entering at
    /// A. `None` in the overflow cells, which have no area.
    pub fn value_per_fraction(&self, z: usize, exit: usize) -> Option<f64> {
        let half = self.z_edges_mm.len();
        if z == 0 || z > 2 * half {
            return None;
        }
        let i = if z > half { z - half - 1 } else { half - z };
        let length = self.z_edges_mm[i] - if i == 0 { 0.0 } else { self.z_edges_mm[i - 1] };
        let area = self.radius_mm * TAU / self.surface.azimuths as f64 * length;
        Some(1.0 / (self.surface.exit.projected_solid_angle(exit) * area))
    }

    fn z_cell(&self, z_mm: f64) -> usize {
        let half = self.z_edges_mm.len();
        let beyond = self.z_edges_mm.partition_point(|&edge| edge <= z_mm.abs());
        if z_mm < 0.0 { half - beyond } else { half + 1 + beyond }
    }
}

/// Traces the entry patch from the cells of incident directions, and sums over the lit surface to f* as it goes: each
/// path knows the tilt and azimuth of its light exactly, so that no interpolation between directions blurs the sum.
pub struct PatchTracer<'a> {
    yarn: &'a Yarn,
    sharing: Vec<Sharing<'a>>,
    grid: BssrdfGrid,
    summed: RadianceFactorGrid,
    cells: FactorCells,
    around: Sectors,
    exit: CellFinder,
    effort: Effort,
}

/// Result of one batch.
#[derive(Clone, Debug, PartialEq)]
pub struct BssrdfBatch {
    /// Fractions, axes as [`BssrdfGrid`] says.
    pub fractions: Vec<f64>,
    /// f* as the sum of the BSSRDF over the lit surface, 1/sr: cell × wavelength, wavelength fastest.
    pub radiance_factor: Vec<f64>,
    /// See [`super::DirectBatch::passages`].
    pub passages: Vec<f64>,
    /// Traced direction × wavelength, wavelength fastest; means over the directions' cells.
    pub ledgers: Vec<Ledger>,
}

/// A direction's part of f*: the tilts it reaches.
struct Part {
    first_tilt: usize,
    values: Vec<f64>,
    passages: Vec<f64>,
    ledgers: Vec<Ledger>,
}

impl<'a> PatchTracer<'a> {
    pub fn new(
        yarn: &'a Yarn,
        grid: BssrdfGrid,
        summed: RadianceFactorGrid,
        effort: Effort,
    ) -> Result<Self, YarnError> {
        Ok(Self {
            yarn,
            sharing: yarn.sharing()?,
            summed,
            cells: FactorCells::new(summed)?,
            around: grid.surface.sectors()?,
            exit: grid.surface.exit.finder(),
            grid,
            effort,
        })
    }

    pub fn grid(&self) -> &BssrdfGrid {
        &self.grid
    }

    /// Traces one batch from every direction.
    pub fn batch(&self, batch: usize) -> BssrdfBatch {
        let wavelengths = self.grid.wavelengths;
        let mut fractions = vec![0.0; self.grid.shape().iter().product()];
        let mut radiance_factor = vec![0.0; self.summed.cells() * wavelengths];
        let mut passages = vec![0.0; self.summed.passages() * wavelengths];
        let mut ledgers = Vec::with_capacity(self.grid.incident.traced() * wavelengths);
        let per_direction = self.grid.values_per_direction();
        let per_tilt = |count: usize| count / self.summed.tilts() * wavelengths;
        for (held, fractions) in fractions.chunks_mut(per_direction * HELD_DIRECTIONS).enumerate() {
            let parts: Vec<Part> = fractions
                .par_chunks_mut(per_direction)
                .enumerate()
                .map(|(k, fractions)| self.direction(batch, held * HELD_DIRECTIONS + k, fractions))
                .collect();
            for part in parts {
                let target = &mut radiance_factor[part.first_tilt * per_tilt(self.summed.cells())..];
                target.iter_mut().zip(part.values).for_each(|(t, v)| *t += v);
                let target = &mut passages[part.first_tilt * per_tilt(self.summed.passages())..];
                target.iter_mut().zip(part.passages).for_each(|(t, v)| *t += v);
                ledgers.extend(part.ledgers);
            }
        }
        let exits = self.summed.surface().exit().cells();
        for (cell, row) in radiance_factor.chunks_exact_mut(wavelengths).enumerate() {
            let factor = self.summed.radiance_factor_per_light(cell % exits);
            row.iter_mut().for_each(|value| *value *= factor);
        }
        for (tilt, rows) in passages.chunks_exact_mut(per_tilt(self.summed.passages())).enumerate() {
            let factor = self.summed.fraction_per_light(tilt);
            rows.iter_mut().for_each(|value| *value *= factor);
        }
        BssrdfBatch {
            fractions,
            radiance_factor,
            passages,
            ledgers,
        }
    }

    fn direction(&self, batch: usize, direction: usize, fractions: &mut [f64]) -> Part {
        let wavelengths = self.grid.wavelengths;
        let (summed, surface) = (&self.summed, &self.grid.surface);
        let incident = &self.grid.incident;
        let cell = incident.cell(direction);
        let [low, high] = cell.sine_of_tilt();
        let tilts = self.cells.tilt(low)..=self.cells.tilt(high);
        let first_cell = summed.cell(*tilts.start(), 0, 0);
        let first_passage = summed.passage(*tilts.start(), 0, false, 0);
        let reached = |count: usize| count / summed.tilts() * tilts.clone().count() * wavelengths;
        // The part of the hemisphere that this direction and its mirror images stand for.
        let seen = incident.images() * cell.solid_angle();
        let mut values = vec![0.0; reached(summed.cells())];
        let mut passages = vec![0.0; reached(summed.passages())];
        let mut ledgers = Vec::with_capacity(wavelengths);
        let width = TAU / surface.azimuths as f64;
        let inverse_radius = 1.0 / self.yarn.cylinder.radius_mm();
        let (half_sin, half_cos) = (0.5 * width).sin_cos();
        let [_, _, z_cells, exits, _] = self.grid.shape();
        let paths = self.effort.paths_per_batch;
        let scale = 1.0 / paths as f64;
        for sharing in &self.sharing {
            let here = sharing.first..sharing.first + sharing.interior.wavelengths();
            let stream = Stream::open(self.effort.seed, Purpose::Bssrdf, direction, batch, sharing.first);
            let traced = self.yarn.walk(&sharing.interior).trace(
                stream,
                paths,
                |[zenith, turn, around, _]| {
                    let position = self.yarn.cylinder.at(width * (around - 0.5));
                    let frame = self.yarn.cylinder.frame(&position);
                    let omega_in = frame.to_world(&cell.direction(*zenith, *turn));
                    Entry {
                        position,
                        normal: frame.normal,
                        omega_in,
                    }
                },
                |exit| {
                    if !exit.scattered {
                        return;
                    }
                    // The entry patch is the middle of sector 0.
                    let (x, z) = (exit.normal.x, exit.normal.z);
                    let azimuth = self
                        .around
                        .sector(z * half_cos - x * half_sin, x * half_cos + z * half_sin);
                    let out = self.yarn.cylinder.frame(&exit.position).to_local(&exit.direction);
                    let z = self.grid.z_cell(exit.position.y);
                    let at = (azimuth * z_cells + z) * exits + self.exit.cell(&out);
                    if !(fault::active(Fault::ZOverflow) && (z == 0 || z == z_cells - 1)) {
                        add_scaled(&mut fractions[at * wavelengths..][here.clone()], exit.weights, scale);
                    }
                    let omega_in = &exit.omega_in;
                    let light = LightSide {
                        x: omega_in.x,
                        z: omega_in.z,
                        tilt: self.cells.tilt(omega_in.y.abs()).clamp(*tilts.start(), *tilts.end()),
                        axis_reversed: omega_in.y < 0.0,
                    };
                    // cos α of the light's azimuth from the patch's normal.
                    let facing = (exit.entry.x * omega_in.x + exit.entry.z * omega_in.z) * inverse_radius;
                    let across = (omega_in.x * omega_in.x + omega_in.z * omega_in.z).sqrt();
                    let cosine = match fault::active(Fault::MissingCosine) {
                        true => 1.0,
                        false => facing / across.max(f64::MIN_POSITIVE),
                    };
                    let factor = scale * seen * cosine;
                    let at = self.cells.cell(&light, &exit.normal, &exit.direction) - first_cell;
                    add_scaled(&mut values[at * wavelengths..][here.clone()], exit.weights, factor);
                    let entry = self.cells.entry(&light, &exit.entry);
                    let at = self.cells.passage(&light, entry, &exit.normal) - first_passage;
                    add_scaled(&mut passages[at * wavelengths..][here.clone()], exit.weights, factor);
                },
            );
            ledgers.extend(traced.ledgers.iter().map(|sum| sum.scaled(scale)));
        }
        Part {
            first_tilt: *tilts.start(),
            values,
            passages,
            ledgers,
        }
    }
}
