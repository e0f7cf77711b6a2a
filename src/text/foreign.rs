use super::encoding::beginning;

/// A kind of file that is often given in place of a table, recognised by its first bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Foreign {
    /// With its article: "a web page (HTML)".
    pub what: &'static str,
    pub remedy: &'static str,
}

impl Foreign {
    pub fn is_json(self) -> bool {
        self.what == JSON
    }
}

const JSON: &str = "a JSON document";

/// Bytes of a file's beginning that are looked at.
const HEAD: usize = 4096;

const SHEET: &str = "save the sheet as CSV";
const UNPACK: &str = "unpack it, and name the file inside";
const VALUES: &str = "give the table of values behind it";
const DOWNLOAD: &str = "download the file itself: the page usually has a link named Raw or Download";

/// What a file is by its first bytes, if it is none that anything here reads.
pub(crate) fn foreign(bytes: &[u8]) -> Option<Foreign> {
    const MAGIC: [(&[u8], &str, &str); 9] = [
        (b"\x1f\x8b", "a gzip archive", UNPACK),
        (b"\xfd7zXZ", "an xz archive", UNPACK),
        (b"BZh", "a bzip2 archive", UNPACK),
        (b"7z\xbc\xaf\x27\x1c", "a 7z archive", UNPACK),
        (
            b"\xd0\xcf\x11\xe0",
            "a spreadsheet or document of an old office program",
            SHEET,
        ),
        (b"\xff\xd8\xff", "an image", VALUES),
        (b"\x89PNG", "an image", VALUES),
        (b"%PDF", "a PDF document", VALUES),
        (
            b"version https://git-lfs",
            "a pointer of Git LFS",
            "fetch the file itself with `git lfs pull`",
        ),
    ];
    let head = &bytes[..bytes.len().min(HEAD)];
    let of = |what, remedy| Some(Foreign { what, remedy });
    if let Some((_, what, remedy)) = MAGIC.iter().find(|(magic, ..)| head.starts_with(magic)) {
        return of(what, remedy);
    }
    if head.starts_with(b"PK\x03\x04") {
        let has = |word: &[u8]| head.windows(word.len()).any(|bytes| bytes == word);
        return match has(b"[Content_Types].xml") || has(b"xl/") || has(b"opendocument.spreadsheet") {
            true => of("a spreadsheet", SHEET),
            false => of("a ZIP archive", UNPACK),
        };
    }
    let text = beginning(head);
    let text = text.trim_start_matches('\u{feff}').trim_start();
    if is_web_page(text) {
        return of("a web page (HTML)", DOWNLOAD);
    }
    if is_json(text) {
        return of(JSON, "export its values as CSV");
    }
    let lower = text.get(..text.len().min(200)).unwrap_or(text).to_ascii_lowercase();
    let is_answer = text.len() < 200 && (lower.starts_with("404") || lower.starts_with("403"));
    match is_answer && ["not found", "forbidden"].iter().any(|word| lower.contains(word)) {
        true => of("the error message of a web server", DOWNLOAD),
        false => None,
    }
}

/// Whether a page of HTML begins, be it a reader's error page or the view of a file.
fn is_web_page(text: &str) -> bool {
    let lower = text.to_ascii_lowercase();
    let page = ["<!doctype html", "<html", "<head>"]
        .iter()
        .filter_map(|tag| lower.find(tag))
        .min();
    page.is_some_and(|at| lower.starts_with('<') && lower.find("<windowelement").is_none_or(|bsdf| at < bsdf))
}

/// Whether an object, or a list of objects, lists or numbers begins; `[section]` is none.
fn is_json(text: &str) -> bool {
    let after = |sign: char| text.strip_prefix(sign).map(str::trim_start);
    after('{').is_some_and(|rest| rest.starts_with(['"', '}']))
        || after('[').is_some_and(|rest| {
            rest.starts_with(['{', '['])
                || rest.starts_with(|c: char| c.is_ascii_digit() || c == '-') && rest.contains([',', '\n'])
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn foreign_files_are_named_and_tables_are_not() {
        for (bytes, what) in [
            (&b"\x1f\x8b\x08\x08"[..], "a gzip archive"),
            (b"PK\x03\x04\x14\0\x06\0[Content_Types].xml", "a spreadsheet"),
            (b"PK\x03\x04\x14\0\0\0data.csv", "a ZIP archive"),
            (b"%PDF-1.7", "a PDF document"),
            (b"\n<!DOCTYPE html><html>", "a web page (HTML)"),
            (b"{\n  \"a\": [1]}", "a JSON document"),
            (b"[[400, 0.1], [410, 0.2]]", "a JSON document"),
            (b"404: Not Found", "the error message of a web server"),
            (b"version https://git-lfs.github.com/spec/v1\n", "a pointer of Git LFS"),
        ] {
            assert_eq!(foreign(bytes).map(|of| of.what), Some(what));
        }
        for text in [
            "",
            "theta_i_deg,theta_v_deg,beta\n0,0,0.4\n",
            "[WIF]\nVersion=1.1\n",
            "[trace]\ntilts = 8\n",
            "<?xml version=\"1.0\"?><!DOCTYPE x><WindowElement><html/></WindowElement>",
            "404 0.1\n405 0.2\n",
        ] {
            assert_eq!(foreign(text.as_bytes()), None, "{text}");
        }
    }
}
