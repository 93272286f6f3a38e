//! A start that is clear of what was seen: a little farther back where nothing says how far back, else a hint.

use std::f64::consts::TAU;

use nalgebra::{Translation3, UnitQuaternion, Vector3};
use posture::{Environment, FaceIndex};
use robot_model::collision::{BodyShape, Other};
use robot_model::{Configuration, Kinematics, PatchId, Robot};
use surfaces::Terrain;

use super::{StartState, assumed};
use crate::scene::Start;

/// Places are looked at in steps of this, m.
const STEP_M: f64 = 0.05;
/// What rises less over the ground than this is floor, as far as its plane is known, m.
const RISES_M: f64 = 0.01;
/// A start is farther off than this where no place is clear, m.
const HINT_MAX_M: f64 = 1.0;
/// Directions in which places are looked at.
const DIRECTIONS: usize = 16;

/// Steps back, against the ground's x, until no link is within `clearance_m` of what was seen, `reach_m` at most; where that
/// is not far enough the robot stays. Links that stand may be near to what does not rise over their ground. Says so where
/// it did.
///
/// # Errors
/// Bodies that cannot be made of the terrain.
pub fn step_back(
    stand: &mut StartState,
    robot: &Robot,
    terrain: &Terrain,
    body: impl FnOnce(Terrain) -> Result<Environment, posture::Error>,
    (clearance_m, reach_m): (f64, f64),
) -> Result<Option<String>, posture::Error> {
    let mut seen = terrain.clone();
    seen.obstacles
        .retain(|thing| !assumed::may_be_refuted(thing));
    let environment = body(seen)?;
    // Stepping back is along the ground: its plane stays.
    let (n, on) = (
        stand.X_WG.rotation * Vector3::z(),
        stand.X_WG.translation.vector,
    );
    let rises = |body: usize| {
        let body = &environment.world().obstacles()[body];
        let up_O = body.pose().inverse_transform_vector(&n);
        let highest_W = body.pose() * body.geometry().support(&up_O);
        n.dot(&(highest_W.coords - on)) > RISES_M
    };
    let stands = |shape: BodyShape, body: usize| {
        let mut feet = stand.patches.iter();
        feet.any(|&foot| robot.patches[foot].body == shape.body) && !rises(body)
    };
    let met = |by_m: f64| {
        let by = stand.X_WG.rotation * Vector3::x() * -by_m;
        let moved = moved(&stand.configuration, &by);
        met(robot, &moved, &environment, clearance_m, &stands)
    };
    let Some(body) = met(0.0) else {
        return Ok(None);
    };
    let steps = (1..).map(|k| f64::from(k) * STEP_M);
    let mut steps = steps.take_while(|by_m| *by_m <= reach_m);
    let Some(by_m) = steps.find(|by_m| met(*by_m).is_none()) else {
        return Ok(None);
    };
    let by = stand.X_WG.rotation * Vector3::x() * -by_m;
    stand.configuration = moved(&stand.configuration, &by);
    stand.X_WG = Translation3::from(by) * stand.X_WG;
    Ok(Some(format!(
        "the robot starts {by_m:.2} m farther back from the floor that is seen, clear of {}",
        environment.body_name(body)
    )))
}

/// Where near its start the robot would be clear of what it is too near to there, as --start says it; `contacts` are
/// what it stands on.
pub fn hint(
    robot: &Robot,
    environment: &Environment,
    (q, contacts): (&Configuration, &[(PatchId, FaceIndex)]),
    start: &Start,
    clearance_m: f64,
) -> Option<String> {
    let stands = |shape: BodyShape, body: usize| {
        let mut contacts = contacts.iter();
        let shape = &robot.collision.shapes()[shape.shape];
        contacts.any(|&(patch, face)| {
            let touch = (&robot.patches[patch], face);
            let least_m = environment.contact_distance_m(robot, touch, shape, body, 0.0);
            least_m.is_some()
        })
    };
    let met = |by: &Vector3<f64>| met(robot, &moved(q, by), environment, clearance_m, &stands);
    let body = met(&Vector3::zeros())?;
    let rings = (1..).map(|k| f64::from(k) * STEP_M);
    let rings = rings.take_while(|by_m| *by_m <= HINT_MAX_M);
    // Straight back first.
    let mut places = rings.flat_map(|by_m| {
        (0..DIRECTIONS).map(move |k| {
            let angle = 0.5 * TAU + TAU * k as f64 / DIRECTIONS as f64;
            by_m * Vector3::new(angle.cos(), angle.sin(), 0.0)
        })
    });
    let by = places.find(|by| met(by).is_none())?;
    let [x, y, z]: [f64; 3] = (q.p_WB + by).into();
    let (roll, pitch, yaw) = q.R_WB.euler_angles();
    let turned = match q.R_WB.angle_to(&UnitQuaternion::identity()) > 1e-3 {
        true => format!(",{roll:.3},{pitch:.3},{yaw:.3}"),
        false => String::new(),
    };
    let flag = match start {
        Start::Over { name, .. } => format!(
            ": --start {}@{x:.2},{y:.2}",
            name.as_deref().unwrap_or_default()
        ),
        Start::Posture { name, .. } => {
            let name = name.as_deref().unwrap_or_default();
            format!(": --start {name}@{x:.3},{y:.3},{z:.3}{turned}")
        }
        Start::Contacts(_) => String::new(),
    };
    Some(format!(
        "moved by ({:.2}, {:.2}) m the robot would be clear of {}{flag}",
        by.x,
        by.y,
        environment.body_name(body)
    ))
}

