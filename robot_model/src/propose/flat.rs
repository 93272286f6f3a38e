//! The flat face that a body shows to one side.

use nalgebra::{Isometry3, Point2, Point3, UnitQuaternion, Vector3};

use crate::collision::{Shape, ShapeGeometry};

/// Points that lie this near to the foremost plane lie in it, m: hulls leave out half a millimetre, and
/// soles are worn.
const IN_PLANE_M: f64 = 0.002;
/// Points of a round side lie this near, m: it is no sole that is worn, and rolls over what is not under it.
const ROUND_M: f64 = 0.000_25;
/// A face may look aside by this from the direction that is asked for: the cosine of 40°.
const ASIDE: f64 = 0.766;
/// Most vertices of a patch: forces act at each.
const VERTICES: usize = 8;
/// How far the middle of a face may be behind the very end, m.
const BEHIND_M: f64 = 0.015;
/// How far backward, against the direction of its end, the side of a hand may look: the sine of 10°.
const BACK: f64 = 0.17;
/// Points of a cylinder's rim.
const RIM: usize = 16;

/// A flat face of a body.
#[derive(Clone, Debug)]
pub struct Flat {
    /// Frame C in the frame of the points: in the face, z into the body.
    pub X_BC: Isometry3<f64>,
    /// Its outline in C, counter-clockwise, m.
    pub polygon: Vec<Point2<f64>>,
    /// Index of the shape that has most of it.
    pub shape: usize,
    /// Indices of all shapes that have some of it.
    pub of: Vec<usize>,
}

/// The largest flat face, among those foremost in some direction about `toward`, of placed shapes; its
/// frame's x axis along `ahead`.
pub fn flat(
    shapes: &[(Isometry3<f64>, &Shape)],
    toward: &Vector3<f64>,
    ahead: &Vector3<f64>,
) -> Option<Flat> {
    let mut candidates = vec![*toward];
    candidates.extend(lying(shapes, toward));
    candidates.extend(turned(shapes));
    candidates.retain(|n| n.dot(toward) > ASIDE);
    let candidates = apart(candidates);
    let faces = candidates.iter().filter_map(|n| foremost(shapes, n, ahead));
    // What is foremost seen aslant may lie far behind the end.
    let end = foremost_m(shapes, toward);
    let at_end = |f: &Flat| end - f.X_BC.translation.vector.dot(toward) < BEHIND_M;
    let faces = faces.filter(at_end);
    let area = |f: &Flat| doubled_area(&f.polygon) * (f.X_BC.rotation * Vector3::z()).dot(&-toward);
    faces.reduce(|best, face| {
        if area(&face) > 1.02 * area(&best) {
            face
        } else {
            best
        }
    })
}

/// The flat faces that placed shapes show to any side but backward, against `along`; x of their frames along it.
pub fn sides(shapes: &[(Isometry3<f64>, &Shape)], along: &Vector3<f64>) -> Vec<Flat> {
    let mut candidates = turned(shapes);
    candidates.retain(|n| n.dot(along) > -BACK);
    let faces = apart(candidates);
    let faces = faces.iter().filter_map(|n| foremost(shapes, n, along));
    faces.collect()
}

/// The normals of all flat faces of placed shapes.
fn turned(shapes: &[(Isometry3<f64>, &Shape)]) -> Vec<Vector3<f64>> {
    let of = |(X_BG, shape): &(Isometry3<f64>, &Shape)| {
        let normals = normals(&shape.geometry).into_iter();
        normals.map(|n| X_BG.rotation * n).collect::<Vec<_>>()
    };
    shapes.iter().flat_map(of).collect()
}

/// For each cylinder the direction nearest to `toward` in which it lies on a line of its side.
fn lying(shapes: &[(Isometry3<f64>, &Shape)], toward: &Vector3<f64>) -> Vec<Vector3<f64>> {
    let of = |(X_BG, shape): &(Isometry3<f64>, &Shape)| {
        let ShapeGeometry::Cylinder { .. } = shape.geometry else {
            return None;
        };
        let axis = X_BG.rotation * Vector3::z();
        (toward - axis * axis.dot(toward)).try_normalize(1e-6)
    };
    shapes.iter().filter_map(of).collect()
}

