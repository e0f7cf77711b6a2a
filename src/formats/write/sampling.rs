use std::f64::consts::FRAC_PI_2;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::Relaxed;

use nalgebra::{Matrix3, Vector3};

use super::{WriteError, WriteNotice};
use crate::colour::{ColourSystem, Convention, Xyz};
use crate::geometry::Vec3;
use crate::goniometric::{
    ChannelSet, Component, Format, Parameters, Quantity, Scatter, Side, Table, angles_of, direction,
};
use crate::spectrum::WavelengthGrid;

/// f of a component at any pair of directions a format asks for. Beyond what was measured it keeps the value of the
/// nearest incidence and of the nearest polar angle towards the normal, and counts how often.
pub(super) struct Sampler<'a> {
    component: &'a Component,
    format: Format,
    /// First and last incident polar angle of the component.
    incidences_rad: [f64; 2],
    asked: AtomicUsize,
    filled: AtomicUsize,
}

/// Nearest to the horizon that a value is looked up, so that one that holds a cosine can be divided by it.
const HORIZON_RAD: f64 = FRAC_PI_2 - 1e-4;

impl<'a> Sampler<'a> {
    pub(super) fn new(component: &'a Component, format: Format) -> Result<Self, WriteError> {
        match component.quantity {
            Quantity::Unscaled => return Err(WriteError::Unscaled),
            Quantity::Fraction => {
                return Err(WriteError::CannotHold {
                    format,
                    holds: "scattering over directions".into(),
                    found: "specular fractions".into(),
                    remedy: "take sdr or ssdd for specular fractions".into(),
                });
            }
            Quantity::Bsdf | Quantity::BsdfCosine | Quantity::BrightnessFactor => {}
        }
        let nodes = match &component.table {
            Table::Klems(_) | Table::Tree(_) => None,
            Table::Grid(grid) if *grid.parameters() == Parameters::HalfDifference => None,
            _ => Some(component.incidences_deg()),
        };
        let ends = nodes
            .as_deref()
            .and_then(|nodes| Some([*nodes.first()?, *nodes.last()?]));
        Ok(Self {
            component,
            format,
            incidences_rad: ends.unwrap_or([0.0, 90.0]).map(f64::to_radians),
            asked: AtomicUsize::new(0),
            filled: AtomicUsize::new(0),
        })
    }

    pub(super) fn channels(&self) -> usize {
        self.component.channels.count()
    }

    /// That so many values were had from the source in another way.
    pub(super) fn measured(&self, values: usize) {
        self.asked.fetch_add(values, Relaxed);
    }

    /// Directions as they are above the surface, light on its front; of transmission the outgoing one mirrored up.
    pub(super) fn bsdf(&self, omega_in: &Vec3, omega_out: &Vec3) -> Result<Vec<f64>, WriteError> {
        self.mean_over_turns(omega_in, omega_out, &[0.0])
    }

    /// The mean of [`Self::bsdf`] over pairs turned about the normal by these angles.
    pub(super) fn mean_over_turns(
        &self,
        omega_in: &Vec3,
        omega_out: &Vec3,
        turns_rad: &[f64],
    ) -> Result<Vec<f64>, WriteError> {
        self.asked.fetch_add(turns_rad.len(), Relaxed);
        let (theta_o, phi_o) = angles_of(omega_out);
        let mut left = turns_rad.to_vec();
        let mut sums = vec![0.0; self.component.channels.count()];
        if theta_o <= HORIZON_RAD {
            self.add(omega_in, omega_out, &mut left, &mut sums);
        } else if theta_o <= FRAC_PI_2 {
            self.add(omega_in, &direction(HORIZON_RAD, phi_o), &mut left, &mut sums);
        }
        if !left.is_empty() {
            // Below the horizon there is nothing to measure; tables only need something smooth there.
            let counted = if theta_o <= FRAC_PI_2 { left.len() } else { 0 };
            self.filled.fetch_add(counted, Relaxed);
            let (theta_i, phi_i) = angles_of(omega_in);
            let [first, last] = self.incidences_rad;
            let omega_in = direction(theta_i.clamp(first, last), phi_i);
            let mut polar = theta_o.min(HORIZON_RAD);
            while !left.is_empty() {
                if polar < 0.0 {
                    return Err(WriteError::NotMeasured {
                        format: self.format,
                        theta_i_deg: theta_i.to_degrees(),
                        theta_o_deg: theta_o.to_degrees(),
                        phi_o_deg: phi_o.to_degrees(),
                    });
                }
                self.add(&omega_in, &direction(polar, phi_o), &mut left, &mut sums);
                polar -= 1f64.to_radians();
            }
        }
        let turns = turns_rad.len() as f64;
        sums.iter_mut().for_each(|sum| *sum /= turns);
        Ok(sums)
    }

