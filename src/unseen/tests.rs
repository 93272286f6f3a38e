use nalgebra::Isometry3;
use perception::{PosedScan, SensorOptions, depth_scan};
use scenes::simulator::XTION;

use super::*;
use crate::config::Config;
use crate::environment::{Perceived, of_scans};
use crate::report::Stages;

/// A room with a wall at y = 0.4 along its left side, of which a camera at the origin sees what is ahead.
fn half_a_room() -> Perceived {
    let (image, X_WV) = room::half_a_room(0.4, 0.0);
    let options = SensorOptions {
        sensor: "xtion".into(),
        ..SensorOptions::default()
    };
    let size = (XTION.width, XTION.height);
    let scan = depth_scan("room".as_ref(), size, &image.depth_mm, &options).unwrap();
    let posed = PosedScan::Scan {
        name: "room",
        scan: &scan,
        X_WV,
    };
    of_scans(&[posed], &Config::default(), &mut Stages::default()).unwrap()
}

/// What is told of the quadruped whose base goes from the origin by these places.
fn led(room: &Perceived, places: &[[f64; 2]]) -> Unseen {
    let robot = scenes::robot("quadruped").unwrap();
    let at = |[x, y]: &[f64; 2]| {
        let base = Isometry3::translation(*x, *y, 0.55);
        robot.resting().with_base(&base).to_q()
    };
    let all: Vec<Vec<f64>> = [[0.0, 0.0]].iter().chain(places).map(at).collect();
    let moments = all
        .iter()
        .enumerate()
        .map(|(k, q)| (k, Some(k as f64), &q[..]));
    let moments: Vec<Moment> = moments.collect();
    along(&moments, &robot, &room.terrain.faces, &room.looked).unwrap()
}

#[test]
fn a_way_through_the_half_that_was_not_seen_is_told_and_one_through_the_other_is_not() {
    let room = half_a_room();
    let seen = led(&room, &[[1.5, -0.1], [1.8, -0.1]]);
    assert_eq!((seen.deepest, seen.walls), (None, vec![]));
    assert_eq!(seen.part, 0.0);
    // To the right and back, away from the wall.
    let back = led(&room, &[[-1.0, -0.5]]);
    let deepest = back.deepest.unwrap();
    assert!(deepest.inside_m > 0.6, "{deepest}");
    assert_eq!((deepest.stance, deepest.t_s), (1, Some(1.0)));
    assert_eq!((back.part, back.walls), (0.5, vec![]));
}

#[test]
fn a_wall_that_would_go_on_into_the_way_is_told() {
    let room = half_a_room();
    let told = led(&room, &[[-0.2, 0.1], [-0.3, 0.3]]);
    let [wall] = &told.walls[..] else {
        panic!("{:?}", told.walls)
    };
    assert_eq!(wall.place.stance, 2);
    assert!(wall.place.link.contains("left"), "{}", wall.place);
    assert!((0.05..0.2).contains(&wall.place.inside_m), "{}", wall.place);
    assert!((0.3..1.5).contains(&wall.beyond_m), "{}", wall.beyond_m);
    let mut world = World::default();
    told.tell(&mut world);
    let words = format!("{world:?}");
    assert!(
        words.contains("which the border of the view cuts"),
        "{words}"
    );
    assert!(
        words.contains("through space that no view looked into"),
        "{words}"
    );
}
