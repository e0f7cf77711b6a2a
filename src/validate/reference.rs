use serde::de::DeserializeOwned;

use super::ValidateError;

/// Rows of a table with `#` comments and a header.
pub(super) fn rows<T: DeserializeOwned>(table: &'static str, text: &str) -> Result<Vec<T>, ValidateError> {
    csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_reader(text.as_bytes())
        .deserialize()
        .collect::<Result<_, _>>()
        .map_err(|source| ValidateError::Table { table, source })
}
