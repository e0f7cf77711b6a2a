use super::response_cells::{LightSide, ResponseCells};
use super::tracer::{LightSource, Tracer};
use super::{Effort, IncidentGrid, SurfaceGrid, Yarn, YarnError, YarnResponse, YarnResponseGrid, add_scaled};
use crate::fault::{self, Fault};
use crate::geometry::{CellFinder, Sectors};
use crate::transport::{Cylinder, ENTRY_COORDINATES, Entry, Ledger, Purpose};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Number of directions whose parts of f* are held in memory before they are added in order.
const HELD_DIRECTIONS: usize = 8;

/// Axes of a BSSRDF table: traced incident direction × exit azimuth × z × exit cell × wavelength, wavelength fastest.
/// The entry patch lies at azimuth 0; rotation maps it to every other. An incident direction represents its cell of the
/// hemisphere. Values are fractions of the flux incident on the patch.
#[derive(Clone, Debug, PartialEq)]
pub struct BssrdfGrid {
    incident: IncidentGrid,
    surface: SurfaceGrid,
    radius_mm: f64,
    /// Upper edges of the cells with z > 0, mm. Cells with z < 0 mirror them; one overflow cell lies at either end.
    z_edges_mm: Vec<f64>,
    wavelengths: usize,
}

impl BssrdfGrid {
    /// `z_cells` is the number of cells along the yarn in both halves, without the overflow cells; their edges lie at
    /// ±R, ±2R, ±4R, …
    ///
    /// # Errors
    /// [`YarnError::Count`] if `z_cells` is odd or 0.
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

    /// Grid of incident directions.
    pub fn incident(&self) -> &IncidentGrid {
        &self.incident
    }

    /// Cells of the surface and of exit directions.
    pub fn surface(&self) -> &SurfaceGrid {
        &self.surface
    }

    /// Upper edges of the cells with z > 0, mm.
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

    /// Factor from fraction to BSSRDF, 1/(sr mm²): S = F_out/(∫cosθ dω ΔB F_in), the mean over the cell of radiance at
    /// B per flux entering at A. `None` in the overflow cells, which have no finite area.
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

/// Uniform irradiance on the patch at azimuth 0; a part is the cell of one of the incident directions.
struct Patch {
    cylinder: Cylinder,
    incident: IncidentGrid,
    /// Width of the patch in azimuth, radians.
    width: f64,
}

impl LightSource for Patch {
    fn purpose(&self) -> Purpose {
        Purpose::Bssrdf
    }

    #[inline(always)]
    fn entry(&self, part: usize, [zenith, azimuth, around, _]: &[f64; ENTRY_COORDINATES]) -> Entry {
        let position = self.cylinder.at(self.width * (around - 0.5));
        let frame = self.cylinder.frame(&position);
        Entry {
            position,
            normal: frame.normal,
            omega_in: frame.to_world(&self.incident.cell(part).direction(*zenith, *azimuth)),
        }
    }
}

/// Traces light from the cells of incident directions through the entry patch to the BSSRDF, and integrates it over the
/// lit surface to f* at the same time. The integral uses the exact tilt and azimuth of each path's light, so no
/// interpolation between directions blurs it.
pub struct PatchTracer<'a> {
    tracer: Tracer<'a, Patch>,
    grid: BssrdfGrid,
    summed: YarnResponseGrid,
    cells: ResponseCells,
    around: Sectors,
    exit: CellFinder,
}

/// Result of one batch.
#[derive(Clone, Debug, PartialEq)]
pub struct BssrdfBatch {
    /// Fractions of the flux incident on the patch; axes as in [`BssrdfGrid`].
    pub fractions: Vec<f64>,
    /// f* as the integral of the BSSRDF over the lit surface.
    pub response: YarnResponse,
    /// Traced direction × wavelength, wavelength fastest; means over the directions' cells.
    pub ledgers: Vec<Ledger>,
}

/// Contribution of one direction to f*, at the tilts it covers.
struct Part {
    first_tilt: usize,
    values: Vec<f64>,
    transfer: Vec<f64>,
    ledgers: Vec<Ledger>,
}

impl<'a> PatchTracer<'a> {
    /// `effort` gives the paths for each traced direction.
    pub fn new(yarn: &'a Yarn, grid: BssrdfGrid, summed: YarnResponseGrid, effort: Effort) -> Result<Self, YarnError> {
        let patch = Patch {
            cylinder: yarn.cylinder,
            incident: grid.incident,
            width: TAU / grid.surface.azimuths as f64,
        };
        Ok(Self {
            tracer: Tracer::new(yarn, patch, effort)?,
            summed,
            cells: ResponseCells::new(summed)?,
            around: grid.surface.sectors()?,
            exit: grid.surface.exit.finder(),
            grid,
        })
    }

