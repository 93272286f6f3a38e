//! What is drawn of the world, the robot and its contacts: entities of `foxglove.SceneUpdate`.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use plan::{Contact, Plan, Sample};
use robot_model::Robot;
use robot_model::collision::{Hull, ShapeGeometry};
use serde_json::{Value, json};

use super::super::frames::{isometry, rounded, wrench};
use super::{WORLD, time};

/// Length of an arrow of 1 N, m.
const NEWTON_M: f64 = 0.001;
/// Colours: red, green, blue, opacity.
const FACE: [f64; 4] = [0.45, 0.6, 0.45, 1.0];
const OBSTACLE: [f64; 4] = [0.6, 0.6, 0.6, 0.5];
const LINK: [f64; 4] = [0.75, 0.77, 0.8, 1.0];
const FORCE: [f64; 4] = [0.85, 0.2, 0.15, 1.0];
const PATCH: [f64; 4] = [0.1, 0.35, 0.85, 1.0];
/// Diameter of the ball at the centre of mass, m.
const COM_M: f64 = 0.05;

/// A thing in one frame, made of primitives.
#[derive(Default)]
struct Entity {
    arrows: Vec<Value>,
    cubes: Vec<Value>,
    spheres: Vec<Value>,
    cylinders: Vec<Value>,
    lines: Vec<Value>,
    triangles: Vec<Value>,
}

impl Entity {
    fn into_json(self, id: &str, frame: &str, t_s: f64) -> Value {
        json!({
            "timestamp": time(t_s), "frame_id": frame, "id": id, "lifetime": time(0.0), "frame_locked": true,
            "metadata": [], "arrows": self.arrows, "cubes": self.cubes, "spheres": self.spheres,
            "cylinders": self.cylinders, "lines": self.lines, "triangles": self.triangles, "texts": [], "models": [],
        })
    }

    fn sphere(&mut self, X: &Isometry3<f64>, radius_m: f64, colour: [f64; 4]) {
        let size = xyz(&Vector3::repeat(2.0 * radius_m));
        let sphere = json!({ "pose": pose(X), "size": size, "color": rgba(colour) });
        self.spheres.push(sphere);
    }

    fn cylinder(&mut self, X: &Isometry3<f64>, half_length_m: f64, radius_m: f64) {
        let size = Vector3::new(2.0 * radius_m, 2.0 * radius_m, 2.0 * half_length_m);
        self.cylinders.push(json!({
            "pose": pose(X), "size": xyz(&size), "bottom_scale": 1.0, "top_scale": 1.0, "color": rgba(LINK),
        }));
    }

    fn hull(&mut self, X: &Isometry3<f64>, hull: &Hull, colour: [f64; 4]) {
        let corners = hull.vertices().iter().map(|p: &Point3<f64>| p.coords);
        self.mesh(X, corners, hull.triangles(), colour);
    }

    fn mesh(
        &mut self,
        X: &Isometry3<f64>,
        corners: impl Iterator<Item = Vector3<f64>>,
        triangles: &[[u32; 3]],
        colour: [f64; 4],
    ) {
        self.triangles.push(json!({
            "pose": pose(X), "points": corners.map(|p| xyz(&p)).collect::<Vec<_>>(), "color": rgba(colour),
            "colors": [], "indices": triangles.as_flattened(),
        }));
    }
}

fn update(entities: Vec<Value>) -> Value {
    json!({ "deletions": [], "entities": entities })
}

/// Faces, and what is only avoided.
pub(super) fn world(plan: &Plan) -> Value {
    let faces = plan.faces.iter().map(|face| {
        let mut entity = Entity::default();
        let triangles = face.region.triangles();
        let corners = triangles.as_flattened().iter();
        let corners = corners.map(|p| Vector3::new(p.x, p.y, 0.0));
        entity.mesh(&face.X_WF, corners, &in_turn(triangles.len()), FACE);
        entity.into_json(&face.id.to_string(), WORLD, 0.0)
    });
    let obstacles = plan.obstacles.iter().filter_map(|obstacle| {
        // A body without an inside has none to be drawn.
        let hull = Hull::new(&obstacle.points_W).ok()?;
        let mut entity = Entity::default();
        entity.hull(&Isometry3::identity(), &hull, OBSTACLE);
        Some(entity.into_json(&obstacle.id.to_string(), WORLD, 0.0))
    });
    update(faces.chain(obstacles).collect())
}

