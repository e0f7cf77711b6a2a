use super::{SurfaceGrid, YarnError};
use crate::fault::{self, Fault};
use crate::geometry::{Bilinear, CellFinder, Sectors, Vec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::iter::zip;

/// Axes of a radiance factor table. By the cylinder's symmetry f*(ω_in, ω_out) depends on the light's tilt out of the
/// yarn's normal plane, on the azimuth of the surface point from the light, and on ω_out; both mirrors fold the table
/// to tilts 0..90° and azimuths 0..180°. All axes are cells, and a table holds means over them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadianceFactorGrid {
    tilts: usize,
    surface: SurfaceGrid,
}

const ENTRIES: usize = 9;

impl RadianceFactorGrid {
    /// `tilts` is 1 or more.
    pub fn new(tilts: usize, surface: SurfaceGrid) -> Result<Self, YarnError> {
        if tilts == 0 {
            return Err(YarnError::Count {
                quantity: "tilts",
                expected: "1 or more",
                found: tilts,
            });
        }
        Ok(Self { tilts, surface })
    }

    pub fn tilts(&self) -> usize {
        self.tilts
    }

    pub fn surface(&self) -> &SurfaceGrid {
        &self.surface
    }

    /// Azimuth cells from the light's meridian to the one opposite.
    pub fn azimuths(&self) -> usize {
        self.surface.azimuths / 2
    }

    pub fn cells(&self) -> usize {
        self.tilts * self.azimuths() * self.surface.exit.cells()
    }

    /// Cells of a quarter of the section, from the light's meridian to where the light grazes: light comes in at one of them or
    /// at its mirror image. They are 10° wide whatever the grid: a yarn's light between yarns is the same with narrower ones.
    pub fn entries(&self) -> usize {
        ENTRIES
    }

    /// Azimuths from the light's meridian between which entry cell k lies, radians.
    pub fn entry_edges(&self, k: usize) -> [f64; 2] {
        [k, k + 1].map(|edge| edge as f64 * FRAC_PI_2 / self.entries() as f64)
    }

    /// Cells of a table of where light that came in at one place of the section leaves: (tilt, entry, side, azimuth).
    pub fn passages(&self) -> usize {
        self.tilts * self.entries() * 2 * self.azimuths()
    }

    /// Index of (tilt, entry, side, azimuth): light that leaves on the `opposite` side of the light's meridian or on its own.
    pub fn passage(&self, tilt: usize, entry: usize, opposite: bool, azimuth: usize) -> usize {
        ((tilt * self.entries() + entry) * 2 + usize::from(opposite)) * self.azimuths() + azimuth
    }

    /// Middle of tilt cell k, radians.
    pub fn tilt(&self, k: usize) -> f64 {
        (k as f64 + 0.5) * FRAC_PI_2 / self.tilts as f64
    }

    /// Tilts between which cell k lies, radians.
    pub fn tilt_edges(&self, k: usize) -> [f64; 2] {
        [k, k + 1].map(|edge| edge as f64 * FRAC_PI_2 / self.tilts as f64)
    }

    /// Mean of cos ψ over tilt cell k.
    pub fn mean_cosine(&self, k: usize) -> f64 {
        let [low, high] = self.tilt_edges(k);
        (high.sin() - low.sin()) / (high - low)
    }

    /// Index of (tilt, azimuth, exit cell).
    pub fn cell(&self, tilt: usize, azimuth: usize, exit: usize) -> usize {
        (tilt * self.azimuths() + azimuth) * self.surface.exit.cells() + exit
    }

    /// f* in a cell per fraction of the flux of all light of the tilt's cell that leaves through it, 1/sr: radiance of the
    /// cell over irradiance normal to the beam, for flux 2R cos ψ per length of yarn and both mirror images of the
    /// cell, 2 RΔφ long.
    pub fn radiance_factor_per_fraction(&self, tilt: usize, exit: usize) -> f64 {
        let width = TAU / self.surface.azimuths as f64;
        let cosine = match fault::active(Fault::FactorOverCosine) {
            true => 1.0,
            false => self.mean_cosine(tilt),
        };
        cosine / (width * self.surface.exit.projected_solid_angle(exit))
    }

    /// Of all light of the tilt's cell, the fraction per ∫∫ (fraction of the flux on a patch) cos α dω, as in
    /// [`Self::radiance_factor_per_light`].
    pub(super) fn fraction_per_light(&self, tilt: usize) -> f64 {
        let tilt_width = FRAC_PI_2 / self.tilts as f64;
        0.25 / (tilt_width * self.mean_cosine(tilt))
    }

