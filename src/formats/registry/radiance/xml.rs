//! Elements of the XML, whatever their name space, and errors at them.

use roxmltree::Node as Element;

use crate::formats::error::FormatError;
use crate::formats::text::{Text, finite, quoted, remedy_for};

pub(super) struct Xml<'a> {
    pub(super) text: Text<'a>,
    /// Byte of the text at which the XML begins.
    pub(super) begins: usize,
}

impl Xml<'_> {
    pub(super) fn error(
        &self,
        element: Element,
        expected: impl Into<String>,
        found: impl Into<String>,
        remedy: impl Into<String>,
    ) -> FormatError {
        let at = self.begins + element.range().start;
        self.text.error(at, expected, found, remedy)
    }

    pub(super) fn missing(&self, element: Element, name: &str) -> FormatError {
        let remedy = format!("add <{name}>, or export the file again: the format needs it");
        self.error(element, format!("an element <{name}> in it"), "none", remedy)
    }

    pub(super) fn child<'n>(&self, element: Element<'n, 'n>, name: &str) -> Result<Element<'n, 'n>, FormatError> {
        child(element, name).ok_or_else(|| self.missing(element, name))
    }

    pub(super) fn words<'n>(&self, element: Element<'n, 'n>, name: &str) -> Result<&'n str, FormatError> {
        Ok(words(self.child(element, name)?))
    }

    pub(super) fn number(&self, element: Element<'_, '_>, name: &str) -> Result<f64, FormatError> {
        let child = element.children().find(|n| n.has_tag_name_in_any_space(name));
        let child = child.ok_or_else(|| self.missing(element, name))?;
        let word = child.text().unwrap_or_default().trim();
        let range = 0.0..=1e6;
        finite(word, &range).ok_or_else(|| {
            let expected = format!("a number in <{name}>, 0 or more");
            self.error(child, expected, quoted(word), remedy_for(word, &range))
        })
    }
}

/// WINDOW puts its elements into a name space, others do not.
pub(super) trait AnySpace {
    fn has_tag_name_in_any_space(&self, name: &str) -> bool;
}

impl AnySpace for Element<'_, '_> {
    fn has_tag_name_in_any_space(&self, name: &str) -> bool {
        self.is_element() && self.tag_name().name() == name
    }
}

pub(super) fn child<'n>(element: Element<'n, 'n>, name: &str) -> Option<Element<'n, 'n>> {
    element.children().find(|n| n.has_tag_name_in_any_space(name))
}

pub(super) fn words<'n>(element: Element<'n, 'n>) -> &'n str {
    element.text().unwrap_or_default().trim()
}
