//! The world that a plan is simulated in.
#![allow(non_snake_case)]

use anyhow::{Result, bail};
use nalgebra::Vector3;
use planner::plan::Plan;
use simulation::world::{WorldBody, WorldShape};

use crate::command::simulate::World;

/// The bodies of a plan's world, and whether they are the true ones.
///
/// # Errors
/// Where the true world is asked for and not known.
pub fn world(plan: &Plan, choice: World) -> Result<(Vec<WorldBody>, bool)> {
    let known = plan
        .inputs
        .iter()
        .filter(|input| input.role == "scene")
        .filter_map(|input| input.name.strip_prefix("builtin:"))
        .find_map(scenes::builtin);
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
    }
}

/// The bodies behind the surfaces, where no obstacle already is one, and the obstacles.
fn planned(plan: &Plan) -> Vec<WorldBody> {
    let has_body = |id: &str| {
        plan.obstacles
            .iter()
            .any(|o| o.surface.as_deref() == Some(id))
    };
    let thin = plan
        .surfaces
        .iter()
        .filter(|surface| !has_body(&surface.id))
        .map(|surface| WorldBody {
            name: surface.id.clone(),
            shape: WorldShape::Hull(surface.thin_body(plan.thin_body_m).points_W),
        });
    let obstacles = plan.obstacles.iter().map(|obstacle| WorldBody {
        name: obstacle.id.clone(),
        shape: WorldShape::Hull(obstacle.points_W.clone()),
    });
    thin.chain(obstacles).collect()
}
