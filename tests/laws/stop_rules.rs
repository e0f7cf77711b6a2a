//! Stop rules: their notation, and their effect on batches.

use specval::run::{Precision, StopRule, StoppedBy, Tolerance, Watched};
use std::time::Duration;

#[test]
fn precisions_are_parsed_in_every_accepted_notation() {
    for (text, tolerance, of) in [
        ("rel 1%", Tolerance::Relative(0.01), Watched::Curves),
        ("rel 0.5 %", Tolerance::Relative(0.005), Watched::Curves),
        ("  rel  0.02  curves ", Tolerance::Relative(0.02), Watched::Curves),
        ("rel 2e-3 ratios", Tolerance::Relative(0.002), Watched::Ratios),
        ("abs 0.001", Tolerance::Absolute(0.001), Watched::Curves),
        ("abs 1e-4 ratios", Tolerance::Absolute(1e-4), Watched::Ratios),
    ] {
        let precision: Precision = text.parse().unwrap();
        assert_eq!(precision, Precision { tolerance, of }, "{text}");
        // The printed form can be parsed again.
        assert_eq!(precision.to_string().parse(), Ok(precision), "{precision}");
    }
}

#[test]
fn invalid_precision_is_reported_with_an_example() {
    for (text, found) in [
        ("", "\"\""),
        ("curves", "\"curves\""),
        ("1%", "\"1%\""),
        ("relative 1%", "\"relative\""),
        ("rel", "\"\""),
        ("rel %", "\"%\""),
        ("rel one", "\"one\""),
        ("rel 0%", "\"0%\""),
        ("rel -1%", "\"-1%\""),
        ("rel nan", "\"nan\""),
        ("abs inf", "\"inf\""),
        ("abs 1%", "%"),
        ("rel 1% graphs", "graphs"),
        ("rel 1% curves ratios", "curves"),
    ] {
        let message = text.parse::<Precision>().unwrap_err().to_string();
        for part in ["`rel`", "`abs`", "> 0", "rel 1%", found] {
            assert!(message.contains(part), "{text}: {part} is missing in {message}");
        }
    }
}

#[test]
fn study_paths_or_precision_ends_a_run() {
    let precision = "rel 1%".parse().ok();
    for (precision, paths_are_a_limit, batches) in [
        (None, false, 16),
        (None, true, 16),
        (precision, true, 16),
        (precision, false, StopRule::MOST),
    ] {
        let rule = StopRule::new(precision, None, 16, paths_are_a_limit);
        assert_eq!(rule.batches, batches);
        // Beyond the precision by so little that a batch more might do.
        let short = 0.01 * (1.0 + 1e-9);
        assert_eq!(rule.reached(batches - 1, || Some(short)), None);
        assert_eq!(rule.reached(batches, || Some(short)), Some(StoppedBy::Paths));
        // Without any light the precision no longer delays the end.
        let nothing = match batches {
            StopRule::MOST => StoppedBy::NothingHit,
            _ => StoppedBy::Paths,
        };
        assert_eq!(rule.reached(batches, || None), Some(nothing));
    }
    let rule = StopRule::new(precision, None, 16, false);
    assert_eq!(rule.reached(8, || Some(0.01)), Some(StoppedBy::Precision));
    assert_eq!(rule.reached(7, || Some(0.0)), None);
    for unknown in [f64::NAN, f64::INFINITY] {
        assert_eq!(rule.reached(63, || Some(unknown)), None);
        assert_eq!(rule.reached(100, || Some(unknown)), Some(StoppedBy::OutOfReach));
    }
}

/// 1 % at 64 batches from an error of 39 % takes 97 344 of the 100 000 batches, from 40 % 102 400.
#[test]
fn unreachable_precision_ends_an_otherwise_unlimited_run() {
    let precision = "rel 1%".parse().ok();
    let open = StopRule::new(precision, None, 16, false);
    assert_eq!(open.reached(64, || Some(0.39)), None);
    assert_eq!(open.reached(63, || Some(0.40)), None);
    assert_eq!(open.reached(64, || Some(0.40)), Some(StoppedBy::OutOfReach));
    let timed = StopRule::new(precision, Some(Duration::from_secs(60)), 16, false);
    let limited = StopRule::new(precision, None, 1000, true);
    for rule in [timed, limited] {
        assert_eq!(rule.reached(64, || Some(0.40)), None);
    }
}

#[test]
fn errors_are_measured_by_the_tolerance() {
    let relative = Tolerance::Relative(0.01);
    assert_eq!(relative.error(-0.5, 0.01), 0.02);
    assert_eq!(relative.error(0.0, 0.0), f64::INFINITY);
    assert_eq!(relative.error(0.0, 0.01), f64::INFINITY);
    assert_eq!(Tolerance::Absolute(0.1).error(-0.5, 0.01), 0.01);
    assert_eq!(Tolerance::Absolute(0.1).error(0.0, 0.0), f64::INFINITY);
}

#[test]
fn run_ends_when_the_time_limit_is_reached() {
    let rule = StopRule::new(None, Some(Duration::from_secs(60)), 16, false);
    let seconds = Duration::from_secs;
    assert!(!rule.is_out_of_time(2, Duration::from_millis(59_999)));
    assert!(rule.is_out_of_time(2, seconds(60)));
    assert!(!rule.is_out_of_time(1, seconds(1000)));
    assert!(!StopRule::new(None, None, 16, false).is_out_of_time(16, seconds(1 << 40)));
}
