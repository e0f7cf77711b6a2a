//! Whole numbers in the spellings that the command line accepts.

use std::num::{NonZeroU64, NonZeroUsize};
use std::ops::RangeInclusive;

/// Most threads: far more than any machine has cores, few enough for a system to start.
const MOST_THREADS: u64 = 1024;
/// Most paths, as for the keys of a study.
const MOST_PATHS: u64 = 1_000_000_000_000;

/// `1000000`, `1_000_000` or `1e6`.
fn whole(text: &str, range: RangeInclusive<u64>, remedy: &str) -> Result<u64, String> {
    let digits: String = text.trim().chars().filter(|c| *c != '_').collect();
    let number = digits.parse::<u64>().ok().or_else(|| {
        // Whole numbers beyond 2^53 are not all floats, so they are taken as digits only.
        let number = digits.parse::<f64>().ok()?;
        (number.fract() == 0.0 && (0.0..=9e15).contains(&number)).then_some(number as u64)
    });
    number.filter(|number| range.contains(number)).ok_or_else(|| {
        format!(
            "expected a whole number from {} to {}, found {text}; {remedy}",
            range.start(),
            range.end()
        )
    })
}

pub fn seed(text: &str) -> Result<u64, String> {
    whole(text, 0..=i64::MAX as u64, "any number in the range will do, such as 7")
}

pub fn paths(text: &str) -> Result<NonZeroU64, String> {
    let remedy = "write 200000, 200_000 or 2e5, or leave it out for the command's own number";
    let number = whole(text, 1..=MOST_PATHS, remedy)?;
    NonZeroU64::new(number).ok_or_else(|| remedy.to_owned())
}

pub fn threads(text: &str) -> Result<NonZeroUsize, String> {
    let remedy = "leave it out for one a core; more than that is no faster";
    let number = whole(text, 1..=MOST_THREADS, remedy)?;
    NonZeroUsize::new(number as usize).ok_or_else(|| remedy.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_are_read_as_people_write_them() {
        for (text, number) in [
            ("1e6", 1_000_000),
            ("1_000_000", 1_000_000),
            ("2.5e3", 2500),
            ("1000000000000", MOST_PATHS),
        ] {
            assert_eq!(paths(text).map(NonZeroU64::get), Ok(number), "{text}");
        }
        for text in ["0", "-1", "1.5", "1e13", "ten", "", "nan", "inf", "1e-3"] {
            let message = paths(text).unwrap_err();
            assert!(
                message.contains("from 1 to 1000000000000") && message.contains("2e5"),
                "{message}"
            );
        }
        assert_eq!(seed("0"), Ok(0));
        assert_eq!(seed("9223372036854775807"), Ok(i64::MAX as u64));
        assert!(seed("9223372036854775808").is_err() && seed("-1").is_err());
        assert!(threads("1024").is_ok() && threads("100000").is_err() && threads("0").is_err());
    }
}
