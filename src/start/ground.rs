//! The ground under the feet at the start, known from the robot's own kinematics.
//!
//! A camera on the head does not see where its robot stands. The soles do: their planes are
//! support faces. A face that continues a surface of the scan is joined to it, so that the search
//! sees one floor.

use nalgebra::{Isometry3, Point2, Point3, UnitQuaternion, Vector2, Vector3};
use robot_model::{Kinematics, PatchId, Robot};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use surfaces::{ConvexPolygon, Face, FaceId, Region, Source, Terrain};

use super::StartState;

mod join;
mod nowhere;

use join::Floor;

/// Soles whose vertices lie in one plane to this distance stand on one face, and on a surface that
/// is known to be there, m: what a named posture's rounded joints leave between two soles, half of
/// what the verifier grants.
const SAME_FACE_M: f64 = 5e-4;

/// What its first face is called.
const NAME: &str = "ground";

/// Settings of the ground under the feet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Border of ground around the hull of the soles, m.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub border_m: f64,
    /// The largest unseen gap between the soles' border and a scanned surface in their plane that
    /// is taken for floor too, m.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub join_gap_m: f64,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            border_m: 0.02,
            join_gap_m: 0.30,
        }
    }
}

/// The ground under the start's contacts.
#[derive(Clone, Debug, PartialEq)]
pub struct Ground {
    /// For each start contact, in the order given: its patch and the face it is on.
    pub contacts: Vec<(PatchId, FaceId)>,
    /// What was done, for the user.
    pub notes: Vec<String>,
}

/// Adds to `terrain` the faces that the robot stands on at the start; `is_before` says that it was to stand before the floor
/// that is seen, which is then no remedy for a gap.
///
/// 1. Soles in one plane are one face: their hull with a border. Where the terrain has a face in
///    that plane with room for all of them, it is that face.
/// 2. A scanned face that lies in its plane is moved exactly into it; a face of a file or a mesh is
///    known better than that and stays where it is.
/// 3. If there is a gap between the two, the face reaches over it at its own width.
///
/// # Errors
/// In words: a patch whose polygon is degenerate in the plane of its face.
pub fn add_ground(
    terrain: &mut Terrain,
    robot: &Robot,
    (stand, is_before): (&StartState, bool),
    config: &Config,
    edge_sigmas: f64,
) -> anyhow::Result<Ground> {
    let kinematics = Kinematics::new(robot, &stand.configuration);
    let given = terrain.faces.len();
    let mut ground = Ground {
        contacts: Vec::new(),
        notes: Vec::new(),
    };
    let soles = stand.patches.iter();
    let soles = soles.map(|&p| Sole::new(robot, &kinematics, p, &stand.X_WG));
    let soles: Vec<Sole> = soles.collect();

    for (number, members) in faces(&soles).iter().enumerate() {
        let patches = members.iter().map(|&m| soles[m].patch);
        if let Some(face) = known_face(terrain, &soles, members, edge_sigmas) {
            let contacts = patches.map(|patch| (patch, face.id.clone()));
            ground.contacts.extend(contacts);
            continue;
        }
        let id = unique_id(terrain, number);
        let (mut X_WF, mut polygon) = hull(&soles, members, config.border_m)?;
        // One floor is as slippery here as there.
        let mut friction: Option<f64> = None;
        let mut is_joined = false;
        let mut nearest: Option<(f64, &FaceId)> = None;
        for floor in &mut terrain.faces[..given] {
            let (gap_m, notes) = (config.join_gap_m, &mut ground.notes);
            match join::join(&mut X_WF, &mut polygon, floor, gap_m, notes) {
                Floor::Other => {}
                Floor::Apart(apart_m) => {
                    let before = nearest.filter(|(before_m, _)| *before_m <= apart_m);
                    nearest = before.or(Some((apart_m, &floor.id)));
                }
                Floor::Joined => {
                    is_joined = true;
                    friction = friction.into_iter().chain(floor.friction).reduce(f64::min);
                }
            }
        }
        match nearest {
            _ if is_joined => {}
            Some((apart_m, floor)) => ground.notes.push(format!(
                "warning: {floor} continues the ground under the feet {apart_m:.2} m from them; what is between \
                 was not seen, and is not stepped on: take a scan that shows it too (the sensor nods){}, or, where it \
                 is known to be floor, --set ground.join_gap_m={:.2}",
                match is_before {
                    true => String::new(),
                    false => format!(", start before {floor} (--before-floor)"),
                },
                apart_m + 0.005
            )),
            None => {
                let middle = Point3::from(mean_plane(&soles, members).translation.vector);
                ground.notes.extend(nowhere::note(terrain, &middle));
            }
        }
        let contacts = patches.map(|patch| (patch, FaceId::from(id.as_str())));
        ground.contacts.extend(contacts);
        terrain.faces.push(Face {
            source: Source::Robot,
            friction,
            ..Face::new(id, X_WF, Region::from(&polygon))
        });
    }
    // Back into the order in which the contacts were named.
    let named = |patch: &PatchId| stand.patches.iter().position(|s| s == patch);
    ground.contacts.sort_by_key(|(patch, _)| named(patch));
    Ok(ground)
}

