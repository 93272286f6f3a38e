//! The world that a plan is simulated in.

use anyhow::{Result, bail};
use nalgebra::Vector3;
use plan::Plan;
use simulation::world::{WorldBody, WorldShape};
use surfaces::{Face, Source};

use crate::command::simulate::World;

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
            Ok(((scene.truth)().boxes.iter().map(body).collect(), true))
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