    fn add(&self, omega_in: &Vec3, omega_out: &Vec3, turns_rad: &mut Vec<f64>, sums: &mut [f64]) {
        let front = if self.component.side == Side::Front { 1.0 } else { -1.0 };
        let beyond = if self.component.scatter == Scatter::Reflection {
            front
        } else {
            -front
        };
        let turned = |d: &Vec3, sign: f64| Vec3::new(d.x, d.y, d.z * sign);
        let (omega_in, omega_out) = (turned(omega_in, front), turned(omega_out, beyond));
        self.component.add_bsdf_turned(&omega_in, &omega_out, turns_rad, sums);
    }

    /// The notice on values that were not measured.
    pub(super) fn notice(&self, notices: &mut Vec<WriteNotice>) {
        notices.push(WriteNotice::Resampled);
        let (filled, asked) = (self.filled.load(Relaxed), self.asked.load(Relaxed));
        if filled > 0 {
            notices.push(WriteNotice::Filled { filled, asked });
        }
    }
}

/// From the channels of a source to those a format can hold.
pub(super) enum ChannelMap {
    Same,
    /// The one value as each of the three.
    Grey,
    Matrix(Matrix3<f64>),
    Spectral {
        system: Box<ColourSystem>,
        rgb: bool,
    },
}

impl ChannelMap {
    pub(super) fn to_rgb(from: &ChannelSet, notices: &mut Vec<WriteNotice>) -> Result<Self, WriteError> {
        Ok(match from {
            ChannelSet::Rgb => Self::Same,
            ChannelSet::Monochrome => {
                notices.push(WriteNotice::Grey);
                Self::Grey
            }
            ChannelSet::Xyz => {
                notices.push(WriteNotice::XyzAsRgb);
                Self::Matrix(xyz_to_rgb()?)
            }
            ChannelSet::Wavelengths(grid) => {
                notices.push(WriteNotice::SpectraAsRgb);
                Self::Spectral {
                    system: Box::new(colour_of(grid, notices)?),
                    rgb: true,
                }
            }
        })
    }

    pub(super) fn to_xyz(from: &ChannelSet, notices: &mut Vec<WriteNotice>) -> Result<Self, WriteError> {
        Ok(match from {
            ChannelSet::Xyz | ChannelSet::Monochrome => Self::Same,
            ChannelSet::Rgb => {
                notices.push(WriteNotice::RgbAsSrgb);
                let inverse = xyz_to_rgb()?.try_inverse();
                Self::Matrix(inverse.unwrap_or_else(Matrix3::identity))
            }
            ChannelSet::Wavelengths(grid) => {
                notices.push(WriteNotice::SpectraAsXyz);
                Self::Spectral {
                    system: Box::new(colour_of(grid, notices)?),
                    rgb: false,
                }
            }
        })
    }

    pub(super) fn apply(&self, values: &[f64]) -> Vec<f64> {
        match self {
            Self::Same => values.to_vec(),
            Self::Grey => vec![values[0]; 3],
            Self::Matrix(matrix) => (matrix * Vector3::new(values[0], values[1], values[2]))
                .iter()
                .copied()
                .collect(),
            Self::Spectral { system, rgb } => {
                let xyz = system.xyz(values);
                if *rgb {
                    system.linear_rgb(xyz).0.to_vec()
                } else {
                    vec![xyz.x, xyz.y, xyz.z]
                }
            }
        }
    }
}

/// The conversion of spectra, and what makes their colours doubtful.
fn colour_of(grid: &WavelengthGrid, notices: &mut Vec<WriteNotice>) -> Result<ColourSystem, WriteError> {
    let system = ColourSystem::new(grid, Convention::default())?;
    system.require()?;
    notices.extend(system.notice().map(|words| WriteNotice::DoubtfulColours { words }));
    Ok(system)
}

fn xyz_to_rgb() -> Result<Matrix3<f64>, WriteError> {
    // Without adaptation the matrix is the same for every grid.
    let system = ColourSystem::new(&WavelengthGrid::preprint(), Convention::default())?;
    let column = |x, y, z| Vector3::from(system.linear_rgb(Xyz { x, y, z }).0);
    Ok(Matrix3::from_columns(&[
        column(1.0, 0.0, 0.0),
        column(0.0, 1.0, 0.0),
        column(0.0, 0.0, 1.0),
    ]))
}

/// Colours outside the gamut have negative components, which no format takes.
pub(super) fn clipped(values: &mut [f64], notices: &mut Vec<WriteNotice>) {
    let negative = values.iter_mut().filter(|v| **v < 0.0).map(|v| *v = 0.0).count();
    if negative > 0 {
        notices.push(WriteNotice::Clipped {
            components: Some(negative),
        });
    }
}

/// 0 to `last` degrees in equal steps.
pub(super) fn every(step_deg: f64, last_deg: f64) -> Vec<f64> {
    (0..=(last_deg / step_deg).round() as u32)
        .map(|i| f64::from(i) * step_deg)
        .collect()
}
