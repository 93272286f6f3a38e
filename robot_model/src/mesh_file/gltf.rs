//! glTF 2.0, packed (.glb) or text with its buffers inside: the triangles of the scene that is shown, in metres, y up.
//!
//! The crate `gltf` reads the text. It is checked here, since the crate's own checks panic on some of what they are for,
//! and buffers are held against the bytes that are there.

use base64ct::{Base64, Encoding};
use gltf::Gltf;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::scene::Node;
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Index, Root};
use nalgebra::{Matrix4, Point3, Quaternion, UnitQuaternion, Vector3};

use super::{GREATEST_DEPTH, GREATEST_NODES, TriangleMesh, check_count};

/// The header of a packed file and of its first part, bytes.
const LEAST_PACKED: u32 = 20;

pub(super) fn parse(bytes: &[u8]) -> Result<TriangleMesh, String> {
    if bytes.starts_with(b"glTF") {
        let length = bytes.get(8..12).and_then(|b| b.try_into().ok());
        if length.is_none_or(|length| u32::from_le_bytes(length) < LEAST_PACKED) {
            return Err("its header ends in the middle".to_owned());
        }
    }
    let read = Gltf::from_slice_without_validation(bytes).map_err(|error| error.to_string())?;
    let (root, mut blob) = (read.document.into_json(), read.blob);
    // Compression and whole numbers for coordinates; others are of looks.
    if let Some(packed) = root
        .extensions_required
        .iter()
        .find(|name| name.contains("mesh"))
    {
        return Err(format!(
            "\"{packed}\" is not read: save it without compression of meshes"
        ));
    }
    let buffers = root.buffers.iter().enumerate();
    let buffers = buffers.map(|(number, buffer)| match &buffer.uri {
        None => (blob.take()).ok_or_else(|| format!("buffer {number} is not in the file")),
        Some(uri) => embedded(uri).map_err(|cause| format!("buffer {number}: {cause}")),
    });
    let mut reader = Reader {
        buffers: buffers.collect::<Result<_, _>>()?,
        root: &root,
        nodes: 0,
        mesh: TriangleMesh {
            R_up: UnitQuaternion::from_euler_angles(std::f64::consts::FRAC_PI_2, 0.0, 0.0),
            ..TriangleMesh::default()
        },
    };
    let shown = root.scene.and_then(|scene| root.get(scene));
    match shown.or(root.scenes.first()) {
        Some(scene) => {
            for &node in &scene.nodes {
                reader.node(node, &Matrix4::identity(), 0)?;
            }
        }
        None => {
            for mesh in 0..root.meshes.len() {
                reader.mesh(mesh, &Matrix4::identity())?;
            }
        }
    }
    Ok(reader.mesh)
}

/// The bytes of a "data:" address.
fn embedded(uri: &str) -> Result<Vec<u8>, String> {
    let data = uri
        .strip_prefix("data:")
        .and_then(|rest| rest.split_once(";base64,"));
    let (_, data) = data.ok_or_else(|| {
        let name: String = uri.chars().take(80).collect();
        format!("\"{name}\" lies in another file: save it as one file (.glb)")
    })?;
    Base64::decode_vec(data).map_err(|_| "its base64 is broken".to_owned())
}

struct Reader<'a> {
    root: &'a Root,
    buffers: Vec<Vec<u8>>,
    nodes: usize,
    mesh: TriangleMesh,
}

