use nalgebra::{Matrix3, Vector3};

use super::rgb_space::bradford;
use super::{Adaptation, Colour, ColourError, Convention, Illuminant, Lab, LinearRgb, Xyz};
use crate::fault::{self, Fault};
use crate::spectrum::WavelengthGrid;

/// The conversion of spectra on one wavelength grid under one [`Convention`], weights worked out once.
///
/// X = k Σ S(λ) x̄(λ) β(λ) w(λ), likewise Y and Z, k = 1/Σ S ȳ w, so the perfect diffuser has Y = 1. On a uniform grid
/// the weights w are 1: plain sums over exactly the grid's wavelengths, no interpolation, no correction of the ends.
/// On any other grid w is the width in nm of the interval a wavelength stands for: half of the way to either
/// neighbour, and at the two ends the whole step to the only one, the rule that gives plain sums when all steps are
/// equal.
#[derive(Clone, Debug)]
pub struct ColourSystem {
    convention: Convention,
    /// k S w times x̄, ȳ, z̄, a row a wavelength.
    weights: Vec<Vector3<f64>>,
    white: Vector3<f64>,
    /// XYZ → linear RGB, adaptation included.
    to_rgb: Matrix3<f64>,
}

impl ColourSystem {
    /// Fails where the grid leaves the tables (built-in ones: 360..780 nm; under E ..830 nm) or sees no colour at all.
    pub fn new(grid: &WavelengthGrid, convention: Convention) -> Result<Self, ColourError> {
        let observer = convention.observer.tables()?;
        let illuminant = match &convention.illuminant {
            Illuminant::D65 if fault::active(Fault::IlluminantSwap) => &Illuminant::E,
            Illuminant::E if fault::active(Fault::IlluminantSwap) => &Illuminant::D65,
            illuminant => illuminant,
        };
        let illuminant = illuminant.power()?.on(grid)?;
        let read_at = match fault::active(Fault::ObserverShift) {
            true => &WavelengthGrid::new(grid.nm().iter().map(|nm| nm + 10.0).collect())?,
            false => grid,
        };
        let (x, y, z) = (
            observer.x_bar.on(read_at)?,
            observer.y_bar.on(read_at)?,
            observer.z_bar.on(read_at)?,
        );
        let power = illuminant.values().iter().zip(widths(grid)).map(|(s, w)| s * w);
        let mut weights: Vec<Vector3<f64>> = power
            .enumerate()
            .map(|(i, p)| p * Vector3::new(x.values()[i], y.values()[i], z.values()[i]))
            .collect();
        let sum: Vector3<f64> = weights.iter().sum();
        if sum.min() <= 0.0 {
            return Err(ColourError::Blind {
                low: grid.nm()[0],
                high: grid.nm()[grid.len() - 1],
                convention: convention.to_string(),
                x: sum.x,
                y: sum.y,
                z: sum.z,
            });
        }
        for weight in &mut weights {
            *weight /= sum.y;
        }
        let white = sum / sum.y;
        let to_rgb = match convention.adaptation {
            Adaptation::None => convention.rgb.xyz_to_rgb(),
            Adaptation::Bradford => convention.rgb.xyz_to_rgb() * bradford(white, convention.rgb.white()),
        };
        Ok(Self {
            convention,
            weights,
            white,
            to_rgb,
        })
    }

    pub fn convention(&self) -> &Convention {
        &self.convention
    }

    /// The perfect diffuser: the illuminant's own sum on the grid, Y = 1. White of Lab and of the adaptation.
    pub fn white(&self) -> Xyz {
        xyz_of(self.white)
    }

    /// Tristimulus values of a spectral brightness factor, one value a wavelength of the grid.
    ///
    /// # Panics
    /// If the number of values is not that of the grid's wavelengths.
    pub fn xyz(&self, beta: &[f64]) -> Xyz {
        assert_eq!(beta.len(), self.weights.len(), "one value a wavelength of the grid");
        let sum = self
            .weights
            .iter()
            .zip(beta)
            .fold(Vector3::zeros(), |sum: Vector3<f64>, (w, b)| sum + w * *b);
        xyz_of(sum)
    }

    pub fn linear_rgb(&self, xyz: Xyz) -> LinearRgb {
        LinearRgb((self.to_rgb * Vector3::new(xyz.x, xyz.y, xyz.z)).into())
    }

    /// CIE 15:2018, eqs. 8.3 to 8.11, with the exact constants ε = 216/24389, κ = 24389/27.
    pub fn lab(&self, xyz: Xyz) -> Lab {
        let f = |t: f64| {
            if t > 216.0 / 24389.0 {
                t.cbrt()
            } else {
                (24389.0 / 27.0 * t + 16.0) / 116.0
            }
        };
        let (x, y, z) = (
            f(xyz.x / self.white.x),
            f(xyz.y / self.white.y),
            f(xyz.z / self.white.z),
        );
        Lab([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)])
    }

    /// Lab of linear RGB, the reverse of [`Self::linear_rgb`]; `None` if the RGB space cannot be inverted.
    pub fn lab_of_rgb(&self, rgb: LinearRgb) -> Option<Lab> {
        let to_xyz = self.to_rgb.try_inverse()?;
        Some(self.lab(xyz_of(to_xyz * Vector3::from(rgb.0))))
    }

    /// All of it. Panics as [`Self::xyz`] does.
    pub fn convert(&self, beta: &[f64]) -> Colour {
        let xyz = self.xyz(beta);
        let linear_rgb = self.linear_rgb(xyz);
        Colour {
            xyz,
            linear_rgb,
            lab: self.lab(xyz),
            in_gamut: linear_rgb.in_gamut(),
        }
    }

    /// What a unit of β at each wavelength adds to R, G, B and Y: the derivatives that carry a spectrum's errors to
    /// its colour.
    pub fn channel_weights(&self) -> Vec<[f64; 4]> {
        self.weights
            .iter()
            .map(|w| {
                let rgb = self.to_rgb * w;
                [rgb.x, rgb.y, rgb.z, w.y]
            })
            .collect()
    }
}

fn xyz_of(v: Vector3<f64>) -> Xyz {
    Xyz { x: v.x, y: v.y, z: v.z }
}

/// Interval each wavelength stands for, in nm; exactly 1 throughout a uniform grid.
fn widths(grid: &WavelengthGrid) -> Vec<f64> {
    /// Steps this close, relative, are one step written in decimals.
    const EQUAL: f64 = 1e-9;
    let nm = grid.nm();
    let steps: Vec<f64> = nm.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.iter().all(|step| (step / steps[0] - 1.0).abs() < EQUAL) {
        return vec![1.0; nm.len()];
    }
    let last = steps.len() - 1;
    (0..nm.len())
        .map(|i| (steps[i.saturating_sub(1)] + steps[i.min(last)]) / 2.0)
        .collect()
}
