use super::error::FitError;
use super::notice::FitNotice;
use crate::colour::{ColourSystem, Convention};
use crate::rig::Geometry;
use crate::sample::{RawReading, Sample, SampleError};
use crate::spectrum::WavelengthGrid;
use ndarray::{Array2, Axis};
use serde::Serialize;

/// Standard uncertainty of readings that state none, relative to the reading: that of a goniophotometer with a
/// reference standard.
const ASSUMED_RELATIVE: f64 = 0.05;
/// The same relative to the mean of the channel: without it dark readings would count above all others.
const ASSUMED_RELATIVE_OF_MEAN: f64 = 0.01;

/// What a column of readings is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Channel {
    Red,
    Green,
    Blue,
    /// Of samples that have no other.
    Luminance,
    /// Vacuum wavelength, nm.
    Wavelength(f64),
}

impl Channel {
    /// `r`, `g`, `b`, `y`, or the wavelength as `550 nm`.
    pub fn name(self) -> String {
        match self {
            Self::Red => "r".into(),
            Self::Green => "g".into(),
            Self::Blue => "b".into(),
            Self::Luminance => "y".into(),
            Self::Wavelength(nm) => format!("{nm} nm"),
        }
    }

    /// Wavelength in nm; none of red, green, blue and luminance.
    pub fn wavelength_nm(self) -> Option<f64> {
        match self {
            Self::Wavelength(nm) => Some(nm),
            Self::Red | Self::Green | Self::Blue | Self::Luminance => None,
        }
    }
}

/// Readings of a sample that a model is fitted to: absolute brightness factors β as the sample has them, never
/// interpolated.
#[derive(Clone, Debug, PartialEq)]
pub struct FitReadings {
    pub sample: String,
    /// In the plane of incidence, view angles signed.
    pub geometries: Vec<Geometry>,
    pub channels: Vec<Channel>,
    /// β, `[geometry][channel]`.
    pub beta: Array2<f64>,
    /// Standard uncertainty of β, above 0, `[geometry][channel]`; readings err independently.
    pub se: Array2<f64>,
    /// β of the perfect diffuser in each channel, of which gloss takes its colour.
    pub white: Vec<f64>,
    /// What a unit of each channel adds to r, g, b and y; none where the wavelengths cannot carry a colour.
    pub rgby: Option<Vec<[f64; 4]>>,
    /// Whether it is light that went through.
    pub transmission: bool,
    pub notices: Vec<FitNotice>,
}

impl FitReadings {
    /// All readings of a sample: red, green and blue of RGB data, each wavelength of spectral data. XYZ become linear
    /// RGB in the convention, with standard uncertainties propagated and the correlations between R, G and B left out.
    ///
    /// # Errors
    /// [`FitError`] for a sample without readings, such as published ratios.
    pub fn new(sample: &Sample, convention: &Convention) -> Result<Self, FitError> {
        let without = |found, remedy| FitError::NoReadings {
            sample: sample.name().into(),
            found,
            remedy,
        };
        if sample.published_ratios().is_some() {
            return Err(without("published colour ratios alone", "take a sample with curves"));
        }
        let raw: Vec<_> = sample.raw().collect();
        let Some(first) = raw.first() else {
            return Err(without("none in the plane of incidence", "add some to the file"));
        };
        let width = first.beta.len();
        let of = |values: fn(&RawReading) -> Vec<f64>| {
            let all: Vec<f64> = raw.iter().flat_map(values).collect();
            Array2::from_shape_vec((raw.len(), width), all)
                .map_err(|_| without("rows of different lengths", "give every geometry the same channels"))
        };
        let (mut beta, mut se) = (of(|reading| reading.beta.to_vec())?, of(|reading| reading.se.to_vec())?);
        let weights = sample.channel_weights(convention);
        let (channels, white, rgby) = match sample.wavelengths_nm() {
            Some(nm) => {
                let channels: Vec<Channel> = nm.iter().map(|&nm| Channel::Wavelength(nm)).collect();
                // A laser's wavelength is fitted as well as any, though it has no colour.
                (channels, vec![1.0; width], weights.ok())
            }
            None if sample.is_luminance() => (vec![Channel::Luminance], vec![1.0], Some(weights?)),
            None => {
                let weights = weights?;
                let luminance = convention.rgb.luminance_row();
                let rgb: Vec<[f64; 4]> = (0..3)
                    .map(|c| std::array::from_fn(|k| if k == 3 { luminance[c] } else { f64::from(k == c) }))
                    .collect();
                let mut white = vec![1.0; 3];
                if !sample.is_rgb() {
                    let to_rgb = Array2::from_shape_fn((3, 3), |(xyz, c)| weights[xyz][c]);
                    beta = beta.dot(&to_rgb);
                    se = (&se * &se).dot(&(&to_rgb * &to_rgb)).mapv(f64::sqrt);
                    let diffuser = ColourSystem::new(&WavelengthGrid::preprint(), convention.clone());
                    let diffuser = diffuser.map_err(SampleError::from)?;
                    white = diffuser.linear_rgb(diffuser.white()).0.to_vec();
                }
                (vec![Channel::Red, Channel::Green, Channel::Blue], white, Some(rgb))
            }
        };
        let geometries = raw.iter().map(|reading| Geometry {
            theta_i_deg: reading.theta_i_deg,
            theta_v_deg: reading.theta_v_deg,
        });
        let mut readings = Self {
            sample: sample.name().into(),
            geometries: geometries.collect(),
            channels,
            beta,
            se,
            white,
            rgby,
            transmission: sample.is_transmission(),
            notices: Vec::new(),
        };
        readings.assume_uncertainty();
        Ok(readings)
    }