/// Corners of triangles that are given one after the other.
fn in_turn(triangles: usize) -> Vec<[u32; 3]> {
    let first = (0..triangles as u32).map(|i| 3 * i);
    first.map(|i| [i, i + 1, i + 2]).collect()
}

/// The collision shapes of every body, in its frame.
pub(super) fn robot(robot: &Robot) -> Value {
    let mut entities: Vec<Entity> = robot.bodies.iter().map(|_| Entity::default()).collect();
    for shape in robot.collision.shapes() {
        let (entity, X) = (&mut entities[shape.body], &shape.X_BG);
        match &shape.geometry {
            ShapeGeometry::Sphere { radius_m } => entity.sphere(X, *radius_m, LINK),
            ShapeGeometry::Cylinder {
                half_length_m,
                radius_m,
            } => entity.cylinder(X, *half_length_m, *radius_m),
            ShapeGeometry::Capsule {
                half_length_m,
                radius_m,
            } => {
                entity.cylinder(X, *half_length_m, *radius_m);
                for end in [-half_length_m, *half_length_m] {
                    let X = X * Translation3::new(0.0, 0.0, end);
                    entity.sphere(&X, *radius_m, LINK);
                }
            }
            ShapeGeometry::Box { half_extents_m } => {
                let size = xyz(&(2.0 * half_extents_m));
                let cube = json!({ "pose": pose(X), "size": size, "color": rgba(LINK) });
                entity.cubes.push(cube);
            }
            ShapeGeometry::ConvexHull(hull) => entity.hull(X, hull, LINK),
        }
    }
    let bodies = robot.bodies.iter().zip(entities);
    let bodies = bodies.map(|(body, entity)| entity.into_json(&body.name, &body.name, 0.0));
    update(bodies.collect())
}

/// The outlines of the patches that touch, an arrow for each one's force, and the centre of mass; one entity, in
/// the place of the one before.
pub(super) fn contacts(sample: &Sample, closed: &[Contact], robot: &Robot) -> Value {
    let mut entity = Entity::default();
    let [x, y, z] = sample.com_W;
    entity.sphere(&Isometry3::translation(x, y, z), 0.5 * COM_M, FORCE);
    for (contact, forces_W) in closed.iter().zip(&sample.forces_W) {
        let X_WC = isometry(&contact.X_WC);
        let [fx, fy, fz, ..] = wrench(&Contact {
            forces_W: forces_W.clone(),
            ..contact.clone()
        });
        let force = Vector3::new(fx, fy, fz);
        let along = UnitQuaternion::rotation_between(&Vector3::x(), &force);
        let along = along
            .unwrap_or_else(|| UnitQuaternion::from_euler_angles(0.0, 0.0, std::f64::consts::PI));
        let length = NEWTON_M * force.norm();
        entity.arrows.push(json!({
            "pose": pose(&Isometry3::from_parts(X_WC.translation, along)), "shaft_length": rounded(0.8 * length),
            "shaft_diameter": 0.015, "head_length": rounded(0.2 * length), "head_diameter": 0.03, "color": rgba(FORCE),
        }));
        let patch = robot.patches.iter().find(|p| p.name == contact.patch);
        let corners = patch.into_iter().flat_map(|patch| &patch.polygon);
        let corners = corners.map(|p| xyz(&Vector3::new(p.x, p.y, 0.0)));
        entity.lines.push(json!({
            "type": 1, "pose": pose(&X_WC), "thickness": 0.008, "scale_invariant": false,
            "points": corners.collect::<Vec<_>>(), "color": rgba(PATCH), "colors": [], "indices": [],
        }));
    }
    update(vec![entity.into_json("contacts", WORLD, sample.t_s)])
}

pub(super) fn pose(X: &Isometry3<f64>) -> Value {
    let q = X.rotation.coords.map(rounded);
    json!({
        "position": xyz(&X.translation.vector),
        "orientation": { "x": q.x, "y": q.y, "z": q.z, "w": q.w },
    })
}

fn xyz(v: &Vector3<f64>) -> Value {
    let v = v.map(rounded);
    json!({ "x": v.x, "y": v.y, "z": v.z })
}

fn rgba([r, g, b, a]: [f64; 4]) -> Value {
    json!({ "r": r, "g": g, "b": b, "a": a })
}
