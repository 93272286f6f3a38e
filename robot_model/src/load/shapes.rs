//! The collision elements of links → convex shapes on bodies.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use urdf_rs::{Geometry, Link};

use super::urdf::pose;
use super::{Findings, MeshSource};
use crate::collision::{Hull, Shape, ShapeGeometry};
use crate::{Error, mesh_file};

/// A mesh's convex hull is simplified to the vertices that leave the others within this, m: little
/// against a clearance. What it falls short of counts as part of the shape.
const SHORTFALL_M: f64 = 5e-4;
/// Most vertices of it all the same.
const HULL_VERTICES: usize = 256;

/// Radius of the ball that a sphere of radius 0 stands for, m.
const POINT_M: f64 = 1e-3;

/// A mesh is elsewhere for being turned that comes nearer to its link's mass by this, m.
const TURNED_M: f64 = 0.01;

/// Most collision shapes of a robot: each pair of them may be watched.
const SHAPES_MAX: usize = 2000;

/// Reads the collision shapes of a robot's links, every mesh as its convex hull.
pub(super) struct ShapeReader<'a> {
    pub file: &'a str,
    pub meshes: &'a MeshSource<'a>,
    /// Hulls by file name and scale, and what turns them upright: many a robot has two equal arms.
    pub hulls: BTreeMap<(String, [u64; 3]), (Hull, UnitQuaternion<f64>)>,
}

