use super::StudyError;
use super::fields::ValueKind;
use super::free_key::{FreeKey, KeyScale};
use super::keys::Study;
use super::vary::find;
use crate::number::shown;

/// Refuses keys that are no numbers, bounds that exclude each other or the key's range, and half a prior.
pub(super) fn check(free: &FreeKey, study: &Study) -> Result<(), StudyError> {
    let refuse = |expected: String, found: String, remedy: &str| {
        Err(StudyError::Value {
            place: study.origin.place("fit.free"),
            key: "fit.free".into(),
            expected,
            found,
            remedy: remedy.into(),
        })
    };
    let key = &free.key;
    for name in free.keys() {
        let field = find(name, "fit.free").map_err(|error| placed(error, study))?.1;
        let range = match field.kind {
            ValueKind::Number(range) | ValueKind::NumberOrTable(range) => range,
            _ => {
                return refuse(
                    "keys that take any number of a range".into(),
                    format!("`{name}`, which takes {}", field.expected()),
                    "leave it out",
                );
            }
        };
        if let Some(bound) = [free.min, free.max].into_iter().find(|bound| !range.contains(*bound)) {
            let found = format!("{} as a bound", shown(bound));
            return refuse(
                format!("bounds of `{name}` within its range, {range} {}", field.unit)
                    .trim_end()
                    .into(),
                found,
                "change it",
            );
        }
    }
    if free.min.is_nan() || free.max.is_nan() || free.min >= free.max {
        let found = format!("min = {}, max = {}", shown(free.min), shown(free.max));
        return refuse(
            format!("a min of `{key}` below its max"),
            found,
            "exchange or widen them",
        );
    }
    if free.scale == KeyScale::Log && free.min <= 0.0 {
        let found = format!("min = {}", shown(free.min));
        return refuse(
            format!("a min of `{key}` above 0 for the scale \"log\""),
            found,
            "raise it, or take the scale \"linear\"",
        );
    }
    match (free.prior_mean, free.prior_sd) {
        (None, None) => Ok(()),
        (Some(mean), Some(sd))
            if mean.is_finite() && sd.is_finite() && sd > 0.0 && (free.scale == KeyScale::Linear || mean > 0.0) =>
        {
            Ok(())
        }
        (mean, sd) => refuse(
            format!("prior_mean and prior_sd of `{key}` together, the second above 0"),
            format!("prior_mean {mean:?}, prior_sd {sd:?}"),
            "give both or neither",
        ),
    }
}

/// The error of a key that is unknown, with the line of the study that names it.
fn placed(error: StudyError, study: &Study) -> StudyError {
    let line = study.origin.place("fit.free");
    match (error, line) {
        (
            StudyError::UnknownKey {
                key,
                section,
                known,
                suggestion,
                ..
            },
            Some(place),
        ) => StudyError::UnknownKey {
            place,
            key,
            section,
            known,
            suggestion,
        },
        (error, _) => error,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_keys_are_checked_with_their_bounds() {
        let read = |line: &str| Study::from_toml(&format!("[fit]\nfree = [{{ {line} }}]\n"), "s.toml");
        assert!(read("key = \"medium.volume_fraction\", min = 0.01, max = 0.5, scale = \"log\"").is_ok());
        for (line, wanted) in [
            (
                "key = \"medium.volume_fractoin\", min = 0.01, max = 0.5",
                "medium.volume_fraction",
            ),
            (
                "key = \"medium.volume_fraction\", min = 0.5, max = 0.1",
                "below its max",
            ),
            (
                "key = \"medium.volume_fraction\", min = 0.5, max = 0.9",
                "within its range",
            ),
            (
                "key = \"medium.volume_fraction\", min = 0.0, max = 0.5, scale = \"log\"",
                "above 0",
            ),
            (
                "key = \"medium.volume_fraction\", min = 0.1, max = 0.5, prior_sd = 0.1",
                "together",
            ),
            ("key = \"medium.volume_fraction\", min = 0.1, max = 0.5, sd = 0.1", "sd"),
            ("key = \"trace.tilts\", min = 1, max = 5", "any number of a range"),
        ] {
            let error = read(line).unwrap_err().to_string();
            assert!(error.contains(wanted), "{line}: {error}");
            assert!(error.contains("s.toml"), "{error}");
        }
    }
}