/// A patch that touches the ground at the start.
struct Sole {
    patch: PatchId,
    X_WC: Isometry3<f64>,
    /// Radius of a ball, m.
    radius_m: Option<f64>,
    /// Of a ball the point that touches the ground of the start.
    vertices_W: Vec<Point3<f64>>,
}

impl Sole {
    fn new(robot: &Robot, kinematics: &Kinematics, patch: PatchId, X_WG: &Isometry3<f64>) -> Self {
        let shape = &robot.patches[patch];
        let mut X_WC = kinematics.X_WC(shape);
        let radius_m = shape.point_radius_m();
        // A ball does not tell how the ground under it is tilted.
        if let Some(radius) = radius_m {
            X_WC.rotation = X_WG.rotation;
            X_WC.translation.vector -= X_WG.rotation * Vector3::z() * radius;
        }
        let vertices = shape.polygon.iter();
        Self {
            patch,
            X_WC,
            radius_m,
            vertices_W: vertices
                .map(|v| X_WC * Point3::new(v.x, v.y, 0.0))
                .collect(),
        }
    }

    /// What touches a plane of that normal: the vertices, or the point of a ball.
    fn touching(&self, normal: &Vector3<f64>) -> impl Iterator<Item = Point3<f64>> + '_ {
        let up = self.X_WC.rotation * Vector3::z();
        let turned = self.radius_m.unwrap_or(0.0) * (up - normal);
        self.vertices_W.iter().map(move |v| v + turned)
    }

    /// Largest distance of a vertex of `other` from this sole's plane, m.
    fn off_plane_m(&self, other: &Sole) -> f64 {
        let height = |v| self.X_WC.inverse_transform_point(v).z.abs();
        other.vertices_W.iter().map(height).fold(0.0, f64::max)
    }
}

/// The soles, grouped by plane.
fn faces(soles: &[Sole]) -> Vec<Vec<usize>> {
    let mut faces: Vec<Vec<usize>> = Vec::new();
    for (i, sole) in soles.iter().enumerate() {
        let same = |face: &&mut Vec<usize>| soles[face[0]].off_plane_m(sole) <= SAME_FACE_M;
        match faces.iter_mut().find(same) {
            Some(face) => face.push(i),
            None => faces.push(vec![i]),
        }
    }
    faces
}

