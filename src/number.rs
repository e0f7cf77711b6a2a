//! Numbers as people write them, for messages, and as JSON documents have them.

/// Significant digits of a number in a message: enough for any value that was typed, too few for the rounding of binary
/// fractions.
const DIGITS: usize = 10;

/// A number for a message: 10 significant digits without zeros at the end, and an exponent where it is below 1e-5 or
/// from 1e7 on.
pub fn shown(value: f64) -> String {
    if !value.is_finite() {
        return match value.is_nan() {
            true => "no number".into(),
            false => "an infinite number".into(),
        };
    }
    let rounded = format!("{value:.*e}", DIGITS - 1).parse().unwrap_or(value);
    if rounded == 0.0 {
        // Also of −0.
        "0".into()
    } else if (1e-5..1e7).contains(&rounded.abs()) {
        rounded.to_string()
    } else {
        format!("{rounded:e}")
    }
}

/// A number rounded to so many significant digits, as [`shown`]: "14", "0.55", "2.2e-16".
pub fn significant(value: f64, digits: usize) -> String {
    shown(format!("{value:.*e}", digits.max(1) - 1).parse().unwrap_or(value))
}

/// "1 thread", "2 threads".
pub fn count(number: usize, noun: &str) -> String {
    format!("{number} {noun}{}", if number == 1 { "" } else { "s" })
}

/// A time as people say it, to two digits.
pub fn time_in_words(seconds: f64) -> String {
    const UNITS: [(f64, &str); 4] = [
        (31_557_600.0, "years"),
        (86_400.0, "days"),
        (3600.0, "h"),
        (60.0, "min"),
    ];
    let fits = UNITS.iter().find(|(size, _)| seconds >= 2.0 * size);
    let (size, unit) = fits.copied().unwrap_or((1.0, "s"));
    format!("about {} {unit}", shown(to_two_digits(seconds / size)))
}

/// The number rounded to two significant digits.
pub fn to_two_digits(value: f64) -> f64 {
    format!("{value:.1e}").parse().unwrap_or(value)
}

/// Reads a number of a JSON document, which writes one that is not known as null.
pub fn nan_from_null<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    let value: Option<f64> = serde::Deserialize::deserialize(deserializer)?;
    Ok(value.unwrap_or(f64::NAN))
}

#[cfg(test)]
mod tests {
    use super::{shown, significant};

    #[test]
    fn numbers_are_written_as_people_do() {
        for (value, text) in [
            (0.08727000000000007, "0.08727"),
            (90.0, "90"),
            (0.1 + 0.2, "0.3"),
            (1e300, "1e300"),
            (-2.5e-300, "-2.5e-300"),
            (-0.0, "0"),
            (1_000_000.0, "1000000"),
            (0.5196152422706632, "0.5196152423"),
            (f64::NAN, "no number"),
        ] {
            assert_eq!(shown(value), text);
        }
        for (value, digits, text) in [
            (14.0, 3, "14"),
            (-0.7914, 3, "-0.791"),
            (0.00012345, 2, "0.00012"),
            (2.22e-16, 2, "2.2e-16"),
            (1234.6, 2, "1200"),
            (-0.0, 2, "0"),
            (f64::INFINITY, 2, "an infinite number"),
        ] {
            assert_eq!(significant(value, digits), text);
        }
    }
}
