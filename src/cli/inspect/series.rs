use serde::Serialize;

/// Numbers that ascend, each once.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Series(Vec<f64>);

impl Series {
    /// Of numbers in any order.
    pub fn new(mut numbers: Vec<f64>) -> Self {
        numbers.sort_by(f64::total_cmp);
        numbers.dedup();
        Self(numbers)
    }

    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// The step, where all are equal but for rounding; `None` of a single number.
    pub fn step(&self) -> Option<f64> {
        let step = self.0.get(1)? - self.0[0];
        let even = self
            .0
            .windows(2)
            .all(|pair| (pair[1] - pair[0] - step).abs() <= 1e-6 * step.abs());
        even.then_some((step * 1e6).round() / 1e6)
    }

    /// "0 to 80, step 10 (9)", or the numbers themselves where steps differ and they are few.
    pub fn words(&self) -> String {
        const LISTED: usize = 20;
        let n = self.0.len();
        match (self.step(), &self.0[..]) {
            (_, []) => "none".into(),
            (_, [one]) => format!("{one} (1)"),
            (Some(step), [first, .., last]) if n > 2 => format!("{first} to {last}, step {step} ({n})"),
            (_, all) if n <= LISTED => {
                let all: Vec<String> = all.iter().map(f64::to_string).collect();
                format!("{} ({n})", all.join(" "))
            }
            (_, [first, .., last]) => {
                let steps = self.0.windows(2).map(|pair| pair[1] - pair[0]);
                let (least, most) = steps.fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), s| (a.min(s), b.max(s)));
                format!("{first} to {last}, steps {least:.4} to {most:.4} ({n})")
            }
        }
    }
}
