//! The primitives of a COLLADA geometry: where their positions are, and which corners make triangles.

use std::str::FromStr;

use nalgebra::Point3;
use roxmltree::Node;

use super::dae::Reader;
use crate::xml::{child, children};

impl<'a> Reader<'a> {
    /// Where a primitive's positions come from: their `<source>`, the place of their numbers
    /// among a corner's, how many numbers a corner has.
    pub(super) fn positions(
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
    pub(super) fn points(&self, source: Node<'a, 'a>) -> Result<Vec<Point3<f64>>, String> {
        let array = child(source, "float_array");
        let array = array.ok_or_else(|| self.at(source, "there is no <float_array>"))?;
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
        let points = values[start..].chunks_exact(stride);
        Ok(points.map(|v| Point3::new(v[0], v[1], v[2])).collect())
    }

    /// Each `<p>` of a primitive with its triangles as triples of corners in it.
    #[allow(clippy::type_complexity)]
    pub(super) fn faces(
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
                    .map(|i| [0, 1, 2].map(|k| 3 * i + k))
                    .collect(),
                "polylist" => {
                    let counts = child(primitive, "vcount");
                    let counts =
                        counts.ok_or_else(|| self.at(primitive, "there is no <vcount>"))?;
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
                // Every other triangle of a strip is wound the other way.
                "tristrips" => (0..corners.saturating_sub(2))
                    .map(|i| [i + i % 2, i + 1 - i % 2, i + 2])
                    .collect(),
                // A polygon, or a fan.
                _ => fan(0, corners).collect(),
            };
            all.push((list, faces));
        }
        Ok(all)
    }
}
