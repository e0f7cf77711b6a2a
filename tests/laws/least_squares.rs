//! Laws of the bounded least squares: bounds, priors, starts, and what the data cannot tell.

use ndarray::{Array2, array};
use specval::fit::{Bound, FitError, FreeParameter, Prior, Residuals, Scale, Settings, minimise};
use std::cell::Cell;
use std::ops::ControlFlow;

type Values = Result<Vec<f64>, FitError>;

fn parameter(name: &str, bounds: [f64; 2]) -> FreeParameter {
    FreeParameter {
        name: name.into(),
        unit: String::new(),
        bounds,
        scale: Scale::Linear,
        prior: None,
    }
}

/// H. H. Rosenbrock's valley, Comput. J. 3 (1960) 175, as two residuals.
fn rosenbrock(p: &[f64]) -> Values {
    Ok(vec![10.0 * (p[1] - p[0] * p[0]), 1.0 - p[0]])
}

#[test]
fn valley_is_followed_to_its_minimum_or_to_a_bound() {
    let settings = Settings {
        start: Some(vec![-1.2, 1.0]),
        ..Settings::default()
    };
    let wide = [parameter("x", [-5.0, 5.0]), parameter("y", [-5.0, 5.0])];
    let solution = minimise(&wide, &rosenbrock, &settings).unwrap();
    assert!(solution.converged && solution.chi2 < 1e-18, "{solution:?}");
    assert!(solution.parameters.iter().all(|p| (p - 1.0).abs() < 1e-8));
    assert_eq!(solution.assessment.at_bound, [None, None]);

    // With x at most 0.5 the minimum is on the bound, where y = x² and χ² = (1 − x)².
    let narrow = [parameter("x", [-5.0, 0.5]), parameter("y", [-5.0, 5.0])];
    let solution = minimise(&narrow, &rosenbrock, &settings).unwrap();
    assert_eq!(solution.parameters[0], 0.5);
    assert!((solution.parameters[1] - 0.25).abs() < 1e-7, "{solution:?}");
    assert!((solution.chi2 - 0.25).abs() < 1e-12);
    assert_eq!(solution.assessment.at_bound, [Some(Bound::Upper), None]);
    // On the bound x is fixed, and y alone has ∂r/∂y = 10.
    assert_eq!(solution.assessment.se[0], None);
    assert!((solution.assessment.se[1].unwrap() - 0.1).abs() < 1e-9);
}

#[test]
fn straight_line_has_the_covariance_of_the_textbook() {
    // y = a + b x at x = 0..4 with uncertainty 0.5: var b = σ²/Σ(x − x̄)² = 0.25/10, var a = σ² (1/5 + 4/10),
    // cov = −x̄ var b.
    let line = |p: &[f64]| -> Values {
        Ok((0..5)
            .map(|x| (p[0] + p[1] * f64::from(x) - (3.0 + 2.0 * f64::from(x))) / 0.5)
            .collect())
    };
    let parameters = [parameter("a", [-50.0, 50.0]), parameter("b", [-50.0, 50.0])];
    let found = minimise(&parameters, &line, &Settings::default()).unwrap();
    assert!((found.parameters[0] - 3.0).abs() < 1e-9 && (found.parameters[1] - 2.0).abs() < 1e-9);
    let expected = array![[0.15, -0.05], [-0.05, 0.025]];
    let off = (&found.assessment.covariance - &expected).mapv(f64::abs);
    assert!(off.iter().all(|off| *off < 1e-9), "{:?}", found.assessment.covariance);
    assert!((found.assessment.correlation[(0, 1)] + 0.05 / (0.15f64 * 0.025).sqrt()).abs() < 1e-8);
}

#[test]
fn prior_weighs_as_one_more_reading() {
    // One reading of 10 ± 1 and a prior of 4 ± 2: mean (10/1 + 4/4) / (1 + 1/4), variance 1 / (1 + 1/4).
    let reading = |p: &[f64]| -> Values { Ok(vec![p[0] - 10.0]) };
    let prior = Some(Prior { mean: 4.0, sd: 2.0 });
    let known = FreeParameter {
        prior,
        ..parameter("a", [0.0, 100.0])
    };
    let found = minimise(&[known], &reading, &Settings::default()).unwrap();
    assert!((found.parameters[0] - 8.8).abs() < 1e-7, "{found:?}");
    assert!((found.assessment.se[0].unwrap() - 0.8f64.sqrt()).abs() < 1e-7);
    assert_eq!(found.residuals.len(), 1);
    assert!((found.chi2 - (1.2f64.powi(2) + 2.4f64.powi(2))).abs() < 1e-9);
}

#[test]
fn parameters_that_the_data_cannot_tell_apart_are_named() {
    // Only the product of a and b counts, and d does nothing.
    let product = |p: &[f64]| -> Values {
        Ok((1..6)
            .map(|x| f64::from(x) * (p[0] * p[1] - 6.0) + p[2] - 1.0)
            .collect())
    };
    let parameters = ["a", "b", "c", "d"].map(|name| parameter(name, [0.5, 20.0]));
    let found = minimise(&parameters, &product, &Settings::default()).unwrap();
    assert!(found.chi2 < 1e-12);
    let names: Vec<_> = found
        .assessment
        .indistinct
        .iter()
        .map(|group| group.names.join(" "))
        .collect();
    assert_eq!(names, ["d", "a b"]);
    let se = &found.assessment.se;
    assert!(se[0].is_none() && se[1].is_none() && se[2].is_some() && se[3].is_none());

    // Two slopes that differ by little are correlated.
    let near = |p: &[f64]| -> Values {
        Ok((1..6)
            .map(|x| p[0] * f64::from(x) + p[1] * f64::from(x).powf(1.02) - 5.0)
            .collect())
    };
    let found = minimise(&parameters[..2], &near, &Settings::default()).unwrap();
    let pair = found
        .assessment
        .indistinct
        .iter()
        .find(|group| group.correlation.is_some());
    // One may rest on its bound, where it is fixed and no longer correlated.
    assert!(pair.is_some() || found.assessment.at_bound.iter().any(Option::is_some));
}

