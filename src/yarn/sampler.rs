use super::response_cells::{LightSide, ResponseCells};
use super::{Yarn, YarnError, YarnResponse, YarnResponseGrid};
use crate::fault::{self, Fault};
use crate::geometry::Vec3;
use crate::optics::fresnel::{self, Interface};
use std::f64::consts::{PI, TAU};

/// Sampler of a yarn's scattering, built from its f* and its transfer table (which maps the azimuth of entry on the
/// section to the azimuth of exit). Two approximations: the exit direction depends on the exit point alone, with the
/// distribution given by f*, not on the entry point; and light leaves at the position along the yarn where it entered.
///
/// Directions and normals are components along (tangent, axis, normal) where the particle met the yarn; the normal of
/// any other point of the section is (sin φ, 0, cos φ).
pub struct YarnSampler {
    grid: YarnResponseGrid,
    cells: ResponseCells,
    wavelengths: usize,
    /// Fraction of the non-ballistic light entering at an entry cell that leaves at an azimuth cell:
    /// transfer cell × wavelength.
    crossing: Vec<f64>,
    /// Sums of `crossing` over the azimuth of exit: tilt × entry × wavelength.
    albedo: Vec<f64>,
    /// Fraction of the light leaving at an azimuth cell or its mirror image that leaves through an exit cell: cell ×
    /// wavelength.
    leaving: Vec<f64>,
    /// Cumulative probabilities of the azimuth cell for each entry, and of the exit cell for each azimuth; the last is
    /// 1, or 0 where no light leaves.
    azimuths_chosen: Vec<f64>,
    exits_chosen: Vec<f64>,
}

/// Incidence of light on a yarn, as cells of the response.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    side: LightSide,
    /// Index of the entry cell over all tilts.
    entry: usize,
    /// Index of the entry cell within its tilt, and whether the entry is on the side of negative azimuth.
    entered: (usize, bool),
}

/// Exit of a particle: position on the section, direction, transfer cell and exit cell.
#[derive(Clone, Copy, Debug)]
pub struct Leaving {
    pub normal: Vec3,
    pub direction: Vec3,
    transfer: usize,
    cell: usize,
    probability: f64,
}

/// Quadrature nodes over the sines of a tilt cell and over the width of the yarn; the integrand is smooth.
const TILT_NODES: usize = 8;
const WIDTH_NODES: usize = 72;

impl YarnResponse {
    /// Builds the sampler of this response; `yarn` is the yarn in which it was traced.
    ///
    /// # Errors
    /// See [`YarnSampler::new`].
    pub fn sampler(&self, yarn: &Yarn) -> Result<YarnSampler, YarnError> {
        YarnSampler::new(yarn, self)
    }
}

impl YarnSampler {
    /// Builds the sampler of a response; `yarn` is the yarn in which it was traced.
    ///
    /// # Errors
    /// [`YarnError::Values`] if the yarn has another number of wavelengths than the response.
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

    /// Incidence of light on the yarn. `omega_in` is the unit vector towards the light in the local frame (tangent,
    /// axis, normal).
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

    /// Albedo at each wavelength: scattered fraction of the light that is neither reflected nor ballistic.
    pub fn albedo(&self, meeting: &Meeting) -> &[f64] {
        &self.albedo[meeting.entry * self.wavelengths..(meeting.entry + 1) * self.wavelengths]
    }

    /// Draws the exit of a particle from three uniform random numbers in [0, 1); `None` if the yarn scatters nothing.
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
        // The remainder of a random number, rescaled to [0, 1), gives the position inside the chosen cell.
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

    /// Probability density with which [`Self::sample`] draws a point of the section and a direction there, per radian
    /// of azimuth and per projected steradian (cosθ dω); 0 if the yarn scatters nothing.
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

