//! The world that a plan is simulated in.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use nalgebra::{Point3, Vector3};
use plan::Plan;
use simulation::world::{WorldBody, WorldShape};
use surfaces::outline::Outline;
use surfaces::{Face, Obstacle, Source};

use crate::command::simulate::World;
use crate::config::Config;
use crate::environment::perceive;
use crate::provenance::Inputs;
use crate::report::Stages;
use crate::scene::{Environment, Files};

/// A face is farther off its body than this by no scan, m.
const SEEN_OFF_M: f64 = 0.05;
/// A mesh's body is no farther off the plane of the face that it is under, m.
const OF_PLANE_M: f64 = 0.002;

/// The bodies of a plan's world, and whether they are the true ones.
///
/// # Errors
/// Where the true world is asked for and not known.
pub fn world(plan: &Plan, choice: World) -> Result<(Vec<WorldBody>, bool)> {
    let scenes = plan.inputs.iter().filter(|input| input.role == "scene");
    let mut builtin = scenes.filter_map(|input| input.name.strip_prefix("builtin:"));
    let known = builtin.find_map(scenes::builtin);
    match (choice, known) {
        (World::Known | World::True, Some(scene)) => {
            let mut bodies: Vec<WorldBody> = (scene.truth)().boxes.iter().map(body).collect();
            make_slippery(&mut bodies, &plan.faces);
            Ok((bodies, true))
        }
        (World::True, None) => {
            bail!("what really stands in {:?} is not known", plan.scene)
        }
        (World::Known | World::Planned, _) => {
            let bodies = standing(&plan.faces, &plan.obstacles, plan.thin_body_m);
            Ok((bodies, false))
        }
    }
}

/// The bodies of a mesh of what really stands there, with the friction of the faces that were seen of them.
///
/// # Errors
/// As [`perceive`].
pub fn of_mesh(mesh: &Path, seen: &[Face], config: &Config) -> Result<Vec<WorldBody>> {
    let source = Environment::Mesh(mesh.display().to_string());
    let (mut stages, mut inputs) = (Stages::default(), Inputs::default());
    let here = Files::Folder(PathBuf::new());
    let terrain = perceive(&source, &here, config, &mut stages, &mut inputs)?.terrain;
    // The mesh itself is behind its faces.
    let mut bodies = standing(&[], &terrain.obstacles, 0.0);
    make_slippery(&mut bodies, seen);
    Ok(bodies)
}

fn body(solid: &scenes::OrientedBox) -> WorldBody {
    WorldBody {
        name: solid.name.clone(),
        part_of: solid.name.clone(),
        shape: WorldShape::Box {
            X_WO: solid.X_WO(),
            half_m: Vector3::from(solid.size_m) / 2.0,
        },
        friction: None,
    }
}

/// Gives bodies the friction of the faces that were seen of them: each face is of the body of which the
/// surface is nearest to its middle. Of several the least counts.
fn make_slippery(bodies: &mut [WorldBody], faces: &[Face]) {
    for face in faces {
        let (n, p) = (
            face.normal_W(),
            face.point_W(&face.region.centroid()).coords,
        );
        let Some(own) = face.friction else { continue };
        let away = bodies.iter_mut().map(|b| (b.face_distance_m(&p, &n), b));
        let nearest = away.min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, body)) = nearest.filter(|(away_m, _)| *away_m < SEEN_OFF_M) {
            body.friction = Some(body.friction.map_or(own, |least| least.min(own)));
        }
    }
}

/// The least friction of the faces of a mesh that are sides of one of its bodies, or parts of sides.
fn friction_of_mesh(points_W: &[Point3<f64>], faces: &[Face]) -> Option<f64> {
    let of_mesh = faces.iter().filter(|face| face.source == Source::Mesh);
    let own = of_mesh.filter_map(|face| {
        let friction = face.friction?;
        let on_plane = |p: &&Point3<f64>| face.height_of(p).abs() <= OF_PLANE_M;
        let side: Vec<Vector3<f64>> = points_W.iter().filter(on_plane).map(|p| p.coords).collect();
        let middle_W = Point3::from(side.iter().sum::<Vector3<f64>>() / side.len() as f64);
        let middle = face.X_WF.inverse_transform_point(&middle_W).xy();
        let is_its = side.len() >= 3 && Outline::from(&face.region).contains(&middle);
        is_its.then_some(friction)
    });
    own.reduce(f64::min)
}

