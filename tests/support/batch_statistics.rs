//! A joint test of many means that know nothing of each other's correlation.

use std::fmt;

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Random signs tried: p is known in steps of 1/2000.
const TRIALS: usize = 1999;

/// Whether the means of many values are all 0, judged from independent batches of them.
pub struct Joint {
    /// Values that are not exactly 0 in every batch.
    pub values: usize,
    /// Mean of t² over the values; near 1 if all their means are 0.
    pub mean_square: f64,
    /// Greatest |t|.
    pub worst: f64,
    /// Probability of a sum of t² at least this large if all means are 0.
    pub p_sum: f64,
    /// The same of the greatest |t|.
    pub p_worst: f64,
}

impl Joint {
    /// Both the sum and the greatest must be likelier than `false_alarms`/2: together they raise one alarm in
    /// 1/`false_alarms` new seeds.
    pub fn holds(&self, false_alarms: f64) -> bool {
        self.p_sum > 0.5 * false_alarms && self.p_worst > 0.5 * false_alarms
    }
}

impl fmt::Display for Joint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            values,
            mean_square,
            worst,
            p_sum,
            p_worst,
        } = self;
        write!(
            f,
            "{values} values, mean t² {mean_square:.3} (p {p_sum}), greatest |t| {worst:.2} (p {p_worst})"
        )
    }
}

/// χ² = Σ t² over the values, and the greatest |t|, against what they become when each batch as a whole is given a
/// random sign (Fisher's randomisation test). A batch of means 0 is as likely as its opposite, exactly so for the
/// difference of two runs alike and near enough for means over many paths; and as all values of a batch turn together,
/// their correlation, be it between wavelengths that share paths or between cells that share light, is the same in
/// every trial. So is Student's excess over the normal distribution. `batches` is \[batch\]\[value\].
pub fn all_zero(batches: &[Vec<f64>]) -> Joint {
    let values = batches[0].len();
    let squares: Vec<f64> = (0..values).map(|i| batches.iter().map(|b| b[i] * b[i]).sum()).collect();
    let kept: Vec<usize> = (0..values).filter(|&i| squares[i] > 0.0).collect();
    let batches: Vec<Vec<f64>> = batches.iter().map(|b| kept.iter().map(|&i| b[i]).collect()).collect();
    let squares: Vec<f64> = kept.iter().map(|&i| squares[i]).collect();
    let n = batches.len() as f64;
    let mut sum = vec![0.0; kept.len()];
    let mut statistics = |mut sign: Box<dyn FnMut() -> f64>| -> [f64; 2] {
        sum.fill(0.0);
        for batch in &batches {
            let sign = sign();
            sum.iter_mut().zip(batch).for_each(|(s, x)| *s += sign * x);
        }
        sum.iter()
            .zip(&squares)
            .fold([0.0f64; 2], |[total, worst], (s, square)| {
                let between = s * s / n;
                let t2 = (n - 1.0) * between / (square - between).max(f64::MIN_POSITIVE);
                [total + t2, worst.max(t2)]
            })
    };
    let [total, worst] = statistics(Box::new(|| 1.0));
    let mut exceeded = [1.0; 2];
    for trial in 0..TRIALS {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(trial as u64);
        let [a, b] = statistics(Box::new(move || if rng.random::<bool>() { 1.0 } else { -1.0 }));
        exceeded[0] += f64::from(u8::from(a >= total));
        exceeded[1] += f64::from(u8::from(b >= worst));
    }
    let [p_sum, p_worst] = exceeded.map(|count| count / (TRIALS + 1) as f64);
    Joint {
        values: kept.len(),
        mean_square: total / kept.len() as f64,
        worst: worst.sqrt(),
        p_sum,
        p_worst,
    }
}
