/// A name that is not among the known ones.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{kind} '{found}' is not known; known: {}{}", .known.join(", "), .nearest.as_ref().map(|n| format!("; did you \
                                                                                                            mean \
                                                                                                            '{n}'?")).unwrap_or_default())]
pub struct UnknownName {
    /// What was to be named, such as "dye".
    pub kind: &'static str,
    pub found: String,
    pub known: Vec<String>,
    pub nearest: Option<String>,
}

impl UnknownName {
    pub(crate) fn new<'a>(kind: &'static str, found: &str, known: impl IntoIterator<Item = &'a str>) -> Self {
        let known: Vec<String> = known.into_iter().map(str::to_owned).collect();
        let nearest = nearest(found, &known);
        Self {
            kind,
            found: found.into(),
            known,
            nearest,
        }
    }
}

/// The known name that looks most like what was typed; none if all are far.
fn nearest(found: &str, known: &[String]) -> Option<String> {
    const ALIKE: f64 = 0.5;
    let found = found.to_lowercase();
    known
        .iter()
        .map(|name| {
            (
                strsim::normalized_damerau_levenshtein(&found, &name.to_lowercase()),
                name,
            )
        })
        .filter(|(score, _)| *score >= ALIKE)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name.clone())
}
