//! The world that a plan is simulated in.
#![allow(non_snake_case)]

use anyhow::{Result, bail};
use nalgebra::Vector3;
use planner::plan::Plan;
use simulation::world::{WorldBody, WorldShape};
use surfaces::Surface;

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

/// The bodies behind the surfaces, where no obstacle already is one, and the obstacles that were
/// seen.
fn planned(plan: &Plan) -> Vec<WorldBody> {
    let seen = || plan.obstacles.iter().filter(|o| !o.assumed);
    let has_body = |id: &str| seen().any(|o| o.surface.as_deref() == Some(id));
    let thin = plan
        .surfaces
        .iter()
        .filter(|surface| !has_body(&surface.id))
        .map(|surface| {
            let surface = Surface {
                edge_m: 0.0,
                depth_m: 0.0,
                ..surface.clone()
            };
            WorldBody {
                shape: WorldShape::Hull(surface.thin_body(plan.thin_body_m).points_W),
                name: surface.id,
            }
        });
    let obstacles = seen().map(|obstacle| WorldBody {
        name: obstacle.id.clone(),
        shape: WorldShape::Hull(obstacle.points_W.clone()),
    });
    thin.chain(obstacles).collect()
}
