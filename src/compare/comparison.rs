//! From model, classical shading and measurement to everything that is said of them.

use super::metrics::{Curves, peak_angle_deg, ratio_of};
use super::propagation::{Channels, Propagation};
use super::{
    Channel, ColourRatios, CompareError, Comparison, CurvePoint, Inputs, Normalisation, Peak, Rmse, Source,
    SourceRatios,
};

impl ColourRatios {
    /// From r, g and b as functions of (model, measured).
    fn new(propagation: &Propagation, component: impl Fn(Channel, &[Channels], &[Option<Channels>]) -> f64) -> Self {
        /// Errors and share of the largest component within which red counts as 0.
        const SIGMAS: f64 = 2.0;
        const SHARE: f64 = 0.02;
        let [red, green, blue] =
            [Channel::R, Channel::G, Channel::B].map(|c| propagation.estimate(|a, b| component(c, a, b)));
        let over_red = |c| propagation.estimate(|a, b| component(c, a, b) / component(Channel::R, a, b));
        let largest = red.value.abs().max(green.value.abs()).max(blue.value.abs());
        Self {
            blue_over_red: over_red(Channel::B),
            green_over_red: over_red(Channel::G),
            red,
            red_is_zero: !(red.value - red.se).is_finite() || red.value.abs() <= (SIGMAS * red.se).max(SHARE * largest),
        }
    }
}

impl Comparison {
    pub fn new(inputs: &Inputs) -> Result<Self, CompareError> {
        let propagation = Propagation::new(inputs.model_batches, inputs.measured)?;
        let curves = Curves::new(inputs, propagation.model_mean())?;
        let coefficient = |source| propagation.estimate(|model, measured| curves.coefficient(source, model, measured));
        let mut comparison = Self {
            normalisation: curves.normalised().then(|| Normalisation {
                model: coefficient(Source::Model),
                classical: coefficient(Source::Classical),
            }),
            reference: inputs.geometries[curves.reference()],
            curves: curve_points(inputs, &propagation, &curves),
            rmse: Vec::new(),
            peaks: Vec::new(),
            rmse_ratios: Vec::new(),
            colour_ratios: [Source::Model, Source::Classical, Source::Measured]
                .map(|source| SourceRatios {
                    source,
                    ratios: reference_ratios(&propagation, &curves, source),
                })
                .to_vec(),
        };
        for (theta_i_deg, views) in curves.incidences() {
            let error = comparison.model_error(&propagation, &curves, &views);
            for channel in Channel::ALL {
                comparison.add_metrics(&propagation, &curves, theta_i_deg, &views, channel, error);
            }
        }
        Ok(comparison)
    }

    /// Relative Monte Carlo error of the model's luminance over the views, rms over mean, or of its coefficient, if larger.
    fn model_error(&self, propagation: &Propagation, curves: &Curves, views: &[usize]) -> f64 {
        let estimates = views.iter().map(|&j| {
            propagation.estimate(|model, measured| curves.value(Source::Model, j, Channel::Y, model, measured))
        });
        let (squares, sum) = estimates.fold((0.0, 0.0), |(squares, sum), e| {
            (squares + e.se_monte_carlo.powi(2), sum + e.value)
        });
        let count = views.len() as f64;
        let of_views = (squares / count).sqrt() / (sum / count);
        let of_coefficient = self
            .normalisation
            .map_or(0.0, |n| n.model.se_monte_carlo / n.model.value);
        // f64::max would pass over NaN.
        if of_coefficient > of_views {
            of_coefficient
        } else {
            of_views
        }
    }

