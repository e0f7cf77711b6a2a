//! CGATS-like text: key words, one data format, one block of data (CGATS.17, ISO 28178; Argyll's `.sp` files are of
//! it).

use super::decimals::Decimals;
use super::{CsvError, CsvTable, shortened};

/// A CGATS text and those of its key words that say how to read it.
pub(crate) struct Cgats {
    pub table: CsvTable,
    keywords: Vec<Keyword>,
    decimals: Decimals,
}

struct Keyword {
    line: usize,
    key: String,
    value: String,
}

/// Where in the file a line is.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    Keywords,
    Format,
    Data,
    End,
}

/// Whether a text is CGATS and not CSV: a line of it begins with one of the words that every CGATS file has.
pub(crate) fn is_cgats(text: &str) -> bool {
    const WORDS: [&str; 4] = ["BEGIN_DATA_FORMAT", "BEGIN_DATA", "NUMBER_OF_FIELDS", "NUMBER_OF_SETS"];
    text.lines().any(|line| {
        line.split_whitespace()
            .next()
            .is_some_and(|word| WORDS.iter().any(|known| word.eq_ignore_ascii_case(known)))
    })
}

impl Cgats {
    /// A set is one line with as many values as the format has fields; stated numbers of fields and sets must be right.
    pub(crate) fn parse(name: &str, text: &str) -> Result<Self, Box<CsvError>> {
        let mut part = Part::Keywords;
        let mut has_format = false;
        let mut cgats = Self {
            table: CsvTable::new(name),
            keywords: Vec::new(),
            decimals: Decimals::default(),
        };
        let last_line = text.lines().count().max(1);
        for (index, content) in text.lines().enumerate() {
            let line = index + 1;
            let mut words = cgats.words(line, content)?;
            let Some(first) = words.first() else { continue };
            let fault =
                |expected: &str, remedy| Err(cgats.table.error(line, None, expected, &shortened(first), remedy));
            match (part, first.to_ascii_uppercase().as_str()) {
                (Part::Keywords, "BEGIN_DATA_FORMAT") if !has_format => {
                    part = Part::Format;
                    has_format = true;
                    cgats.table.header_line = line;
                    words.remove(0);
                }
                (Part::Keywords, "BEGIN_DATA") if has_format && words.len() == 1 => {
                    part = Part::Data;
                    continue;
                }
                (Part::Keywords, "BEGIN_DATA" | "BEGIN_DATA_FORMAT" | "END_DATA" | "END_DATA_FORMAT") => {
                    let expected = if has_format { "BEGIN_DATA" } else { "BEGIN_DATA_FORMAT" };
                    return fault(expected, "one data format and then one block of data make a file");
                }
                (Part::Format, "BEGIN_DATA") => {
                    return fault(
                        "END_DATA_FORMAT",
                        "end the list of fields with END_DATA_FORMAT before the data",
                    );
                }
                (Part::Data, "END_DATA") if words.len() == 1 => {
                    part = Part::End;
                    continue;
                }
                (Part::End, _) => return fault("the end of the file after END_DATA", "keep one table a file"),
                _ => {}
            }
            match part {
                Part::Keywords => cgats.keyword(line, words)?,
                Part::Format => {
                    if words
                        .last()
                        .is_some_and(|word| word.eq_ignore_ascii_case("END_DATA_FORMAT"))
                    {
                        words.pop();
                        part = Part::Keywords;
                    }
                    cgats.table.columns.append(&mut words);
                }
                Part::Data => cgats.set(line, words)?,
                Part::End => {}
            }
        }
        let missing = match part {
            Part::Keywords if has_format => "BEGIN_DATA",
            Part::Keywords => "BEGIN_DATA_FORMAT",
            Part::Format => "END_DATA_FORMAT",
            Part::Data => "END_DATA",
            Part::End => {
                cgats.counted("NUMBER_OF_FIELDS", cgats.table.columns.len())?;
                cgats.counted("NUMBER_OF_SETS", cgats.table.len())?;
                if let Some((line, expected, found, remedy)) = cgats.decimals.ambiguous() {
                    return Err(cgats.table.error(line, None, expected, &found, remedy));
                }
                cgats.table.notices.extend(cgats.decimals.notice());
                cgats.table = cgats.table.complete()?;
                return Ok(cgats);
            }
        };
        let remedy = "the file may be cut off: copy or export it again";
        Err(cgats
            .table
            .error(last_line, None, missing, "the end of the file", remedy))
    }

