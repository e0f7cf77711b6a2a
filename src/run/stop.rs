use std::fmt;
use std::str::FromStr;
use std::time::Duration;

/// When to make no further batch.
#[derive(Clone, Debug, PartialEq)]
pub struct StopRule {
    /// Stop as soon as every watched quantity is known this well.
    pub precision: Option<Precision>,
    /// Stop when this much time is over.
    pub max_time: Option<Duration>,
    /// Stop at this many batches.
    pub batches: usize,
}

/// Which part of the rule ended a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoppedBy {
    /// Every batch, hence every path, that was allowed.
    Paths,
    Precision,
    Time,
    /// All that the precision is of is 0 in every batch.
    NothingHit,
    /// By the errors so far the precision would take more batches than [`StopRule::MOST`].
    OutOfReach,
}

impl StoppedBy {
    /// As reports and artefacts say it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Paths => "paths",
            Self::Precision => "precision",
            Self::Time => "time",
            Self::NothingHit => "nothing hit",
            Self::OutOfReach => "precision out of reach",
        }
    }
}

impl StopRule {
    /// Batches made in any case: one has no standard error.
    pub const LEAST: usize = 2;
    /// Batches before precision is asked: the standard error of fewer is itself too uncertain (25 % of it with 8).
    pub const LEAST_FOR_PRECISION: usize = 8;
    /// Batches after which what is 0 in each of them is no longer waited for, nor a precision that is out of reach.
    pub const LEAST_FOR_NOTHING: usize = 64;
    /// Batches of a run that waits for its precision.
    pub const MOST: usize = 100_000;

    /// The study's batches or the time, whichever comes first. With a precision batches go on beyond the study's
    /// number, unless `paths_are_a_limit`: then they end there.
    pub fn new(
        precision: Option<Precision>,
        max_time: Option<Duration>,
        study_batches: usize,
        paths_are_a_limit: bool,
    ) -> Self {
        let open_end = precision.is_some() && !paths_are_a_limit;
        Self {
            precision,
            max_time,
            batches: if open_end { Self::MOST } else { study_batches },
        }
    }

    /// Whether the run ends with this many batches; `error` is the largest error of what is watched, and is asked
    /// for only where it decides. Depends on nothing but the batches, unlike [`Self::is_out_of_time`].
    pub fn reached(&self, batches: usize, error: impl FnOnce() -> Option<f64>) -> Option<StoppedBy> {
        let by_precision = self
            .precision
            .filter(|_| batches >= Self::LEAST_FOR_PRECISION)
            .and_then(|precision| match error() {
                Some(error) if error <= precision.tolerance.size() => Some(StoppedBy::Precision),
                Some(error) => self
                    .is_out_of_reach(batches, error / precision.tolerance.size())
                    .then_some(StoppedBy::OutOfReach),
                None => (batches >= Self::LEAST_FOR_NOTHING).then_some(StoppedBy::NothingHit),
            });
        if by_precision.is_some() {
            by_precision
        } else if batches >= self.batches {
            Some(StoppedBy::Paths)
        } else {
            None
        }
    }

    /// Whether nothing but the precision would end the run, and that not within [`Self::MOST`] batches: errors fall
    /// with the root of their number. `times` is the error over the tolerance; one that is not known after so many
    /// batches never is.
    fn is_out_of_reach(&self, batches: usize, times: f64) -> bool {
        let needed = batches as f64 * times * times;
        let open_end = self.batches >= Self::MOST && batches < self.batches && self.max_time.is_none();
        open_end && batches >= Self::LEAST_FOR_NOTHING && (needed.is_nan() || needed > Self::MOST as f64)
    }

    /// Whether time is over; never before the least number of batches.
    pub fn is_out_of_time(&self, batches: usize, elapsed: Duration) -> bool {
        batches >= Self::LEAST && self.max_time.is_some_and(|limit| elapsed >= limit)
    }
}

/// How well to know what.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Precision {
    pub tolerance: Tolerance,
    pub of: Watched,
}

/// Largest standard error allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// Over the value, 0.01 for 1 %.
    Relative(f64),
    /// In the unit of the value; brightness factors and ratios have none.
    Absolute(f64),
}

impl Tolerance {
    pub fn size(&self) -> f64 {
        match *self {
            Self::Relative(size) | Self::Absolute(size) => size,
        }
    }

