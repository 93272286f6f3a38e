//! Reading attributes out of an XML file, with the line in every complaint.

use std::str::FromStr;

use roxmltree::{Document, Node, ParsingOptions};

use crate::Error;

/// An XML file (or embedded text) by the name it is complained about under.
pub(super) struct Source<'a> {
    pub name: &'a str,
    pub document: Document<'a>,
}

impl<'a> Source<'a> {
    /// Parses `text`.
    ///
    /// # Errors
    /// [`Error::Parse`] when it is no well-formed XML.
    pub fn parse(name: &'a str, text: &'a str) -> Result<Self, Error> {
        // Robots of a few hundred links stay far below this; a bomb does not.
        let options = ParsingOptions {
            nodes_limit: 4_000_000,
            ..ParsingOptions::default()
        };
        let text = text.trim_start_matches('\u{feff}').trim_start();
        match Document::parse_with_options(text, options) {
            Ok(document) => Ok(Source { name, document }),
            Err(error) => Err(Error::Parse {
                file: name.to_owned(),
                cause: format!("no XML: {error}"),
            }),
        }
    }

    /// The root element, which must be a `<robot>`.
    pub fn robot(&self) -> Result<Node<'_, 'a>, Error> {
        let root = self.document.root_element();
        if root.tag_name().name() == "robot" {
            return Ok(root);
        }
        let found = root.tag_name().name();
        Err(self.refuse(
            root,
            format!("the root element is <{found}>, <robot> is wanted"),
        ))
    }

    /// An error at a node.
    pub fn refuse(&self, node: Node, cause: impl AsRef<str>) -> Error {
        let line = self.document.text_pos_at(node.range().start).row;
        Error::Parse {
            file: self.name.to_owned(),
            cause: format!("line {line}: {}", cause.as_ref()),
        }
    }

    /// A required attribute that is not empty.
    pub fn text<'n>(&self, node: Node<'n, '_>, attribute: &str) -> Result<&'n str, Error> {
        match node.attribute(attribute).map(str::trim) {
            Some(text) if !text.is_empty() => Ok(text),
            _ => {
                let tag = node.tag_name().name();
                Err(self.refuse(node, format!("<{tag}> has no attribute \"{attribute}\"")))
            }
        }
    }

    /// A finite number, or `None` where the attribute is absent.
    pub fn optional_number(&self, node: Node, attribute: &str) -> Result<Option<f64>, Error> {
        let Some(text) = node.attribute(attribute) else {
            return Ok(None);
        };
        match f64::from_str(text.trim()) {
            Ok(value) if value.is_finite() => Ok(Some(value)),
            _ => Err(self.refuse(node, format!("{attribute}=\"{text}\" is not a number"))),
        }
    }

    /// A required finite number.
    pub fn number(&self, node: Node, attribute: &str) -> Result<f64, Error> {
        self.text(node, attribute)?;
        Ok(self.optional_number(node, attribute)?.unwrap_or(0.0))
    }

    /// Three finite numbers, or `None` where the attribute is absent.
    pub fn optional_triple(&self, node: Node, attribute: &str) -> Result<Option<[f64; 3]>, Error> {
        let Some(text) = node.attribute(attribute) else {
            return Ok(None);
        };
        let mut values = text.split_whitespace().map(f64::from_str);
        match (values.next(), values.next(), values.next(), values.next()) {
            (Some(Ok(x)), Some(Ok(y)), Some(Ok(z)), None)
                if x.is_finite() && y.is_finite() && z.is_finite() =>
            {
                Ok(Some([x, y, z]))
            }
            _ => Err(self.refuse(node, format!("{attribute}=\"{text}\" is not three numbers"))),
        }
    }
}

/// The child elements of that tag.
pub(super) fn children<'a, 'input: 'a>(
    node: Node<'a, 'input>,
    tag: &'static str,
) -> impl Iterator<Item = Node<'a, 'input>> {
    node.children()
        .filter(move |child| child.is_element() && child.tag_name().name() == tag)
}

/// The first child element of that tag.
pub(super) fn child<'a, 'input: 'a>(
    node: Node<'a, 'input>,
    tag: &'static str,
) -> Option<Node<'a, 'input>> {
    children(node, tag).next()
}