impl Reader<'_> {
    /// A node's mesh and its children.
    fn node(
        &mut self,
        index: Index<Node>,
        parent: &Matrix4<f64>,
        depth: usize,
    ) -> Result<(), String> {
        self.nodes += 1;
        if depth > GREATEST_DEPTH || self.nodes > GREATEST_NODES {
            return Err("nodes refer to themselves or to too many others".to_owned());
        }
        let root = self.root;
        let node = root
            .get(index)
            .ok_or_else(|| format!("node {index} is missing"))?;
        let pose = parent * local(node);
        if let Some(mesh) = node.mesh {
            self.mesh(mesh.value(), &pose)?;
        }
        for &child in node.children.iter().flatten() {
            self.node(child, &pose, depth + 1)?;
        }
        Ok(())
    }

    /// A mesh's triangles, placed.
    fn mesh(&mut self, number: usize, pose: &Matrix4<f64>) -> Result<(), String> {
        let root = self.root;
        let mesh = root.meshes.get(number);
        let mesh = mesh.ok_or_else(|| format!("mesh {number} is missing"))?;
        for (k, primitive) in mesh.primitives.iter().enumerate() {
            (self.primitive(primitive, pose))
                .map_err(|cause| format!("mesh {number}, primitive {k}: {cause}"))?;
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: &Primitive, pose: &Matrix4<f64>) -> Result<(), String> {
        let Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) =
            primitive.mode
        else {
            return Ok(());
        };
        let positions = primitive
            .attributes
            .get(&Checked::Valid(Semantic::Positions));
        let positions = positions.ok_or("it has no positions")?;
        let points = self.elements(*positions, Type::Vec3)?;
        let (first, count) = (self.mesh.vertices.len(), points.len());
        check_count("vertices", first + count)?;
        for (k, p) in points.into_iter().enumerate() {
            let placed = pose.transform_point(&Point3::from(p));
            if placed.iter().any(|x| !x.is_finite()) {
                return Err(format!("vertex {k} has no three finite coordinates"));
            }
            self.mesh.vertices.push(placed);
        }
        let corners: Vec<u32> = match primitive.indices {
            None => (0..count as u32).collect(),
            Some(indices) => (self.elements(indices, Type::Scalar)?.iter())
                .map(|[k, ..]| *k as u32)
                .collect(),
        };
        if let Some(unknown) = corners.iter().find(|&&k| k as usize >= count) {
            return Err(format!("corner {unknown} is no vertex: there are {count}"));
        }
        let mirrored = pose.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
        let mut add = |[a, b, c]: [u32; 3], turned: bool| {
            let corners = if turned == mirrored {
                [a, b, c]
            } else {
                [a, c, b]
            };
            self.mesh.triangles.push(corners.map(|k| first as u32 + k));
        };
        match mode {
            Mode::TriangleStrip => (corners.windows(3).enumerate())
                .for_each(|(k, t)| add([t[0], t[1], t[2]], k % 2 == 1)),
            Mode::TriangleFan => corners
                .get(1..)
                .unwrap_or_default()
                .windows(2)
                .for_each(|t| add([corners[0], t[0], t[1]], false)),
            _ => (corners.chunks_exact(3)).for_each(|t| add([t[0], t[1], t[2]], false)),
        }
        check_count("triangles", self.mesh.triangles.len())
    }

    /// The values of an accessor, up to three each.
    fn elements(&self, index: Index<Accessor>, expected: Type) -> Result<Vec<[f64; 3]>, String> {
        let fail = |cause: &str| format!("accessor {index} {cause}");
        let accessor = self.root.get(index).ok_or_else(|| fail("is missing"))?;
        if accessor.sparse.is_some() {
            return Err(fail("is sparse, which is not read"));
        }
        let (Checked::Valid(kind), Checked::Valid(component)) =
            (accessor.type_, accessor.component_type)
        else {
            return Err(fail("has no known type"));
        };
        let read: fn(&[u8]) -> f64 = match (component.0, expected) {
            (ComponentType::F32, Type::Vec3) => {
                |b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            }
            (ComponentType::U8, Type::Scalar) => |b| f64::from(b[0]),
            (ComponentType::U16, Type::Scalar) => |b| f64::from(u16::from_le_bytes([b[0], b[1]])),
            (ComponentType::U32, Type::Scalar) => {
                |b| f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            }
            _ => {
                return Err(fail(
                    "has components of another kind: positions are floats, corners whole numbers",
                ));
            }
        };
        if kind != expected {
            return Err(fail("has another number of components"));
        }
        let (width, parts) = (component.0.size(), expected.multiplicity());
        let view = accessor.buffer_view.and_then(|view| self.root.get(view));
        let view = view.ok_or_else(|| fail("refers to no buffer"))?;
        let start =
            |offset: Option<gltf::json::validation::USize64>| offset.map_or(0, |offset| offset.0);
        let buffer = self
            .buffers
            .get(view.buffer.value())
            .map_or(&[][..], Vec::as_slice);
        let range = || {
            let first = usize::try_from(start(view.byte_offset)).ok()?;
            let end = first.checked_add(usize::try_from(view.byte_length.0).ok()?)?;
            buffer
                .get(first..end)?
                .get(usize::try_from(start(accessor.byte_offset)).ok()?..)
        };
        let bytes = range().ok_or_else(|| fail("begins behind its buffer's end"))?;
        let size = width * parts;
        let stride = view.byte_stride.map_or(size, |stride| stride.0);
        let count = usize::try_from(accessor.count.0).unwrap_or(usize::MAX);
        if stride < size {
            return Err(fail(&format!(
                "has elements of {size} bytes, one in {stride}"
            )));
        }
        // Behind the last element there need be no gap.
        let more = bytes.len().checked_sub(size);
        let fitting = more.map_or(0, |more| more / stride + 1);
        if count > fitting {
            return Err(fail(&format!("has {count} elements, its buffer {fitting}")));
        }
        let element = |k: usize| {
            let mut values = [0.0; 3];
            for (part, value) in values.iter_mut().take(parts).enumerate() {
                *value = read(&bytes[k * stride + part * width..]);
            }
            values
        };
        Ok((0..count).map(element).collect())
    }
}

