//! From models, classical shadings and samples to everything that is said of them.

use super::metrics::{Curves, Slot, peak_angle_deg, ratio_of};
use super::propagation::{Channels, Propagation};
use super::{
    Channel, Coefficient, ColourRatios, CompareError, Compared, Comparison, CurvePoint, Geometry, Inputs, Peak,
    PropagatedEstimate, Rmse, Role, Source, SourceId, SourceRatios,
};
use crate::sample::Reading;

impl ColourRatios {
    /// From r, g and b as functions of (model, measured).
    fn new(propagation: &Propagation, component: impl Fn(Channel, &[Channels], &[Option<Channels>]) -> f64) -> Self {
        /// Red counts as 0 within so many of its standard errors, and below this share of the largest component.
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
    /// Compares every model and every classical shading with every sample. Curves are normalised to the first sample;
    /// without a sample they are absolute, and there is nothing else.
    ///
    /// # Errors
    /// Lists of other lengths than the geometries, values that are not finite, fewer than two batches, a sample without
    /// any reading, or an id that occurs twice.
    pub fn new(inputs: &Inputs) -> Result<Self, CompareError> {
        let sources: Vec<Source> = inputs.sources().cloned().collect();
        let twice = |(place, source): (usize, &Source)| sources[..place].iter().any(|other| other.id == source.id);
        if let Some(place) = sources.iter().enumerate().position(twice) {
            return Err(CompareError::SameId {
                id: sources[place].id.clone(),
            });
        }
        let beside: Vec<Beside> = inputs
            .measured
            .iter()
            .map(|sample| Beside::new(inputs, Some(sample)))
            .collect::<Result<_, _>>()?;
        let curves = match beside.first() {
            Some(first) => first.points(),
            None => Beside::new(inputs, None)?.points(),
        };
        let mut comparison = Self {
            sources,
            curves,
            normalisation: Vec::new(),
            references: beside.iter().map(|of| of.geometry(of.curves.reference())).collect(),
            rmse: Vec::new(),
            peaks: Vec::new(),
            rmse_ratios: Vec::new(),
            colour_ratios: Vec::new(),
        };
        for (place, of) in beside.iter().enumerate() {
            if place > 0 {
                comparison.curves.extend(of.measured_points());
            }
            comparison.normalisation.extend(of.coefficients());
            comparison.colour_ratios.extend(of.colour_ratios());
            for (theta_i_deg, views) in of.curves.incidences() {
                let errors = of.model_errors(&views);
                for channel in Channel::ALL {
                    of.add_metrics(&mut comparison, theta_i_deg, &views, channel, &errors);
                }
            }
        }
        Ok(comparison)
    }
}

impl Comparison {
    /// One model, one classical shading and one sample, with the ids and labels of their roles.
    ///
    /// # Errors
    /// As [`Comparison::new`].
    pub fn of_one_each(
        geometries: &[Geometry],
        model_batches: &[Vec<Channels>],
        classical: &[Channels],
        measured: &[Option<Reading>],
    ) -> Result<Self, CompareError> {
        let [model, shading, sample] =
            [Role::Model, Role::Classical, Role::Measured].map(|role| Source::numbered(role, 0, role.id()));
        Self::new(&Inputs {
            geometries,
            models: &[Compared::new(&model, model_batches)],
            classical: &[Compared::new(&shading, classical)],
            measured: &[Compared::new(&sample, measured)],
        })
    }
}

impl<'a> Inputs<'a> {
    fn sources(&self) -> impl Iterator<Item = &'a Source> {
        let models = self.models.iter().map(|model| model.source);
        let classical = self.classical.iter().map(|shading| shading.source);
        let measured = self.measured.iter().map(|sample| sample.source);
        models.chain(classical).chain(measured)
    }
}

/// Every model and classical shading beside one sample, or beside none.
struct Beside<'a> {
    inputs: &'a Inputs<'a>,
    sample: Option<&'a Compared<'a, Option<Reading>>>,
    curves: Curves<'a>,
    /// One a model; without a model, one of the measurement's errors alone.
    propagations: Vec<Propagation>,
}

/// A source with the function that its values are and the errors that they have.
struct ComparedEntry<'a> {
    id: &'a SourceId,
    slot: Slot,
    propagation: &'a Propagation,
}