    /// The number that a key word states, with its line; it must be above 0.
    pub(crate) fn number(&self, key: &str) -> Result<Option<(f64, usize)>, Box<CsvError>> {
        let Some(keyword) = self.keywords.iter().find(|keyword| keyword.key == key) else {
            return Ok(None);
        };
        match keyword.value.parse::<f64>() {
            Ok(value) if value.is_finite() && value > 0.0 => Ok(Some((value, keyword.line))),
            _ => {
                let found = shortened(&keyword.value);
                Err(self.table.error(
                    keyword.line,
                    Some(key),
                    "a number above 0",
                    &found,
                    "correct the number, or remove the line",
                ))
            }
        }
    }

    /// Key words that state for what illuminant or observer colours are worked out, with their values.
    pub(crate) fn stated(&self) -> Vec<(String, String)> {
        const OF_COLOUR: [&str; 8] = [
            "ILLUMINANT",
            "ILLUMINATION",
            "ILLUMINATION_NAME",
            "OBSERVER",
            "OBSERVER_ANGLE",
            "WEIGHTING_FUNCTION",
            "MEASUREMENT_SOURCE",
            "COMPUTATIONAL_PARAMETER",
        ];
        let of_colour = |keyword: &&Keyword| OF_COLOUR.iter().any(|key| keyword.key.eq_ignore_ascii_case(key));
        let stated = self.keywords.iter().filter(of_colour);
        stated
            .map(|keyword| (keyword.key.clone(), keyword.value.clone()))
            .collect()
    }

    /// Words of a line, in double quotes or between white space, up to a comment; a doubled quote in quotes is a quote.
    fn words(&self, line: usize, content: &str) -> Result<Vec<String>, Box<CsvError>> {
        let mut words = Vec::new();
        let mut rest = content.trim_start();
        while !rest.is_empty() && !rest.starts_with('#') {
            let mut word = String::new();
            if let Some(mut quoted) = rest.strip_prefix('"') {
                loop {
                    let Some((inside, after)) = quoted.split_once('"') else {
                        let expected = "a closing quotation mark on the same line";
                        let remedy = "close the quotation mark, or double it where it is a character of the text";
                        return Err(self.table.error(line, None, expected, &shortened(rest), remedy));
                    };
                    word += inside;
                    quoted = after;
                    match quoted.strip_prefix('"') {
                        Some(after) => {
                            word.push('"');
                            quoted = after;
                        }
                        None => break,
                    }
                }
                rest = quoted;
            } else {
                let (bare, after) = rest.split_at(rest.find(char::is_whitespace).unwrap_or(rest.len()));
                word += bare;
                rest = after;
            }
            words.push(word);
            rest = rest.trim_start();
        }
        Ok(words)
    }

    fn keyword(&mut self, line: usize, mut words: Vec<String>) -> Result<(), Box<CsvError>> {
        let value = if words.len() > 1 {
            words.swap_remove(1)
        } else {
            String::new()
        };
        let key = words.swap_remove(0).to_ascii_uppercase();
        // What reading depends on has one value; the rest are notes and may be repeated.
        let decides = key.starts_with("NUMBER_OF_") || key.starts_with("SPECTRAL_");
        if decides && self.keywords.iter().any(|known| known.key == key) {
            return Err(self.table.error(
                line,
                None,
                "every key word once",
                &format!("{} twice", shortened(&key)),
                "remove one of the two",
            ));
        }
        self.keywords.push(Keyword { line, key, value });
        Ok(())
    }

    fn set(&mut self, line: usize, cells: Vec<String>) -> Result<(), Box<CsvError>> {
        let fields = self.table.columns.len();
        if cells.len() != fields {
            let expected = format!("{fields} values, one a field of the data format, or END_DATA");
            let found = cells.len().to_string();
            return Err(self.table.error(
                line,
                None,
                &expected,
                &found,
                "write each set in a line of its own, and quote values that have blanks in them",
            ));
        }
        let cells: Vec<String> = cells.into_iter().map(|cell| self.decimals.cell(cell, line)).collect();
        self.table.push(line, cells.iter().map(String::as_str));
        Ok(())
    }

    fn counted(&self, key: &str, found: usize) -> Result<(), Box<CsvError>> {
        match self.number(key)? {
            Some((stated, line)) if stated != found as f64 => {
                let expected = format!("{stated}, as stated here");
                Err(self.table.error(
                    line,
                    Some(key),
                    &expected,
                    &found.to_string(),
                    "correct the number; where it is right the file is cut off: export it again",
                ))
            }
            _ => Ok(()),
        }
    }
}