    pub fn word(&self) -> &'static str {
        match self {
            Self::Relative(_) => "rel",
            Self::Absolute(_) => "abs",
        }
    }

    /// A standard error as the tolerance counts it. Of 0 ± 0 nothing is known: no path that would tell was among those
    /// traced.
    pub fn error(&self, value: f64, se: f64) -> f64 {
        match self {
            _ if value == 0.0 && se == 0.0 => f64::INFINITY,
            Self::Relative(_) => se / value.abs(),
            Self::Absolute(_) => se,
        }
    }

    /// The largest standard error of values and their standard errors after so many batches, as the tolerance counts
    /// it. What is 0 ± 0 after [`StopRule::LEAST_FOR_NOTHING`] of them is left out; `None` where that is all.
    pub fn largest_error(&self, batches: usize, estimates: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
        let hit = |(value, se): &(f64, f64)| batches < StopRule::LEAST_FOR_NOTHING || *value != 0.0 || *se != 0.0;
        // In this order NaN is the largest, and no precision is ever reached with one.
        estimates
            .filter(hit)
            .map(|(value, se)| self.error(value, se))
            .max_by(f64::total_cmp)
    }
}

/// The quantities of which each must be precise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Watched {
    /// Luminance factor of every point of the model's curves, gloss included.
    Curves,
    /// BLUE/RED and GREEN/RED of the model in Table 1.
    Ratios,
    /// Scattered fraction of the ledger at every wavelength and incident direction.
    Scattered,
}

impl Watched {
    pub fn word(self) -> &'static str {
        match self {
            Self::Curves => "curves",
            Self::Ratios => "ratios",
            Self::Scattered => "scattered",
        }
    }
}

/// A precision that cannot be understood.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "expected `rel` or `abs`, a number > 0 and, if you like, {allowed}, such as \"rel 1%\" or \"abs 0.001 {example}\"; \
     found {found}"
)]
pub struct PrecisionError {
    /// Quantities that may be named.
    allowed: String,
    example: &'static str,
    found: String,
}

impl FromStr for Precision {
    type Err = PrecisionError;

    /// Of the curves, unless the ratios are named.
    fn from_str(text: &str) -> Result<Self, PrecisionError> {
        Self::parse(text, Watched::Curves, &[Watched::Ratios])
    }
}

impl Precision {
    /// Of one quantity, unless one of the others is named.
    pub fn parse(text: &str, default: Watched, others: &[Watched]) -> Result<Self, PrecisionError> {
        let quantities: Vec<Watched> = [default].into_iter().chain(others.iter().copied()).collect();
        let wrong = |found: String| PrecisionError {
            allowed: quantities
                .iter()
                .map(|of| format!("`{}`", of.word()))
                .collect::<Vec<_>>()
                .join(" or "),
            example: quantities[quantities.len() - 1].word(),
            found,
        };
        let mut words: Vec<&str> = text.split_whitespace().collect();
        let of = words
            .last()
            .and_then(|last| quantities.iter().copied().find(|of| of.word() == *last));
        if of.is_some() {
            words.pop();
        }
        let Some((&kind, number)) = words.split_first() else {
            return Err(wrong(format!("\"{text}\"")));
        };
        // "1 %" is how many write it.
        let number = number.concat();
        let size = |digits: &str| {
            let size = digits.parse::<f64>().ok();
            size.filter(|size| size.is_finite() && *size > 0.0)
                .ok_or_else(|| wrong(format!("\"{number}\" for the number in \"{text}\"")))
        };
        let tolerance = match (kind, number.strip_suffix('%')) {
            ("rel", Some(percent)) => Tolerance::Relative(size(percent)? / 100.0),
            ("rel", None) => Tolerance::Relative(size(&number)?),
            ("abs", Some(_)) => return Err(wrong(format!("a share, %, for an absolute error in \"{text}\""))),
            ("abs", None) => Tolerance::Absolute(size(&number)?),
            _ => return Err(wrong(format!("\"{kind}\" in \"{text}\""))),
        };
        Ok(Self {
            tolerance,
            of: of.unwrap_or(default),
        })
    }
}

/// In the words it is read from.
impl fmt::Display for Precision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} {} {}",
            self.tolerance.word(),
            self.tolerance.size(),
            self.of.word()
        )
    }
}
