use super::response_cells::{LightSide, ResponseCells};
use super::{Yarn, YarnError, YarnResponse, YarnResponseGrid};
use crate::fault::{self, Fault};
use crate::geometry::Vec3;
use crate::optics::fresnel::{self, Interface};
use std::f64::consts::{PI, TAU};

/// How a yarn scatters light that meets it, by a table of f* and one of where on the section light leaves that came in
/// at one place of it. The direction in which particles leave a place is taken as that of all light that leaves there, as f* has it,
/// wherever it came in; and they leave at the place along the yarn where they came in.
///
/// Directions and normals are components along (tangent, axis, normal) where the particle met the yarn; the normal of any
/// other point of the section is (sin φ, 0, cos φ).
pub struct YarnSampler {
    grid: YarnResponseGrid,
    cells: ResponseCells,
    wavelengths: usize,
    /// Of the light that enters at an entry cell and is not ballistic, the fraction that leaves at an azimuth cell:
    /// transfer cell × wavelength.
    crossing: Vec<f64>,
    /// Their sums over where light leaves: tilt × entry × wavelength.
    albedo: Vec<f64>,
    /// Of the light that leaves at an azimuth cell or its mirror image, the fraction that leaves through an exit cell: cell × wavelength.
    leaving: Vec<f64>,
    /// Running sums of the probability to choose an azimuth of an entry, and an exit cell of an azimuth; 1 at the end, or 0
    /// where no light leaves.
    azimuths_chosen: Vec<f64>,
    exits_chosen: Vec<f64>,
}

/// Light that meets a yarn.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    side: LightSide,
    /// Its entry cell, numbered over the tilts.
    entry: usize,
    /// That within its tilt, and whether it is the one of two mirror images on the side of negative azimuth.
    entered: (usize, bool),
}

/// Where, in what direction, and by which transfer cell and exit cell a particle leaves.
#[derive(Clone, Copy, Debug)]
pub struct Leaving {
    pub normal: Vec3,
    pub direction: Vec3,
    transfer: usize,
    cell: usize,
    probability: f64,
}

/// Nodes over the sines of a tilt cell and over the width of the yarn, of a smooth integrand.
const TILT_NODES: usize = 8;
const WIDTH_NODES: usize = 72;

impl YarnResponse {
    /// Tables to draw by where on the section of `yarn`, and in what direction, scattered light leaves.
    ///
    /// # Errors
    /// None for the yarn this was traced in.
    pub fn sampler(&self, yarn: &Yarn) -> Result<YarnSampler, YarnError> {
        YarnSampler::new(yarn, self)
    }
}

impl YarnSampler {
    /// Of the yarn that the response was traced in.
    ///
    /// # Errors
    /// A yarn with other wavelengths.
    pub fn new(yarn: &Yarn, response: &YarnResponse) -> Result<Self, YarnError> {
        let grid = *response.grid();
        let wavelengths = yarn.wavelengths();
        if response.wavelengths() != wavelengths {
            return Err(YarnError::Values {
                quantity: "wavelengths of f*",
                expected: wavelengths,
                found: response.wavelengths(),
            });
        }
        let (table, transfer) = (response.values(), response.transfer_values());
        let exits = grid.surface().exit().cells();
        let mut crossing = Vec::with_capacity(transfer.len());
        let mut albedo = Vec::with_capacity(grid.tilts() * grid.entries() * wavelengths);
        let mut azimuths_chosen = Vec::with_capacity(grid.transfer_cells());
        let of_entry = 2 * grid.azimuths() * wavelengths;
        for (entry, rows) in transfer.chunks_exact(of_entry).enumerate() {
            let tilts = grid.tilt_edges(entry / grid.entries());
            let entering = scattered_or_absorbed(yarn, tilts, grid.entry_edges(entry % grid.entries()));
            let first = crossing.len();
            for row in rows.chunks_exact(wavelengths) {
                let fractions = row.iter().zip(&entering);
                crossing.extend(fractions.map(|(x, entering)| if *entering > 0.0 { x / entering } else { 0.0 }));
            }
            let here = &crossing[first..];
            albedo.extend(sum_of_rows(here, wavelengths));
            choose(here, wavelengths, &mut azimuths_chosen);
        }
        let mut leaving = Vec::with_capacity(table.len());
        let mut exits_chosen = Vec::with_capacity(grid.cells());
        for (place, rows) in table.chunks_exact(exits * wavelengths).enumerate() {
            let tilt = place / grid.azimuths();
            let first = leaving.len();
            for (exit, row) in rows.chunks_exact(wavelengths).enumerate() {
                let fraction = 1.0 / grid.response_per_fraction(tilt, exit);
                leaving.extend(row.iter().map(|f| f * fraction));
            }
            let here = &mut leaving[first..];
            let whole = sum_of_rows(here, wavelengths);
            for row in here.chunks_exact_mut(wavelengths) {
                for (x, whole) in row.iter_mut().zip(&whole).filter(|(_, whole)| **whole > 0.0) {
                    *x /= whole;
                }
            }
            choose(here, wavelengths, &mut exits_chosen);
        }
        Ok(Self {
            cells: ResponseCells::new(grid)?,
            grid,
            wavelengths,
            crossing,
            albedo,
            leaving,
            azimuths_chosen,
            exits_chosen,
        })
    }

