//! Tensor trees: braces around braces or values.

use roxmltree::Node as Element;

use super::xml::{AnySpace, Xml};
use crate::formats::error::FormatError;
use crate::formats::text::{FINITE, Readings, finite, quoted, remedy_for};
use crate::goniometric::Node;

/// A nesting beyond it is none that can be meant.
const DEPTH: usize = 64;

pub(super) fn tree(xml: &Xml, block: Element, rank: usize, readings: &mut Readings) -> Result<Node, FormatError> {
    let data = block.children().find(|n| n.has_tag_name_in_any_space("ScatteringData"));
    let data = data.ok_or_else(|| xml.missing(block, "ScatteringData"))?;
    let text = data.text().unwrap_or_default();
    let mut words = Braces { rest: text };
    let refuse = |expected: String, found: &str| {
        let remedy = "compare the braces: a tree that was cut short or edited is to be exported again";
        xml.error(data, expected, quoted(found), remedy)
    };
    if words.next() != Some("{") {
        return Err(refuse("'{' at the beginning of a tree".into(), text.trim_start()));
    }
    // Nodes begun and not yet ended: their children and their values.
    let mut open: Vec<(Vec<Node>, Vec<f64>)> = vec![Default::default()];
    loop {
        let word = words.next().ok_or_else(|| refuse("'}' for every '{'".into(), ""))?;
        match word {
            "{" => {
                if open.len() == DEPTH {
                    return Err(refuse(format!("at most {DEPTH} nested braces"), "more"));
                }
                open.push(Default::default());
            }
            "}" => {
                let (children, values) = open.pop().unwrap_or_default();
                let node = ended(children, values, rank).map_err(|found| {
                    let expected = format!(
                        "{} nodes, or a power of {} values, between braces",
                        1 << rank,
                        1 << rank
                    );
                    refuse(expected, &found)
                })?;
                match open.last_mut() {
                    Some((siblings, _)) => siblings.push(node),
                    None if words.next().is_none() => return Ok(node),
                    None => return Err(refuse("the end of the tree after its last brace".into(), "more")),
                }
            }
            number => {
                let value = finite(number, &FINITE).ok_or_else(|| {
                    xml.error(
                        data,
                        "values in 1/sr, 0 or more",
                        quoted(number),
                        remedy_for(number, &FINITE),
                    )
                })?;
                readings.take(value, xml.begins + data.range().start);
                if let Some((_, values)) = open.last_mut() {
                    values.push(value);
                }
            }
        }
    }
}

fn ended(children: Vec<Node>, values: Vec<f64>, rank: usize) -> Result<Node, String> {
    let found = format!("{} nodes and {} values", children.len(), values.len());
    if values.is_empty() && children.len() == 1 << rank {
        return Ok(Node::Branch(children));
    }
    let count = values.len();
    let fits = children.is_empty() && count.is_power_of_two() && (count.trailing_zeros() as usize).is_multiple_of(rank);
    if fits { Ok(Node::Grid(values)) } else { Err(found) }
}

/// Braces and numbers between commas and white space.
struct Braces<'a> {
    rest: &'a str,
}

impl<'a> Iterator for Braces<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        let between = |c: char| c.is_whitespace() || c == ',';
        self.rest = self.rest.trim_start_matches(between);
        let end = match self.rest.chars().next()? {
            '{' | '}' => 1,
            _ => self
                .rest
                .find(|c: char| between(c) || c == '{' || c == '}')
                .unwrap_or(self.rest.len()),
        };
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        Some(word)
    }
}
