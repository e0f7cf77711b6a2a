//! What every reader of goniometric files must survive: any bytes. What it takes, it must evaluate.

use specval::formats::{ReadOptions, direction, parse};

pub fn survive(name: &str, bytes: &[u8]) {
    let Ok(data) = parse(name, bytes, &ReadOptions::default()) else {
        return;
    };
    for (theta_i, theta_o, phi) in [(0.0, 0.0, 0.0), (0.3, 1.2, 2.0), (1.5, 3.0, 6.0)] {
        if let Some(evaluation) = data.eval(&direction(theta_i, 0.1), &direction(theta_o, phi)) {
            assert!(evaluation.values.iter().all(|v| v.is_finite()), "{evaluation:?}");
        }
    }
}
