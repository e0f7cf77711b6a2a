use super::{Convention, Illuminant, Observer};

/// What a file of spectra states of illuminant and observer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stated {
    /// Value of the key word, and the built-in table that it names.
    illuminant: Option<(String, Option<Illuminant>)>,
    observer: Option<(String, Option<Observer>)>,
}

impl Stated {
    /// Of CGATS key words and their values, such as `ILLUMINANT` "D50", `OBSERVER` "10 degree" and `WEIGHTING_FUNCTION`
    /// "ILLUMINANT, D50".
    pub fn of(keywords: &[(String, String)]) -> Self {
        let mut stated = Self::default();
        for (key, value) in keywords.iter().flat_map(pairs) {
            if key.starts_with("ILLUMIN") {
                let known = illuminant(&value);
                stated.illuminant.get_or_insert((value, known));
            } else if key.starts_with("OBSERVER") {
                let known = observer(&value);
                stated.observer.get_or_insert((value, known));
            }
        }
        stated
    }

    /// The illuminant asked for, else the stated one, else the default; and a notice where they differ.
    pub fn illuminant(&self, asked: Option<Illuminant>, notices: &mut Vec<String>) -> Illuminant {
        let of = |used: &Illuminant| used.name().to_owned();
        chosen(
            "illuminant",
            asked,
            &self.illuminant,
            Convention::default().illuminant,
            of,
            notices,
        )
    }

    /// The observer asked for, else the stated one, else the default; and a notice where they differ.
    pub fn observer(&self, asked: Option<Observer>, notices: &mut Vec<String>) -> Observer {
        let of = |used: &Observer| used.name().to_owned();
        chosen(
            "observer",
            asked,
            &self.observer,
            Convention::default().observer,
            of,
            notices,
        )
    }
}

/// What a key word says: of lists of assignments, such as `MEASUREMENT_SOURCE` "Illumination=D50
/// ObserverAngle=10degree", each one; of "D50/2" illuminant and observer.
fn pairs((key, value): &(String, String)) -> Vec<(String, String)> {
    let pair = |key: &str, value: &str| (key.trim().to_ascii_uppercase(), value.trim().to_owned());
    match key.as_str() {
        "WEIGHTING_FUNCTION" => value
            .split_once(',')
            .map(|(key, value)| pair(key, value))
            .into_iter()
            .collect(),
        "MEASUREMENT_SOURCE" | "COMPUTATIONAL_PARAMETER" if value.contains('=') => value
            .split([' ', ';', '\t'])
            .filter_map(|word| word.split_once('='))
            .map(|(key, value)| pair(key, value))
            .collect(),
        key => match value.split_once('/') {
            Some((left, right)) if illuminant(left).is_some() && observer(right).is_some() => {
                vec![pair("ILLUMINANT", left), pair("OBSERVER", right)]
            }
            _ => vec![pair(key, value)],
        },
    }
}

fn chosen<T: Clone + PartialEq>(
    kind: &str,
    asked: Option<T>,
    stated: &Option<(String, Option<T>)>,
    default: T,
    name: impl Fn(&T) -> String,
    notices: &mut Vec<String>,
) -> T {
    let is_asked = asked.is_some();
    let Some((value, known)) = stated else {
        return asked.unwrap_or(default);
    };
    let used = asked.or_else(|| known.clone()).unwrap_or_else(|| default.clone());
    if known.as_ref() != Some(&used) {
        let why = match known {
            None if !is_asked => format!("; that is not built in, give its table by --{kind}"),
            _ => String::new(),
        };
        notices.push(format!(
            "the file states the {kind} '{value}', and {} is used{why}",
            name(&used)
        ));
    } else if !is_asked && used != default {
        notices.push(format!("{} is used, the {kind} that the file states", name(&used)));
    }
    used
}

/// A built-in illuminant named by a word of a text.
fn illuminant(text: &str) -> Option<Illuminant> {
    let words = || text.split(|c: char| !c.is_ascii_alphanumeric());
    let named = |known: &&Illuminant| words().any(|word| word.eq_ignore_ascii_case(known.name()));
    Illuminant::ALL.iter().find(named).cloned()
}

/// The standard observer of a text such as "2", "10 degree", "2deg" or "CIE 1964".
fn observer(text: &str) -> Option<Observer> {
    let words = text.split(|c: char| !c.is_ascii_alphanumeric());
    words
        .into_iter()
        .find_map(|word| match word.trim_end_matches(|c: char| c.is_ascii_alphabetic()) {
            "2" | "1931" => Some(Observer::Cie1931),
            "10" | "1964" => Some(Observer::Cie1964),
            _ => None,
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_honoured_or_contradicted_aloud() {
        let keys = |pairs: &[(&str, &str)]| -> Vec<(String, String)> {
            pairs
                .iter()
                .map(|(key, value)| ((*key).into(), (*value).into()))
                .collect()
        };
        for pairs in [
            &[("ILLUMINANT", "D50"), ("OBSERVER", "10 degree")][..],
            &[
                ("WEIGHTING_FUNCTION", "ILLUMINANT, D50"),
                ("WEIGHTING_FUNCTION", "OBSERVER, 10 degree"),
            ],
            &[("ILLUMINATION_NAME", "CIE d50"), ("OBSERVER_ANGLE", "10deg")],
            &[(
                "MEASUREMENT_SOURCE",
                "Illumination=D50 ObserverAngle=10degree WhiteBase=Abs Filter=No",
            )],
            &[("ILLUMINANT", "D50/10")],
            &[("COMPUTATIONAL_PARAMETER", "D50/10")],
        ] {
            let stated = Stated::of(&keys(pairs));
            let mut notices = Vec::new();
            assert_eq!(stated.illuminant(None, &mut notices), Illuminant::D50);
            assert_eq!(stated.observer(None, &mut notices), Observer::Cie1964);
            assert_eq!(notices.len(), 2, "{notices:?}");
            let mut notices = Vec::new();
            assert_eq!(stated.illuminant(Some(Illuminant::A), &mut notices), Illuminant::A);
            assert!(
                notices[0].contains("states the illuminant") && notices[0].contains("A is used"),
                "{notices:?}"
            );
        }
        let mut notices = Vec::new();
        let other = Stated::of(&keys(&[("ILLUMINANT", "F11")]));
        assert_eq!(other.illuminant(None, &mut notices), Illuminant::D65);
        assert!(
            notices[0].contains("'F11'") && notices[0].contains("--illuminant"),
            "{notices:?}"
        );
        notices.clear();
        assert_eq!(Stated::of(&[]).observer(None, &mut notices), Observer::Cie1931);
        assert_eq!(notices, Vec::<String>::new());
    }
}
