use super::radiance_factor::{FactorCells, LightSide};
use super::{RadianceFactorGrid, Yarn, YarnError};
use crate::geometry::Vec3;
use crate::optics::fresnel::{self, Interface};
use std::f64::consts::{PI, TAU};

/// How a yarn scatters light that met it anywhere across its width, by a table of f*: particles that forget where on the
/// section they came in, as the light of a beam wider than the yarn does.
///
/// Directions and normals are components along (tangent, axis, normal) where the particle met the yarn; the normal of any
/// other point of the section is (sin φ, 0, cos φ).
pub struct YarnScatter {
    grid: RadianceFactorGrid,
    cells: FactorCells,
    wavelengths: usize,
    /// Of the light that enters and is not ballistic, the fraction that leaves through a cell and its mirror image:
    /// cell × wavelength.
    leaving: Vec<f64>,
    /// Their sums over the cells: tilt × wavelength.
    albedo: Vec<f64>,
    /// Running sums over the cells of a tilt of the probability to choose them, 1 at the end.
    chosen: Vec<f64>,
}

/// Light that meets a yarn.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    side: LightSide,
}

/// Where, in what direction, and through which cell a particle leaves.
#[derive(Clone, Copy, Debug)]
pub struct Leaving {
    pub normal: Vec3,
    pub direction: Vec3,
    cell: usize,
    probability: f64,
}

/// Nodes over the sines of a tilt cell and over the width of the yarn, of a smooth integrand.
const TILT_NODES: usize = 8;
const WIDTH_NODES: usize = 64;

impl YarnScatter {
    /// `table` is f* on the grid, cell × wavelength, wavelength fastest.
    pub fn new(yarn: &Yarn, grid: RadianceFactorGrid, table: &[f64]) -> Result<Self, YarnError> {
        let wavelengths = yarn.medium.grid().len();
        let exits = grid.surface().exit().cells();
        let cells = grid.azimuths() * exits;
        let mut leaving = Vec::with_capacity(table.len());
        let mut chosen = Vec::with_capacity(grid.cells());
        let mut albedos = Vec::with_capacity(grid.tilts() * wavelengths);
        for tilt in 0..grid.tilts() {
            let entering = scattered_or_absorbed(yarn, grid.tilt_edges(tilt));
            let rows = &table[tilt * cells * wavelengths..(tilt + 1) * cells * wavelengths];
            let first = leaving.len();
            for (cell, row) in rows.chunks_exact(wavelengths).enumerate() {
                let fraction = 1.0 / grid.radiance_factor_per_fraction(tilt, cell % exits);
                leaving.extend(row.iter().zip(&entering).map(|(f, entering)| {
                    if *entering > 0.0 { f * fraction / entering } else { 0.0 }
                }));
            }
            let here = &leaving[first..];
            let mut albedo = vec![0.0; wavelengths];
            for row in here.chunks_exact(wavelengths) {
                albedo.iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
            }
            // Each wavelength has an equal say in where particles go.
            let say: Vec<f64> = albedo.iter().map(|a| if *a > 0.0 { 1.0 / a } else { 0.0 }).collect();
            let total = albedo.iter().filter(|a| **a > 0.0).count().max(1) as f64;
            let mut sum = 0.0;
            for row in here.chunks_exact(wavelengths) {
                sum += row.iter().zip(&say).map(|(x, say)| x * say).sum::<f64>() / total;
                chosen.push(sum);
            }
            albedos.extend(albedo);
        }
        Ok(Self {
            cells: FactorCells::new(grid)?,
            grid,
            wavelengths,
            leaving,
            albedo: albedos,
            chosen,
        })
    }

    pub fn meet(&self, omega_in: &Vec3) -> Meeting {
        Meeting {
            side: LightSide {
                x: omega_in.x,
                z: omega_in.z,
                tilt: self.cells.tilt(omega_in.y.abs().min(1.0)),
                axis_reversed: omega_in.y < 0.0,
            },
        }
    }

    /// Fraction of light that is neither reflected nor ballistic that is not absorbed, at each wavelength.
    pub fn albedo(&self, meeting: &Meeting) -> &[f64] {
        let tilt = meeting.side.tilt;
        &self.albedo[tilt * self.wavelengths..(tilt + 1) * self.wavelengths]
    }

