//! What a robot may touch and must not hit.
#![allow(non_snake_case)]

use std::ops::Index;
use std::sync::OnceLock;

use nalgebra::Point3;
use robot_model::collision::World;
use surfaces::outline::Outline;
use surfaces::{Face, Region, Terrain};

use crate::Error;

/// One of an environment's faces, as [`Environment::face`] finds it by name.
///
/// It belongs to the environment that gave it, whose `environment[face]` is the face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FaceIndex(usize);

/// What the robot may touch and must not hit.
#[derive(Default)]
pub struct Environment {
    faces: Vec<Face>,
    /// Standard deviations by which faces are taken back at their edges.
    edge_sigmas: f64,
    /// For each face what that leaves of it, computed when it is first asked for.
    inset: Vec<OnceLock<Vec<Region>>>,
    /// Convex bodies to keep away from.
    world: World,
    body_names: Vec<String>,
    /// `behind[face][body]`: whether the body lies wholly behind the face's plane.
    behind: Vec<Vec<bool>>,
}

/// How far a body may rise over a plane and still count as behind it, m: two scanned planes of one
/// floor differ by as much.
const BEHIND_M: f64 = 0.015;

impl Environment {
    /// The environment of a terrain: bodies of `thickness_m` behind every face, and the terrain's
    /// obstacles. Faces are taken back by `edge_sigmas` standard deviations of where their edges
    /// are.
    ///
    /// # Errors
    /// [`Error::Body`] where a body is degenerate.
    pub fn new(terrain: Terrain, thickness_m: f64, edge_sigmas: f64) -> Result<Self, Error> {
        let behind_faces = terrain.faces.iter().flat_map(|face| {
            let bodies = face.bodies_W(thickness_m).into_iter();
            bodies.map(|points_W| (face.id.to_string(), points_W))
        });
        let obstacles = terrain.obstacles.into_iter();
        let (body_names, bodies): (Vec<String>, Vec<Vec<Point3<f64>>>) = behind_faces
            .chain(obstacles.map(|body| (body.id, body.points_W)))
            .unzip();
        let behind = |face: &Face| {
            let bodies = bodies.iter();
            bodies.map(|b| face.is_behind(b, BEHIND_M)).collect()
        };
        let world = World::new(&bodies).map_err(|(i, cause)| Error::Body {
            body: body_names[i].clone(),
            cause: cause.to_string(),
        })?;
        Ok(Self {
            behind: terrain.faces.iter().map(behind).collect(),
            inset: terrain.faces.iter().map(|_| OnceLock::new()).collect(),
            faces: terrain.faces,
            edge_sigmas,
            world,
            body_names,
        })
    }

    /// The face of that name.
    ///
    /// # Errors
    /// [`Error::UnknownFace`] with the names that there are.
    pub fn face(&self, id: &str) -> Result<FaceIndex, Error> {
        let position = self.faces.iter().position(|face| face.id.as_str() == id);
        position.map(FaceIndex).ok_or_else(|| Error::UnknownFace {
            face: id.to_owned(),
            known: self.faces.iter().map(|face| face.id.to_string()).collect(),
        })
    }

    /// All faces.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = FaceIndex> + Clone + use<> {
        (0..self.faces.len()).map(FaceIndex)
    }

    /// The connected parts of what a face's insets leave.
    fn inset(&self, face: FaceIndex) -> &[Region] {
        self.inset[face.0].get_or_init(|| self.outline(face, 0.0).regions())
    }

    /// Where on a face points may be that stay `margin_m` inside what its insets leave, in its
    /// frame.
    pub fn outline(&self, face: FaceIndex, margin_m: f64) -> Outline {
        self[face].inset_region(self.edge_sigmas, margin_m)
    }

    /// The distance of a point of W from what a face's insets leave of it, m: beside the edge (0
    /// inside) and over the plane; nothing where they leave nothing.
    pub fn distances_m(&self, face: FaceIndex, p_W: &Point3<f64>) -> Option<(f64, f64)> {
        let p_F = self[face].X_WF.inverse_transform_point(p_W);
        let beside = |region: &Region| (region.nearest(&p_F.xy()) - p_F.xy()).norm();
        let nearest = self.inset(face).iter().map(beside);
        Some((nearest.min_by(f64::total_cmp)?, p_F.z))
    }

    /// The convex bodies to keep away from.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Name of a body of [`Self::world`].
    pub fn body_name(&self, body: usize) -> &str {
        &self.body_names[body]
    }

    /// Whether a body of the world lies wholly behind the plane of a face: a link whose patch
    /// rests on the face cannot meet it.
    pub fn is_behind(&self, face: FaceIndex, body: usize) -> bool {
        self.behind[face.0][body]
    }
}

impl Index<FaceIndex> for Environment {
    type Output = Face;

    fn index(&self, face: FaceIndex) -> &Face {
        &self.faces[face.0]
    }
}