    /// f* in a cell per ∫∫ (fraction of the flux on a patch that leaves through it) cos α dω, 1/sr: the sum of the BSSRDF
    /// over the lit surface, mean over the tilts of the cell. α is the light's azimuth from the patch's normal, and ω runs over
    /// the whole hemisphere of the patch, which holds each tilt twice.
    pub(super) fn radiance_factor_per_light(&self, exit: usize) -> f64 {
        let width = TAU / self.surface.azimuths as f64;
        let tilt_width = FRAC_PI_2 / self.tilts as f64;
        0.25 / (tilt_width * width * self.surface.exit.projected_solid_angle(exit))
    }
}

/// Weights of the cells of a radiance factor table whose weighted sum is a mean of f* over many pairs of directions.
/// They know no wavelength, no medium, and no value of f*: any table on the same grid may be summed with them.
#[derive(Clone, Debug, PartialEq)]
pub struct FactorWeights {
    /// Ascending.
    cells: Vec<u32>,
    weights: Vec<f64>,
}

impl FactorWeights {
    /// Σ weight · f* at every wavelength, in the order of the cells: `table` is one batch's, wavelength fastest.
    pub fn contract(&self, table: &[f64], wavelengths: usize) -> Vec<f64> {
        let mut sum = vec![0.0; wavelengths];
        for (&cell, weight) in zip(&self.cells, &self.weights) {
            let row = &table[cell as usize * wavelengths..][..wavelengths];
            sum.iter_mut().zip(row).for_each(|(s, f)| *s += weight * f);
        }
        sum
    }
}

/// Adds up, cell by cell, the weights of the multilinear interpolation of f* at pairs of directions.
pub struct WeightTally {
    grid: RadianceFactorGrid,
    /// 1/cos ψ of the grid's tilts.
    tilt_secants: Vec<f64>,
    weights: Vec<f64>,
    /// A bit for each cell that was added to.
    touched: Vec<u64>,
}

impl WeightTally {
    pub fn new(grid: RadianceFactorGrid) -> Self {
        Self {
            grid,
            tilt_secants: (0..grid.tilts()).map(|k| 1.0 / grid.mean_cosine(k)).collect(),
            weights: vec![0.0; grid.cells()],
            touched: vec![0; grid.cells().div_ceil(64)],
        }
    }

    /// Adds weights such that f* = Σ weight · table at a local direction (tangent, axis, normal) towards the light,
    /// anywhere on the sphere, and one towards the viewer, `seen` on the exit grid. Between tilts, f*/cos ψ is what is
    /// linear.
    #[inline]
    pub fn add(&mut self, omega_in: &Vec3, seen: &Bilinear) {
        let sin_tilt = omega_in.y.abs().min(1.0);
        let axis_reversed = omega_in.y < 0.0 && !fault::active(Fault::AxisMirror);
        // Azimuth of the point as seen from the light.
        let sign = if fault::active(Fault::AzimuthSign) { 1.0 } else { -1.0 };
        let azimuth = sign * omega_in.x.atan2(omega_in.z);
        let tangent_reversed = azimuth < 0.0;
        // Places between the nodes, counted from one before the first.
        let (tilts, azimuths) = (self.grid.tilts(), self.grid.azimuths());
        let steps =
            sin_tilt.asin() / FRAC_PI_2 * tilts as f64 + if fault::active(Fault::TiltHalfCell) { 1.0 } else { 0.5 };
        let turns = azimuth.abs() / PI * azimuths as f64 + 0.5;
        let cos_tilt = (1.0 - sin_tilt * sin_tilt).sqrt();
        let (low, near) = (steps as usize, turns as usize);
        let (wt, wa) = (steps - low as f64, turns - near as f64);
        for (k, weight_k) in [(low, 1.0 - wt), (low + 1, wt)] {
            // Below the first node lies its own mirror image.
            let mirror_axis = axis_reversed != (k == 0);
            let node = k.clamp(1, tilts) - 1;
            let weight_k = weight_k * cos_tilt * self.tilt_secants[node];
            for (a, weight_a) in [(near, 1.0 - wa), (near + 1, wa)] {
                let beyond = a == 0 || a > azimuths;
                let mirror_tangent = tangent_reversed != beyond;
                let row = self.grid.cell(node, a.clamp(1, azimuths) - 1, 0);
                let weight = weight_k * weight_a;
                for (exit, weight_e) in zip(seen.cells(mirror_tangent, mirror_axis), seen.weights()) {
                    let cell = row + exit;
                    self.weights[cell] += weight * weight_e;
                    self.touched[cell / 64] |= 1 << (cell % 64);
                }
            }
        }
    }