    pub fn meet(&self, omega_in: &Vec3) -> Meeting {
        let side = LightSide {
            x: omega_in.x,
            z: omega_in.z,
            tilt: self.cells.tilt(omega_in.y.abs().min(1.0)),
            axis_reversed: omega_in.y < 0.0,
        };
        let entered = self.cells.entry(&side, &Vec3::z());
        Meeting {
            side,
            entry: side.tilt * self.grid.entries() + entered.0,
            entered,
        }
    }

    /// Fraction of light that is neither reflected nor ballistic that is not absorbed, at each wavelength.
    pub fn albedo(&self, meeting: &Meeting) -> &[f64] {
        &self.albedo[meeting.entry * self.wavelengths..(meeting.entry + 1) * self.wavelengths]
    }

    /// Draws where a particle leaves, by three uniform random numbers; `None` for a yarn that scatters nothing.
    pub fn sample(&self, meeting: &Meeting, [u, v, w]: [f64; 3]) -> Option<Leaving> {
        let exit = self.grid.surface().exit();
        let exits = exit.cells();
        let azimuths = self.grid.azimuths();
        let LightSide {
            x,
            z,
            tilt,
            axis_reversed,
        } = meeting.side;
        // What is left of a number places the particle inside the cell that it chose.
        let at = Drawn::from(&self.azimuths_chosen[meeting.entry * 2 * azimuths..][..2 * azimuths], u)?;
        let (opposite, azimuth) = (at.cell >= azimuths, at.cell % azimuths);
        let mirrored = meeting.entered.1 != opposite;
        let from_light = (azimuth as f64 + at.rest) * PI / azimuths as f64;
        let phi = x.atan2(z) + if mirrored { -from_light } else { from_light };
        let place = tilt * azimuths + azimuth;
        let out = Drawn::from(&self.exits_chosen[place * exits..][..exits], v)?;
        let (row, column) = (out.cell / exit.phi_cells(), out.cell % exit.phi_cells());
        let edge = |k: usize| (k as f64 * 0.5 * PI / exit.theta_cells() as f64).sin().powi(2);
        let sin2 = edge(row) + out.rest * (edge(row + 1) - edge(row));
        let around = (column as f64 + w) * TAU / exit.phi_cells() as f64;
        let (sin, cos) = (sin2.sqrt(), (1.0 - sin2).max(0.0).sqrt());
        let tangent = sin * around.cos() * if mirrored { -1.0 } else { 1.0 };
        let axis = sin * around.sin() * if axis_reversed { -1.0 } else { 1.0 };
        let (sin_phi, cos_phi) = phi.sin_cos();
        Some(Leaving {
            normal: Vec3::new(sin_phi, 0.0, cos_phi),
            direction: Vec3::new(
                tangent * cos_phi + cos * sin_phi,
                axis,
                cos * cos_phi - tangent * sin_phi,
            ),
            transfer: meeting.entry * 2 * azimuths + at.cell,
            cell: place * exits + out.cell,
            probability: at.probability * out.probability,
        })
    }

    /// Density with which [`Self::sample`] draws a point of the section and a direction there, per radian of azimuth and
    /// steradian perpendicular to the direction; 0 for a yarn that scatters nothing.
    pub fn pdf(&self, meeting: &Meeting, normal: &Vec3, direction: &Vec3) -> f64 {
        let azimuths = self.grid.azimuths();
        let exit = self.grid.surface().exit();
        let transfer = self.cells.transfer_cell(&meeting.side, meeting.entered, normal);
        let cell = self.cells.cell(&meeting.side, normal, direction);
        let of_entry = 2 * azimuths;
        let place = probability(
            &self.azimuths_chosen[meeting.entry * of_entry..][..of_entry],
            transfer % of_entry,
        );
        let exits = &self.exits_chosen[cell / exit.cells() * exit.cells()..][..exit.cells()];
        let width = PI / azimuths as f64;
        place * probability(exits, cell % exit.cells()) / (width * exit.projected_solid_angle(cell % exit.cells()))
    }

    /// What the weights of light that is neither reflected nor ballistic are worth after the draw, at each wavelength.
    pub fn worth(&self, leaving: &Leaving) -> impl Iterator<Item = f64> {
        let gain = if fault::active(Fault::BounceGain) { 1.03 } else { 1.0 };
        let share = gain / leaving.probability;
        self.rows(leaving.transfer, leaving.cell).map(move |x| x * share)
    }

    /// Of light that is neither reflected nor ballistic, the fraction that leaves at a point of the section along a direction, per
    /// radian of azimuth and steradian perpendicular to the direction, at each wavelength: over the surface per radian, the radiance.
    pub fn radiance(&self, meeting: &Meeting, normal: &Vec3, direction: &Vec3) -> impl Iterator<Item = f64> {
        let cell = self.cells.cell(&meeting.side, normal, direction);
        let transfer = self.cells.transfer_cell(&meeting.side, meeting.entered, normal);
        let exit = self.grid.surface().exit();
        let width = PI / self.grid.azimuths() as f64;
        let per = 1.0 / (width * exit.projected_solid_angle(cell % exit.cells()));
        self.rows(transfer, cell).map(move |x| x * per)
    }