/// A node's pose in its parent.
fn local(node: &Node) -> Matrix4<f64> {
    if let Some(columns) = node.matrix {
        return Matrix4::from_iterator(columns.map(f64::from));
    }
    let triple = |values: Option<[f32; 3]>, fallback: f32| {
        Vector3::from(values.unwrap_or([fallback; 3])).cast::<f64>()
    };
    let [x, y, z, w] = node
        .rotation
        .map_or([0.0, 0.0, 0.0, 1.0], |q| q.0)
        .map(f64::from);
    let turn = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-12).unwrap_or_default();
    Matrix4::new_translation(&triple(node.translation, 0.0))
        * turn.to_homogeneous()
        * Matrix4::new_nonuniform_scaling(&triple(node.scale, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square as two triangles, corners with a gap of four bytes between them, on a node that is moved and mirrored.
    fn text(change: impl Fn(String) -> String) -> String {
        let mut data = Vec::new();
        for [x, y] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0_f32]] {
            data.extend([x, y, 0.0, f32::NAN].iter().flat_map(|v| v.to_le_bytes()));
        }
        data.extend([0_u16, 1, 2, 0, 2, 3].iter().flat_map(|k| k.to_le_bytes()));
        let data = Base64::encode_string(&data);
        change(format!(
            r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [1]}}],
"nodes": [{{"mesh": 0, "scale": [-2, 1, 1]}}, {{"children": [0], "translation": [0, 0, 3]}}],
"meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1}}]}}],
"accessors": [{{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}},
  {{"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}}],
"bufferViews": [{{"buffer": 0, "byteLength": 64, "byteStride": 16}}, {{"buffer": 0, "byteOffset": 64, "byteLength": 12}}],
"buffers": [{{"byteLength": 76, "uri": "data:application/octet-stream;base64,{data}"}}]}}"#
        ))
    }

    fn packed(json: &str, binary: &[u8]) -> Vec<u8> {
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        let json = format!("{json}{}", " ".repeat((4 - json.len() % 4) % 4));
        bytes.extend((28 + json.len() as u32 + binary.len() as u32).to_le_bytes());
        for (kind, part) in [(b"JSON", json.as_bytes()), (b"BIN\0", binary)] {
            bytes.extend((part.len() as u32).to_le_bytes());
            bytes.extend(kind);
            bytes.extend(part);
        }
        bytes
    }

    #[test]
    fn a_square_is_placed_by_its_nodes_and_keeps_its_front() {
        let mesh = parse(text(|text| text).as_bytes()).unwrap();
        assert_eq!(mesh.vertices[2], Point3::new(-2.0, 1.0, 3.0));
        // Mirrored, it would face down.
        assert_eq!(mesh.triangles, [[0, 2, 1], [0, 3, 2]]);
        assert!((mesh.R_up * Vector3::y() - Vector3::z()).norm() < 1e-12);
    }

    #[test]
    fn a_packed_file_is_read_as_its_text() {
        let plain = text(|text| text);
        let (start, end) = (
            plain.find(",\"uri\"").or(plain.find(", \"uri\"")).unwrap(),
            plain.rfind('"').unwrap(),
        );
        let data = plain[..end].rsplit_once("base64,").unwrap().1;
        let binary = Base64::decode_vec(data).unwrap();
        let json = format!("{}{}", &plain[..start], &plain[end + 1..]);
        let bytes = packed(&json, &binary);
        assert_eq!(parse(&bytes).unwrap(), parse(plain.as_bytes()).unwrap());
        for end in 0..bytes.len() {
            assert!(parse(&bytes[..end]).is_err(), "cut to {end} bytes");
        }
    }

    #[test]
    fn what_is_broken_or_not_read_is_told() {
        let told = |from: &str, to: &str| {
            let edited = text(|text| {
                assert!(text.contains(from), "{from}");
                text.replace(from, to)
            });
            parse(edited.as_bytes()).unwrap_err()
        };
        assert!(told("\"count\": 6", "\"count\": 60").contains("has 60 elements, its buffer 6"));
        assert!(
            told("\"byteOffset\": 64", "\"byteOffset\": 70").contains("behind its buffer's end")
        );
        assert!(told("\"byteStride\": 16", "\"byteStride\": 8").contains("elements"));
        let endless = format!("\"byteStride\": {}", usize::MAX);
        assert!(told("\"byteStride\": 16", &endless).contains("has 4 elements, its buffer 1"));
        assert!(told("5123", "5126").contains("another kind"));
        assert!(told("data:application", "https://application").contains("another file"));
        assert!(told("\"children\": [0]", "\"children\": [1]").contains("refer to themselves"));
        assert!(told("\"mesh\": 0", "\"mesh\": 7").contains("mesh"));
        let required = "\"extensionsRequired\": [\"KHR_draco_mesh_compression\"], \"scene\": 0";
        assert!(told("\"scene\": 0", required).contains("without compression"));
    }
}
