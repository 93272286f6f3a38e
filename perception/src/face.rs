//! Regions of planes → faces of the world.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Point2};
use surfaces::{Edge, EdgeKind, Face, Fit, Region, Ring, Source, Surface};

/// What is known of a face beside its region.
pub(crate) struct Known {
    pub fit: Fit,
    pub view: surfaces::EdgeView,
}

/// A face of rings on a plane P in V, whose edges `of` tells: ring, index. Frame F has its origin at the
/// region's centroid; `covariance` is asked for with that, on P, and the rotation from P.
///
/// `None` where the rings are no region.
pub(crate) fn face(
    rings: &[Vec<Point2<f64>>],
    of: impl Fn(usize, usize) -> Edge,
    X_WP: &Isometry3<f64>,
    known: Known,
    covariance: impl FnOnce(&Point2<f64>) -> Option<[[f64; 3]; 3]>,
) -> Option<Face> {
    let ring = |(k, vertices): (usize, &Vec<Point2<f64>>)| Ring {
        vertices: vertices.clone(),
        edges: (0..vertices.len()).map(|i| of(k, i)).collect(),
    };
    let region = Region::new(rings.iter().enumerate().map(ring)).ok()?;
    let centroid = region.centroid();
    let X_PF = nalgebra::Translation3::new(centroid.x, centroid.y, 0.0);
    Some(Face {
        plane_covariance: covariance(&centroid),
        fit: Some(known.fit),
        views: vec![known.view],
        source: Source::Scan,
        ..Face::new("", X_WP * X_PF, region.moved(&-centroid.coords))
    })
}

/// A surface of one convex piece as a face. Its insets are further errors of its edges.
pub(crate) fn of_convex(surface: &Surface) -> Option<Face> {
    let vertices = surface.polygon.vertices().to_vec();
    let edge = |i: usize| Edge {
        kind: surface
            .polygon_edges
            .get(i)
            .copied()
            .unwrap_or(EdgeKind::Real),
        further_m: (surface.edge_insets_m.get(i).copied().unwrap_or(0.0)).max(surface.inset_m),
        ..Edge::default()
    };
    let edges = (0..vertices.len()).map(edge).collect();
    let region = Region::new([Ring { vertices, edges }]).ok()?;
    Some(Face {
        plane_covariance: surface.plane_covariance,
        fit: Some(Fit {
            points: surface.inliers,
            rms_m: surface.rms_m,
        }),
        depth_m: surface.depth_m,
        source: surface.source,
        ..Face::new(surface.id.as_str(), surface.X_WS, region)
    })
}

/// Names faces f0, f1, … by falling area.
pub(crate) fn named(mut faces: Vec<Face>) -> Vec<Face> {
    faces.sort_by(|a, b| b.region.area().total_cmp(&a.region.area()));
    for (i, face) in faces.iter_mut().enumerate() {
        face.id = format!("f{i}").into();
    }
    faces
}

/// A face as a surface: the hull of its outer ring, to compare planes by.
pub(crate) fn hull(face: &Face) -> Option<Surface> {
    let outer = &face.region.rings().first()?.vertices;
    let polygon = surfaces::ConvexPolygon::hull(outer).ok()?;
    Some(Surface {
        plane_covariance: face.plane_covariance,
        source: face.source,
        ..Surface::new(face.id.as_str(), face.X_WF, polygon)
    })
}