impl ShapeReader<'_> {
    /// The shapes of every link that has a place in a body.
    ///
    /// # Errors
    /// Too many of them. Meshes that are missing, malformed or without volume and a size that is not positive are
    /// refused with all else, by link and mesh.
    pub fn read(
        &mut self,
        links: &[Link],
        places: &[Option<(usize, Isometry3<f64>)>],
        findings: &mut Findings,
    ) -> Result<Vec<Shape>, Error> {
        let mut shapes = Vec::new();
        // What their files would have turned, and where the masses of their links are.
        let mut lying = Vec::new();
        for (link, place) in links.iter().zip(places) {
            let Some((body, X_BL)) = place else { continue };
            let collisions = link.collision.iter().map(|c| (&c.origin, &c.geometry));
            let shown = link.visual.iter().map(|v| (&v.origin, &v.geometry));
            for (origin, geometry) in collisions.chain(shown) {
                if shapes.len() == SHAPES_MAX {
                    let cause = format!("there are more than {SHAPES_MAX} collision shapes");
                    return Err(Error::file(self.file, cause));
                }
                let read = match self.shape(&link.name, geometry, findings) {
                    Err(error) if link.collision.is_empty() => {
                        findings.note(format!("{error} (left out: it is only shown)"));
                        None
                    }
                    read => findings.kept(read),
                };
                let Some((geometry, R_up)) = read else {
                    continue;
                };
                if R_up != UnitQuaternion::identity() && link.inertial.mass.value > 0.0 {
                    let com_B = X_BL * pose(&link.inertial.origin).translation.vector;
                    lying.push((shapes.len(), R_up, Point3::from(com_B)));
                }
                shapes.push(Shape {
                    link: link.name.clone(),
                    body: *body,
                    X_BG: X_BL * pose(origin),
                    geometry,
                    is_pad: true,
                });
            }
            if !link.visual.is_empty() {
                let what = "no link has a collision shape; what these show is taken for it";
                findings.list(what, &link.name);
            }
        }
        raise(&mut shapes, &lying, findings);
        Ok(shapes)
    }

    /// A shape, and what turns it upright if its file is to be believed.
    fn shape(
        &mut self,
        link: &str,
        geometry: &Geometry,
        findings: &mut Findings,
    ) -> Result<(ShapeGeometry, UnitQuaternion<f64>), Error> {
        let mut R_up = UnitQuaternion::identity();
        #[rustfmt::skip]
        let (what, shape) = match geometry {
            Geometry::Box { size } => {
                let half_extents_m = Vector3::from(**size) / 2.0;
                ("box", ShapeGeometry::Box { half_extents_m })
            }
            // A point where a foot touches.
            Geometry::Sphere { radius } if *radius == 0.0 => {
                let what = "spheres of radius 0 are taken for balls of 1 mm";
                findings.list(what, link);
                ("sphere", ShapeGeometry::Sphere { radius_m: POINT_M })
            }
            Geometry::Sphere { radius } => ("sphere", ShapeGeometry::Sphere { radius_m: *radius }),
            Geometry::Cylinder { radius, length } => {
                let (half_length_m, radius_m) = (length / 2.0, *radius);
                ("cylinder", ShapeGeometry::Cylinder { half_length_m, radius_m })
            }
            Geometry::Capsule { radius, length } => {
                let (half_length_m, radius_m) = (length / 2.0, *radius);
                ("capsule", ShapeGeometry::Capsule { half_length_m, radius_m })
            }
            Geometry::Mesh { filename, scale } => {
                let scale = scale.map_or([1.0; 3], |scale| *scale);
                let hull;
                (hull, R_up) = self.hull(link, filename, &scale, findings)?;
                (filename.as_str(), ShapeGeometry::ConvexHull(hull))
            }
        };
        match shape.flaw() {
            None => Ok((shape, R_up)),
            Some(cause) => Err(self.refuse(link, what, cause)),
        }
    }

    /// The convex hull of a mesh.
    fn hull(
        &mut self,
        link: &str,
        filename: &str,
        scale: &[f64; 3],
        findings: &mut Findings,
    ) -> Result<(Hull, UnitQuaternion<f64>), Error> {
        let key = (filename.to_owned(), scale.map(f64::to_bits));
        if let Some(hull) = self.hulls.get(&key) {
            return Ok(hull.clone());
        }
        let bytes = (self.meshes)(filename).map_err(|cause| self.refuse(link, filename, cause))?;
        let mesh = mesh_file::parse(Path::new(filename), &bytes).map_err(|error| match error {
            Error::File { cause, .. } => self.refuse(link, filename, cause),
            other => other,
        })?;
        let scale = Vector3::from(*scale);
        let scaled = |v: &Point3<f64>| Point3::from(v.coords.component_mul(&scale));
        let scaled: Vec<Point3<f64>> = mesh.vertices.iter().map(scaled).collect();
        let hull = Hull::simplified(&scaled, SHORTFALL_M, HULL_VERTICES)
            .map_err(|error| self.refuse(link, filename, error.to_string()))?;
        let shortfall_mm = hull.shortfall_m() * 1e3;
        if shortfall_mm > 1.0 {
            let what = "hulls were simplified, and are grown by what the meshes stick out of them";
            findings.list(what, format!("{link} ({shortfall_mm:.1} mm)"));
        }
        self.hulls.insert(key, (hull.clone(), mesh.R_up));
        Ok((hull, mesh.R_up))
    }

    fn refuse(&self, link: &str, what: &str, cause: String) -> Error {
        let part = format!("link \"{link}\": collision {what}");
        let file = self.file.to_owned();
        Error::Part { file, part, cause }
    }
}

/// Turns meshes upright, as their files have it, where that brings them to the masses of their links: some
/// robots' authors mean it so, most do not.
fn raise(
    shapes: &mut [Shape],
    lying: &[(usize, UnitQuaternion<f64>, Point3<f64>)],
    findings: &mut Findings,
) {
    let middle = |geometry: &ShapeGeometry| {
        let points = geometry.vertices();
        let first = points.first().copied().unwrap_or_default();
        let (low, high) = (points.iter()).fold((first, first), |(l, h), p| (l.inf(p), h.sup(p)));
        nalgebra::center(&low, &high)
    };
    let gains = lying.iter().map(|(shape, R_up, com_B)| {
        let shape = &shapes[*shape];
        let middle = middle(&shape.geometry);
        let off = |p: Point3<f64>| (shape.X_BG * p - com_B).norm();
        off(middle) - off(R_up * middle)
    });
    let gains: Vec<f64> = gains.collect();
    let count = |sign: f64| gains.iter().filter(|gain| sign * **gain > TURNED_M).count();
    if count(1.0) > 2 * count(-1.0) {
        for (shape, R_up, _) in lying {
            let shape = &mut shapes[*shape];
            shape.X_BG *= *R_up;
            let what = "meshes lie at their links' masses only turned as their files' up_axis says, \
                        and are";
            findings.list(what, &shape.link);
        }
    }
}
