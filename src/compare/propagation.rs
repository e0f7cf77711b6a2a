use crate::number::nan_from_null;
use serde::{Deserialize, Serialize};

use super::CompareError;
use crate::sample::Reading;

/// β in the channels r, g, b, y.
pub type Channels = [f64; 4];

/// A value and its standard error, with the two parts the error is made of, added in quadrature.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PropagatedEstimate {
    #[serde(deserialize_with = "nan_from_null")]
    pub value: f64,
    #[serde(deserialize_with = "nan_from_null")]
    pub se: f64,
    /// What Monte Carlo noise adds to the value on average, by the jackknife: nothing for a linear function, more than
    /// nothing for an RMSE. Not subtracted from the value.
    #[serde(deserialize_with = "nan_from_null")]
    pub bias_monte_carlo: f64,
    #[serde(deserialize_with = "nan_from_null")]
    pub se_monte_carlo: f64,
    #[serde(deserialize_with = "nan_from_null")]
    pub se_measurement: f64,
}

/// Carries Monte Carlo and measurement errors to any function of the model's mean and the measurement.
///
/// Monte Carlo: delete-one jackknife over the batches, se² = (B−1)/B Σ (F₍b₎ − F̄)² (Efron and Stein 1981), which for
/// the mean itself is the usual standard error of the mean; its bias is (B−1) (F̄ − F).
///
/// Measurement: se² = Σ_j gⱼᵀ Cⱼ gⱼ, gⱼ the differences of F over ± one standard error of each channel of reading j, Cⱼ
/// the covariance of its channels. Readings of different geometries are taken as independent; where they are not (a fit
/// evaluated at many angles, views interpolated from common neighbours) the error comes out too small for quantities
/// that average over them.
#[derive(Clone, Debug)]
pub struct Propagation {
    model_mean: Vec<Channels>,
    leave_one_out: Vec<Vec<Channels>>,
    measured: Vec<Option<Reading>>,
}

impl Propagation {
    /// `measured` has an entry a geometry, as each batch has.
    pub fn new(batches: &[Vec<Channels>], measured: &[Option<Reading>]) -> Result<Self, CompareError> {
        if batches.len() < 2 {
            return Err(CompareError::TooFewBatches { found: batches.len() });
        }
        for (index, batch) in batches.iter().enumerate() {
            check(&format!("model batch {index}"), batch, measured.len())?;
        }
        check_readings(measured)?;
        let mean_without = |left_out: Option<usize>| -> Vec<Channels> {
            let count = (batches.len() - usize::from(left_out.is_some())) as f64;
            let mut mean = vec![[0.0; 4]; measured.len()];
            for (_, batch) in batches.iter().enumerate().filter(|(b, _)| Some(*b) != left_out) {
                for (sum, value) in mean.as_flattened_mut().iter_mut().zip(batch.as_flattened()) {
                    *sum += value;
                }
            }
            mean.as_flattened_mut().iter_mut().for_each(|sum| *sum /= count);
            mean
        };
        Ok(Self {
            model_mean: mean_without(None),
            leave_one_out: (0..batches.len()).map(|b| mean_without(Some(b))).collect(),
            measured: measured.to_vec(),
        })
    }

    /// Of the measurement's errors alone.
    ///
    /// # Errors
    /// A reading that is not finite.
    pub fn of_readings(measured: &[Option<Reading>]) -> Result<Self, CompareError> {
        check_readings(measured)?;
        Ok(Self {
            model_mean: Vec::new(),
            leave_one_out: Vec::new(),
            measured: measured.to_vec(),
        })
    }

    pub fn model_mean(&self) -> &[Channels] {
        &self.model_mean
    }

    /// β of the readings.
    pub fn measured_values(&self) -> Vec<Option<Channels>> {
        self.measured.iter().map(|r| r.map(|r| r.beta)).collect()
    }

    /// Number of batches, at least 2; none without a model.
    pub fn batches(&self) -> usize {
        self.leave_one_out.len()
    }

    /// Value and standard error of F(model mean, measured). Deterministic; F must not depend on anything else.
    pub fn estimate(&self, f: impl Fn(&[Channels], &[Option<Channels>]) -> f64) -> PropagatedEstimate {
        let mut measured = self.measured_values();
        let value = f(&self.model_mean, &measured);
        let replicates: Vec<f64> = self.leave_one_out.iter().map(|model| f(model, &measured)).collect();
        let count = replicates.len() as f64;
        let mean = replicates.iter().sum::<f64>() / count;
        let (monte_carlo, bias) = match replicates.is_empty() {
            true => (0.0, 0.0),
            false => (
                (count - 1.0) / count * replicates.iter().map(|r| (r - mean).powi(2)).sum::<f64>(),
                (count - 1.0) * (mean - value),
            ),
        };
        let mut measurement = 0.0;
        for (j, reading) in self.measured.iter().enumerate() {
            let Some(reading) = reading else { continue };
            let mut gradient = [0.0; 4];
            for (channel, se) in reading.se().into_iter().enumerate().filter(|(_, se)| *se > 0.0) {
                let mut moved = |by: f64| {
                    let mut beta = reading.beta;
                    beta[channel] += by;
                    measured[j] = Some(beta);
                    f(&self.model_mean, &measured)
                };
                gradient[channel] = (moved(se) - moved(-se)) / (2.0 * se);
            }
            measured[j] = Some(reading.beta);
            for (g, line) in gradient.iter().zip(&reading.covariance) {
                measurement += g * line.iter().zip(&gradient).map(|(c, h)| c * h).sum::<f64>();
            }
        }
        PropagatedEstimate {
            value,
            se: (monte_carlo + measurement).sqrt(),
            bias_monte_carlo: bias,
            se_monte_carlo: monte_carlo.sqrt(),
            se_measurement: measurement.sqrt(),
        }
    }
}

fn check_readings(measured: &[Option<Reading>]) -> Result<(), CompareError> {
    for (index, reading) in measured.iter().enumerate() {
        let Some(reading) = reading else { continue };
        let values = [reading.beta.as_slice(), reading.covariance.as_flattened()].concat();
        if values.iter().any(|v| !v.is_finite()) {
            return Err(CompareError::NotFinite {
                what: "measured".into(),
                index,
                found: values,
            });
        }
    }
    Ok(())
}

/// As many finite values as there are geometries.
pub(super) fn check(what: &str, values: &[Channels], geometries: usize) -> Result<(), CompareError> {
    if values.len() != geometries {
        return Err(CompareError::Length {
            what: what.into(),
            expected: geometries,
            found: values.len(),
        });
    }
    match values.iter().position(|v| v.iter().any(|x| !x.is_finite())) {
        Some(index) => Err(CompareError::NotFinite {
            what: what.into(),
            index,
            found: values[index].to_vec(),
        }),
        None => Ok(()),
    }
}