/// One of each directions that are the same up to rounding: triangles of one face have one normal.
fn apart(directions: Vec<Vector3<f64>>) -> Vec<Vector3<f64>> {
    let mut kept: Vec<Vector3<f64>> = Vec::new();
    for n in directions {
        if kept.iter().all(|c| c.dot(&n) < 1.0 - 1e-5) {
            kept.push(n);
        }
    }
    kept
}

/// How far placed shapes go along `d`, m.
pub fn foremost_m(shapes: &[(Isometry3<f64>, &Shape)], d: &Vector3<f64>) -> f64 {
    let along = |(X_BG, shape): &(Isometry3<f64>, &Shape)| {
        let p = X_BG * shape.geometry.support(&(X_BG.rotation.inverse() * d));
        p.coords.dot(d)
    };
    shapes.iter().map(along).fold(f64::NEG_INFINITY, f64::max)
}

/// What lies in the foremost plane of normal `n`.
fn foremost(
    shapes: &[(Isometry3<f64>, &Shape)],
    n: &Vector3<f64>,
    ahead: &Vector3<f64>,
) -> Option<Flat> {
    let height = |p: &Point3<f64>| p.coords.dot(n);
    let points: Vec<Vec<Point3<f64>>> = shapes
        .iter()
        .map(|(X_BG, shape)| extreme(&shape.geometry, X_BG, n))
        .collect();
    let top = points
        .iter()
        .flatten()
        .map(height)
        .fold(f64::NEG_INFINITY, f64::max);
    let lies = |p: &&Point3<f64>| height(p) >= top - IN_PLANE_M;
    // C: z into the body, x ahead in the plane.
    let z = -n;
    let x = (ahead - z * z.dot(ahead)).try_normalize(1e-3);
    let x = x.or_else(|| (Vector3::x() - z * z.x).try_normalize(1e-3))?;
    let y = z.cross(&x);
    let flat = |p: &Point3<f64>| Point2::new(p.coords.dot(&x), p.coords.dot(&y));
    let all: Vec<Point2<f64>> = points.iter().flatten().filter(lies).map(flat).collect();
    let hull = simplified(hull(all)?);
    let count = |k: &usize| points[*k].iter().filter(lies).count();
    let shape = (0..shapes.len()).max_by_key(|k| (count(k), std::cmp::Reverse(*k)))?;
    let (low, high) = hull
        .iter()
        .fold((hull[0], hull[0]), |(l, h), p| (l.inf(p), h.sup(p)));
    let middle = nalgebra::center(&low, &high);
    let axes = nalgebra::Matrix3::from_columns(&[x, y, z]);
    let origin = x * middle.x + y * middle.y + n * top;
    let R = UnitQuaternion::from_matrix(&axes);
    Some(Flat {
        X_BC: Isometry3::from_parts(origin.into(), R),
        polygon: hull.iter().map(|p| Point2::from(p - middle)).collect(),
        shape,
        of: (0..shapes.len()).filter(|k| count(k) > 0).collect(),
    })
}

/// Outward normals of a shape's flat faces, in G.
fn normals(geometry: &ShapeGeometry) -> Vec<Vector3<f64>> {
    match geometry {
        ShapeGeometry::Box { .. } => (0..6)
            .map(|k| Vector3::ith(k % 3, if k < 3 { 1.0 } else { -1.0 }))
            .collect(),
        ShapeGeometry::Cylinder { .. } => vec![Vector3::z(), -Vector3::z()],
        ShapeGeometry::ConvexHull(hull) => {
            // Faces by their area: the largest few dozen are enough.
            let v = |i: u32| hull.vertices()[i as usize];
            let cross = hull
                .triangles()
                .iter()
                .map(|&[a, b, c]| (v(b) - v(a)).cross(&(v(c) - v(a))));
            let mut cross: Vec<Vector3<f64>> = cross.collect();
            cross.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
            cross
                .iter()
                .take(40)
                .filter_map(|c| c.try_normalize(0.0))
                .collect()
        }
        _ => Vec::new(),
    }
}

