//! Text of files in other encodings than UTF-8.

use std::borrow::Cow;

use super::FormatError;

/// The text of a file, and what its encoding was taken for where that is not plain.
pub(crate) struct Decoded<'a> {
    pub(crate) text: Cow<'a, str>,
    pub(crate) warning: Option<String>,
}

/// UTF-8; UTF-16 with a byte order mark or with the zero bytes of ASCII letters; else Latin-1, of which every byte is a
/// character.
pub(crate) fn decode<'a>(path: &str, bytes: &'a [u8]) -> Result<Decoded<'a>, FormatError> {
    let (text, warning) = match utf16(bytes) {
        Some(text) => (Cow::Owned(text), None),
        None => match std::str::from_utf8(bytes) {
            Ok(text) if declared_latin(bytes) && !text.is_ascii() => (Cow::Owned(latin(bytes)), None),
            Ok(text) => (Cow::Borrowed(text), None),
            Err(_) => {
                let warning = "the file is not in UTF-8: characters beyond ASCII are read as Latin-1".to_owned();
                (Cow::Owned(latin(bytes)), (!declared_latin(bytes)).then_some(warning))
            }
        },
    };
    if let Some(at) = text.find('\0') {
        return Err(FormatError::byte(
            path,
            at,
            "text",
            "byte 0x00",
            "the file is binary or damaged: copy it again, or give the file that its program exports as text",
        ));
    }
    Ok(Decoded { text, warning })
}

/// The beginning of a file as far as it is text.
pub(super) fn beginning(head: &[u8]) -> String {
    utf16(head).unwrap_or_else(|| String::from_utf8_lossy(head).into_owned())
}

pub(super) fn utf16(bytes: &[u8]) -> Option<String> {
    let little = match bytes {
        [0xff, 0xfe, ..] => true,
        [0xfe, 0xff, ..] => false,
        // Without a mark: two ASCII characters at the beginning.
        [a, 0, b, 0, ..] if is_text(*a) && is_text(*b) => true,
        [0, a, 0, b, ..] if is_text(*a) && is_text(*b) => false,
        _ => return None,
    };
    let units = bytes.chunks_exact(2).map(|pair| match little {
        true => u16::from_le_bytes([pair[0], pair[1]]),
        false => u16::from_be_bytes([pair[0], pair[1]]),
    });
    let characters = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
    Some(characters.collect())
}

fn is_text(byte: u8) -> bool {
    byte.is_ascii_graphic() || byte.is_ascii_whitespace()
}

pub(super) fn latin(bytes: &[u8]) -> String {
    bytes.iter().map(|&byte| char::from(byte)).collect()
}

/// Whether an XML declaration names Latin-1 or the variant of it that Windows has.
fn declared_latin(bytes: &[u8]) -> bool {
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(200)]).to_ascii_lowercase();
    let declaration = head.find("<?xml").and_then(|from| head[from..].split("?>").next());
    declaration.is_some_and(|d| d.contains("iso-8859-1") || d.contains("windows-1252") || d.contains("latin"))
}
