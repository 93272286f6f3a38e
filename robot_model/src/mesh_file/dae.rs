//! COLLADA: the triangles of a scene's geometry, in metres.
//!
//! Transforms of the scene's nodes and the asset's unit are applied. Its `up_axis` is not: in
//! robot descriptions the axes are the link's whatever the exporter wrote (RViz and Pinocchio
//! read them so, too).

use std::collections::HashMap;
use std::str::FromStr;

use nalgebra::{Matrix4, Point3, Rotation3, Unit, Vector3};
use roxmltree::{Document, Node};

use super::{TriangleMesh, check_count};
use crate::xml::{self, child, children};

/// Nodes nested deeper than this refer to themselves.
const GREATEST_DEPTH: usize = 64;
/// Nodes that instantiate others twice over, time and again, make more than this.
const GREATEST_NODES: usize = 100_000;

pub(super) fn parse(bytes: &[u8]) -> Result<TriangleMesh, String> {
    let text = std::str::from_utf8(bytes)
        .map_err(|error| format!("byte {} is no UTF-8 text", error.valid_up_to()))?;
    let document = xml::document(text)?;
    let by_id: HashMap<&str, Node> = document
        .descendants()
        .filter_map(|node| Some((node.attribute("id")?, node)))
        .collect();
    let mut reader = Reader {
        document: &document,
        by_id,
        nodes: 0,
        mesh: TriangleMesh::default(),
    };
    let root = document.root_element();
    let unit = child(root, "asset").and_then(|asset| child(asset, "unit"));
    let meter = unit
        .and_then(|n| n.attribute("meter"))
        .map_or(Ok(1.0), |text| {
            let value = f64::from_str(text.trim())
                .ok()
                .filter(|v| v.is_finite() && *v > 0.0);
            value.ok_or_else(|| format!("its unit of \"{text}\" metres is no length"))
        })?;
    let scale = Matrix4::new_scaling(meter);
    // The scene that is shown, or every geometry where there is none.
    let shown = child(root, "scene").and_then(|scene| child(scene, "instance_visual_scene"));
    match shown {
        Some(instance) => {
            let scene = reader.follow(instance, "url")?;
            reader.node(scene, &scale, 0)?;
        }
        None => {
            for library in children(root, "library_geometries") {
                for geometry in children(library, "geometry") {
                    reader.geometry(geometry, &scale)?;
                }
            }
        }
    }
    Ok(reader.mesh)
}

struct Reader<'a> {
    document: &'a Document<'a>,
    by_id: HashMap<&'a str, Node<'a, 'a>>,
    nodes: usize,
    mesh: TriangleMesh,
}

impl<'a> Reader<'a> {
    fn at(&self, node: Node, cause: &str) -> String {
        format!("line {}: {cause}", xml::line(self.document, node))
    }

    /// The element that a "#id" attribute refers to.
    fn follow(&self, node: Node, attribute: &str) -> Result<Node<'a, 'a>, String> {
        let reference = node.attribute(attribute).unwrap_or_default();
        let found = reference
            .strip_prefix('#')
            .and_then(|id| self.by_id.get(id))
            .copied();
        found.ok_or_else(|| self.at(node, &format!("{attribute}=\"{reference}\" leads nowhere")))
    }

