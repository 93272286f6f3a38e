//! Plane faces: triangles in one plane, merged into regions with holes.

use geo::buffer::{BufferStyle, LineJoin};
use geo::{Area, Buffer, Coord, LineString, MultiPolygon, Polygon};
use nalgebra::{Isometry3, Point2, Point3, UnitQuaternion, Vector3};

use super::topology::Topology;
use super::weld::Welded;
use super::{GAP_M, MERGE_ANGLE_RAD, MERGE_OFFSET_M, WELD_M};
use crate::bounds::{Bounds, BoundsTree, around};
use crate::polygon::clean_ring;
use crate::{Face, Fit, Region, Source};

/// Corners that are sharper than this are cut off where gaps are closed, rad.
const TIP_MIN_RAD: f64 = 0.3;

/// The faces that the given triangles make, the largest first, and the triangles of those whose
/// outline is beyond use.
pub(super) fn faces(
    mesh: &Welded,
    topology: &Topology,
    triangles: &[usize],
) -> (Vec<Face>, Vec<Vec<usize>>) {
    let mut faces = Vec::new();
    let mut broken = Vec::new();
    for plane in merge(mesh, grow(mesh, topology, triangles)) {
        match plane_faces(mesh, &plane) {
            Some(mut list) => faces.append(&mut list),
            None => broken.push(plane.triangles),
        }
    }
    // Stable, so that equal areas keep the order of the mesh.
    faces.sort_by(|a: &Face, b: &Face| b.region.area().total_cmp(&a.region.area()));
    (faces, broken)
}

/// Triangles in one plane.
struct Plane {
    normal: Vector3<f64>,
    origin: Point3<f64>,
    area_m2: f64,
    triangles: Vec<usize>,
}

/// Grows planes over the edges of the mesh, each from the largest triangle that is left.
///
/// The plane of that triangle is the one all others are held to: a gently curved strip would
/// otherwise drift away from it.
fn grow(mesh: &Welded, topology: &Topology, triangles: &[usize]) -> Vec<Plane> {
    let mut order = triangles.to_vec();
    let area = |t: &usize| mesh.triangles[*t].area_m2;
    order.sort_by(|a, b| area(b).total_cmp(&area(a)).then(a.cmp(b)));
    let mut free = vec![false; mesh.triangles.len()];
    for t in triangles {
        free[*t] = true;
    }
    let mut planes = Vec::new();
    for seed in order {
        let (normal, origin) = (mesh.triangles[seed].normal, mesh.corners(seed)[0]);
        let near = |t: usize| topology.neighbours[t].iter().copied();
        let list = flood(&mut free, seed, near, |t| fits(mesh, t, &normal, &origin));
        if !list.is_empty() {
            planes.push(fitted(mesh, list));
        }
    }
    planes
}

/// What is reached from a seed over what fits, each of it free before and not afterwards; nothing if the seed is not free.
fn flood<N: Iterator<Item = usize>>(
    free: &mut [bool],
    seed: usize,
    near: impl Fn(usize) -> N,
    fits: impl Fn(usize) -> bool,
) -> Vec<usize> {
    let mut list = Vec::new();
    if std::mem::take(&mut free[seed]) {
        list.push(seed);
    }
    let mut next = 0;
    while let Some(i) = list.get(next).copied() {
        next += 1;
        for j in near(i) {
            if free[j] && fits(j) {
                free[j] = false;
                list.push(j);
            }
        }
    }
    list
}

/// Whether a triangle lies in a plane and looks the same way.
fn fits(mesh: &Welded, t: usize, normal: &Vector3<f64>, origin: &Point3<f64>) -> bool {
    let triangle = &mesh.triangles[t];
    // A corner may be off by as much as is welded, which turns narrow triangles most.
    let angle = MERGE_ANGLE_RAD + 2.0 * WELD_M / triangle.height_m;
    let near = |p: &Point3<f64>| normal.dot(&(p - origin)).abs() <= MERGE_OFFSET_M;
    triangle.normal.angle(normal) <= angle && mesh.corners(t).iter().all(near)
}

/// The plane through triangles that nearly lie in one: mean normal and centroid by area.
fn fitted(mesh: &Welded, mut triangles: Vec<usize>) -> Plane {
    triangles.sort_unstable();
    let mut normal = Vector3::zeros();
    let mut moment = Vector3::zeros();
    let mut area_m2 = 0.0;
    for t in &triangles {
        let triangle = &mesh.triangles[*t];
        let middle = mesh
            .corners(*t)
            .iter()
            .map(|p| p.coords)
            .sum::<Vector3<f64>>()
            / 3.0;
        normal += triangle.normal * triangle.area_m2;
        moment += middle * triangle.area_m2;
        area_m2 += triangle.area_m2;
    }
    Plane {
        normal: normal.normalize(),
        origin: Point3::from(moment / area_m2),
        area_m2,
        triangles,
    }
}