fn moved(q: &Configuration, by: &Vector3<f64>) -> Configuration {
    let mut moved = q.clone();
    moved.p_WB += by;
    moved
}

/// A body that the robot is too near to, the nearest; none of those that `skip` excepts.
fn met(
    robot: &Robot,
    q: &Configuration,
    environment: &Environment,
    clearance_m: f64,
    skip: &dyn Fn(BodyShape, usize) -> bool,
) -> Option<usize> {
    let kinematics = Kinematics::new(robot, q);
    let mut near = Vec::new();
    let world = environment.world();
    robot
        .collision
        .world_proximities(&kinematics, world, clearance_m, skip, &mut near);
    let nearest = near
        .iter()
        .min_by(|a, b| a.distance.total_cmp(&b.distance))?;
    match nearest.b {
        Other::Obstacle(body) => Some(body),
        Other::Shape(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;
    use surfaces::{Face, Obstacle, Source};

    use super::*;
    use crate::start;

    /// A floor from x = 0.5 m on and a shelf over it that begins at `x`, as high as the arms.
    fn world(x: f64) -> Terrain {
        let at = Isometry3::translation(1.5, 0.0, 0.0);
        let floor = Face::rectangle("floor", at, [2.0, 2.0]).unwrap();
        let source = Source::Scan;
        let shelf = Obstacle::cuboid("shelf", [x, -1.0, 0.6], [x + 0.5, 1.0, 0.9]);
        Terrain {
            faces: vec![Face { source, ..floor }],
            obstacles: vec![shelf],
        }
    }

    /// How far the robot stands back from the floor's edge, and what is said.
    fn back(terrain: &Terrain) -> (f64, Option<String>) {
        let robot = scenes::robot("hrp2").unwrap();
        let config = posture::Config::default();
        let (start, nothing) = (Start::default(), Environment::default());
        let mut stand = start::stand(&robot, &start, &nothing, &config).unwrap();
        start::floor::stand_before(&mut stand, &robot, &mut terrain.clone());
        let before = stand.clone();
        let body = |terrain| Environment::new(terrain, 0.02, 2.0);
        let said = step_back(&mut stand, &robot, terrain, body, (0.02, 0.3)).unwrap();
        let ground = before.X_WG.translation.vector - stand.X_WG.translation.vector;
        let base = before.configuration.p_WB - stand.configuration.p_WB;
        assert!((ground - base).norm() < 1e-9);
        (base.x, said)
    }

    #[test]
    fn a_start_that_is_too_near_is_told_where_it_would_not_be() {
        let robot = scenes::robot("hrp2").unwrap();
        let config = posture::Config::default();
        let (start, nothing) = (Start::default(), Environment::default());
        let stand = start::stand(&robot, &start, &nothing, &config).unwrap();
        let told = |x: f64, q: &Configuration| {
            let mut terrain = world(x);
            terrain.faces = vec![Face::rectangle("ground", stand.X_WG, [4.0, 4.0]).unwrap()];
            let environment = Environment::new(terrain, 0.02, 2.0).unwrap();
            let on = environment.face("ground").unwrap();
            let contacts: Vec<_> = stand.patches.iter().map(|&foot| (foot, on)).collect();
            hint(&robot, &environment, (q, &contacts), &start, 0.02)
        };
        assert_eq!(told(1.0, &stand.configuration), None);
        let said = told(0.1, &stand.configuration).unwrap();
        let (_, place) = said.split_once("clear of shelf: --start @").unwrap();
        let place: Vec<f64> = place.split(',').map(|c| c.parse().unwrap()).collect();
        let mut there = stand.configuration.clone();
        there.p_WB = Vector3::new(place[0], place[1], place[2]);
        assert!(place[0] < -0.01 && place[1].abs() < 1e-9, "{said}");
        assert_eq!(told(0.1, &there), None);
    }

    #[test]
    fn a_start_before_the_floor_steps_back_from_what_is_over_it_as_far_as_the_floor_is_joined() {
        assert_eq!(back(&world(1.0)), (0.0, None));
        // From where it is met at all, by nothing but what hangs over the floor's edge.
        let mut nearer = (0..12).map(|k| back(&world(0.7 - 0.05 * f64::from(k))));
        let (by_m, said) = nearer.find(|(by_m, _)| *by_m > 0.0).unwrap();
        assert!(by_m > 0.04 && by_m < 0.3, "{by_m}");
        assert!(said.unwrap().contains("clear of shelf"));
        // No place within reach is clear: it stays.
        assert_eq!(back(&world(-0.1)), (0.0, None));
    }

    #[test]
    fn feet_step_back_from_what_rises_before_them() {
        let mut terrain = world(3.0);
        let low = Obstacle::cuboid("kerb", [0.49, -1.0, 0.0], [0.6, 1.0, 0.06]);
        terrain.obstacles.push(low);
        let (by_m, said) = back(&terrain);
        assert!((by_m - STEP_M).abs() < 1e-9, "{by_m}");
        assert!(said.unwrap().contains("clear of kerb"));
    }
}