    /// The sums times `factor`; leaves the tally empty.
    pub fn drain(&mut self, factor: f64) -> FactorWeights {
        let count = self.touched.iter().map(|bits| bits.count_ones() as usize).sum();
        let mut cells = Vec::with_capacity(count);
        let mut weights = Vec::with_capacity(count);
        for (place, bits) in self.touched.iter_mut().enumerate() {
            while *bits != 0 {
                let cell = place * 64 + bits.trailing_zeros() as usize;
                *bits &= *bits - 1;
                cells.push(cell as u32);
                weights.push(factor * std::mem::take(&mut self.weights[cell]));
            }
        }
        FactorWeights { cells, weights }
    }
}

/// Where a path's light stands about the yarn.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightSide {
    /// Towards it in the plane across the yarn, of any length.
    pub x: f64,
    pub z: f64,
    /// Its tilt cell.
    pub tilt: usize,
    /// It comes from −y.
    pub axis_reversed: bool,
}

/// Finds the cell of a radiance factor table that light belongs to.
#[derive(Clone, Debug)]
pub(super) struct FactorCells {
    grid: RadianceFactorGrid,
    around: Sectors,
    entry: Sectors,
    exit: CellFinder,
    /// Of the edges between tilt cells.
    sines: Vec<f64>,
}

impl FactorCells {
    pub fn new(grid: RadianceFactorGrid) -> Result<Self, YarnError> {
        Ok(Self {
            around: grid.surface.sectors()?,
            entry: SurfaceGrid::sectors_of(4 * ENTRIES)?,
            exit: grid.surface.exit.finder(),
            sines: (1..grid.tilts).map(|k| grid.tilt_edges(k)[0].sin()).collect(),
            grid,
        })
    }

    /// Tilt cell of light with |sin ψ| = `sine`.
    #[inline(always)]
    pub fn tilt(&self, sine: f64) -> usize {
        self.sines.iter().map(|edge| usize::from(sine >= *edge)).sum()
    }

    /// Cell of light that leaves at a surface `normal` along `direction`.
    #[inline(always)]
    pub fn cell(&self, light: &LightSide, normal: &Vec3, direction: &Vec3) -> usize {
        let (azimuth, mirrored) = azimuth(&self.around, light, normal);
        let azimuth = match fault::active(Fault::ExitAzimuthShift) {
            true => (azimuth + 1) % self.grid.azimuths(),
            false => azimuth,
        };
        let mirrored = mirrored != fault::active(Fault::ExitTangentMirrored);
        let tangent = direction.x * normal.z - direction.z * normal.x;
        let local = Vec3::new(
            if mirrored { -tangent } else { tangent },
            if light.axis_reversed { -direction.y } else { direction.y },
            direction.dot(normal),
        );
        self.grid.cell(light.tilt, azimuth, self.exit.cell(&local))
    }

    /// Passage of light that comes in as [`Self::entry`] says and leaves at a point of the section.
    #[inline(always)]
    pub fn passage(&self, light: &LightSide, (entered, entry_mirrored): (usize, bool), exit: &Vec3) -> usize {
        let (azimuth, exit_mirrored) = azimuth(&self.around, light, exit);
        self.grid
            .passage(light.tilt, entered, entry_mirrored != exit_mirrored, azimuth)
    }

    /// Entry cell of light that comes in at a point of the section, along its normal of any length, and whether that is on the side of
    /// negative azimuth.
    #[inline(always)]
    pub fn entry(&self, light: &LightSide, normal: &Vec3) -> (usize, bool) {
        let (azimuth, mirrored) = azimuth(&self.entry, light, normal);
        (azimuth.min(ENTRIES - 1), mirrored)
    }
}

/// Which of the sectors a point of the section lies in, seen from the light, and whether it is on the side of negative azimuth.
#[inline(always)]
fn azimuth(sectors: &Sectors, light: &LightSide, normal: &Vec3) -> (usize, bool) {
    let across = normal.x * light.z - normal.z * light.x;
    let facing = normal.x * light.x + normal.z * light.z;
    let sector = sectors.sector(facing, across.abs()).min(sectors.count() / 2 - 1);
    (sector, across < 0.0)
}
