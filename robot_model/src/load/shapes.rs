//! The collision elements of links → convex shapes on bodies.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::{Isometry3, Point3, Vector3};
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

/// Most collision shapes of a robot: each pair of them may be watched.
const SHAPES_MAX: usize = 2000;

/// Reads the collision shapes of a robot's links, every mesh as its convex hull.
pub(super) struct ShapeReader<'a> {
    pub file: &'a str,
    pub meshes: &'a MeshSource<'a>,
    /// Hulls by file name and scale: many a robot has two equal arms.
    pub hulls: BTreeMap<(String, [u64; 3]), Hull>,
}

impl ShapeReader<'_> {
    /// The shapes of every link that has a place in a body.
    ///
    /// # Errors
    /// [`Error::Part`] naming link and mesh: missing, malformed, without volume; a size that is
    /// not positive.
    pub fn read(
        &mut self,
        links: &[Link],
        places: &[Option<(usize, Isometry3<f64>)>],
        findings: &mut Findings,
    ) -> Result<Vec<Shape>, Error> {
        let mut shapes = Vec::new();
        for (link, place) in links.iter().zip(places) {
            let Some((body, X_BL)) = place else { continue };
            for collision in &link.collision {
                if shapes.len() == SHAPES_MAX {
                    let cause = format!("there are more than {SHAPES_MAX} collision shapes");
                    return Err(Error::file(self.file, cause));
                }
                let geometry = self.shape(&link.name, &collision.geometry, findings)?;
                shapes.push(Shape {
                    link: link.name.clone(),
                    body: *body,
                    X_BG: X_BL * pose(&collision.origin),
                    geometry,
                });
            }
        }
        Ok(shapes)
    }

    fn shape(
        &mut self,
        link: &str,
        geometry: &Geometry,
        findings: &mut Findings,
    ) -> Result<ShapeGeometry, Error> {
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
                let hull = self.hull(link, filename, &scale, findings)?;
                (filename.as_str(), ShapeGeometry::ConvexHull(hull))
            }
        };
        match shape.flaw() {
            None => Ok(shape),
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
    ) -> Result<Hull, Error> {
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
        self.hulls.insert(key, hull.clone());
        Ok(hull)
    }

    fn refuse(&self, link: &str, what: &str, cause: String) -> Error {
        let part = format!("link \"{link}\": collision {what}");
        let file = self.file.to_owned();
        Error::Part { file, part, cause }
    }
}