/// Points of a shape among which those foremost along `n` are, in the frame of `X_BG`.
fn extreme(geometry: &ShapeGeometry, X_BG: &Isometry3<f64>, n: &Vector3<f64>) -> Vec<Point3<f64>> {
    let n_G = X_BG.rotation.inverse() * n;
    let ends = |half: f64, r: f64| {
        [half, -half]
            .map(|z| Point3::new(0.0, 0.0, z) + n_G * r)
            .to_vec()
    };
    let points = match geometry {
        ShapeGeometry::Sphere { radius_m } => vec![Point3::from(n_G * *radius_m)],
        ShapeGeometry::Capsule {
            half_length_m,
            radius_m,
        } => ends(*half_length_m, *radius_m),
        ShapeGeometry::Cylinder {
            half_length_m,
            radius_m,
        } => {
            // Around the line that it would lie on, as far as that is in the plane.
            let lies = n_G.y.atan2(n_G.x);
            let strip = (1.0 - ROUND_M / radius_m.max(ROUND_M)).acos();
            let around = (0..RIM).map(|k| std::f64::consts::TAU * k as f64 / RIM as f64);
            let rim = around.chain([-1.0, 0.0, 1.0].map(|side| lies + 0.999 * side * strip));
            let rim = rim.flat_map(|a| {
                let (s, c) = a.sin_cos();
                [1.0, -1.0]
                    .map(|side| Point3::new(radius_m * c, radius_m * s, side * half_length_m))
            });
            rim.collect()
        }
        _ => geometry.vertices(),
    };
    points.into_iter().map(|p| X_BG * p).collect()
}

/// The convex hull, counter-clockwise; `None` where the points lie on a line.
fn hull(mut points: Vec<Point2<f64>>) -> Option<Vec<Point2<f64>>> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup_by(|a, b| (*a - *b).norm() < 1e-5);
    let mut hull: Vec<Point2<f64>> = Vec::new();
    for half in 0..2 {
        let first = hull.len();
        for p in &points {
            while hull.len() >= first + 2
                && (hull[hull.len() - 1] - hull[hull.len() - 2]).perp(&(p - hull[hull.len() - 1]))
                    < 1e-9
            {
                hull.pop();
            }
            hull.push(*p);
        }
        hull.pop();
        if half == 0 {
            points.reverse();
        }
    }
    (hull.len() > 2 && doubled_area(&hull) > 1e-6).then_some(hull)
}

/// The polygon without the vertices that add least to it, inside the other: at most [`VERTICES`], and
/// none that adds less than a hundredth.
fn simplified(mut polygon: Vec<Point2<f64>>) -> Vec<Point2<f64>> {
    let whole = doubled_area(&polygon);
    while polygon.len() > 3 {
        let n = polygon.len();
        let adds = |i: usize| {
            let (a, b, c) = (polygon[(i + n - 1) % n], polygon[i], polygon[(i + 1) % n]);
            (b - a).perp(&(c - b)).abs()
        };
        let Some(least) = (0..n).min_by(|a, b| adds(*a).total_cmp(&adds(*b))) else {
            break;
        };
        if n <= VERTICES && adds(least) > 0.01 * whole {
            break;
        }
        polygon.remove(least);
    }
    polygon
}

/// Twice the area of a polygon.
pub fn doubled_area(polygon: &[Point2<f64>]) -> f64 {
    let n = polygon.len();
    let part = |i: usize| polygon[i].coords.perp(&polygon[(i + 1) % n].coords);
    (0..n).map(part).sum()
}
