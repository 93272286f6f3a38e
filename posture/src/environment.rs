//! What a robot may touch and must not hit.

use std::ops::Index;
use std::sync::OnceLock;

use nalgebra::{Isometry3, Point3, Vector3};
use robot_model::collision::{BoxIndex, Shape, ShapeGeometry, World, gap_m};
use robot_model::{ContactPatch, Robot};
use surfaces::outline::Outline;
use surfaces::{Face, Region, Source, Terrain};

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
    /// The boxes around the faces.
    index: BoxIndex,
}

/// How far a body may rise over a plane and still count as behind it, m: two scanned planes of one
/// floor differ by as much. Faces of a mesh are where it has them, to what their triangles are off a plane.
const BEHIND_M: f64 = 0.015;
const BEHIND_MESH_M: f64 = 0.003;
/// How deep a link that stands on a face with a ball may be in what lies behind it, m: four fifths of
/// what `verify` allows.
const CONTACT_DEPTH_M: f64 = 4e-3;
/// Ground that leans by no more than this from the plane that a ball touches holds it as well, where friction is at least
/// 0.58; what is steeper is a thing beside it, rad.
const GENTLE_RAD: f64 = 30.0_f64.to_radians();

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
        let world = World::new(&bodies).map_err(|(i, cause)| Error::Body {
            body: body_names[i].clone(),
            cause: cause.to_string(),
        })?;
        Ok(Self {
            index: BoxIndex::new(terrain.faces.iter().map(box_around)),
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

    /// The faces whose boxes along W's axes meet a box, in ascending order.
    pub fn faces_near(&self, low: &Point3<f64>, high: &Point3<f64>) -> Vec<FaceIndex> {
        let found = self.index.near(low, high, 0.0).into_iter();
        found.map(FaceIndex).collect()
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
        self.rise_m(face, body).is_some()
    }

    /// How far a body rises over a face's plane, m, where that is so little that it lies behind it.
    pub fn rise_m(&self, face: FaceIndex, body: usize) -> Option<f64> {
        let (face, body) = (&self.faces[face.0], &self.world.obstacles()[body]);
        let up_O = body.pose().inverse_transform_vector(&face.normal_W());
        let highest_W = body.pose() * body.geometry().support(&up_O);
        let rise_m = face.height_of(&highest_W).max(0.0);
        let most_m = match face.source {
            Source::Mesh => BEHIND_MESH_M,
            Source::Scan | Source::File | Source::Robot => BEHIND_M,
        };
        (rise_m <= most_m).then_some(rise_m)
    }

    /// The least distance, m, between a body of the world that lies behind the plane of a face and a shape of a link that
    /// rests on the face, or carries one that does; nothing where the body does not lie behind it, or the link does neither.
    ///
    /// A flat patch holds its link over the plane, so that nothing is asked of the distance (−∞). The links that carry it
    /// ([`Robot::are_close`]) are held over it as well, wherever the plane is: they keep what parts of the robot keep from
    /// each other, `carrying_m`. A ball lets its link tilt, and into the ground: what holds the ball may be as deep
    /// there as the body rises over the plane, and a little more; any other shape of the link stays off it by half of the
    /// ball's radius, as it does where the link is upright.
    pub fn contact_distance_m(
        &self,
        robot: &Robot,
        (patch, face): (&ContactPatch, FaceIndex),
        shape: &Shape,
        body: usize,
        carrying_m: f64,
    ) -> Option<f64> {
        let radius_m = patch.point_radius_m();
        let (is_own, is_ball) = (shape.body == patch.body, radius_m.is_some());
        if !is_own && (is_ball || !robot.are_close(patch.body, shape.body)) {
            return None;
        }
        let rise_m = self.rise_m(face, body)?;
        Some(match radius_m {
            Some(radius_m) if !shape.is_pad => 0.5 * radius_m,
            Some(_) => -CONTACT_DEPTH_M - rise_m,
            None if is_own => f64::NEG_INFINITY,
            None => carrying_m,
        })
    }

    /// Whether ground of a unit normal leans so little from a face that a ball on the face could stand on it as well.
    pub fn is_gentle(&self, face: FaceIndex, normal_W: &Vector3<f64>) -> bool {
        normal_W.angle(&self[face].normal_W()) <= GENTLE_RAD
    }

    /// The least distance, m, between a body of the world that rises over the plane of a face and a link that rests on the
    /// face with a ball, where the body is ground that rises gently beside it, as in a hollow between the triangles of a
    /// mesh; nothing where it stands there as a thing to keep clear of.
    ///
    /// Ground it is where a plane that leans little from the face's parts it from the shape. The ball itself may come to
    /// where it touches both. What holds it may where it is near the ball, and stays off the more the farther from it; all
    /// else of the link stays off by half of the ball's radius.
    pub fn beside_contact_m(
        &self,
        (patch, face): (&ContactPatch, FaceIndex),
        shape: &PlacedShape,
        body: usize,
    ) -> Option<f64> {
        let radius_m = patch.point_radius_m()?;
        let most_m = 0.5 * radius_m;
        let normal_W = &shape.normal_W;
        let (parts_m, least_m) = match shape.is_pad {
            true => {
                let centre_B = Point3::from(patch.X_BC.translation.vector);
                let centre_W = shape.X_WG * shape.X_BG.inverse_transform_point(&centre_B);
                let off_m = (shape.nearest_W - centre_W).norm() - radius_m;
                (0.0, (0.5 * off_m).clamp(0.0, most_m))
            }
            false => (most_m, most_m),
        };
        if self.is_gentle(face, normal_W) {
            return Some(least_m);
        }
        // The nearest point may be on the edge of ground that falls away from it: the steepest plane that counts, then.
        let up_W = self[face].normal_W();
        let aside_W = (normal_W - up_W * normal_W.dot(&up_W)).try_normalize(0.0)?;
        let across_W = up_W * GENTLE_RAD.cos() + aside_W * GENTLE_RAD.sin();
        let body = &self.world.obstacles()[body];
        let (geometry, X_WG) = (shape.geometry, shape.X_WG);
        let gap_m = gap_m(geometry, X_WG, body.geometry(), body.pose(), &across_W);
        (gap_m >= parts_m).then_some(least_m)
    }
}

/// A shape of a robot where it is, near a body of the world.
#[derive(Clone, Copy)]
pub struct PlacedShape<'a> {
    /// The shape.
    pub geometry: &'a ShapeGeometry,
    /// Its pose in its link's frame.
    pub X_BG: &'a Isometry3<f64>,
    /// Its pose in W.
    pub X_WG: &'a Isometry3<f64>,
    /// Whether it may be a part of what touches.
    pub is_pad: bool,
    /// Its point that is nearest to the body.
    pub nearest_W: Point3<f64>,
    /// The direction in which they are apart, toward the shape.
    pub normal_W: Vector3<f64>,
}

/// The lowest and the highest corner of the box along W's axes around a face.
fn box_around(face: &Face) -> (Point3<f64>, Point3<f64>) {
    let corners = face.vertices_W();
    let first = corners.first().copied().unwrap_or_default();
    let corners = corners.iter();
    corners.fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)))
}

impl Index<FaceIndex> for Environment {
    type Output = Face;

    fn index(&self, face: FaceIndex) -> &Face {
        &self.faces[face.0]
    }
}
