//! Words and numbers of text files, with their places.

use std::ops::RangeInclusive;

use super::error::{FormatError, Location, remedy};
use crate::goniometric::ReadNotice;
use crate::spectrum::{Doubt, plausibility};
use crate::text::encoding::{self, Decoded};

/// A text file and what to call it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Text<'a> {
    pub(crate) path: &'a str,
    pub(crate) text: &'a str,
}

impl<'a> Text<'a> {
    /// A byte order mark is passed over.
    pub(crate) fn new(path: &'a str, text: &'a str) -> Self {
        Self {
            path,
            text: text.strip_prefix('\u{feff}').unwrap_or(text),
        }
    }

    /// An error at a byte of the text.
    pub(crate) fn error(
        &self,
        at: usize,
        expected: impl Into<String>,
        found: impl Into<String>,
        remedy: impl Into<String>,
    ) -> FormatError {
        FormatError::at(self.path, self.place(at), expected, found, remedy)
    }

    /// Adds the warning of readings that are below 0 by noise, and refuses those below it.
    pub(crate) fn judge(&self, readings: &Readings, warnings: &mut Vec<ReadNotice>) -> Result<(), FormatError> {
        match readings.judged() {
            Ok(doubt) => warnings.extend(doubt.map(ReadNotice::from)),
            Err((at, [expected, found, remedy])) => return Err(self.error(at, expected, found, remedy)),
        }
        Ok(())
    }

    /// Line and column of a byte of the text.
    pub(crate) fn place(&self, at: usize) -> Location {
        let before = &self.text[..at.min(self.text.len())];
        // Lines end with \n, \r\n or \r.
        let ends = before.as_bytes().iter().enumerate();
        let lines = ends.filter(|&(i, &b)| b == b'\n' || (b == b'\r' && before.as_bytes().get(i + 1) != Some(&b'\n')));
        let (line, start) = lines.fold((1, 0), |(line, _), (i, _)| (line + 1, i + 1));
        let column = before[start..].chars().count() + 1;
        Location::Line { line, column }
    }
}

/// The text of a file in any of the encodings of [`crate::text::encoding`].
pub(crate) fn decode<'a>(path: &str, bytes: &'a [u8]) -> Result<Decoded<'a>, FormatError> {
    encoding::decode(bytes).map_err(|not| {
        FormatError::byte(
            path,
            not.at,
            "text in UTF-8, or in the encoding that its beginning states",
            format!("byte 0x{:02x}", not.byte),
            "the file is binary, damaged or of another encoding: copy it again, or save it as UTF-8",
        )
    })
}

/// What a message quotes of a file: no control characters, no page of text.
pub(crate) fn quoted(text: &str) -> String {
    const LONGEST: usize = 40;
    let mut quoted: String = text.escape_debug().take(LONGEST).collect();
    if text.escape_debug().nth(LONGEST).is_some() {
        quoted.push('…');
    }
    format!("'{quoted}'")
}

/// A word and where it begins, in bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Token<'a> {
    pub(crate) word: &'a str,
    pub(crate) at: usize,
}

impl Token<'_> {
    pub(crate) fn is(&self, word: &str) -> bool {
        self.word.eq_ignore_ascii_case(word)
    }
}

/// The words of a text, separated by white space; a word that begins with `comment` ends its line.
#[derive(Clone, Debug)]
pub(crate) struct Tokens<'a> {
    pub(crate) source: Text<'a>,
    position: usize,
    comment: &'static str,
    comments: Vec<&'a str>,
}

impl<'a> Tokens<'a> {
    pub(crate) fn new(source: Text<'a>, comment: &'static str) -> Self {
        Self {
            source,
            position: 0,
            comment,
            comments: Vec::new(),
        }
    }

    /// The first comments passed over so far.
    pub(crate) fn comments(&self) -> &[&'a str] {
        &self.comments
    }