impl<'a> Beside<'a> {
    fn new(inputs: &'a Inputs<'a>, sample: Option<&'a Compared<'a, Option<Reading>>>) -> Result<Self, CompareError> {
        let none = vec![None; inputs.geometries.len()];
        let measured = sample.map_or(none.as_slice(), |sample| sample.values);
        let mut propagations = Vec::new();
        for model in inputs.models {
            propagations.push(Propagation::new(model.values, measured)?);
        }
        if propagations.is_empty() {
            propagations.push(Propagation::of_readings(measured)?);
        }
        let means: Vec<_> = propagations.iter().map(Propagation::model_mean).collect();
        let curves = Curves::new(inputs, &means[..inputs.models.len()], sample)?;
        Ok(Self {
            inputs,
            sample,
            curves,
            propagations,
        })
    }

    fn models(&self) -> impl Iterator<Item = ComparedEntry<'_>> {
        let models = self.inputs.models.iter().zip(&self.propagations);
        models.map(|(model, propagation)| ComparedEntry {
            id: &model.source.id,
            slot: Slot::Model,
            propagation,
        })
    }

    fn classical(&self) -> impl Iterator<Item = ComparedEntry<'_>> {
        self.inputs
            .classical
            .iter()
            .enumerate()
            .map(|(place, shading)| ComparedEntry {
                id: &shading.source.id,
                slot: Slot::Classical(place),
                propagation: &self.propagations[0],
            })
    }

    /// The sample itself.
    fn measured(&self) -> Option<ComparedEntry<'_>> {
        self.sample.map(|sample| ComparedEntry {
            id: &sample.source.id,
            slot: Slot::Measured,
            propagation: &self.propagations[0],
        })
    }

    fn geometry(&self, place: usize) -> Geometry {
        self.inputs.geometries[place]
    }

    fn coefficient(&self, of: &ComparedEntry) -> PropagatedEstimate {
        of.propagation
            .estimate(|model, measured| self.curves.coefficient(of.slot, model, measured))
    }

    /// None where values stay absolute.
    fn coefficients(&self) -> Vec<Coefficient> {
        let Some(sample) = self.sample.filter(|_| self.curves.normalised()) else {
            return Vec::new();
        };
        let of = |entry: ComparedEntry| Coefficient {
            source: entry.id.clone(),
            sample: sample.source.id.clone(),
            at: self.geometry(self.curves.reference()),
            factor: self.coefficient(&entry),
        };
        self.models().chain(self.classical()).map(of).collect()
    }

    fn colour_ratios(&self) -> Vec<SourceRatios> {
        let Some(sample) = self.measured().map(|sample| sample.id.clone()) else {
            return Vec::new();
        };
        let reference = self.curves.reference();
        let of = |entry: ComparedEntry| SourceRatios {
            source: entry.id.clone(),
            sample: sample.clone(),
            ratios: ColourRatios::new(entry.propagation, |channel, model, measured| {
                self.curves.value(entry.slot, reference, channel, model, measured)
            }),
        };
        let all = self.models().chain(self.classical()).chain(self.measured());
        all.map(of).collect()
    }

    /// Curves of all sources.
    fn points(&self) -> Vec<CurvePoint> {
        let mut points = Vec::new();
        for entry in self.models().chain(self.classical()) {
            for channel in Channel::ALL {
                for (j, geometry) in self.inputs.geometries.iter().enumerate() {
                    let beta = entry
                        .propagation
                        .estimate(|model, measured| self.curves.value(entry.slot, j, channel, model, measured));
                    points.push(CurvePoint {
                        theta_i_deg: geometry.theta_i_deg,
                        theta_v_deg: geometry.theta_v_deg,
                        source: entry.id.clone(),
                        channel,
                        beta: beta.value,
                        se: beta.se,
                        interpolated: false,
                    });
                }
            }
        }
        points.extend(self.measured_points());
        points
    }

    /// Curves of the sample as it was read.
    fn measured_points(&self) -> Vec<CurvePoint> {
        let mut points = Vec::new();
        let Some(sample) = self.sample else {
            return points;
        };
        for channel in Channel::ALL {
            for (geometry, reading) in self.inputs.geometries.iter().zip(sample.values) {
                let Some(reading) = reading else { continue };
                points.push(CurvePoint {
                    theta_i_deg: geometry.theta_i_deg,
                    theta_v_deg: geometry.theta_v_deg,
                    source: sample.source.id.clone(),
                    channel,
                    beta: reading.beta[channel as usize],
                    se: reading.se()[channel as usize],
                    interpolated: reading.interpolated,
                });
            }
        }
        points
    }

    /// Of each model the relative Monte Carlo error of its luminance over the views, rms over mean, or of its
    /// coefficient, if that is larger.
    fn model_errors(&self, views: &[usize]) -> Vec<f64> {
        let of = |model: ComparedEntry| {
            let estimates = views.iter().map(|&j| {
                model
                    .propagation
                    .estimate(|mean, measured| self.curves.value(Slot::Model, j, Channel::Y, mean, measured))
            });
            let (squares, sum) = estimates.fold((0.0, 0.0), |(squares, sum), e| {
                (squares + e.se_monte_carlo.powi(2), sum + e.value)
            });
            let count = views.len() as f64;
            let of_views = (squares / count).sqrt() / (sum / count);
            let of_coefficient = match self.curves.normalised() {
                true => {
                    let coefficient = self.coefficient(&model);
                    coefficient.se_monte_carlo / coefficient.value
                }
                false => 0.0,
            };
            // f64::max would pass over NaN.
            if of_coefficient > of_views {
                of_coefficient
            } else {
                of_views
            }
        };
        self.models().map(of).collect()
    }

    fn add_metrics(
        &self,
        comparison: &mut Comparison,
        theta_i_deg: f64,
        views: &[usize],
        channel: Channel,
        model_errors: &[f64],
    ) {
        let Some(sample) = self.measured() else { return };
        let curves = &self.curves;
        for entry in self.models().chain(self.classical()) {
            let relative = entry.propagation.estimate(|model, measured| {
                curves.rmse(entry.slot, channel, views, model, measured)
                    / curves.mean_measured(channel, views, measured)
            });
            comparison.rmse.push(Rmse {
                theta_i_deg,
                source: entry.id.clone(),
                channel,
                rmse: entry
                    .propagation
                    .estimate(|model, measured| curves.rmse(entry.slot, channel, views, model, measured)),
                relative: (relative.value.is_finite() && relative.value >= 0.0).then_some(relative),
                views: views.len(),
                sample: sample.id.clone(),
            });
        }
        let angles_deg: Vec<f64> = views.iter().map(|&j| curves.theta_v_deg(j)).collect();
        for entry in self.measured().into_iter().chain(self.models()).chain(self.classical()) {
            let peak = |model: &[Channels], measured: &[Option<Channels>]| {
                let values: Vec<f64> = views
                    .iter()
                    .map(|&j| curves.value(entry.slot, j, channel, model, measured))
                    .collect();
                peak_angle_deg(&angles_deg, &values)
            };
            let angle = entry.propagation.estimate(peak);
            comparison.peaks.push(Peak {
                theta_i_deg,
                source: entry.id.clone(),
                channel,
                angle_deg: angle.value.is_finite().then_some(angle),
                at_edge: angles_deg.first() == Some(&angle.value) || angles_deg.last() == Some(&angle.value),
                sample: sample.id.clone(),
            });
        }
        for (model, &model_error) in self.models().zip(model_errors) {
            let propagation = model.propagation;
            let square = |slot, model: &[Channels], measured: &[Option<Channels>]| {
                curves.rmse(slot, channel, views, model, measured).powi(2)
            };
            // Monte Carlo noise is in the model's mean square alone and would count against the model. It is
            // subtracted, but no more than half: a model that is nothing but noise away from the measurement keeps a
            // finite ratio.
            let mean_square = propagation.estimate(|model, measured| square(Slot::Model, model, measured));
            let noise = mean_square.bias_monte_carlo.clamp(0.0, mean_square.value / 2.0);
            for classical in self.classical() {
                let log_ratio = propagation.estimate(|mean, measured| {
                    let of_model = square(Slot::Model, mean, measured);
                    let of_classical = square(classical.slot, mean, measured);
                    (of_classical.ln() - (of_model - noise).ln()) / 2.0
                });
                let pair = [model.id, classical.id, sample.id];
                let ratio = ratio_of(&log_ratio, propagation, theta_i_deg, channel, model_error, pair);
                comparison.rmse_ratios.push(ratio);
            }
        }
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
