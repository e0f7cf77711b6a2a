use super::error::FitError;
use super::parameter::FreeParameter;
use super::residuals::{Differences, Residuals};
use nalgebra::{DMatrix, SVD};
use ndarray::Array2;
use serde::Serialize;

/// Correlation from which on two parameters cannot be told apart.
const CORRELATED: f64 = 0.99;
/// Singular value, relative to the largest of the Jacobian with columns of unit length, below which the data say
/// nothing of a combination of parameters. Derivatives by differences are good to less than this.
const SINGULAR: f64 = 1e-6;
/// Share of a parameter in such a combination from which on it is named.
const TAKES_PART: f64 = 0.1;

/// The bound that a parameter lies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Bound {
    Lower,
    Upper,
}

/// Parameters that the data cannot tell apart, or one that they do not depend on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Indistinct {
    pub names: Vec<String>,
    /// Between two parameters that have a standard error; none where a combination of the parameters has no effect.
    pub correlation: Option<f64>,
}

/// What the data say of each parameter at a point, to first order.
#[derive(Clone, Debug, PartialEq)]
pub struct Assessment {
    /// Derivatives of the residuals of the readings, `[residual][parameter]`, in the parameters' units.
    pub jacobian: Array2<f64>,
    /// (JᵀJ + priors)⁻¹ for residuals in units of their standard uncertainty; 0 for parameters on a bound, and the
    /// pseudo-inverse where parameters are indistinct.
    pub covariance: Array2<f64>,
    /// Square roots of the diagonal; none on a bound, and none for parameters of a combination without effect.
    pub se: Vec<Option<f64>>,
    /// Correlations of parameters with a standard error; 0 for others.
    pub correlation: Array2<f64>,
    pub at_bound: Vec<Option<Bound>>,
    pub indistinct: Vec<Indistinct>,
}

/// Jacobian, covariance, and parameters that cannot be told apart, at a point.
///
/// # Errors
/// Those of the model.
pub fn assess(
    parameters: &[FreeParameter],
    model: &dyn Residuals,
    values: &[f64],
    differences: Differences,
) -> Result<Assessment, FitError> {
    let count = parameters.len();
    let jacobian = match model.jacobian(values) {
        Some(jacobian) => jacobian,
        None => derivatives(parameters, model, values, differences.step)?,
    };
    let at_bound: Vec<Option<Bound>> = parameters
        .iter()
        .zip(values)
        .map(|(p, &value)| bound_of(p, value))
        .collect();
    let mut rows: Vec<Vec<f64>> = jacobian.outer_iter().map(|row| row.to_vec()).collect();
    for (place, parameter) in parameters.iter().enumerate() {
        if let Some(derivative) = parameter.prior_derivative(values[place]) {
            let mut row = vec![0.0; count];
            row[place] = derivative;
            rows.push(row);
        }
    }
    let length = |p: usize| rows.iter().map(|row| row[p] * row[p]).sum::<f64>().sqrt();
    let lengths: Vec<f64> = (0..count).map(length).collect();
    let mut assessment = Assessment {
        covariance: Array2::zeros((count, count)),
        correlation: Array2::zeros((count, count)),
        se: vec![None; count],
        indistinct: Vec::new(),
        jacobian,
        at_bound,
    };
    let inside: Vec<usize> = (0..count).filter(|&p| assessment.at_bound[p].is_none()).collect();
    let (seen, unseen): (Vec<usize>, Vec<usize>) = inside.into_iter().partition(|&p| lengths[p] > 0.0);
    let name = |p: usize| parameters[p].name.clone();
    assessment.indistinct.extend(unseen.into_iter().map(|p| Indistinct {
        names: vec![name(p)],
        correlation: None,
    }));
    if seen.is_empty() || rows.iter().flatten().any(|derivative| !derivative.is_finite()) {
        return Ok(assessment);
    }
    let unit_columns = DMatrix::from_fn(rows.len(), seen.len(), |r, k| rows[r][seen[k]] / lengths[seen[k]]);
    let svd = SVD::new(unit_columns, false, true);
    let Some(directions) = svd.v_t else {
        return Ok(assessment);
    };
    let largest = svd.singular_values.max();
    let mut undetermined = vec![false; count];
    for (direction, &singular) in directions.row_iter().zip(svd.singular_values.iter()) {
        if singular <= SINGULAR * largest {
            let part: Vec<usize> = (0..seen.len()).filter(|&k| direction[k].abs() > TAKES_PART).collect();
            part.iter().for_each(|&k| undetermined[seen[k]] = true);
            assessment.indistinct.push(Indistinct {
                names: part.into_iter().map(|k| name(seen[k])).collect(),
                correlation: None,
            });
            continue;
        }
        for (i, &p) in seen.iter().enumerate() {
            for (j, &q) in seen.iter().enumerate() {
                let share = direction[i] * direction[j] / (singular * singular * lengths[p] * lengths[q]);
                assessment.covariance[(p, q)] += share;
            }
        }
    }
    for &p in seen.iter().filter(|&&p| !undetermined[p]) {
        assessment.se[p] = Some(assessment.covariance[(p, p)].sqrt());
    }
    for p in 0..count {
        for q in 0..count {
            let (Some(se_p), Some(se_q)) = (assessment.se[p], assessment.se[q]) else {
                continue;
            };
            let correlation = assessment.covariance[(p, q)] / (se_p * se_q);
            assessment.correlation[(p, q)] = correlation;
            if p < q && correlation.abs() > CORRELATED {
                assessment.indistinct.push(Indistinct {
                    names: vec![name(p), name(q)],
                    correlation: Some(correlation),
                });
            }
        }
    }
    Ok(assessment)
}

/// A value within rounding of a bound lies on it.
fn bound_of(parameter: &FreeParameter, value: f64) -> Option<Bound> {
    const ROUNDING: f64 = 1e-9;
    let [low, high] = parameter.scaled_bounds();
    let range = if (high - low).is_finite() { high - low } else { 1.0 };
    let at = parameter.scaled(value);
    match (at - low, high - at) {
        (below, _) if below <= ROUNDING * range => Some(Bound::Lower),
        (_, above) if above <= ROUNDING * range => Some(Bound::Upper),
        _ => None,
    }
}

/// Differences on the parameters' scales: central ones, and towards the inside next to a bound.
fn derivatives(
    parameters: &[FreeParameter],
    model: &dyn Residuals,
    values: &[f64],
    step: f64,
) -> Result<Array2<f64>, FitError> {
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for (place, parameter) in parameters.iter().enumerate() {
        let [low, high] = parameter.scaled_bounds();
        let at = parameter.scaled(values[place]);
        let step = match high - low {
            range if range.is_finite() => step * range,
            _ if at == 0.0 => step,
            _ => step * at.abs(),
        };
        let ends = [(at - step).max(low), (at + step).min(high)];
        let mut sides = Vec::new();
        for end in ends {
            let mut moved = values.to_vec();
            moved[place] = parameter.value(end);
            sides.push(model.residuals(&moved)?);
        }
        let by_value = parameter.value_by_scaled(values[place]) * (ends[1] - ends[0]);
        columns.push(
            sides[0]
                .iter()
                .zip(&sides[1])
                .map(|(below, above)| (above - below) / by_value)
                .collect(),
        );
    }
    let rows = match columns.first() {
        Some(column) => column.len(),
        None => 0,
    };
    if let Some(column) = columns.iter().find(|column| column.len() != rows) {
        return Err(FitError::Length {
            expected: rows,
            found: column.len(),
        });
    }
    Ok(Array2::from_shape_fn((rows, columns.len()), |(r, p)| columns[p][r]))
}