    pub(crate) fn next(&mut self) -> Option<Token<'a>> {
        const COMMENTS_KEPT: usize = 20;
        loop {
            let rest = &self.source.text[self.position..];
            let blank = rest.len() - rest.trim_start().len();
            let rest = &rest[blank..];
            let at = self.position + blank;
            if rest.starts_with(self.comment) {
                let end = rest.find(['\n', '\r']).unwrap_or(rest.len());
                let words = rest[self.comment.len()..end].trim();
                if self.comments.len() < COMMENTS_KEPT && !words.is_empty() {
                    self.comments.push(words);
                }
                self.position = at + end;
                continue;
            }
            let end = rest.find(char::is_whitespace).unwrap_or(rest.len());
            self.position = at + end;
            return (end > 0).then_some(Token { word: &rest[..end], at });
        }
    }

    pub(crate) fn peek(&mut self) -> Option<Token<'a>> {
        let position = self.position;
        let token = self.next();
        self.position = position;
        token
    }

    pub(crate) fn expect(&mut self, expected: &str) -> Result<Token<'a>, FormatError> {
        let token = self.next();
        token.ok_or_else(|| self.ended(expected))
    }

    /// This very word, in any case.
    pub(crate) fn keyword(&mut self, word: &str) -> Result<Token<'a>, FormatError> {
        let token = self.expect(&format!("'{word}'"))?;
        if token.is(word) {
            Ok(token)
        } else {
            Err(self.unexpected(&token, format!("'{word}'"), remedy::SPELLING_OR_COUNT))
        }
    }

    pub(crate) fn ended(&self, expected: &str) -> FormatError {
        let end = self.source.text.trim_end().len();
        self.source
            .error(end, expected, "the end of the file", remedy::CUT_SHORT)
    }

    pub(crate) fn unexpected(
        &self,
        token: &Token,
        expected: impl Into<String>,
        remedy: impl Into<String>,
    ) -> FormatError {
        self.source.error(token.at, expected, quoted(token.word), remedy)
    }

    /// A finite number in a range; `expected` names it with its unit.
    pub(crate) fn number(&mut self, expected: &str, range: &RangeInclusive<f64>) -> Result<f64, FormatError> {
        let token = self.expect(expected)?;
        finite(token.word, range).ok_or_else(|| self.unexpected(&token, expected, remedy_for(token.word, range)))
    }

    /// A count of things that each take at least one character and a separator of what follows.
    pub(crate) fn count(&mut self, what: &str) -> Result<usize, FormatError> {
        let expected = format!("the number of {what}, a whole number, 1 or more");
        let token = self.expect(&expected)?;
        let count = token.word.parse::<usize>().ok().filter(|&n| n > 0);
        let count = count.ok_or_else(|| {
            let remedy = format!("write before the {what} how many there are");
            self.unexpected(&token, expected, remedy)
        })?;
        self.room_for(count, what, token.at)?;
        Ok(count)
    }

    /// Refuses a promise of more numbers than the rest of the text can hold.
    pub(crate) fn room_for(&self, count: usize, what: &str, at: usize) -> Result<(), FormatError> {
        let most = (self.source.text.len() - self.position).div_ceil(2);
        if count <= most {
            return Ok(());
        }
        let found = format!("room for {most} at most in the rest of the file");
        let remedy = "check the counts in the header; where they are right the file is cut short: export it again";
        Err(self.source.error(at, format!("{count} {what}"), found, remedy))
    }

    /// So many strictly ascending angles within a range in degrees.
    pub(crate) fn angles_deg(
        &mut self,
        count: usize,
        what: &str,
        range: RangeInclusive<f64>,
    ) -> Result<Vec<f64>, FormatError> {
        let (low, high) = (range.start(), range.end());
        let expected = format!("{count} {what} in degrees, ascending, {low}..{high}");
        let mut angles: Vec<f64> = Vec::with_capacity(count);
        for _ in 0..count {
            let token = self.expect(&expected)?;
            let angle = finite(token.word, &range).filter(|a| angles.last().is_none_or(|last| a > last));
            angles.push(angle.ok_or_else(|| {
                let remedy = format!("sort the angles, check their count, {count}, and that they are in degrees");
                self.unexpected(&token, expected.as_str(), remedy)
            })?);
        }
        Ok(angles)
    }

    /// So many values of scattering, appended; `expected` names them with their unit.
    pub(crate) fn readings(
        &mut self,
        count: usize,
        expected: &str,
        readings: &mut Readings,
        into: &mut Vec<f64>,
    ) -> Result<(), FormatError> {
        self.room_for(count, expected, self.position)?;
        into.reserve(count);
        for _ in 0..count {
            let token = self.expect(expected)?;
            let value = finite(token.word, &FINITE)
                .ok_or_else(|| self.unexpected(&token, expected, remedy_for(token.word, &FINITE)))?;
            readings.take(value, token.at);
            into.push(value);
        }
        Ok(())
    }

    /// So many finite numbers in a range, appended.
    pub(crate) fn numbers(
        &mut self,
        count: usize,
        expected: &str,
        range: &RangeInclusive<f64>,
        into: &mut Vec<f64>,
    ) -> Result<(), FormatError> {
        self.room_for(count, expected, self.position)?;
        into.reserve(count);
        for _ in 0..count {
            into.push(self.number(expected, range)?);
        }
        Ok(())
    }
}

/// Finite numbers; what scattering can be is judged when all are read ([`Readings`]).
pub(crate) const FINITE: RangeInclusive<f64> = -1e30..=1e30;

/// Values that are not below 0.
pub(crate) const NOT_NEGATIVE: RangeInclusive<f64> = 0.0..=1e30;

pub(crate) fn finite(word: &str, range: &RangeInclusive<f64>) -> Option<f64> {
    word.parse::<f64>().ok().filter(|v| v.is_finite() && range.contains(v))
}

/// What to do about a word that is no number, or a number out of its range.
pub(crate) fn remedy_for(word: &str, range: &RangeInclusive<f64>) -> String {
    match word.parse::<f64>() {
        Ok(value) if value.is_finite() && value < *range.start() && *range.start() == 0.0 => {
            "a value below 0 is none here: check its sign and its column".into()
        }
        Ok(value) if value.is_finite() => "check the unit of the number and its place in the file".into(),
        Ok(_) => remedy::NOT_FINITE.into(),
        Err(_) if word.is_empty() => "fill in the value, or leave the line out".into(),
        Err(_) if word.contains(',') => "write a point as decimal mark and blanks between numbers".into(),
        Err(_) => "check the counts of angles and values before it: they say where numbers stand".into(),
    }
}

/// The lowest and the highest of the values of a file. Dark subtraction leaves values a little below 0, which are kept;
/// what is further below is no scattering.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Readings {
    highest: f64,
    lowest: f64,
    /// Where the lowest stands.
    at: usize,
    negative: usize,
}

impl Readings {
    /// A value and the byte where it stands.
    pub(crate) fn take(&mut self, value: f64, at: usize) {
        self.highest = self.highest.max(value);
        self.negative += usize::from(value < 0.0);
        if value < self.lowest {
            (self.lowest, self.at) = (value, at);
        }
    }

    /// As [`plausibility::below_zero`], with the place of the lowest value.
    pub(crate) fn judged(&self) -> Result<Option<Doubt>, (usize, [String; 3])> {
        let judged = plausibility::below_zero("scattering", self.lowest, self.highest, self.negative);
        judged.map_err(|words| (self.at, words))
    }
}