/// The face that the soles stand on already, as a file or a mesh may give it.
fn known_face<'t>(
    terrain: &'t Terrain,
    soles: &[Sole],
    members: &[usize],
    edge_sigmas: f64,
) -> Option<&'t Face> {
    let upward = soles[members[0]].X_WC.rotation * Vector3::z();
    terrain.faces.iter().find(|face| {
        let normal = face.normal_W();
        let vertices = || members.iter().flat_map(|&m| soles[m].touching(&normal));
        let in_plane = vertices().all(|v| face.height_of(&v).abs() <= SAME_FACE_M);
        if !in_plane || normal.dot(&upward) <= 0.0 {
            return false;
        }
        let regions = face.inset_region(edge_sigmas, 0.0).regions();
        regions.iter().any(|region| {
            vertices().all(|v| {
                let p = face.X_WF.inverse_transform_point(&v).xy();
                (region.nearest(&p) - p).norm() <= SAME_FACE_M
            })
        })
    })
}

/// The hull of the soles and a border, in their mean plane.
fn hull(
    soles: &[Sole],
    members: &[usize],
    border_m: f64,
) -> anyhow::Result<(Isometry3<f64>, ConvexPolygon)> {
    let plane = mean_plane(soles, members);
    let points: Vec<Point2<f64>> = members
        .iter()
        .flat_map(|&m| &soles[m].vertices_W)
        .map(|v| plane.inverse_transform_point(v).xy())
        .flat_map(|p| around(p, border_m))
        .collect();
    let hull = ConvexPolygon::hull(&points)
        .map_err(|error| anyhow::anyhow!("the ground under the start: {error}"))?;
    centred(&plane, &hull)
}

/// The frame of the first sole, turned to the mean normal and moved to the mean of the vertices.
fn mean_plane(soles: &[Sole], members: &[usize]) -> Isometry3<f64> {
    let first = &soles[members[0]].X_WC;
    let normal_of = |m: &usize| soles[*m].X_WC.rotation * Vector3::z();
    let normal: Vector3<f64> = members.iter().map(normal_of).sum();
    let turn = UnitQuaternion::rotation_between(&normal_of(&members[0]), &normal)
        .unwrap_or_else(UnitQuaternion::identity);
    let vertices: Vec<Vector3<f64>> = members
        .iter()
        .flat_map(|&m| &soles[m].vertices_W)
        .map(|v| v.coords)
        .collect();
    let middle = vertices.iter().sum::<Vector3<f64>>() / vertices.len().max(1) as f64;
    Isometry3::from_parts(middle.into(), turn * first.rotation)
}

/// The corners of an octagon whose inscribed circle about `p` has radius `border_m`.
fn around(p: Point2<f64>, border_m: f64) -> impl Iterator<Item = Point2<f64>> {
    let eighth = std::f64::consts::FRAC_PI_4;
    let radius = border_m / (0.5 * eighth).cos();
    (0..8).map(move |i| {
        let angle = (f64::from(i) + 0.5) * eighth;
        p + radius * Vector2::new(angle.cos(), angle.sin())
    })
}

/// The same polygon with the frame's origin at its centroid.
fn centred(
    X_WF: &Isometry3<f64>,
    polygon: &ConvexPolygon,
) -> anyhow::Result<(Isometry3<f64>, ConvexPolygon)> {
    let centroid = polygon.centroid();
    let moved = polygon.vertices().iter().map(|v| v - centroid.coords);
    let origin = X_WF * Point3::new(centroid.x, centroid.y, 0.0);
    let X_WF = Isometry3::from_parts(origin.into(), X_WF.rotation);
    Ok((X_WF, ConvexPolygon::new(moved.collect())?))
}

/// Whether the ground under the feet may have this name.
pub fn is_name(id: &str) -> bool {
    id.starts_with(NAME)
}

/// A name for the ground that nothing has yet.
fn unique_id(terrain: &Terrain, number: usize) -> String {
    let taken = |id: &str| {
        terrain.faces.iter().any(|f| f.id.as_str() == id)
            || terrain.obstacles.iter().any(|o| o.id == id)
    };
    let mut id = match number {
        0 => NAME.to_owned(),
        _ => format!("{NAME}-{}", number + 1),
    };
    while taken(&id) {
        id.push('\'');
    }
    id
}

#[cfg(test)]
mod tests;
