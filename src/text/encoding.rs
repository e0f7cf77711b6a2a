use super::notice::TextNotice;
use std::borrow::Cow;

use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};

/// Text of a file.
#[derive(Debug)]
pub(crate) struct Decoded<'a> {
    /// Without byte order mark.
    pub(crate) text: Cow<'a, str>,
    /// What the bytes were taken for, where neither a mark nor a declaration says it and they are not UTF-8.
    pub(crate) notice: Option<TextNotice>,
}

/// Bytes that are no text of a supported encoding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NotText {
    /// Offset of the first byte that is not.
    pub(crate) at: usize,
    /// Of the line that it stands on, from 1.
    pub(crate) line: usize,
    pub(crate) byte: u8,
}

/// Decodes the bytes of a text file.
///
/// The encoding is that of a byte order mark (UTF-8, UTF-16), else that of an XML declaration, else UTF-16 where every
/// other byte of the beginning is 0, else UTF-8. What is not UTF-8 is Windows-1252, of which Latin-1 is a part.
///
/// # Errors
/// The first zero byte or other control character of a binary file; bytes that a stated encoding does not have.
pub(crate) fn decode(bytes: &[u8]) -> Result<Decoded<'_>, NotText> {
    let stated = Encoding::for_bom(bytes)
        .map(|(encoding, _)| encoding)
        .or_else(|| without_mark(bytes));
    let (encoding, guessed) = match stated {
        Some(encoding) => (encoding, false),
        None => match std::str::from_utf8(bytes) {
            Ok(_) => (UTF_8, false),
            Err(e) => match is_western(bytes) {
                true => (WINDOWS_1252, true),
                false => return Err(not_text(bytes, e.valid_up_to())),
            },
        },
    };
    let (text, _, malformed) = encoding.decode(bytes);
    if malformed {
        let at = std::str::from_utf8(bytes).map_or_else(|e| e.valid_up_to(), |_| 0);
        return Err(not_text(bytes, at));
    }
    if text.contains('\0') {
        return Err(not_text(bytes, bytes.iter().position(|&b| b == 0).unwrap_or(0)));
    }
    let notice = guessed.then_some(TextNotice::GuessedEncoding);
    Ok(Decoded { text, notice })
}

/// The beginning of a file, cut anywhere, as far as it is text: to tell its format by.
pub(crate) fn beginning(head: &[u8]) -> Cow<'_, str> {
    let encoding = Encoding::for_bom(head).map(|(encoding, _)| encoding);
    encoding.or_else(|| without_mark(head)).unwrap_or(UTF_8).decode(head).0
}

/// The encoding of an XML declaration or of the places of zero bytes.
fn without_mark(bytes: &[u8]) -> Option<&'static Encoding> {
    let is_text = |byte: u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
    match bytes {
        [a, 0, b, 0, ..] if is_text(*a) && is_text(*b) => return Some(UTF_16LE),
        [0, a, 0, b, ..] if is_text(*a) && is_text(*b) => return Some(UTF_16BE),
        _ => {}
    }
    // What is read as single bytes cannot be UTF-16, whatever it declares.
    declared(bytes).filter(|encoding| *encoding != UTF_16LE && *encoding != UTF_16BE)
}

/// `encoding="…"` of an XML declaration.
fn declared(bytes: &[u8]) -> Option<&'static Encoding> {
    const BEGINNING: usize = 4096;
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(BEGINNING)]);
    let (_, declaration) = head.split_once("<?xml")?;
    let (declaration, _) = declaration.split_once("?>")?;
    let (_, value) = declaration.split_once("encoding")?;
    let value = value.trim_start().strip_prefix('=')?.trim_start();
    let quote = value.chars().next().filter(|c| matches!(c, '"' | '\''))?;
    let label = value[1..].split(quote).next()?;
    Encoding::for_label(label.as_bytes())
}

/// Whether bytes that are not UTF-8 can be Western text: no control characters, and not all of it beyond ASCII.
fn is_western(bytes: &[u8]) -> bool {
    let control = |b: u8| (b < 0x20 && !matches!(b, b'\t' | b'\n' | b'\r' | 0x0c)) || b == 0x7f;
    let ascii = bytes.iter().filter(|b| b.is_ascii()).count();
    !bytes.iter().any(|&b| control(b)) && 4 * ascii >= bytes.len()
}

fn not_text(bytes: &[u8], at: usize) -> NotText {
    let at = at.min(bytes.len().saturating_sub(1));
    NotText {
        at,
        line: 1 + bytes[..at].iter().filter(|&&b| b == b'\n').count(),
        byte: bytes.get(at).copied().unwrap_or(0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8]) -> (String, bool) {
        let decoded = decode(bytes).unwrap();
        (decoded.text.into_owned(), decoded.notice.is_some())
    }

    fn utf16(text: &str, bytes_of: fn(u16) -> [u8; 2]) -> Vec<u8> {
        text.encode_utf16().flat_map(bytes_of).collect()
    }

    #[test]
    fn encodings_are_told_by_mark_declaration_or_bytes() {
        let text = "a \u{b5}m\n";
        assert_eq!(read(text.as_bytes()), (text.into(), false));
        let marked = format!("\u{feff}{text}");
        assert_eq!(read(marked.as_bytes()), (text.into(), false));
        for bytes_of in [u16::to_le_bytes, u16::to_be_bytes] {
            assert_eq!(read(&utf16(&marked, bytes_of)), (text.into(), false));
            assert_eq!(read(&utf16(text, bytes_of)), (text.into(), false));
            assert_eq!(beginning(&utf16(&marked, bytes_of)[..5]).chars().next(), Some('a'));
        }
        assert_eq!(read(b"a \xb5m\n"), (text.into(), true));
        let xml = b"<?xml version='1.0' encoding='ISO-8859-1'?><a>\xb5</a>";
        assert_eq!(
            read(xml),
            ("<?xml version='1.0' encoding='ISO-8859-1'?><a>\u{b5}</a>".into(), false)
        );
    }

    #[test]
    fn binary_files_are_no_text() {
        let of = |bytes: &[u8]| decode(bytes).unwrap_err();
        assert_eq!(
            of(b"a\nb\0"),
            NotText {
                at: 3,
                line: 2,
                byte: 0
            }
        );
        assert_eq!(of(b"\x89PNG\r\n\x1a\n").at, 0);
        assert_eq!(of(&[0xff; 64]).at, 0);
        assert_eq!(of(b"\xef\xbb\xbfa\xff").at, 4);
        assert_eq!(decode(b"").unwrap().text, "");
    }
}