    /// Draws where a particle leaves, from four even numbers; `None` for a yarn that scatters nothing.
    pub fn draw(&self, meeting: &Meeting, [u, v, w, side]: [f64; 4]) -> Option<Leaving> {
        let exit = self.grid.surface().exit();
        let exits = exit.cells();
        let of_tilt = self.grid.azimuths() * exits;
        let LightSide {
            x,
            z,
            tilt,
            axis_reversed,
        } = meeting.side;
        let sums = &self.chosen[tilt * of_tilt..(tilt + 1) * of_tilt];
        let total = sums[of_tilt - 1];
        let wanted = u * total;
        let within = sums.partition_point(|sum| *sum <= wanted).min(of_tilt - 1);
        let below = if within == 0 { 0.0 } else { sums[within - 1] };
        let probability = (sums[within] - below) / total;
        if !(total > 0.0 && probability > 0.0) {
            return None;
        }
        // What is left of the number places the azimuth inside its cell; its own mirror image is as likely.
        let rest = ((wanted - below) / (sums[within] - below)).clamp(0.0, 1.0);
        let mirrored = side < 0.5;
        let width = PI / self.grid.azimuths() as f64;
        let from_light = ((within / exits) as f64 + rest) * width;
        let phi = x.atan2(z) + if mirrored { -from_light } else { from_light };
        let cell = within % exits;
        let (row, column) = (cell / exit.phi_cells(), cell % exit.phi_cells());
        let edge = |k: usize| (k as f64 * 0.5 * PI / exit.theta_cells() as f64).sin().powi(2);
        let sin2 = edge(row) + v * (edge(row + 1) - edge(row));
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
            cell: tilt * of_tilt + within,
            probability,
        })
    }

    /// What the weights of light that is neither reflected nor ballistic are worth after the draw, at each wavelength.
    pub fn worth(&self, leaving: &Leaving) -> impl Iterator<Item = f64> {
        let share = 1.0 / leaving.probability;
        self.row(leaving.cell).iter().map(move |x| x * share)
    }

    /// Of light that is neither reflected nor ballistic, the fraction that leaves at a point of the section along a direction, per
    /// radian of azimuth and steradian perpendicular to the direction, at each wavelength: over the surface per radian, the radiance.
    pub fn radiance(&self, meeting: &Meeting, normal: &Vec3, direction: &Vec3) -> impl Iterator<Item = f64> {
        let cell = self.cells.cell(&meeting.side, normal, direction);
        let exit = self.grid.surface().exit();
        let both_images = TAU / self.grid.azimuths() as f64;
        let per = 1.0 / (both_images * exit.projected_solid_angle(cell % exit.cells()));
        self.row(cell).iter().map(move |x| x * per)
    }

    fn row(&self, cell: usize) -> &[f64] {
        &self.leaving[cell * self.wavelengths..(cell + 1) * self.wavelengths]
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
    entering - entering * entering * x / (1.0 - r * x)
}

/// Mean of it over the width of the yarn and a tilt cell, at each wavelength.
fn scattered_or_absorbed(yarn: &Yarn, [low, high]: [f64; 2]) -> Vec<f64> {
    let medium = &yarn.medium;
    let (low, high) = (low.sin(), high.sin());
    let per_node = 1.0 / (TILT_NODES * WIDTH_NODES) as f64;
    let mut mean = vec![0.0; medium.grid().len()];
    for node in 0..TILT_NODES * WIDTH_NODES {
        let sine = low + (high - low) * ((node % TILT_NODES) as f64 + 0.5) / TILT_NODES as f64;
        // The width as h = sin t, whose integrand stays smooth where the beam grazes.
        let t = ((node / TILT_NODES) as f64 + 0.5) / WIDTH_NODES as f64 * 0.5 * PI;
        let cos_in = t.cos() * (1.0 - sine * sine).sqrt();
        for (w, mean) in mean.iter_mut().enumerate() {
            let index = medium.host_index()[w];
            let interface = fresnel::interface(cos_in, index);
            *mean += per_node * 0.5 * PI * t.cos() * kept_by_straight_yarn(yarn, w, &interface, sine / index);
        }
    }
    mean
}