/// The bodies behind the faces, where no obstacle already is one, and the obstacles that were seen. Behind the faces of a
/// mesh are the mesh's bodies: others, of the thickness of those behind scanned faces, would stand out of the far side of
/// a thin board.
fn standing(faces: &[Face], obstacles: &[Obstacle], thin_m: f64) -> Vec<WorldBody> {
    let seen = || obstacles.iter().filter(|o| !o.assumed);
    let has_body = |id: &str| seen().any(|o| o.surface.as_deref() == Some(id));
    let mesh = seen().any(|o| o.surface.is_none());
    let of_mesh = |face: &Face| mesh && face.source == Source::Mesh;
    let bare = |face: &&Face| !of_mesh(face) && !has_body(face.id.as_str());
    let bare = faces.iter().filter(bare);
    let thin = bare.flat_map(|face| {
        // What was seen of it, and not what is kept away from.
        let face = Face {
            depth_m: 0.0,
            source: Source::File,
            ..face.clone()
        };
        let (bodies, friction) = (face.bodies_W(thin_m).into_iter(), face.friction);
        bodies.map(move |points_W| WorldBody {
            name: face.id.to_string(),
            part_of: face.id.to_string(),
            shape: WorldShape::Hull(points_W),
            friction,
        })
    });
    let obstacles = seen().map(|obstacle| {
        let face = faces
            .iter()
            .find(|face| Some(face.id.as_str()) == obstacle.surface.as_deref());
        WorldBody {
            name: obstacle.id.clone(),
            part_of: obstacle.surface.as_ref().unwrap_or(&obstacle.id).clone(),
            shape: WorldShape::Hull(obstacle.points_W.clone()),
            friction: match face {
                Some(face) => face.friction,
                None => friction_of_mesh(&obstacle.points_W, faces),
            },
        }
    });
    thin.chain(obstacles).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;
    use surfaces::Region;

    use super::*;

    #[test]
    fn what_is_known_of_a_face_counts_for_the_body_under_it() {
        let scene = scenes::builtin("irregular-stairs").unwrap();
        let mut bodies: Vec<WorldBody> = (scene.truth)().boxes.iter().map(body).collect();
        let top = |body: &WorldBody| {
            let corners = body.corners_W();
            let sum: Vector3<f64> = corners.iter().map(|c| c.coords).sum();
            let high = corners
                .iter()
                .map(|c| c.z)
                .fold(f64::NEG_INFINITY, f64::max);
            Vector3::new(sum.x / 8.0, sum.y / 8.0, high)
        };
        let corners = [[-0.05, -0.05], [0.05, -0.05], [0.05, 0.05], [-0.05, 0.05]];
        let square = surfaces::ConvexPolygon::new(corners.map(Into::into).to_vec()).unwrap();
        let face = |body: &WorldBody, own: Option<f64>, off_m: f64| Face {
            friction: own,
            ..Face::new(
                "seen",
                Isometry3::from(top(body) + Vector3::z() * off_m),
                Region::from(&square),
            )
        };
        let last = bodies.len() - 1;
        let faces = [
            face(&bodies[last], Some(0.3), 0.004),
            face(&bodies[last], Some(0.2), -0.004),
            face(&bodies[last], None, 0.0),
            face(&bodies[0], Some(0.1), 0.2),
        ];
        make_slippery(&mut bodies, &faces);
        let own: Vec<Option<f64>> = bodies.iter().map(|b| b.friction).collect();
        assert!(own[..last].iter().all(Option::is_none), "{own:?}");
        assert_eq!(own[last], Some(0.2));
    }

    /// Of a board of 20 mm nothing stands out, however thick the bodies behind scanned faces are.
    #[test]
    fn a_mesh_stands_as_it_is_and_is_as_slippery_as_its_faces() {
        let side = |id: &str, X_WF: Isometry3<f64>, friction: f64| Face {
            source: Source::Mesh,
            friction: Some(friction),
            ..Face::rectangle(id, X_WF, [1.0, 1.0]).unwrap()
        };
        let turned = Isometry3::rotation(Vector3::x() * std::f64::consts::PI);
        let top = Isometry3::translation(0.5, 0.5, 0.02);
        let faces = [
            side("m0", top, 0.3),
            side("m1", Isometry3::translation(0.5, 0.5, 0.0) * turned, 0.4),
            side("m2", Isometry3::translation(5.0, 5.0, 0.0), 0.1),
        ];
        let board = Obstacle::cuboid("mesh/solid0", [0.0, 0.0, 0.0], [1.0, 1.0, 0.02]);
        let bodies = standing(&faces, &[board], 0.03);
        let heights = bodies.iter().flat_map(WorldBody::corners_W).map(|p| p.z);
        assert_eq!(heights.fold(f64::NEG_INFINITY, f64::max), 0.02);
        assert_eq!((bodies.len(), bodies[0].friction), (1, Some(0.3)));
    }

    #[test]
    fn the_bodies_of_a_mesh_have_the_friction_that_was_seen_of_them() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("block.obj");
        let corners = (0..8).map(|k| [0, 1, 2].map(|axis| f64::from(k >> axis & 1)));
        let corners = corners.map(|[x, y, z]| format!("v {x} {y} {z}\n"));
        let sides = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
        std::fs::write(&file, corners.collect::<String>() + sides).unwrap();
        let top = Isometry3::translation(0.5, 0.5, 1.01);
        let mut seen = Face::rectangle("seen", top, [0.5, 0.5]).unwrap();
        seen.friction = Some(0.3);
        let bodies = of_mesh(&file, &[seen], &Config::default()).unwrap();
        assert_eq!(bodies.len(), 1, "{bodies:?}");
        assert_eq!(
            (bodies[0].corners_W().len(), bodies[0].friction),
            (8, Some(0.3))
        );
    }
}