    fn add_metrics(
        &mut self,
        propagation: &Propagation,
        curves: &Curves,
        theta_i_deg: f64,
        views: &[usize],
        channel: Channel,
        model_error: f64,
    ) {
        for source in [Source::Model, Source::Classical] {
            let relative = propagation.estimate(|model, measured| {
                curves.rmse(source, channel, views, model, measured) / curves.mean_measured(channel, views, measured)
            });
            self.rmse.push(Rmse {
                theta_i_deg,
                source,
                channel,
                rmse: propagation.estimate(|model, measured| curves.rmse(source, channel, views, model, measured)),
                relative: (relative.value.is_finite() && relative.value >= 0.0).then_some(relative),
                views: views.len(),
            });
        }
        for source in [Source::Measured, Source::Model, Source::Classical] {
            let angles_deg: Vec<f64> = views.iter().map(|&j| curves.theta_v_deg(j)).collect();
            let peak = |model: &[Channels], measured: &[Option<Channels>]| {
                let values: Vec<f64> = views
                    .iter()
                    .map(|&j| curves.value(source, j, channel, model, measured))
                    .collect();
                peak_angle_deg(&angles_deg, &values)
            };
            let angle = propagation.estimate(peak);
            self.peaks.push(Peak {
                theta_i_deg,
                source,
                channel,
                angle_deg: angle.value.is_finite().then_some(angle),
                at_edge: angles_deg.first() == Some(&angle.value) || angles_deg.last() == Some(&angle.value),
            });
        }
        let square = |source, model: &[Channels], measured: &[Option<Channels>]| {
            curves.rmse(source, channel, views, model, measured).powi(2)
        };
        // Monte Carlo noise is in the model's mean square alone and would count against the model. It is taken off, but
        // no more than half: a model that is nothing but noise away from the measurement keeps a finite ratio.
        let mean_square = propagation.estimate(|model, measured| square(Source::Model, model, measured));
        let noise = mean_square.bias_monte_carlo.clamp(0.0, mean_square.value / 2.0);
        let log_ratio = propagation.estimate(|model, measured| {
            let [model, classical] = [Source::Model, Source::Classical].map(|source| square(source, model, measured));
            (classical.ln() - (model - noise).ln()) / 2.0
        });
        self.rmse_ratios
            .push(ratio_of(&log_ratio, propagation, theta_i_deg, channel, model_error));
    }
}

/// Colour ratios of a model alone, from its batches at normal incidence and view: a row of Table 1.
pub fn model_colour_ratios(batches: &[Channels]) -> Result<ColourRatios, CompareError> {
    let batches: Vec<Vec<Channels>> = batches.iter().map(|batch| vec![*batch]).collect();
    let propagation = Propagation::new(&batches, &[None])?;
    Ok(ColourRatios::new(&propagation, |channel, model, _| {
        model[0][channel as usize]
    }))
}

fn reference_ratios(propagation: &Propagation, curves: &Curves, source: Source) -> ColourRatios {
    ColourRatios::new(propagation, |channel, model, measured| {
        curves.value(source, curves.reference(), channel, model, measured)
    })
}

fn curve_points(inputs: &Inputs, propagation: &Propagation, curves: &Curves) -> Vec<CurvePoint> {
    let mut points = Vec::new();
    for source in [Source::Model, Source::Classical, Source::Measured] {
        for channel in Channel::ALL {
            for (j, geometry) in inputs.geometries.iter().enumerate() {
                let (estimate, interpolated) = match (source, &inputs.measured[j]) {
                    (Source::Measured, None) => continue,
                    (Source::Measured, Some(reading)) => {
                        let c = channel as usize;
                        ((reading.beta[c], reading.se()[c]), reading.interpolated)
                    }
                    _ => {
                        let e =
                            propagation.estimate(|model, measured| curves.value(source, j, channel, model, measured));
                        ((e.value, e.se), false)
                    }
                };
                points.push(CurvePoint {
                    theta_i_deg: geometry.theta_i_deg,
                    theta_v_deg: geometry.theta_v_deg,
                    source,
                    channel,
                    beta: estimate.0,
                    se: estimate.1,
                    interpolated,
                });
            }
        }
    }
    points
}
