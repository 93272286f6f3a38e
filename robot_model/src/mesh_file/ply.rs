//! PLY (ascii, binary little and big endian): vertices and faces; polygons become fans.

use nalgebra::Point3;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult, PropertyType};

use super::{TriangleMesh, check_count};

/// The names that the corners of a face go by.
const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];

pub(super) fn parse(bytes: &[u8]) -> Result<TriangleMesh, String> {
    let parser = Parser::<Element>::new();
    let mut reader = Reader::new(bytes);
    let header = parser.read_header(&mut reader).map_err(|e| e.to_string())?;
    let has = |element: &str, property: &str| {
        let element = header.elements.get(element);
        element.and_then(|e| e.properties.get(property).map(|p| &p.data_type))
    };
    for axis in ["x", "y", "z"] {
        if !matches!(has("vertex", axis), Some(PropertyType::Scalar(_))) {
            return Err(format!("element vertex has no scalar {axis}"));
        }
    }
    let lists = |name: &str| matches!(has("face", name), Some(PropertyType::List(..)));
    if !CORNERS.into_iter().any(lists) {
        let names = CORNERS.join(" or ");
        return Err(format!(
            "element face has no list {names}: are these points alone?"
        ));
    }
    let (mut mesh, mut faces) = (TriangleMesh::default(), Vec::new());
    for element in header.elements.values() {
        let (name, count) = (&element.name, element.count);
        if count > bytes.len() {
            let there = bytes.len();
            return Err(format!(
                "element {name}: {count} of them cannot be in {there} bytes"
            ));
        }
        check_count(name, count)?;
        let read = parser.read_payload_for_element(&mut reader, element, &header);
        let read = read.map_err(|e| format!("element {name}: {e}"))?;
        match name.as_str() {
            "vertex" => mesh.vertices = read.into_iter().map(|e| e.p.into()).collect(),
            "face" => faces = read,
            _ => {}
        }
    }
    let is_finite = |p: &Point3<f64>| p.iter().all(|x| x.is_finite());
    if let Some(k) = mesh.vertices.iter().position(|p| !is_finite(p)) {
        return Err(format!("vertex {k} has no three finite coordinates"));
    }
    for (number, face) in faces.iter().enumerate() {
        let known = |corner: &i64| {
            u32::try_from(*corner)
                .ok()
                .filter(|&k| (k as usize) < mesh.vertices.len())
        };
        let corners: Option<Vec<u32>> = face.corners.iter().map(known).collect();
        let corners =
            corners.ok_or_else(|| format!("face {number} has a corner that is no vertex"))?;
        mesh.add_face(&corners)
            .map_err(|cause| format!("face {number}: {cause}"))?;
    }
    Ok(mesh)
}

/// A vertex or a face; what else it has is not stored.
struct Element {
    p: [f64; 3],
    corners: Vec<i64>,
}

impl Element {
    fn list<T: Into<i64>>(&mut self, name: &str, corners: Vec<T>) -> PropertyAccessResult {
        if !CORNERS.contains(&name) {
            return PropertyAccessResult::Ignored;
        }
        self.corners = corners.into_iter().map(Into::into).collect();
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Element {
    fn new() -> Self {
        Self {
            p: [f64::NAN; 3],
            corners: Vec::new(),
        }
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
            Property::ListChar(x) => return self.list(name, x),
            Property::ListUChar(x) => return self.list(name, x),
            Property::ListShort(x) => return self.list(name, x),
            Property::ListUShort(x) => return self.list(name, x),
            Property::ListInt(x) => return self.list(name, x),
            Property::ListUInt(x) => return self.list(name, x),
            _ => return PropertyAccessResult::Ignored,
        };
        match ["x", "y", "z"].iter().position(|axis| *axis == name) {
            Some(axis) => self.p[axis] = value,
            None => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "ply\nformat ascii 1.0\ncomment a square\nelement vertex 4\nproperty float x\n\
                          property double y\nproperty float z\nproperty uchar red\nelement face 1\n\
                          property list uchar int vertex_indices\nend_header\n";
    const SQUARE: &str = "0 0 0 255\n1 0 0 255\n1 1 0 255\n0 1 0 255\n";

    #[test]
    fn a_polygon_is_read_in_text_and_in_bytes() {
        let mesh = parse(format!("{HEADER}{SQUARE}4 0 1 2 3\n").as_bytes()).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(mesh.vertices[2], Point3::new(1.0, 1.0, 0.0));
        let mut bytes = HEADER.replace("ascii", "binary_little_endian").into_bytes();
        for [x, y] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0_f32]] {
            bytes.extend(x.to_le_bytes());
            bytes.extend(f64::from(y).to_le_bytes());
            bytes.extend([0, 0, 0, 0, 255]);
        }
        bytes.push(4);
        bytes.extend([0, 1, 2, 3_i32].iter().flat_map(|k| k.to_le_bytes()));
        assert_eq!(parse(&bytes).unwrap(), mesh);
        assert!(parse(&bytes[..bytes.len() - 1]).is_err());
    }

    #[test]
    fn what_is_no_mesh_is_told() {
        let told = |text: String| parse(text.as_bytes()).unwrap_err();
        let faces = |face: &str| told(format!("{HEADER}{SQUARE}{face}\n"));
        assert!(faces("3 0 1 4").contains("face 0 has a corner that is no vertex"));
        assert!(faces("3 0 1 -1").contains("no vertex"));
        assert!(faces("0").contains("no corners"));
        let points = HEADER.replace("vertex_indices", "neighbours");
        assert!(told(points).contains("points alone"));
        let many = HEADER.replace("face 1", "face 99999999999");
        let many = format!("{many}{SQUARE}3 0 1 2\n");
        assert!(told(many).contains("99999999999 of them"));
    }
}