    /// Fractions that leave at a place of the section, through a cell.
    fn rows(&self, transfer: usize, cell: usize) -> impl Iterator<Item = f64> {
        let crossing = &self.crossing[transfer * self.wavelengths..][..self.wavelengths];
        let leaving = &self.leaving[cell * self.wavelengths..][..self.wavelengths];
        crossing.iter().zip(leaving).map(|(x, y)| x * y)
    }
}

/// Sums over rows of as many wavelengths.
fn sum_of_rows(rows: &[f64], wavelengths: usize) -> Vec<f64> {
    let mut sums = vec![0.0; wavelengths];
    for row in rows.chunks_exact(wavelengths) {
        sums.iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
    }
    sums
}

/// Appends running sums of the probability to choose each row, in which each wavelength that leaves at all has an equal say.
fn choose(rows: &[f64], wavelengths: usize, chosen: &mut Vec<f64>) {
    let whole = sum_of_rows(rows, wavelengths);
    let total = whole.iter().filter(|x| **x > 0.0).count().max(1) as f64;
    let say: Vec<f64> = whole
        .iter()
        .map(|x| if *x > 0.0 { 1.0 / (x * total) } else { 0.0 })
        .collect();
    let mut sum = 0.0;
    for row in rows.chunks_exact(wavelengths) {
        sum += row.iter().zip(&say).map(|(x, say)| x * say).sum::<f64>();
        chosen.push(sum);
    }
}

/// With what probability running sums choose a cell.
fn probability(sums: &[f64], cell: usize) -> f64 {
    let total = sums.last().copied().unwrap_or(0.0);
    let below = if cell == 0 { 0.0 } else { sums[cell - 1] };
    if total > 0.0 { (sums[cell] - below) / total } else { 0.0 }
}

/// A cell drawn by running sums of probability, and what is left of the uniform random number that chose it.
struct Drawn {
    cell: usize,
    probability: f64,
    rest: f64,
}

impl Drawn {
    fn from(sums: &[f64], uniform: f64) -> Option<Self> {
        let total = *sums.last()?;
        let wanted = uniform * total;
        let cell = sums.partition_point(|sum| *sum <= wanted).min(sums.len() - 1);
        let below = if cell == 0 { 0.0 } else { sums[cell - 1] };
        let wide = sums[cell] - below;
        (total > 0.0 && wide > 0.0).then(|| Self {
            cell,
            probability: wide / total,
            rest: ((wanted - below) / wide).clamp(0.0, 1.0),
        })
    }
}

/// Of light that meets a straight yarn's surface as `entry` says, the fraction at wavelength number `w` that is neither reflected
/// on the way in nor leaves without having met a particle: with reflectance r, alike at every hit, and transmittance x of the
/// chord, 1 − r − (1 − r)² x/(1 − r x). `sine` of the tilt inside the yarn.
pub fn kept_by_straight_yarn(yarn: &Yarn, w: usize, entry: &Interface, sine: f64) -> f64 {
    let medium = &yarn.medium;
    let across = 1.0 - sine.powi(2);
    let chord = 2.0 * yarn.cylinder.radius_mm() * entry.cos_t / across;
    let x = (-(medium.mu_s_per_mm()[w] + medium.mu_a_per_mm()[w]) * chord).exp();
    let (r, entering) = (entry.reflectance, 1.0 - entry.reflectance);
    let high = if fault::active(Fault::EnteringHigh) { 1.03 } else { 1.0 };
    high * (entering - entering * entering * x / (1.0 - r * x))
}

/// Of all light of a tilt cell, the part that comes in between two azimuths from the light's meridian, or at their mirror image, and is
/// kept, at each wavelength: its mean over the sines of the tilts.
pub(crate) fn scattered_or_absorbed(yarn: &Yarn, tilts: [f64; 2], [from, to]: [f64; 2]) -> Vec<f64> {
    let medium = &yarn.medium;
    let [low, high] = tilts.map(f64::sin);
    // The width as h = sin t, whose integrand stays smooth where the beam grazes.
    let width_nodes = ((to - from) / (0.5 * PI) * WIDTH_NODES as f64).ceil() as usize;
    let step = (to - from) / width_nodes as f64;
    let mut kept = vec![0.0; medium.grid().len()];
    for node in 0..TILT_NODES * width_nodes {
        let sine = low + (high - low) * ((node % TILT_NODES) as f64 + 0.5) / TILT_NODES as f64;
        let t = from + ((node / TILT_NODES) as f64 + 0.5) * step;
        let cos_in = t.cos() * (1.0 - sine * sine).sqrt();
        for (w, kept) in kept.iter_mut().enumerate() {
            let index = medium.host_index()[w];
            let interface = fresnel::interface(cos_in, index);
            *kept += step / TILT_NODES as f64 * t.cos() * kept_by_straight_yarn(yarn, w, &interface, sine / index);
        }
    }
    kept
}
