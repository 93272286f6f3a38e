//! Triangles of a shape, good enough to look at.

use std::f64::consts::{PI, TAU};

use nalgebra::Point3;

use super::ShapeGeometry;

/// Corners of a round shape's polygon.
const SIDES: u32 = 20;
/// Rings of a hemisphere.
const RINGS: u32 = 5;

impl ShapeGeometry {
    /// Vertices in G and counter-clockwise (outward) triangles over them. Exact for boxes and
    /// hulls; round shapes become polyhedra inscribed in them.
    pub fn triangles(&self) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
        match self {
            ShapeGeometry::Sphere { radius_m } => turned(&dome(0.0, *radius_m)),
            ShapeGeometry::Capsule {
                half_length_m,
                radius_m,
            } => turned(&dome(*half_length_m, *radius_m)),
            ShapeGeometry::Cylinder {
                half_length_m: half,
                radius_m: radius,
            } => turned(&[
                (0.0, -half),
                (*radius, -half),
                (*radius, *half),
                (0.0, *half),
            ]),
            ShapeGeometry::Box { .. } => (self.vertices(), BOX_TRIANGLES.to_vec()),
            ShapeGeometry::ConvexHull(hull) => {
                (hull.vertices().to_vec(), hull.triangles().to_vec())
            }
        }
    }
}

/// Corner bits: 1 is +x, 2 is +y, 4 is +z.
const BOX_TRIANGLES: [[u32; 3]; 12] = [
    [0, 4, 6],
    [0, 6, 2],
    [1, 3, 7],
    [1, 7, 5],
    [0, 1, 5],
    [0, 5, 4],
    [2, 6, 7],
    [2, 7, 3],
    [0, 2, 3],
    [0, 3, 1],
    [4, 5, 7],
    [4, 7, 6],
];

/// The outline (radius, z) of a capsule from its lower to its upper pole.
fn dome(half_length: f64, radius: f64) -> Vec<(f64, f64)> {
    let arc = |from: f64, shift: f64| {
        (0..=RINGS).map(move |k| {
            let angle = from + PI / 2.0 * f64::from(k) / f64::from(RINGS);
            (radius * angle.cos().max(0.0), shift + radius * angle.sin())
        })
    };
    let mut outline: Vec<_> = arc(-PI / 2.0, -half_length)
        .chain(arc(0.0, half_length))
        .collect();
    // The poles lie on the axis exactly, and a sphere's equator is there once.
    outline.dedup_by(|p, q| (p.0 - q.0).abs() + (p.1 - q.1).abs() < 1e-12);
    if let Some(last) = outline.last_mut() {
        last.0 = 0.0;
    }
    if let Some(first) = outline.first_mut() {
        first.0 = 0.0;
    }
    outline
}

/// The surface swept by an outline that begins and ends on the z axis.
fn turned(outline: &[(f64, f64)]) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    // One vertex for a pole, SIDES for a ring.
    let mut rings: Vec<(u32, bool)> = Vec::new();
    for &(radius, z) in outline {
        let is_pole = radius == 0.0;
        rings.push((vertices.len() as u32, is_pole));
        for side in 0..if is_pole { 1 } else { SIDES } {
            let angle = TAU * f64::from(side) / f64::from(SIDES);
            vertices.push(Point3::new(radius * angle.cos(), radius * angle.sin(), z));
        }
    }
    for pair in rings.windows(2) {
        let ((low, low_is_pole), (high, high_is_pole)) = (pair[0], pair[1]);
        for side in 0..SIDES {
            let next = (side + 1) % SIDES;
            let at =
                |(start, is_pole): (u32, bool), k: u32| if is_pole { start } else { start + k };
            if !low_is_pole {
                let (a, b) = (at((low, low_is_pole), side), at((low, low_is_pole), next));
                triangles.push([a, b, at((high, high_is_pole), next)]);
            }
            if !high_is_pole {
                let (c, d) = (
                    at((high, high_is_pole), next),
                    at((high, high_is_pole), side),
                );
                triangles.push([at((low, low_is_pole), side), c, d]);
            }
        }
    }
    (vertices, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// Volume by the divergence theorem: right only if the surface is closed and outward.
    fn volume(shape: &ShapeGeometry) -> f64 {
        let (vertices, triangles) = shape.triangles();
        let at = |i: u32| vertices[i as usize].coords;
        triangles
            .iter()
            .map(|t| at(t[0]).dot(&at(t[1]).cross(&at(t[2]))) / 6.0)
            .sum()
    }

    #[test]
    fn drawn_volumes_are_those_of_the_shapes() {
        let half_extents_m = Vector3::new(0.1, 0.2, 0.3);
        let exact = 8.0 * 0.1 * 0.2 * 0.3;
        assert!((volume(&ShapeGeometry::Box { half_extents_m }) - exact).abs() < 1e-15);
        // Inscribed polyhedra of 20 sides and 5 rings a hemisphere lose less than 5 %.
        let (r, h) = (0.1_f64, 0.25);
        let (half_length_m, radius_m) = (h, r);
        for (shape, exact) in [
            (
                ShapeGeometry::Sphere { radius_m },
                4.0 / 3.0 * PI * r.powi(3),
            ),
            (
                ShapeGeometry::Cylinder {
                    half_length_m,
                    radius_m,
                },
                2.0 * h * PI * r * r,
            ),
            (
                ShapeGeometry::Capsule {
                    half_length_m,
                    radius_m,
                },
                2.0 * h * PI * r * r + 4.0 / 3.0 * PI * r.powi(3),
            ),
        ] {
            let ratio = volume(&shape) / exact;
            assert!(ratio > 0.95 && ratio < 1.0, "{shape:?}: {ratio}");
        }
    }
}
