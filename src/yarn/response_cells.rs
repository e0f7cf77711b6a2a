use super::response_grid::ENTRIES;
use super::{SurfaceGrid, YarnError, YarnResponseGrid};
use crate::fault::{self, Fault};
use crate::geometry::{CellFinder, Sectors, Vec3};

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

/// Finds the cell of a yarn response that light belongs to.
#[derive(Clone, Debug)]
pub(super) struct ResponseCells {
    grid: YarnResponseGrid,
    around: Sectors,
    entry: Sectors,
    exit: CellFinder,
    /// Of the edges between tilt cells.
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
    pub fn transfer_cell(&self, light: &LightSide, (entered, entry_mirrored): (usize, bool), exit: &Vec3) -> usize {
        let (azimuth, exit_mirrored) = azimuth(&self.around, light, exit);
        self.grid
            .transfer_cell(light.tilt, entered, entry_mirrored != exit_mirrored, azimuth)
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