/// Joins planes that are the same and meet although no edge connects them (tiles with and without joints, T-junctions).
fn merge(mesh: &Welded, mut planes: Vec<Plane>) -> Vec<Plane> {
    planes.sort_by(|a, b| b.area_m2.total_cmp(&a.area_m2));
    let bounds = |plane: &Plane| {
        let corners = plane.triangles.iter().flat_map(|t| mesh.corners(*t));
        around(&corners.collect::<Vec<_>>())
    };
    let boxes: Vec<Bounds> = planes.iter().map(bounds).collect();
    let tree = BoundsTree::new(boxes.clone());
    let mut free = vec![true; planes.len()];
    let mut merged = Vec::new();
    for seed in 0..planes.len() {
        let Plane { normal, origin, .. } = &planes[seed];
        let near = |i: usize| tree.meeting(&boxes[i], GAP_M);
        let list = flood(&mut free, seed, near, |i| {
            let mut triangles = planes[i].triangles.iter();
            triangles.all(|t| fits(mesh, *t, normal, origin))
        });
        if list.is_empty() {
            continue;
        }
        let triangles = list.iter().flat_map(|i| planes[*i].triangles.clone());
        merged.push(fitted(mesh, triangles.collect()));
    }
    merged
}

/// The connected regions of a plane; None when an outline is beyond use.
fn plane_faces(mesh: &Welded, plane: &Plane) -> Option<Vec<Face>> {
    let X_WF = frame(&plane.normal, &plane.origin);
    let corners: Vec<[Point3<f64>; 3]> = plane
        .triangles
        .iter()
        .map(|t| mesh.corners(*t).map(|p| X_WF.inverse_transform_point(&p)))
        .collect();
    let heights = corners.iter().flatten().map(|p| p.z * p.z);
    let rms_m = (heights.sum::<f64>() / (3 * corners.len()) as f64).sqrt();
    let flat: Vec<Polygon<f64>> = corners
        .iter()
        .map(|triangle| {
            let line = triangle.iter().map(|p| Coord { x: p.x, y: p.y });
            Polygon::new(line.collect(), vec![])
        })
        .collect();
    let mut faces = Vec::new();
    for polygon in bridged(geo::unary_union(&flat)) {
        let lines = std::iter::once(polygon.exterior()).chain(polygon.interiors());
        let mut rings = lines.map(open_ring);
        // Without its outer ring a face is a sliver; holes of that kind are gaps.
        let Some(outer) = rings.next().filter(|ring| ring.len() >= 3) else {
            continue;
        };
        let holes = rings.filter(|ring| ring.len() >= 3);
        let region = Region::new(std::iter::once(outer).chain(holes)).ok()?;
        faces.push(Face {
            fit: Some(Fit {
                points: 3 * corners.len(),
                rms_m,
            }),
            source: Source::Mesh,
            ..Face::new("", X_WF, region)
        });
    }
    Some(faces)
}

/// Regions of a plane without the gaps of at most [`GAP_M`] in and between them; as they are where there is none.
fn bridged(regions: MultiPolygon<f64>) -> MultiPolygon<f64> {
    let rings = regions.iter().map(|part| 1 + part.interiors().len());
    if rings.sum::<usize>() < 2 {
        return regions;
    }
    let by = |m: f64| BufferStyle::new(m).line_join(LineJoin::Miter(TIP_MIN_RAD));
    let wide = regions.buffer_with_style(by(0.5 * GAP_M));
    let closed = wide.buffer_with_style(by(-0.5 * GAP_M));
    if closed.unsigned_area() > regions.unsigned_area() + GAP_M * GAP_M {
        closed
    } else {
        regions
    }
}

/// The points of a closed line, each once, without those on a straight edge.
fn open_ring(line: &LineString<f64>) -> Vec<Point2<f64>> {
    let mut points: Vec<Point2<f64>> = line.0.iter().map(|c| Point2::new(c.x, c.y)).collect();
    points.pop();
    // The union works on a grid a billion times finer than the face: a micrometre is straight.
    clean_ring(points, 1e-6)
}

/// A frame with z along the normal and x as near to W's x axis as that allows, else to its y axis.
fn frame(normal: &Vector3<f64>, origin: &Point3<f64>) -> Isometry3<f64> {
    // Beyond 0.9 the projection of W's x axis is short and turns quickly.
    let toward = if normal.x.abs() < 0.9 {
        Vector3::x()
    } else {
        Vector3::y()
    };
    let x = (toward - normal * normal.dot(&toward)).normalize();
    let y = normal.cross(&x);
    let rotation = UnitQuaternion::from_basis_unchecked(&[x, y, *normal]);
    Isometry3::from_parts(origin.coords.into(), rotation)
}
