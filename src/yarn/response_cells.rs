use super::response_grid::ENTRIES;
use super::{SurfaceGrid, YarnError, YarnResponseGrid};
use crate::fault::{self, Fault};
use crate::geometry::{CellFinder, Sectors, Vec3};

/// Incident direction of a path relative to the yarn.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightSide {
    /// Components towards the light in the plane normal to the axis; the length is arbitrary.
    pub x: f64,
    pub z: f64,
    /// Tilt cell of the light.
    pub tilt: usize,
    /// Whether the light comes from −y.
    pub axis_reversed: bool,
}

/// Finds the cells of a yarn response for incident and exiting light.
#[derive(Clone, Debug)]
pub(super) struct ResponseCells {
    grid: YarnResponseGrid,
    around: Sectors,
    entry: Sectors,
    exit: CellFinder,
    /// sin ψ at the edges between tilt cells.
    sines: Vec<f64>,
}

impl ResponseCells {
    pub fn new(grid: YarnResponseGrid) -> Result<Self, YarnError> {
        Ok(Self {
            around: grid.surface().sectors()?,
            entry: SurfaceGrid::sectors_of(4 * ENTRIES)?,
            exit: grid.surface().exit().finder(),
            sines: (1..grid.tilts()).map(|k| grid.tilt_edges(k)[0].sin()).collect(),
            grid,
        })
    }

    /// Tilt cell of light with |sin ψ| = `sine`.
    #[inline(always)]
    pub fn tilt(&self, sine: f64) -> usize {
        self.sines.iter().map(|edge| usize::from(sine >= *edge)).sum()
    }

    /// Cell of light that leaves at a surface point with outward `normal` along the unit vector `direction`.
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

    /// Transfer cell of light that enters as given by [`Self::entry`] and leaves at a point of the section.
    #[inline(always)]
    pub fn transfer_cell(&self, light: &LightSide, (entered, entry_mirrored): (usize, bool), exit: &Vec3) -> usize {
        let (azimuth, exit_mirrored) = azimuth(&self.around, light, exit);
        self.grid
            .transfer_cell(light.tilt, entered, entry_mirrored != exit_mirrored, azimuth)
    }

    /// Entry cell of light that enters at the point of the section with outward `normal` (of any length), and whether
    /// that point is on the side of negative azimuth.
    #[inline(always)]
    pub fn entry(&self, light: &LightSide, normal: &Vec3) -> (usize, bool) {
        let (azimuth, mirrored) = azimuth(&self.entry, light, normal);
        (azimuth.min(ENTRIES - 1), mirrored)
    }
}

/// Sector of a point of the section, counted from the light, and whether it is on the side of negative azimuth.
#[inline(always)]
fn azimuth(sectors: &Sectors, light: &LightSide, normal: &Vec3) -> (usize, bool) {
    let across = normal.x * light.z - normal.z * light.x;
    let facing = normal.x * light.x + normal.z * light.z;
    let sector = sectors.sector(facing, across.abs()).min(sectors.count() / 2 - 1);
    (sector, across < 0.0)
}
