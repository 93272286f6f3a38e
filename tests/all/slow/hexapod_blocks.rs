//! The hexapod crosses a field of blocks on a level body, from exactly known surfaces: feet onto and
//! between them, one leg at a time; the verifier agrees, and physics.
use nalgebra::{UnitQuaternion, Vector3};
use surfaces::{Obstacle, Terrain};

use crate::support::program::robot;
use crate::support::walk::{Walk, Walked, face};

/// Middle, edges and height of each block, m.
const BLOCKS: [([f64; 2], [f64; 2], f64); 7] = [
    ([1.10, 0.45], [0.30, 0.40], 0.08),
    ([1.25, -0.40], [0.35, 0.30], 0.12),
    ([1.00, -0.85], [0.30, 0.30], 0.06),
    ([1.70, 0.60], [0.40, 0.50], 0.12),
    ([1.85, -0.55], [0.30, 0.50], 0.08),
    ([1.45, 0.95], [0.30, 0.20], 0.10),
    ([2.35, 0.10], [0.30, 0.70], 0.10),
];
/// Past the blocks with the middle feet.
const WAY_M: f64 = 2.4;

/// The body is level to this, degrees.
const TILT_DEG: f64 = 4.0;

/// A floor with blocks on it: a block's top can be stepped on, and it is an obstacle as a whole.
fn field() -> Terrain {
    let (x, y) = (Vector3::x(), Vector3::y());
    let mut faces = vec![face("floor", x * 1.5, x, y, [2.8, 1.6])];
    let mut obstacles = Vec::new();
    for (k, ([cx, cy], [lx, ly], height)) in BLOCKS.into_iter().enumerate() {
        let half = [0.5 * lx, 0.5 * ly];
        let id = format!("block{k}");
        faces.push(face(&id, Vector3::new(cx, cy, height), x, y, half));
        let [low, high] = [-1.0, 1.0].map(|side| [cx + side * half[0], cy + side * half[1]]);
        obstacles.push(Obstacle {
            surface: Some(id.clone()),
            ..Obstacle::cuboid(id, [low[0], low[1], 0.0], [high[0], high[1], height])
        });
    }
    Terrain { faces, obstacles }
}

fn walked() -> Walked {
    let terrain = field();
    let usable = terrain.faces.iter().map(|f| f.id.to_string()).collect();
    let walk = Walk {
        robot: robot("hexapod"),
        terrain,
        way: vec![Vector3::new(WAY_M, 0.0, 0.0)],
        tolerance_m: 0.1,
        goal_face: None,
        usable,
        // The body is held level rather than the legs in their middle.
        posture: posture::Config {
            weight_base: 10.0,
            ..posture::Config::default()
        },
    };
    walk.plan()
}

#[test]
fn it_crosses_them() {
    let walked = walked();
    walked.assert_found();
    walked.show("hexapod-blocks");
    let stances = &walked.plan.stances;
    for stance in stances {
        // One leg at a time.
        assert!(stance.contacts.iter().filter(|c| c.loaded).count() >= 5);
        let turn = UnitQuaternion::new_normalize([3, 4, 5, 6].map(|i| stance.q[i]).into());
        let tilt = (turn * Vector3::z()).z.acos().to_degrees();
        assert!(tilt < TILT_DEG, "stance {}: {tilt}°", stance.index);
    }
    // Onto the blocks, and between them.
    let made: Vec<_> = stances.iter().filter_map(|s| s.contacts.last()).collect();
    let on = made.iter().filter(|c| c.face.as_str().starts_with("block"));
    let between = made
        .iter()
        .filter(|c| c.face.as_str() == "floor" && (0.9..2.4).contains(&c.X_WC.p[0]));
    assert!(on.count() >= 5 && between.count() >= 5);
    walked.assert_certified();
    #[cfg(feature = "mujoco")]
    walked.assert_executed();
}
