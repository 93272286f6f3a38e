//! Reading attributes out of an XML file, with the line in every complaint.

use std::str::FromStr;

use roxmltree::{Document, Node, ParsingOptions};

use crate::{Error, GREATEST_M};

/// Attributes that hold lengths, m.
const LENGTHS: [&str; 4] = ["xyz", "size", "radius", "length"];

/// The root element of MuJoCo's format.
const MJCF: &str = "mujoco";

/// Whether a text is MuJoCo's format.
pub fn is_mjcf(text: &str) -> bool {
    document(text).is_ok_and(|document| document.root_element().tag_name().name() == MJCF)
}

/// An XML file (or embedded text) by the name it is complained about under.
pub(crate) struct Source<'a> {
    pub name: &'a str,
    pub document: Document<'a>,
    /// Where its lines end, in bytes.
    line_ends: Vec<usize>,
}

impl<'a> Source<'a> {
    /// Parses `text`.
    ///
    /// # Errors
    /// [`Error::File`] when it is no well-formed XML.
    pub fn parse(name: &'a str, text: &'a str) -> Result<Self, Error> {
        let document = document(text).map_err(|cause| Error::file(name, cause))?;
        let ends = document.input_text().match_indices('\n');
        let line_ends = ends.map(|(at, _)| at).collect();
        Ok(Source {
            name,
            document,
            line_ends,
        })
    }

    /// The root element, which must be a `<robot>`.
    pub fn robot(&self) -> Result<Node<'_, 'a>, Error> {
        let root = self.document.root_element();
        if root.tag_name().name() == "robot" {
            return Ok(root);
        }
        let found = root.tag_name().name();
        if found == MJCF {
            let cause = "this is MJCF, MuJoCo's format, which a program built with MuJoCo reads \
                         (`cargo build --release --features mujoco`)";
            return Err(self.refuse(root, cause));
        }
        Err(self.refuse(
            root,
            format!("the root element is <{found}>, <robot> is wanted"),
        ))
    }

    /// The line that a node begins on.
    pub fn line(&self, node: Node) -> u32 {
        let above = (self.line_ends).partition_point(|end| *end < node.range().start);
        above as u32 + 1
    }

    /// An error at a node.
    pub fn refuse(&self, node: Node, cause: impl AsRef<str>) -> Error {
        let cause = format!("line {}: {}", self.line(node), cause.as_ref());
        Error::file(self.name, cause)
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

    /// The text of an attribute that holds `count` finite numbers, lengths up to [`GREATEST_M`], or
    /// `None` where it is absent.
    pub fn numbers<'n>(
        &self,
        node: Node<'n, '_>,
        attribute: &str,
        count: usize,
    ) -> Result<Option<&'n str>, Error> {
        let Some(text) = node.attribute(attribute) else {
            return Ok(None);
        };
        let most = match LENGTHS.contains(&attribute) {
            true => GREATEST_M,
            false => f64::MAX,
        };
        let mut words = text.split_whitespace().map(f64::from_str);
        let numbers = words.by_ref().take(count);
        let fine = numbers.filter(|word| matches!(word, Ok(v) if v.abs() <= most));
        if fine.count() == count && words.next().is_none() {
            return Ok(Some(text.trim()));
        }
        let wanted = match count {
            1 => "a number".to_owned(),
            3 => "three numbers".to_owned(),
            more => format!("{more} numbers"),
        };
        let bound = match most < f64::MAX {
            true => format!(" up to {most} m"),
            false => String::new(),
        };
        Err(self.refuse(
            node,
            format!("{attribute}=\"{text}\" is not {wanted}{bound}"),
        ))
    }
}

/// Parses a document of a size that robots and their meshes have.
///
/// # Errors
/// What is wrong where it is no well-formed XML.
pub(crate) fn document(text: &str) -> Result<Document<'_>, String> {
    // Files of robots stay far below this; a bomb does not.
    let options = ParsingOptions {
        nodes_limit: 4_000_000,
        ..ParsingOptions::default()
    };
    let text = text.trim_start_matches('\u{feff}').trim_start();
    Document::parse_with_options(text, options).map_err(|error| format!("no XML: {error}"))
}

/// The line that a node begins on.
pub(crate) fn line(document: &Document, node: Node) -> u32 {
    document.text_pos_at(node.range().start).row
}

/// The child elements of that tag.
pub(crate) fn children<'a, 'input: 'a>(
    node: Node<'a, 'input>,
    tag: &'static str,
) -> impl Iterator<Item = Node<'a, 'input>> {
    node.children()
        .filter(move |child| child.is_element() && child.tag_name().name() == tag)
}

/// The first child element of that tag.
pub(crate) fn child<'a, 'input: 'a>(
    node: Node<'a, 'input>,
    tag: &'static str,
) -> Option<Node<'a, 'input>> {
    children(node, tag).next()
}
