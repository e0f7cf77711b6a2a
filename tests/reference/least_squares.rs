//! Least squares against certified values: Statistical Reference Datasets of the U.S. National Institute of Standards
//! and Technology, nonlinear regression (public domain). Certified are parameters, their standard deviations and the
//! residual sum of squares, to 11 digits.

use specval::fit::{FitError, FreeParameter, Scale, Settings, Solution, minimise};

struct Certified<'a> {
    model: fn(&[f64], f64) -> f64,
    /// Pairs x, y.
    data: &'a [[f64; 2]],
    starts: [&'a [f64]; 2],
    values: &'a [f64],
    deviations: &'a [f64],
    sum_of_squares: f64,
}

impl Certified<'_> {
    fn fit(&self, start: &[f64]) -> Solution {
        let parameters: Vec<FreeParameter> = (1..=start.len())
            .map(|k| FreeParameter {
                name: format!("b{k}"),
                unit: String::new(),
                bounds: [f64::NEG_INFINITY, f64::INFINITY],
                scale: Scale::Linear,
                prior: None,
            })
            .collect();
        let residuals = |b: &[f64]| -> Result<Vec<f64>, FitError> {
            Ok(self.data.iter().map(|&[x, y]| (self.model)(b, x) - y).collect())
        };
        let settings = Settings {
            start: Some(start.to_vec()),
            tolerance: 1e-14,
            ..Settings::default()
        };
        minimise(&parameters, &residuals, &settings).unwrap()
    }

    /// Largest relative disagreement of parameters, of standard deviations, and of the sum of squares.
    fn disagreement(&self) -> [f64; 3] {
        let mut worst = [0.0f64; 3];
        for start in self.starts {
            let solution = self.fit(start);
            assert!(solution.converged);
            // The data have no uncertainty of their own: it is that of the residuals.
            let scale = solution.reduced_chi2().sqrt();
            let off = |found: f64, certified: f64| (found / certified - 1.0).abs();
            for (k, &certified) in self.values.iter().enumerate() {
                worst[0] = worst[0].max(off(solution.parameters[k], certified));
                let deviation = scale * solution.assessment.se[k].unwrap();
                worst[1] = worst[1].max(off(deviation, self.deviations[k]));
            }
            worst[2] = worst[2].max(off(solution.chi2, self.sum_of_squares));
        }
        worst
    }
}

#[test]
fn misra1a_has_its_certified_parameters() {
    let worst = Certified {
        model: |b, x| b[0] * (1.0 - (-b[1] * x).exp()),
        data: &[
            [77.6, 10.07],
            [114.9, 14.73],
            [141.1, 17.94],
            [190.8, 23.93],
            [239.9, 29.61],
            [289.0, 35.18],
            [332.8, 40.02],
            [378.4, 44.82],
            [434.8, 50.76],
            [477.3, 55.05],
            [536.8, 61.01],
            [593.1, 66.40],
            [689.1, 75.47],
            [760.0, 81.78],
        ],
        starts: [&[500.0, 0.0001], &[250.0, 0.0005]],
        values: &[2.3894212918e2, 5.5015643181e-4],
        deviations: &[2.7070075241, 7.2668688436e-6],
        sum_of_squares: 1.2455138894e-1,
    }
    .disagreement();
    // Found: 1.0e-11, 1.3e-10, 3.5e-11; certified are 11 digits.
    assert!(worst[0] < 5e-11 && worst[1] < 5e-10 && worst[2] < 1e-10, "{worst:?}");
}

#[test]
fn thurber_has_its_certified_parameters() {
    let worst = Certified {
        model: |b, x| (b[0] + x * (b[1] + x * (b[2] + x * b[3]))) / (1.0 + x * (b[4] + x * (b[5] + x * b[6]))),
        data: &[
            [-3.067, 80.574],
            [-2.981, 84.248],
            [-2.921, 87.264],
            [-2.912, 87.195],
            [-2.840, 89.076],
            [-2.797, 89.608],
            [-2.702, 89.868],
            [-2.699, 90.101],
            [-2.633, 92.405],
            [-2.481, 95.854],
            [-2.363, 100.696],
            [-2.322, 101.060],
            [-1.501, 401.672],
            [-1.460, 390.724],
            [-1.274, 567.534],
            [-1.212, 635.316],
            [-1.100, 733.054],
            [-1.046, 759.087],
            [-0.915, 894.206],
            [-0.714, 990.785],
            [-0.566, 1090.109],
            [-0.545, 1080.914],
            [-0.400, 1122.643],
            [-0.309, 1178.351],
            [-0.109, 1260.531],
            [-0.103, 1273.514],
            [0.010, 1288.339],
            [0.119, 1327.543],
            [0.377, 1353.863],
            [0.790, 1414.509],
            [0.963, 1425.208],
            [1.006, 1421.384],
            [1.115, 1442.962],
            [1.572, 1464.350],
            [1.841, 1468.705],
            [2.047, 1447.894],
            [2.200, 1457.628],
        ],
        starts: [
            &[1000.0, 1000.0, 400.0, 40.0, 0.7, 0.3, 0.03],
            &[1300.0, 1500.0, 500.0, 75.0, 1.0, 0.4, 0.05],
        ],
        values: &[
            1.2881396800e3,
            1.4910792535e3,
            5.8323836877e2,
            7.5416644291e1,
            9.6629502864e-1,
            3.9797285797e-1,
            4.9727297349e-2,
        ],
        deviations: &[
            4.6647963344,
            3.9571156086e1,
            2.8698696102e1,
            5.5675370270,
            3.1333340687e-2,
            1.4984928198e-2,
            6.5842344623e-3,
        ],
        sum_of_squares: 5.6427082397e3,
    }
    .disagreement();
    // Found: 2.7e-8, 1.2e-7, 5.9e-12.
    assert!(worst[0] < 1e-7 && worst[1] < 5e-7 && worst[2] < 5e-11, "{worst:?}");
}