    /// Axes of the BSSRDF.
    pub fn grid(&self) -> &BssrdfGrid {
        &self.grid
    }

    /// Traces one batch from every direction.
    pub fn batch(&self, batch: usize) -> BssrdfBatch {
        let wavelengths = self.grid.wavelengths;
        let mut fractions = vec![0.0; self.grid.shape().iter().product()];
        let mut response = YarnResponse::zeros(self.summed, wavelengths);
        let [factor, transfer] = response.values_mut();
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
                let target = &mut factor[part.first_tilt * per_tilt(self.summed.cells())..];
                target.iter_mut().zip(part.values).for_each(|(t, v)| *t += v);
                let target = &mut transfer[part.first_tilt * per_tilt(self.summed.transfer_cells())..];
                target.iter_mut().zip(part.transfer).for_each(|(t, v)| *t += v);
                ledgers.extend(part.ledgers);
            }
        }
        let exits = self.summed.surface().exit().cells();
        for (cell, row) in factor.chunks_exact_mut(wavelengths).enumerate() {
            let factor = self.summed.response_per_light(cell % exits);
            row.iter_mut().for_each(|value| *value *= factor);
        }
        let of_tilts = transfer.chunks_exact_mut(per_tilt(self.summed.transfer_cells()));
        for (tilt, rows) in of_tilts.enumerate() {
            let factor = self.summed.fraction_per_light(tilt);
            rows.iter_mut().for_each(|value| *value *= factor);
        }
        BssrdfBatch {
            fractions,
            response,
            ledgers,
        }
    }

    fn direction(&self, batch: usize, direction: usize, fractions: &mut [f64]) -> Part {
        let wavelengths = self.grid.wavelengths;
        let (summed, incident) = (&self.summed, &self.grid.incident);
        let cylinder = &self.tracer.yarn().cylinder;
        let cell = incident.cell(direction);
        let [low, high] = cell.sine_of_tilt();
        let tilts = self.cells.tilt(low)..=self.cells.tilt(high);
        let first_cell = summed.cell(*tilts.start(), 0, 0);
        let first_transfer = summed.transfer_cell(*tilts.start(), 0, false, 0);
        let reached = |count: usize| count / summed.tilts() * tilts.clone().count() * wavelengths;
        // Solid angle that this direction and its mirror images represent.
        let seen = incident.images() * cell.solid_angle();
        let mut values = vec![0.0; reached(summed.cells())];
        let mut transfer = vec![0.0; reached(summed.transfer_cells())];
        let inverse_radius = 1.0 / cylinder.radius_mm();
        let (half_sin, half_cos) = (0.5 * self.tracer.source.width).sin_cos();
        let [_, _, z_cells, exits, _] = self.grid.shape();
        let share = self.tracer.share_of_path();
        let ledgers = self.tracer.part(batch, direction, |exit, here| {
            if !exit.scattered {
                return;
            }
            // The entry patch is the middle of sector 0.
            let (x, z) = (exit.normal.x, exit.normal.z);
            let azimuth = self
                .around
                .sector(z * half_cos - x * half_sin, x * half_cos + z * half_sin);
            let out = cylinder.frame(&exit.position).to_local(&exit.direction);
            let z = self.grid.z_cell(exit.position.y);
            let at = (azimuth * z_cells + z) * exits + self.exit.cell(&out);
            if !(fault::active(Fault::ZOverflow) && (z == 0 || z == z_cells - 1)) {
                add_scaled(&mut fractions[at * wavelengths..][here.clone()], exit.weights, share);
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
            let factor = share * seen * cosine;
            let at = self.cells.cell(&light, &exit.normal, &exit.direction) - first_cell;
            add_scaled(&mut values[at * wavelengths..][here.clone()], exit.weights, factor);
            let entry = self.cells.entry(&light, &exit.entry);
            let at = self.cells.transfer_cell(&light, entry, &exit.normal) - first_transfer;
            add_scaled(&mut transfer[at * wavelengths..][here], exit.weights, factor);
        });
        Part {
            first_tilt: *tilts.start(),
            values,
            transfer,
            ledgers,
        }
    }
}