    /// Factors that a draw applies to the weights of light that is neither reflected nor ballistic, at each wavelength.
    pub fn worth(&self, leaving: &Leaving) -> impl Iterator<Item = f64> {
        let gain = if fault::active(Fault::BounceGain) { 1.03 } else { 1.0 };
        let share = gain / leaving.probability;
        self.rows(leaving.transfer, leaving.cell).map(move |x| x * share)
    }

    /// Fraction of the light that is neither reflected nor ballistic that leaves at a point of the section along a
    /// direction, per radian of azimuth and per projected steradian (cosθ dω), at each wavelength. Divided by the
    /// surface area per radian it is the radiance.
    pub fn radiance(&self, meeting: &Meeting, normal: &Vec3, direction: &Vec3) -> impl Iterator<Item = f64> {
        let cell = self.cells.cell(&meeting.side, normal, direction);
        let transfer = self.cells.transfer_cell(&meeting.side, meeting.entered, normal);
        let exit = self.grid.surface().exit();
        let width = PI / self.grid.azimuths() as f64;
        let per = 1.0 / (width * exit.projected_solid_angle(cell % exit.cells()));
        self.rows(transfer, cell).map(move |x| x * per)
    }

    /// Fractions that leave at an azimuth of the section through an exit cell, at each wavelength.
    fn rows(&self, transfer: usize, cell: usize) -> impl Iterator<Item = f64> {
        let crossing = &self.crossing[transfer * self.wavelengths..][..self.wavelengths];
        let leaving = &self.leaving[cell * self.wavelengths..][..self.wavelengths];
        crossing.iter().zip(leaving).map(|(x, y)| x * y)
    }
}

/// Sum of rows, each with one value per wavelength.
fn sum_of_rows(rows: &[f64], wavelengths: usize) -> Vec<f64> {
    let mut sums = vec![0.0; wavelengths];
    for row in rows.chunks_exact(wavelengths) {
        sums.iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
    }
    sums
}

/// Appends the cumulative probabilities of the rows. The probability of a row is the mean, over wavelengths with any
/// light, of the row's share at that wavelength.
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

/// Probability of a cell, from cumulative probabilities.
fn probability(sums: &[f64], cell: usize) -> f64 {
    let total = sums.last().copied().unwrap_or(0.0);
    let below = if cell == 0 { 0.0 } else { sums[cell - 1] };
    if total > 0.0 { (sums[cell] - below) / total } else { 0.0 }
}

/// A cell drawn from cumulative probabilities, and the remainder of the uniform random number that chose it, rescaled
/// to [0, 1).
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

/// Fraction of the light meeting a straight yarn that is neither reflected at entry nor ballistic, at wavelength index
/// `w`. With reflectance r, the same at every hit, and unscattered transmittance x of one chord it is
/// 1 − r − (1 − r)² x/(1 − r x). `entry` is the interface at the entry point, `sine` that of the tilt inside the yarn.
pub fn kept_by_straight_yarn(yarn: &Yarn, w: usize, entry: &Interface, sine: f64) -> f64 {
    let medium = &yarn.medium;
    let across = 1.0 - sine.powi(2);
    let chord = 2.0 * yarn.cylinder.radius_mm() * entry.cos_t / across;
    let x = (-(medium.mu_s_per_mm()[w] + medium.mu_a_per_mm()[w]) * chord).exp();
    let (r, entering) = (entry.reflectance, 1.0 - entry.reflectance);
    let high = if fault::active(Fault::EnteringHigh) { 1.03 } else { 1.0 };
    high * (entering - entering * entering * x / (1.0 - r * x))
}

/// Fraction of all light of a tilt cell that enters between two azimuths from the light's meridian, or at their mirror
/// images, and is neither reflected nor ballistic, at each wavelength. Mean over the sine of the tilt, radians.
pub(crate) fn scattered_or_absorbed(yarn: &Yarn, tilts: [f64; 2], [from, to]: [f64; 2]) -> Vec<f64> {
    let medium = &yarn.medium;
    let [low, high] = tilts.map(f64::sin);
    // Substituting h = sin t keeps the integrand smooth at grazing incidence.
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