    /// A scene or node, its children and what it instantiates.
    fn node(
        &mut self,
        node: Node<'a, 'a>,
        parent: &Matrix4<f64>,
        depth: usize,
    ) -> Result<(), String> {
        self.nodes += 1;
        if depth > GREATEST_DEPTH || self.nodes > GREATEST_NODES {
            return Err(self.at(node, "nodes refer to themselves or to too many others"));
        }
        // A node's transforms are multiplied as they come.
        let mut pose = *parent;
        for element in node.children().filter(Node::is_element) {
            let numbers = || self.numbers::<f64>(element);
            match element.tag_name().name() {
                "matrix" => {
                    let values = numbers()?;
                    if values.len() != 16 {
                        return Err(self.at(element, "a matrix has 16 numbers"));
                    }
                    pose *= Matrix4::from_row_slice(&values);
                }
                "translate" => pose *= Matrix4::new_translation(&self.triple(element)?),
                "scale" => pose *= Matrix4::new_nonuniform_scaling(&self.triple(element)?),
                "rotate" => {
                    let [x, y, z, degrees] = numbers()?
                        .try_into()
                        .map_err(|_: Vec<f64>| self.at(element, "a rotation has 4 numbers"))?;
                    if let Some(axis) = Unit::try_new(Vector3::new(x, y, z), 1e-12) {
                        pose *= Rotation3::from_axis_angle(&axis, degrees.to_radians())
                            .to_homogeneous();
                    }
                }
                "lookat" | "skew" => {
                    return Err(self.at(element, "<lookat> and <skew> are not read"));
                }
                "node" => self.node(element, &pose, depth + 1)?,
                "instance_node" => {
                    let other = self.follow(element, "url")?;
                    self.node(other, &pose, depth + 1)?;
                }
                "instance_geometry" => {
                    let geometry = self.follow(element, "url")?;
                    self.geometry(geometry, &pose)?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// A geometry's triangles, placed.
    fn geometry(&mut self, geometry: Node<'a, 'a>, pose: &Matrix4<f64>) -> Result<(), String> {
        let Some(mesh) = child(geometry, "mesh") else {
            return Ok(());
        };
        for element in mesh.children().filter(Node::is_element) {
            let tag = element.tag_name().name();
            if !["triangles", "polylist", "polygons", "tristrips", "trifans"].contains(&tag) {
                continue;
            }
            let Some((source, offset, stride)) = self.positions(element)? else {
                continue;
            };
            let positions = self.points(source)?;
            let first = self.mesh.vertices.len();
            check_count("vertices", first + positions.len())?;
            for p in &positions {
                let placed = pose.transform_point(p);
                if !placed.iter().all(|c| c.is_finite()) {
                    return Err(self.at(source, "a position is not finite"));
                }
                self.mesh.vertices.push(placed);
            }
            let count = positions.len();
            let corner = |corners: &[u32], i: usize| -> Result<u32, String> {
                match corners.get(i * stride + offset) {
                    Some(&number) if (number as usize) < count => Ok(first as u32 + number),
                    Some(number) => {
                        let cause = format!("there is no position {number} among the {count}");
                        Err(self.at(element, &cause))
                    }
                    None => Err(self.at(element, "its <p> ends too early")),
                }
            };
            let mut triangles = Vec::new();
            for (list, faces) in self.faces(element, tag, stride)? {
                for [a, b, c] in faces {
                    triangles.push([corner(&list, a)?, corner(&list, b)?, corner(&list, c)?]);
                }
                check_count("triangles", self.mesh.triangles.len() + triangles.len())?;
            }
            self.mesh.triangles.append(&mut triangles);
        }
        Ok(())
    }

    /// Where a primitive's positions come from: their `<source>`, the place of their numbers
    /// among a corner's, how many numbers a corner has.
    fn positions(
        &self,
        primitive: Node<'a, 'a>,
    ) -> Result<Option<(Node<'a, 'a>, usize, usize)>, String> {
        let mut vertex = None;
        let mut stride = 1;
        for input in children(primitive, "input") {
            let offset = input.attribute("offset").unwrap_or("0").trim();
            // No primitive has more inputs than a few.
            let offset = usize::from_str(offset).ok().filter(|o| *o < 64);
            let offset = offset.ok_or_else(|| self.at(input, "its offset is no small number"))?;
            stride = stride.max(offset + 1);
            if input.attribute("semantic") == Some("VERTEX") {
                vertex = Some((input, offset));
            }
        }
        let Some((input, offset)) = vertex else {
            return Ok(None);
        };
        let vertices = self.follow(input, "source")?;
        let position =
            children(vertices, "input").find(|n| n.attribute("semantic") == Some("POSITION"));
        let position = position.ok_or_else(|| self.at(vertices, "there is no POSITION input"))?;
        Ok(Some((self.follow(position, "source")?, offset, stride)))
    }

    /// The points of a `<source>`.
    fn points(&self, source: Node<'a, 'a>) -> Result<Vec<Point3<f64>>, String> {
        let array = child(source, "float_array")
            .ok_or_else(|| self.at(source, "there is no <float_array>"))?;
        let values = self.numbers::<f64>(array)?;
        let accessor = child(source, "technique_common").and_then(|t| child(t, "accessor"));
        let stated = |name: &str| {
            let text = accessor.and_then(|n| n.attribute(name))?;
            usize::from_str(text.trim()).ok()
        };
        let stride = stated("stride").unwrap_or(3);
        if stride < 3 {
            return Err(self.at(source, "a position has three coordinates"));
        }
        let start = stated("offset").unwrap_or(0).min(values.len());
        Ok(values[start..]
            .chunks_exact(stride)
            .map(|v| Point3::new(v[0], v[1], v[2]))
            .collect())
    }

    /// Each `<p>` of a primitive with its triangles as triples of corners in it.
    #[allow(clippy::type_complexity)]
    fn faces(
        &self,
        primitive: Node<'a, 'a>,
        tag: &str,
        stride: usize,
    ) -> Result<Vec<(Vec<u32>, Vec<[usize; 3]>)>, String> {
        let lists = children(primitive, "p").map(|p| self.numbers::<u32>(p));
        let fan = |start: usize, n: usize| {
            (1..n.saturating_sub(1)).map(move |i| [start, start + i, start + i + 1])
        };
        let mut all = Vec::new();
        for list in lists {
            let list = list?;
            let corners = list.len() / stride;
            let faces = match tag {
                "triangles" => (0..corners / 3)
                    .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
                    .collect(),
                "polylist" => {
                    let counts = child(primitive, "vcount")
                        .ok_or_else(|| self.at(primitive, "there is no <vcount>"))?;
                    let mut faces = Vec::new();
                    let mut start = 0_usize;
                    for n in self.numbers::<u32>(counts)? {
                        let end = start + n as usize;
                        if end > corners {
                            return Err(self.at(counts, "it counts more corners than there are"));
                        }
                        faces.extend(fan(start, n as usize));
                        start = end;
                    }
                    faces
                }
                "tristrips" => (0..corners.saturating_sub(2))
                    .map(|i| {
                        if i % 2 == 0 {
                            [i, i + 1, i + 2]
                        } else {
                            [i + 1, i, i + 2]
                        }
                    })
                    .collect(),
                // A polygon, or a fan.
                _ => fan(0, corners).collect(),
            };
            all.push((list, faces));
        }
        Ok(all)
    }

    fn numbers<T: FromStr>(&self, node: Node) -> Result<Vec<T>, String> {
        let words = node.text().unwrap_or_default().split_ascii_whitespace();
        words
            .map(|word| {
                T::from_str(word).map_err(|_| self.at(node, &format!("\"{word}\" is no number")))
            })
            .collect()
    }

    fn triple(&self, node: Node) -> Result<Vector3<f64>, String> {
        match self.numbers::<f64>(node)?.as_slice() {
            &[x, y, z] => Ok(Vector3::new(x, y, z)),
            _ => Err(self.at(node, "three numbers are wanted")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quad and a triangle, turned by 90° about z, lifted by 1, in millimetres.
    const SCENE: &str = r##"<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema">
      <asset><unit meter="0.001"/><up_axis>Y_UP</up_axis></asset>
      <library_geometries><geometry id="g"><mesh>
        <source id="s"><float_array id="a" count="12">0 0 0 1 0 0 1 1 0 0 1 0</float_array>
          <technique_common><accessor source="#a" count="4" stride="3"/></technique_common></source>
        <vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
        <polylist count="1"><input semantic="VERTEX" source="#v" offset="0"/>
          <input semantic="NORMAL" source="#s" offset="1"/>
          <vcount>4</vcount><p>0 0 1 0 2 0 3 0</p></polylist>
        <triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
      </mesh></geometry></library_geometries>
      <library_visual_scenes><visual_scene id="w"><node>
        <translate>0 0 1</translate><rotate>0 0 1 90</rotate><instance_geometry url="#g"/>
      </node></visual_scene></library_visual_scenes>
      <scene><instance_visual_scene url="#w"/></scene></COLLADA>"##;

    #[test]
    fn scenes_are_placed_and_scaled() {
        let mesh = parse(SCENE.as_bytes()).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [4, 5, 6]]);
        let second = mesh.vertices[1];
        assert!(
            (second - Point3::new(0.0, 0.001, 0.001)).norm() < 1e-15,
            "{second}"
        );
    }

    #[test]
    fn what_does_not_hold_together_is_refused() {
        for (from, to, cause) in [
            ("0 1 2</p>", "0 1 4</p>", "no position 4"),
            ("<vcount>4", "<vcount>5", "more corners"),
            ("url=\"#g\"", "url=\"#h\"", "leads nowhere"),
            (
                "<instance_geometry url=\"#g\"/>",
                "<instance_node url=\"#w\"/>",
                "themselves",
            ),
            (
                "0 1 0</float_array>",
                "0 1 x</float_array>",
                "\"x\" is no number",
            ),
            ("meter=\"0.001\"", "meter=\"-1\"", "no length"),
        ] {
            assert!(SCENE.contains(from), "{from}");
            let error = parse(SCENE.replace(from, to).as_bytes()).unwrap_err();
            assert!(error.contains(cause), "{to}: {error}");
        }
    }
}
