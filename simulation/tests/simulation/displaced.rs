//! Things of a world that are displaced.

use nalgebra::Vector3;
use simulation::config::Config;
use simulation::perturbation::{Kinds, Perturbation};
use simulation::playback::Playback;
use simulation::reference::Reference;
use simulation::used_faces::used_faces;
use simulation::world::{WorldBody, WorldShape};

use crate::robot::hrp2;
use crate::stepping::step_in_place;

const STEP_M: f64 = 0.03;

/// A box with its top at a height, from y to y.
fn slab(name: &str, part_of: &str, top_m: f64, [from, to]: [f64; 2]) -> WorldBody {
    let centre = Vector3::new(0.0, (from + to) / 2.0, top_m - 0.1);
    WorldBody {
        name: name.to_owned(),
        part_of: part_of.to_owned(),
        shape: WorldShape::Box {
            X_WO: centre.into(),
            half_m: Vector3::new(1.0, (to - from) / 2.0, 0.1),
        },
        friction: None,
    }
}

/// The left foot steps onto a plate that was seen in two parts, the one half of its sole on each.
#[test]
fn the_parts_of_one_thing_are_displaced_as_one() {
    let robot = hrp2();
    let playback = Playback::new(&robot, step_in_place(&robot, STEP_M)).unwrap();
    let world = [
        slab("floor", "floor", 0.0, [-1.0, 1.0]),
        slab("plate/0", "plate", STEP_M, [0.08, 0.5]),
        slab("plate/1", "plate", STEP_M, [-0.5, 0.08]),
        slab("beside", "beside", STEP_M, [0.6, 0.7]),
        slab("riser", "riser", STEP_M + 0.005, [0.48, 0.52]),
    ];
    let used = used_faces(&robot, &world, &playback);
    assert_eq!(used[0], None, "it carries the robot at the start");
    assert_eq!(used[3], None, "nothing touches it");
    assert!(used[1].is_some() && used[1] == used[2], "{used:?}");
    assert_eq!(used[4], used[1], "it ends at the plate");
    let spread = Config::default().perturbation;
    let drawn = Perturbation::draw(3, 0, &spread, Kinds::ALL, &used, playback.duration_s());
    assert!(drawn.moved[1].motion_W().translation.vector.norm() > 1e-4);
    assert_eq!(drawn.moved[1], drawn.moved[2]);
}
