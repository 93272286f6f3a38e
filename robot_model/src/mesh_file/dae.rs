//! COLLADA: the triangles of a scene's geometry, in metres.
//!
//! Transforms of the scene's nodes and the asset's unit are applied. Its `up_axis` is only told: in most
//! robot descriptions the axes are the link's whatever the exporter wrote (RViz and Pinocchio read them
//! so, too); whether it is meant is seen by the robot that the meshes make.

use std::collections::HashMap;
use std::str::FromStr;

use nalgebra::{Matrix4, Rotation3, Unit, UnitQuaternion, Vector3};
use roxmltree::{Document, Node};

use super::{GREATEST_DEPTH, GREATEST_NODES, TriangleMesh, check_count};
use crate::xml::{self, child, children};

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
    let meter = unit.and_then(|n| n.attribute("meter")).unwrap_or("1");
    let value = f64::from_str(meter.trim()).ok();
    let value = value.filter(|v| v.is_finite() && *v > 0.0);
    let meter = value.ok_or_else(|| format!("its unit of \"{meter}\" metres is no length"))?;
    let scale = Matrix4::new_scaling(meter);
    let up = child(root, "asset").and_then(|asset| child(asset, "up_axis"));
    let right_angle = std::f64::consts::FRAC_PI_2;
    reader.mesh.R_up = match up.and_then(|n| n.text()).map(str::trim) {
        Some("Y_UP") => UnitQuaternion::from_euler_angles(right_angle, 0.0, 0.0),
        Some("X_UP") => UnitQuaternion::from_euler_angles(0.0, -right_angle, 0.0),
        _ => UnitQuaternion::identity(),
    };
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

pub(super) struct Reader<'a> {
    document: &'a Document<'a>,
    by_id: HashMap<&'a str, Node<'a, 'a>>,
    nodes: usize,
    mesh: TriangleMesh,
}

impl<'a> Reader<'a> {
    pub(super) fn at(&self, node: Node, cause: &str) -> String {
        format!("line {}: {cause}", xml::line(self.document, node))
    }

    /// The element that a "#id" attribute refers to.
    pub(super) fn follow(&self, node: Node, attribute: &str) -> Result<Node<'a, 'a>, String> {
        let reference = node.attribute(attribute).unwrap_or_default();
        let id = reference.strip_prefix('#');
        let found = id.and_then(|id| self.by_id.get(id)).copied();
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

    pub(super) fn numbers<T: FromStr>(&self, node: Node) -> Result<Vec<T>, String> {
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
    use nalgebra::Point3;

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
        let off = second - Point3::new(0.0, 0.001, 0.001);
        assert!(off.norm() < 1e-15, "{second}");
        let up = mesh.R_up * Vector3::y() - Vector3::z();
        assert!(up.norm() < 1e-15, "{up}");
    }

    #[test]
    fn what_does_not_hold_together_is_refused() {
        for (from, to, cause) in [
            ("0 1 2</p>", "0 1 4</p>", "no position 4"),
            ("<vcount>4", "<vcount>5", "more corners"),
            ("url=\"#g\"", "url=\"#h\"", "leads nowhere"),
            (
                "<instance_geometry url=\"#g",
                "<instance_node url=\"#w",
                "themselves",
            ),
            ("0 1 0</float", "0 1 x</float", "\"x\" is no number"),
            ("meter=\"0.001\"", "meter=\"-1\"", "no length"),
        ] {
            assert!(SCENE.contains(from), "{from}");
            let error = parse(SCENE.replace(from, to).as_bytes()).unwrap_err();
            assert!(error.contains(cause), "{to}: {error}");
        }
    }
}
