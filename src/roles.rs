//! Which patch of the robot may touch which surface.

use robot_model::Robot;
use surfaces::SurfaceSet;
use surfaces::role::{Config, Filter};

/// For each patch of the robot the surfaces it may touch, by the filters of its roles.
///
/// A role without a filter asks for nothing. What a patch touches at the start it may touch again.
pub fn usable(
    robot: &Robot,
    set: &SurfaceSet,
    at_start: &[(usize, usize)],
    config: &Config,
) -> Vec<Vec<usize>> {
    let open = Filter::default();
    robot
        .patches
        .iter()
        .enumerate()
        .map(|(patch, shape)| {
            let filters: Vec<&Filter> = shape
                .roles
                .iter()
                .map(|role| config.filter(role).unwrap_or(&open))
                .collect();
            (0..set.surfaces.len())
                .filter(|&surface| {
                    at_start.contains(&(patch, surface))
                        || filters
                            .iter()
                            .any(|f| f.accepts(&set.surfaces[surface]).is_ok())
                })
                .collect()
        })
        .collect()
}