    fn assume_uncertainty(&mut self) {
        let missing = self.se.iter().filter(|se| **se <= 0.0).count();
        if missing == 0 {
            return;
        }
        for (beta, mut se) in self.beta.axis_iter(Axis(1)).zip(self.se.axis_iter_mut(Axis(1))) {
            let mean = beta.iter().map(|beta| beta.abs()).sum::<f64>() / beta.len() as f64;
            // A channel that is 0 throughout takes the perfect diffuser's scale, so that no weight is infinite.
            let floor = ASSUMED_RELATIVE_OF_MEAN * if mean > 0.0 { mean } else { 1.0 };
            for (beta, se) in beta.iter().zip(&mut se) {
                if *se <= 0.0 {
                    *se = floor.hypot(ASSUMED_RELATIVE * beta);
                }
            }
        }
        self.notices.push(FitNotice::AssumedUncertainty {
            readings: missing,
            of: self.se.len(),
            relative: ASSUMED_RELATIVE,
            relative_of_mean: ASSUMED_RELATIVE_OF_MEAN,
        });
    }

    /// Number of readings: geometries times channels.
    pub fn len(&self) -> usize {
        self.beta.len()
    }

    pub fn is_empty(&self) -> bool {
        self.beta.is_empty()
    }

    /// The readings at geometries that are chosen.
    pub fn subset(&self, chosen: impl Fn(&Geometry) -> bool) -> Self {
        let places: Vec<usize> = (0..self.geometries.len())
            .filter(|&g| chosen(&self.geometries[g]))
            .collect();
        Self {
            geometries: places.iter().map(|&g| self.geometries[g]).collect(),
            beta: self.beta.select(Axis(0), &places),
            se: self.se.select(Axis(0), &places),
            ..self.clone()
        }
    }

    /// Incidences in degrees, ascending, each once.
    pub fn incidences_deg(&self) -> Vec<f64> {
        let mut incidences: Vec<f64> = self.geometries.iter().map(|g| g.theta_i_deg).collect();
        incidences.sort_by(f64::total_cmp);
        incidences.dedup();
        incidences
    }

    /// (model − measured) / uncertainty, `[geometry][channel]`.
    ///
    /// # Panics
    /// If the model has not one value for each reading.
    pub fn residuals(&self, model: &Array2<f64>) -> Array2<f64> {
        (model - &self.beta) / &self.se
    }

    /// The same of some geometries, by their places, channel by channel.
    pub fn residuals_at(&self, model: &Array2<f64>, places: &[usize]) -> Vec<f64> {
        let residuals = self.residuals(model);
        places.iter().flat_map(|&g| residuals.row(g).to_vec()).collect()
    }

    /// r, g, b and y of values of the channels; none where the wavelengths cannot carry a colour.
    pub fn rgby_of(&self, channels: &[f64]) -> Option<[f64; 4]> {
        let weights = self.rgby.as_ref()?;
        let mut sum = [0.0; 4];
        for (weight, value) in weights.iter().zip(channels) {
            sum.iter_mut()
                .zip(weight)
                .for_each(|(sum, weight)| *sum += weight * value);
        }
        Some(sum)
    }
}

/// √(mean of the squares): the misfit in units of the uncertainty, where the values are [`FitReadings::residuals`].
pub fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for value in values {
        sum += value * value;
        count += 1;
    }
    (sum / f64::from(count)).sqrt()
}
