use super::error::FitError;
use serde::{Deserialize, Serialize};

/// Coordinate in which a parameter is searched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scale {
    #[default]
    Linear,
    /// Natural logarithm; bounds and prior mean are positive.
    Log,
}

/// What is known of a parameter before the fit; it enters the fit as one more residual.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Prior {
    pub mean: f64,
    /// Standard deviation in the parameter's unit. On a logarithmic scale the logarithm has sd/mean.
    pub sd: f64,
}

/// A parameter that a fit varies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FreeParameter {
    pub name: String,
    /// Empty for a dimensionless parameter.
    pub unit: String,
    /// Lowest and highest value; infinite where there is none.
    pub bounds: [f64; 2],
    pub scale: Scale,
    pub prior: Option<Prior>,
}

impl FreeParameter {
    /// # Errors
    /// [`FitError`] for bounds that exclude each other or the scale, and for a prior that is none.
    pub fn check(&self) -> Result<(), FitError> {
        let [low, high] = self.bounds;
        let (name, unit) = (self.name.clone(), self.unit_after_number());
        if low.is_nan() || high.is_nan() || low >= high {
            return Err(FitError::Bounds { name, low, high, unit });
        }
        if self.scale == Scale::Log && low <= 0.0 {
            return Err(FitError::LogarithmicBounds { name, low, high, unit });
        }
        match self.prior {
            Some(Prior { mean, sd })
                if !(mean.is_finite() && sd.is_finite() && sd > 0.0 && (self.scale == Scale::Linear || mean > 0.0)) =>
            {
                Err(FitError::Prior { name, mean, sd, unit })
            }
            _ => Ok(()),
        }
    }

    pub(super) fn unit_after_number(&self) -> String {
        match self.unit.as_str() {
            "" => String::new(),
            unit => format!(" {unit}"),
        }
    }

