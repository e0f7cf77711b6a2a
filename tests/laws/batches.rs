//! The driver that collects batches, tested with batches that are plain numbers.

use specval::run::{Gather, Outcome, Precision, Schedule, StopRule, StoppedBy, Tolerance, Watched, gather};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Batch b is the number b, the error is 1 over the number of batches; each batch takes a second of the clock.
struct Numbers<'a> {
    accepted: Vec<usize>,
    made: Mutex<Vec<usize>>,
    saved: Mutex<Vec<usize>>,
    clock_s: &'a AtomicU64,
    saving_takes_s: u64,
    broken: Option<usize>,
}

impl Gather for Numbers<'_> {
    type Batch = usize;
    type Error = String;

    fn batches(&self) -> usize {
        self.accepted.len()
    }

    fn make(&self, batch: usize) -> Result<usize, String> {
        self.clock_s.fetch_add(1, Ordering::Relaxed);
        self.made.lock().unwrap().push(batch);
        if self.broken == Some(batch) {
            return Err(format!("batch {batch}"));
        }
        Ok(batch)
    }

    fn accept(&mut self, batch: usize) {
        self.accepted.push(batch);
    }

    fn largest_error(&self) -> Option<f64> {
        Some(1.0 / self.accepted.len() as f64)
    }

    fn save(&self) -> Result<(), String> {
        self.clock_s.fetch_add(self.saving_takes_s, Ordering::Relaxed);
        self.saved.lock().unwrap().push(self.accepted.len());
        Ok(())
    }
}

fn numbers(first: usize, clock_s: &AtomicU64) -> Numbers<'_> {
    Numbers {
        accepted: (0..first).collect(),
        made: Mutex::default(),
        saved: Mutex::default(),
        clock_s,
        saving_takes_s: 0,
        broken: None,
    }
}

fn run(numbers: &mut Numbers, rule: &StopRule, round: usize, checkpoint_s: Option<u64>) -> Result<Outcome, String> {
    let clock_s = numbers.clock_s;
    let told = Mutex::new(0.0);
    let outcome = gather(
        numbers,
        &Schedule {
            rule,
            round,
            checkpoint: checkpoint_s.map(Duration::from_secs),
            clock: &|| Duration::from_secs(clock_s.load(Ordering::Relaxed)),
            progress: &|share| *told.lock().unwrap() += share,
        },
    );
    assert!(*told.lock().unwrap() < 1.0 + 1e-9);
    outcome
}

fn rule(error: Option<f64>, max_time_s: Option<u64>, batches: usize) -> StopRule {
    let precision = error.map(|size| Precision {
        tolerance: Tolerance::Absolute(size),
        of: Watched::Curves,
    });
    StopRule::new(precision, max_time_s.map(Duration::from_secs), batches, true)
}

#[test]
fn batches_arrive_in_order_and_their_number_follows_the_rule() {
    for (error, stopped_by, batches) in [
        (None, StoppedBy::Paths, 22),
        (Some(0.01), StoppedBy::Paths, 22),
        (Some(0.1), StoppedBy::Precision, 10),
        // Never before 8.
        (Some(0.9), StoppedBy::Precision, 8),
    ] {
        for round in [1, 4, 7] {
            for first in [0, 3, 8] {
                let clock_s = AtomicU64::new(0);
                let mut numbers = numbers(first, &clock_s);
                let outcome = run(&mut numbers, &rule(error, None, 22), round, None).unwrap();
                let expected = Outcome {
                    batches,
                    stopped_by,
                    reached: Some(1.0 / batches as f64),
                };
                assert_eq!(outcome, expected, "{error:?}, round {round}, from {first}");
                assert_eq!(numbers.accepted, (0..batches).collect::<Vec<_>>());
                // Surplus batches of a round are discarded, and no batch is computed twice.
                let mut made = numbers.made.into_inner().unwrap();
                made.sort_unstable();
                let last = made.last().map_or(first, |last| last + 1);
                assert_eq!(made, (first..last).collect::<Vec<_>>());
                assert!(last < batches + round, "{last}");
            }
        }
    }
}

#[test]
fn time_limit_ends_a_run_after_at_least_two_batches() {
    for (max_time_s, round, batches) in [(0, 4, 2), (1, 1, 2), (5, 1, 5), (100, 4, 22)] {
        let clock_s = AtomicU64::new(0);
        let mut numbers = numbers(0, &clock_s);
        let outcome = run(&mut numbers, &rule(None, Some(max_time_s), 22), round, None).unwrap();
        let stopped_by = if batches < 22 {
            StoppedBy::Time
        } else {
            StoppedBy::Paths
        };
        assert_eq!((outcome.batches, outcome.stopped_by), (batches, stopped_by));
        assert_eq!(numbers.accepted, (0..batches).collect::<Vec<_>>());
    }
    // Batches of the resumed run are never discarded.
    let clock_s = AtomicU64::new(9);
    let mut numbers = numbers(13, &clock_s);
    let outcome = run(&mut numbers, &rule(None, Some(9), 22), 4, None).unwrap();
    assert_eq!((outcome.batches, outcome.stopped_by), (13, StoppedBy::Time));
}

#[test]
fn saves_are_spaced_in_proportion_to_their_cost() {
    for (checkpoint_s, saving_takes_s, expected) in [
        (None, 0, vec![]),
        (Some(0), 0, vec![4, 8, 12, 16, 20, 22]),
        (Some(0), 99, vec![4, 8, 12, 16, 20, 22]),
        (Some(8), 0, vec![8, 16]),
        (Some(100), 0, vec![]),
        // After a save that takes one second, no save occurs for the next 20 s.
        (Some(1), 1, vec![4]),
    ] {
        let clock_s = AtomicU64::new(0);
        let mut numbers = numbers(0, &clock_s);
        numbers.saving_takes_s = saving_takes_s;
        run(&mut numbers, &rule(None, None, 22), 4, checkpoint_s).unwrap();
        assert_eq!(numbers.saved.into_inner().unwrap(), expected, "{checkpoint_s:?}");
    }
}

#[test]
fn failed_batch_ends_the_run_with_its_error() {
    let clock_s = AtomicU64::new(0);
    let mut numbers = numbers(0, &clock_s);
    numbers.broken = Some(5);
    assert_eq!(run(&mut numbers, &rule(None, None, 22), 4, None), Err("batch 5".into()));
    assert_eq!(numbers.accepted, [0, 1, 2, 3, 4]);
}
