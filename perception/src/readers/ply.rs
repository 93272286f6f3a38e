//! PLY (ascii, binary little and big endian) → points.

use std::path::Path;

use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType,
    ScalarType,
};

use super::tidy;
use crate::Error;
use crate::scan::PointCloud;

const FORMAT: &str = "PLY";

/// The vertices, in V; elements after them are not read.
///
/// # Errors
/// [`Error::File`] naming the element whose count contradicts the file's length or that lacks a
/// coordinate, and for anything else that is not PLY.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<PointCloud, Error> {
    let parser = Parser::<Xyz>::new();
    let mut reader = Reader::new(bytes);
    let header = parser
        .read_header(&mut reader)
        .map_err(|e| Error::parse(path, FORMAT, e))?;
    check(path, &header, reader.get_ref().len())?;
    let mut vertices = Vec::new();
    for element in header.elements.values() {
        vertices = match header.encoding {
            // The crate's grammar has no NaN; ours splits at white space.
            Encoding::Ascii => ascii_element(path, reader.get_mut(), element)?,
            _ => parser
                .read_payload_for_element(&mut reader, element, &header)
                .map_err(|e| Error::parse(path, FORMAT, e))?,
        };
        if element.name == "vertex" {
            break;
        }
    }
    Ok(tidy(vertices.into_iter().map(|v| v.0).collect(), None))
}

/// Checks that the vertices have coordinates and that no count promises more than is there.
fn check(path: &Path, header: &Header, there: usize) -> Result<(), Error> {
    let fail = |field: String, cause: String| Err(Error::field(path, field, cause));
    let Some(vertex) = header.elements.get("vertex") else {
        return fail("element vertex".to_owned(), "is missing".to_owned());
    };
    for axis in ["x", "y", "z"] {
        match vertex.properties.get(axis).map(|p| &p.data_type) {
            Some(PropertyType::Scalar(_)) => {}
            _ => return fail("element vertex".to_owned(), format!("has no scalar {axis}")),
        }
    }
    for element in header.elements.values() {
        // The least that one element takes: a list may be empty but has a length; an ascii value
        // takes a digit and a separator (the last line may lack its end).
        let least: usize = element
            .properties
            .values()
            .map(|p| match (header.encoding, &p.data_type) {
                (Encoding::Ascii, _) => 2,
                (_, PropertyType::Scalar(scalar) | PropertyType::List(scalar, _)) => size(scalar),
            })
            .sum();
        let needed = element.count.checked_mul(least.max(1));
        if needed.is_none_or(|bytes| bytes > there + 1) {
            let cause = format!("{} of them cannot be in {there} bytes", element.count);
            return fail(format!("element {}", element.name), cause);
        }
        if element.name == "vertex" {
            break;
        }
    }
    Ok(())
}

fn size(scalar: &ScalarType) -> usize {
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

/// All lines of one element, from the front of `rest`.
fn ascii_element(path: &Path, rest: &mut &[u8], element: &ElementDef) -> Result<Vec<Xyz>, Error> {
    let name = format!("element {}", element.name);
    let mut vertices = Vec::with_capacity(element.count);
    for i in 0..element.count {
        if rest.is_empty() {
            let cause = format!("{} lines stated, {i} found", element.count);
            return Err(Error::field(path, name, cause));
        }
        let end = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        let (line, tail) = rest.split_at(end);
        *rest = tail.get(1..).unwrap_or(&[]);
        let bad = || {
            let cause = format!("line {} does not hold its properties", i + 1);
            Error::field(path, name.clone(), cause)
        };
        let line = std::str::from_utf8(line).map_err(|_| bad())?;
        vertices.push(ascii_line(line, element).ok_or_else(bad)?);
    }
    Ok(vertices)
}

/// One line's coordinates; `None` if it is short or not a number where one is needed.
fn ascii_line(line: &str, element: &ElementDef) -> Option<Xyz> {
    let mut tokens = line.split_ascii_whitespace();
    let mut vertex = Xyz::new();
    for (name, property) in &element.properties {
        let token = tokens.next()?;
        match property.data_type {
            PropertyType::Scalar(_) if matches!(name.as_str(), "x" | "y" | "z") => {
                vertex.set(name, token.parse().ok()?);
            }
            PropertyType::Scalar(_) => {}
            PropertyType::List(..) => {
                for _ in 0..token.parse::<usize>().ok()? {
                    tokens.next()?;
                }
            }
        }
    }
    Some(vertex)
}

/// The coordinates of one vertex; its other properties are not stored.
struct Xyz([f32; 3]);

impl Xyz {
    fn set(&mut self, name: &str, value: f64) {
        match name {
            "x" => self.0[0] = value as f32,
            "y" => self.0[1] = value as f32,
            "z" => self.0[2] = value as f32,
            _ => {}
        }
    }
}

impl PropertyAccess for Xyz {
    fn new() -> Self {
        Self([f32::NAN; 3])
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let value = match property {
            Property::Char(x) => f64::from(x),
            Property::UChar(x) => f64::from(x),
            Property::Short(x) => f64::from(x),
            Property::UShort(x) => f64::from(x),
            Property::Int(x) => f64::from(x),
            Property::UInt(x) => f64::from(x),
            Property::Float(x) => f64::from(x),
            Property::Double(x) => x,
            _ => return PropertyAccessResult::Ignored,
        };
        self.set(name, value);
        PropertyAccessResult::Set
    }
}