    /// The value on the parameter's scale.
    pub(super) fn scaled(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => value,
            Scale::Log => value.ln(),
        }
    }

    /// The reverse of [`Self::scaled`], between the bounds in spite of rounding.
    pub(super) fn value(&self, scaled: f64) -> f64 {
        let value = match self.scale {
            Scale::Linear => scaled,
            Scale::Log => scaled.exp(),
        };
        value.clamp(self.bounds[0], self.bounds[1])
    }

    /// Derivative of the value by its scaled form.
    pub(super) fn value_by_scaled(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => 1.0,
            Scale::Log => value,
        }
    }

    pub(super) fn scaled_bounds(&self) -> [f64; 2] {
        self.bounds.map(|bound| self.scaled(bound))
    }

    /// The prior's residual, in standard deviations; none without a prior.
    pub(super) fn prior_residual(&self, value: f64) -> Option<f64> {
        self.prior.map(|Prior { mean, sd }| match self.scale {
            Scale::Linear => (value - mean) / sd,
            Scale::Log => (value / mean).ln() * mean / sd,
        })
    }

    /// Derivative of [`Self::prior_residual`] by the value.
    pub(super) fn prior_derivative(&self, value: f64) -> Option<f64> {
        self.prior.map(|Prior { mean, sd }| match self.scale {
            Scale::Linear => 1.0 / sd,
            Scale::Log => mean / (sd * value),
        })
    }

    /// The value at an unbounded coordinate u, the transformation of MINUIT (F. James, M. Roos, Comput. Phys. Commun.
    /// 10 (1975) 343): on the parameter's scale a + (b − a) (1 + sin u) / 2 between bounds a and b,
    /// a − 1 + √(u² + 1) above a bound a alone, b + 1 − √(u² + 1) below a bound b alone, and u without bounds.
    pub(super) fn value_at(&self, u: f64) -> f64 {
        let [low, high] = self.scaled_bounds();
        self.value(match (low.is_finite(), high.is_finite()) {
            (true, true) => low + (high - low) * 0.5 * (1.0 + u.sin()),
            (true, false) => low - 1.0 + u.hypot(1.0),
            (false, true) => high + 1.0 - u.hypot(1.0),
            (false, false) => u,
        })
    }

    /// Derivative of the value by u.
    pub(super) fn value_by_u(&self, u: f64) -> f64 {
        let [low, high] = self.scaled_bounds();
        let scaled_by_u = match (low.is_finite(), high.is_finite()) {
            (true, true) => (high - low) * 0.5 * u.cos(),
            (true, false) => u / u.hypot(1.0),
            (false, true) => -u / u.hypot(1.0),
            (false, false) => 1.0,
        };
        self.value_by_scaled(self.value_at(u)) * scaled_by_u
    }

    /// The coordinate of a value. On a bound, where the value's derivative by u vanishes and the search would stay,
    /// it is one slightly inside.
    pub(super) fn u_of(&self, value: f64) -> f64 {
        /// Share of the range, or distance on the parameter's scale.
        const INSIDE: f64 = 1e-3;
        let [low, high] = self.scaled_bounds();
        let scaled = self.scaled(value);
        let one_sided = |distance: f64| ((distance.max(INSIDE) + 1.0).powi(2) - 1.0).sqrt();
        match (low.is_finite(), high.is_finite()) {
            (true, true) => {
                let share = ((scaled - low) / (high - low)).clamp(INSIDE, 1.0 - INSIDE);
                (2.0 * share - 1.0).asin()
            }
            (true, false) => one_sided(scaled - low),
            (false, true) => one_sided(high - scaled),
            (false, false) => scaled,
        }
    }

    /// Difference in u over which a derivative is taken, for a step relative to the range, or to u where there is no
    /// range.
    pub(super) fn step_at(&self, u: f64, step: f64) -> f64 {
        let bounded = self.bounds.iter().any(|bound| bound.is_finite()) || self.scale == Scale::Log;
        if bounded || u == 0.0 { step } else { step * u.abs() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(bounds: [f64; 2], scale: Scale) -> FreeParameter {
        FreeParameter {
            name: "p".into(),
            unit: "1/mm".into(),
            bounds,
            scale,
            prior: None,
        }
    }

    #[test]
    fn coordinates_reach_every_value_and_keep_the_bounds() {
        let inf = f64::INFINITY;
        for (bounds, scale) in [
            ([2.0, 50.0], Scale::Linear),
            ([2.0, 50.0], Scale::Log),
            ([2.0, inf], Scale::Linear),
            ([2.0, inf], Scale::Log),
            ([-inf, 50.0], Scale::Linear),
            ([-inf, inf], Scale::Linear),
        ] {
            let p = parameter(bounds, scale);
            for value in [2.1, 7.0, 49.0] {
                let u = p.u_of(value);
                assert!(
                    (p.value_at(u) - value).abs() < 1e-12 * value,
                    "{bounds:?} {scale:?} {value}"
                );
                let h = 1e-6;
                let slope = (p.value_at(u + h) - p.value_at(u - h)) / (2.0 * h);
                assert!(
                    (p.value_by_u(u) - slope).abs() < 1e-7 * slope.abs(),
                    "{bounds:?} {scale:?}"
                );
            }
            for k in -200..200 {
                let value = p.value_at(0.37 * f64::from(k));
                assert!((bounds[0]..=bounds[1]).contains(&value));
            }
        }
    }

    #[test]
    fn refuses_contradictions() {
        assert!(matches!(
            parameter([3.0, 3.0], Scale::Linear).check(),
            Err(FitError::Bounds { .. })
        ));
        assert!(matches!(
            parameter([f64::NAN, 3.0], Scale::Linear).check(),
            Err(FitError::Bounds { .. })
        ));
        let log = parameter([0.0, 3.0], Scale::Log).check().unwrap_err().to_string();
        assert!(log.contains("[0, 3] 1/mm"), "{log}");
        let prior = Some(Prior { mean: 1.0, sd: 0.0 });
        let p = FreeParameter {
            prior,
            ..parameter([0.0, 3.0], Scale::Linear)
        };
        assert!(matches!(p.check(), Err(FitError::Prior { .. })));
    }

    #[test]
    fn prior_of_a_logarithmic_parameter_is_relative() {
        let prior = Some(Prior { mean: 4.0, sd: 0.4 });
        let p = FreeParameter {
            prior,
            ..parameter([0.1, 30.0], Scale::Log)
        };
        assert!((p.prior_residual(4.0 * 0.1f64.exp()).unwrap() - 1.0).abs() < 1e-12);
        let p = FreeParameter {
            prior,
            ..parameter([0.1, 30.0], Scale::Linear)
        };
        assert!((p.prior_residual(4.4).unwrap() - 1.0).abs() < 1e-12);
    }
}
