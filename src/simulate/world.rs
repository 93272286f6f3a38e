//! The world that a plan is simulated in.

use anyhow::{Result, bail};
use nalgebra::Vector3;
use plan::Plan;
use simulation::world::{WorldBody, WorldShape};
use surfaces::{Face, Source};

use crate::command::simulate::World;

/// A face is farther off its body than this by no scan, m.
const SEEN_OFF_M: f64 = 0.05;

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
        (World::Known | World::Planned, _) => Ok((planned(plan), false)),
    }
}

fn body(solid: &scenes::OrientedBox) -> WorldBody {
    WorldBody {
        name: solid.name.clone(),
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

/// The bodies behind the faces, where no obstacle already is one, and the obstacles that were seen.
fn planned(plan: &Plan) -> Vec<WorldBody> {
    let seen = || plan.obstacles.iter().filter(|o| !o.assumed);
    let has_body = |id: &str| seen().any(|o| o.surface.as_deref() == Some(id));
    let bare = plan.faces.iter().filter(|face| !has_body(face.id.as_str()));
    let thin = bare.flat_map(|face| {
        // What was seen of it, and not what is kept away from.
        let face = Face {
            depth_m: 0.0,
            source: Source::File,
            ..face.clone()
        };
        let (bodies, friction) = (face.bodies_W(plan.thin_body_m).into_iter(), face.friction);
        bodies.map(move |points_W| WorldBody {
            name: face.id.to_string(),
            shape: WorldShape::Hull(points_W),
            friction,
        })
    });
    let obstacles = seen().map(|obstacle| {
        let face = plan
            .faces
            .iter()
            .find(|face| Some(face.id.as_str()) == obstacle.surface.as_deref());
        WorldBody {
            name: obstacle.id.clone(),
            shape: WorldShape::Hull(obstacle.points_W.clone()),
            friction: face.and_then(|face| face.friction),
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
}