/// Two valleys, the deeper one far from the middle.
fn two_valleys(p: &[f64]) -> Values {
    let x = p[0];
    Ok(vec![(x * x - 9.0) * 0.3, 0.2 * (x + 3.2)])
}

#[test]
fn several_starts_find_the_lower_minimum_and_keep_their_bits() {
    let parameters = [parameter("x", [-8.0, 8.5])];
    let settings = |starts| Settings {
        starts,
        seed: 7,
        ..Settings::default()
    };
    let one = minimise(&parameters, &two_valleys, &settings(1)).unwrap();
    assert!(
        one.parameters[0] > 2.0,
        "the first start ends in the higher valley: {one:?}"
    );
    let several = minimise(&parameters, &two_valleys, &settings(6)).unwrap();
    assert!((several.parameters[0] + 3.0).abs() < 0.1, "{several:?}");
    assert_eq!(several.starts.len(), 6);
    assert_eq!(several, minimise(&parameters, &two_valleys, &settings(6)).unwrap());
}

/// The valley with its derivatives.
struct WithJacobian {
    evaluations: Cell<usize>,
}

impl Residuals for WithJacobian {
    fn residuals(&self, p: &[f64]) -> Values {
        self.evaluations.set(self.evaluations.get() + 1);
        rosenbrock(p)
    }

    fn jacobian(&self, p: &[f64]) -> Option<Array2<f64>> {
        Some(array![[-20.0 * p[0], 10.0], [-1.0, 0.0]])
    }
}

#[test]
fn given_derivatives_replace_differences() {
    let mut parameters = [parameter("x", [0.01, 5.0]), parameter("y", [-5.0, 5.0])];
    parameters[0].scale = Scale::Log;
    let prior = Some(Prior { mean: 1.5, sd: 0.2 });
    parameters[0].prior = prior;
    let settings = Settings {
        start: Some(vec![0.3, -2.0]),
        ..Settings::default()
    };
    let own = WithJacobian {
        evaluations: Cell::new(0),
    };
    let given = minimise(&parameters, &own, &settings).unwrap();
    let differences = minimise(&parameters, &rosenbrock, &settings).unwrap();
    assert!(given.converged && differences.converged);
    assert!(own.evaluations.get() < differences.evaluations);
    for (one, other) in given.parameters.iter().zip(&differences.parameters) {
        assert!((one - other).abs() < 1e-6, "{given:?} {differences:?}");
    }
    let off = (&given.assessment.covariance - &differences.assessment.covariance).mapv(f64::abs);
    assert!(off.iter().all(|off| *off < 1e-6));
}

#[test]
fn watcher_ends_the_search_with_the_best_so_far() {
    let seen = Cell::new(0);
    let watch = |progress: &specval::fit::Progress| {
        seen.set(progress.evaluations);
        assert!(progress.best_chi2 <= progress.chi2);
        if progress.evaluations < 12 {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        }
    };
    let settings = Settings {
        start: Some(vec![-1.2, 1.0]),
        watch: Some(&watch),
        starts: 3,
        ..Settings::default()
    };
    let wide = [parameter("x", [-5.0, 5.0]), parameter("y", [-5.0, 5.0])];
    let found = minimise(&wide, &rosenbrock, &settings).unwrap();
    assert_eq!((seen.get(), found.evaluations, found.starts.len()), (12, 12, 1));
    assert!(!found.converged && found.chi2 < 24.2);
}

#[test]
fn impossible_fits_are_refused() {
    let one = |p: &[f64]| -> Values { Ok(vec![p[0] + p[1]]) };
    let pair = [parameter("a", [0.0, 1.0]), parameter("b", [0.0, 1.0])];
    let refused = minimise(&pair, &one, &Settings::default()).unwrap_err().to_string();
    assert!(refused.contains("2 free parameters (a, b) and 1 readings"), "{refused}");
    let settings = Settings {
        start: Some(vec![0.5, 7.0]),
        ..Settings::default()
    };
    let refused = minimise(&pair, &rosenbrock, &settings).unwrap_err();
    assert!(matches!(refused, FitError::Start { found: 7.0, .. }), "{refused}");
    let open = [parameter("a", [0.0, f64::INFINITY]), parameter("b", [0.0, 1.0])];
    let refused = minimise(&open, &rosenbrock, &Settings::default()).unwrap_err();
    assert!(
        matches!(refused, FitError::Starts { expected: 2, found: 0 }),
        "{refused}"
    );
    let nowhere = |_: &[f64]| -> Values { Ok(vec![f64::NAN; 3]) };
    let refused = minimise(&pair, &nowhere, &Settings::default()).unwrap_err();
    assert!(matches!(refused, FitError::NotFinite { .. }), "{refused}");
    let broken = |p: &[f64]| -> Values {
        if p[0] > 0.4 {
            Err(FitError::Model("yarns overlap".into()))
        } else {
            rosenbrock(p)
        }
    };
    let settings = Settings {
        start: Some(vec![0.1, 0.5]),
        ..Settings::default()
    };
    let refused = minimise(&pair, &broken, &settings).unwrap_err();
    assert_eq!(refused.to_string(), "yarns overlap");
}
