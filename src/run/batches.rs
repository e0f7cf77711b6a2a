use super::{Progress, StopRule, StoppedBy};
use rayon::prelude::*;
use std::time::Duration;

/// Something that grows batch by batch.
///
/// A batch depends on its number alone, and batches come in their order: what is gathered depends on how many there are
/// and on nothing else, be it threads, rounds or interruptions.
pub trait Gather: Sync {
    type Batch: Send;
    type Error: Send;

    /// How many are in already; the next one has this number.
    fn batches(&self) -> usize;

    /// Makes batch number `batch`.
    fn make(&self, batch: usize) -> Result<Self::Batch, Self::Error>;

    /// Takes in the next one.
    fn accept(&mut self, batch: Self::Batch);

    /// Largest of the standard errors that the stop rule watches, in the rule's measure; `None` where nothing is
    /// watched.
    fn largest_error(&self) -> Option<f64>;

    /// Puts all that is gathered where a later run can go on from it.
    fn save(&self) -> Result<(), Self::Error>;
}

/// How batches are gathered.
#[derive(Clone, Copy)]
pub struct Schedule<'a> {
    pub rule: &'a StopRule,
    /// Batches under way at once, 1 or more; each takes its memory.
    pub round: usize,
    /// Least time between two savings, zero to save after each round; `None` to save nothing.
    pub checkpoint: Option<Duration>,
    /// Time since the run began. Decides about the time limit and about saving, and about nothing else.
    pub clock: &'a (dyn Fn() -> Duration + Sync),
    pub progress: Progress<'a>,
}

/// How a gathering ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    pub batches: usize,
    pub stopped_by: StoppedBy,
    /// Largest of the watched standard errors; see [`Gather::largest_error`].
    pub reached: Option<f64>,
}

/// Saving takes at most about one part of this many of the time.
const SAVING_SHARE: u32 = 20;

/// Makes batches in rounds until the rule says stop. Those of a round behind the batch that satisfied it are thrown
/// away.
pub fn gather<G: Gather>(gathered: &mut G, schedule: &Schedule) -> Result<Outcome, G::Error> {
    let Schedule {
        rule, clock, progress, ..
    } = *schedule;
    // With another end in sight a batch's share is not known before the round is judged.
    let step = match (rule.precision, rule.max_time) {
        (None, None) => 1.0 / rule.batches.max(1) as f64,
        _ => 0.0,
    };
    let mut told = 0.0;
    let mut saving = Saving::new(schedule, clock());
    loop {
        let first = gathered.batches();
        if let Some(stopped_by) = stop(gathered, rule, clock) {
            return Ok(Outcome {
                batches: first,
                stopped_by,
                reached: gathered.largest_error(),
            });
        }
        let shared = &*gathered;
        // The least that is made comes first, with nothing beside it, if time may end the run there.
        let round = match StopRule::LEAST.saturating_sub(first) {
            least if least > 0 && rule.max_time.is_some() => least.min(schedule.round),
            _ => schedule.round,
        };
        let made: Vec<Option<Result<G::Batch, G::Error>>> = (first..(first + round.max(1)).min(rule.batches))
            .into_par_iter()
            .map(|batch| {
                // Begins none after the time is over.
                let made = (!rule.is_out_of_time(batch, clock())).then(|| shared.make(batch));
                progress(step);
                made
            })
            .collect();
        told += step * made.len() as f64;
        for batch in made.into_iter().map_while(|made| made) {
            gathered.accept(batch?);
            if rule.reached(gathered.batches(), || gathered.largest_error()).is_some() {
                break;
            }
        }
        let share = done(gathered, rule, clock());
        progress((share - told).max(0.0));
        told = told.max(share);
        saving.after_round(gathered, clock)?;
    }
}

fn stop<G: Gather>(gathered: &G, rule: &StopRule, clock: &(dyn Fn() -> Duration + Sync)) -> Option<StoppedBy> {
    let batches = gathered.batches();
    rule.reached(batches, || gathered.largest_error())
        .or_else(|| rule.is_out_of_time(batches, clock()).then_some(StoppedBy::Time))
}

/// Share of the work that is behind, by whatever will end it first: errors fall with the root of the batches.
fn done<G: Gather>(gathered: &G, rule: &StopRule, elapsed: Duration) -> f64 {
    let by_precision = rule.precision.and_then(|precision| {
        let error = gathered.largest_error()?;
        Some((precision.tolerance.size() / error).powi(2))
    });
    let by_time = rule.max_time.map(|limit| elapsed.as_secs_f64() / limit.as_secs_f64());
    let by_paths = gathered.batches() as f64 / rule.batches.max(1) as f64;
    [by_precision, by_time]
        .into_iter()
        .flatten()
        .fold(by_paths, f64::max)
        .min(1.0)
}

/// When to save.
struct Saving {
    interval: Option<Duration>,
    last: Duration,
    /// What the last saving took.
    took: Duration,
}

impl Saving {
    fn new(schedule: &Schedule, now: Duration) -> Self {
        Self {
            interval: schedule.checkpoint,
            last: now,
            took: Duration::ZERO,
        }
    }

    fn after_round<G: Gather>(&mut self, gathered: &G, clock: &(dyn Fn() -> Duration + Sync)) -> Result<(), G::Error> {
        let Some(interval) = self.interval else {
            return Ok(());
        };
        let before = clock();
        // Asked for zero, every round counts, whatever it takes.
        if !interval.is_zero() && before.saturating_sub(self.last) < interval.max(self.took * SAVING_SHARE) {
            return Ok(());
        }
        gathered.save()?;
        self.last = clock();
        self.took = self.last.saturating_sub(before);
        Ok(())
    }
}
