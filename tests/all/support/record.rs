//! Plans as records, of stances that were not made by the program.

use plan::{
    Change, PLAN_FORMAT, Plan, Program, RequiredMargins, RobotSummary, SearchSummary, Stance,
};
use robot_model::Robot;
use surfaces::Terrain;

/// A plan of those stances, with no goal and no margins but the generator's own defaults.
pub fn record(robot: &Robot, terrain: Terrain, thin_body_m: f64, stances: Vec<Stance>) -> Plan {
    let count = stances.len();
    let path_stances = stances.iter().filter(|s| s.change != Change::Goal).count();
    Plan {
        format: PLAN_FORMAT.to_owned(),
        program: Program {
            name: "scandent".to_owned(),
            version: "test".to_owned(),
        },
        scene: "exact".to_owned(),
        robot: RobotSummary {
            name: robot.name.clone(),
            joint_names: robot.joint_names().map(str::to_owned).collect(),
            mass_kg: robot.mass_kg,
        },
        faces: terrain.faces,
        obstacles: terrain.obstacles,
        thin_body_m,
        required: RequiredMargins::from(&posture::Config::default()),
        search: SearchSummary {
            nodes_generated: count,
            nodes_expanded: count,
            candidates_solved: count,
            path_stances,
            ..SearchSummary::default()
        },
        stances,
        ..Plan::default()
    }
}
