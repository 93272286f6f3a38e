//! The ground under a humanoid that stands in various places.

use super::*;
use crate::scene::Start;
use crate::start::{StartState, stand};

fn humanoid() -> Robot {
    scenes::robot("hrp2").unwrap()
}

/// Where it is at rest over the origin, its soles on z = 0.
fn at_rest(robot: &Robot) -> StartState {
    let start = Start::default();
    stand(
        robot,
        &start,
        &posture::Environment::default(),
        &posture::Config::default(),
    )
    .unwrap()
}

/// The humanoid at rest over the origin, its soles on z = 0, and the ground that it gives.
fn standing(terrain: &mut Terrain) -> (Ground, Robot) {
    let robot = humanoid();
    let stand = at_rest(&robot);
    let ground = add_ground(terrain, &robot, (&stand, false), &Config::default(), 2.0).unwrap();
    (ground, robot)
}

fn rectangle(id: &str, x: [f64; 2], y: [f64; 2], z: f64, tilt: f64) -> Face {
    let middle = [0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]), z];
    let pose = Isometry3::new(middle.into(), Vector3::y() * tilt);
    Face::rectangle(id, pose, [x[1] - x[0], y[1] - y[0]]).unwrap()
}

fn scanned(id: &str, x: [f64; 2], y: [f64; 2], z: f64, tilt: f64) -> Face {
    Face {
        source: Source::Scan,
        ..rectangle(id, x, y, z, tilt)
    }
}

fn with(faces: Vec<Face>) -> Terrain {
    Terrain {
        faces,
        obstacles: Vec::new(),
    }
}

/// Largest height of a start sole's vertex over its surface, and least depth inside it.
fn fit(terrain: &Terrain, ground: &Ground, robot: &Robot) -> (f64, f64) {
    let kinematics = Kinematics::new(robot, &at_rest(robot).configuration);
    let mut worst = (0.0_f64, f64::INFINITY);
    for (patch, face) in &ground.contacts {
        let face = terrain.get(face).unwrap();
        let polygon = face.region.as_convex().unwrap();
        for v in Sole::new(robot, &kinematics, *patch, &Isometry3::identity()).vertices_W {
            let p = face.X_WF.inverse_transform_point(&v);
            worst.0 = worst.0.max(p.z.abs());
            worst.1 = worst.1.min(-polygon.signed_distance(&p.xy()));
        }
    }
    worst
}

#[test]
fn soles_in_one_plane_are_one_face_with_a_border() {
    let mut terrain = Terrain::default();
    let (ground, robot) = standing(&mut terrain);
    assert_eq!(terrain.faces.len(), 1);
    assert_eq!(terrain.faces[0].source, Source::Robot);
    assert_eq!(ground.contacts.len(), 2);
    let (off, inside) = fit(&terrain, &ground, &robot);
    // Kinematics in f64 over a metre; the border of the default settings.
    assert!(off < 1e-12, "{off}");
    assert!((inside - 0.02).abs() < 1e-9, "{inside}");
    terrain.validate().unwrap();
}

#[test]
fn a_floor_ahead_is_joined_over_the_gap_at_the_faces_own_width() {
    // Seen from 0.30 m ahead on, 4 mm too high and tilted by 2 mrad, much wider than the feet.
    let floor = scanned("floor", [0.30, 1.30], [-0.8, 0.8], 0.004, 0.002);
    let mut terrain = with(vec![floor]);
    let (ground, robot) = standing(&mut terrain);
    let (floor, face) = (&terrain.faces[0], &terrain.faces[1]);
    assert_eq!(ground.notes.len(), 1);
    // The floor is in the face's plane.
    let mut vertices = floor.vertices_W().into_iter();
    assert!(vertices.all(|v| face.height_of(&v).abs() < 1e-12));
    let contains = |x: f64, y: f64| {
        let p = face.X_WF.inverse_transform_point(&Point3::new(x, y, 0.0));
        face.region.contains(&p.xy())
    };
    // The gap ahead of the feet is part of the face, unseen ground beside it is not; and the face
    // reaches as far as the floor was seen.
    assert!(contains(0.25, 0.0) && !contains(0.25, 0.4) && contains(1.2, 0.0));
    let (off, inside) = fit(&terrain, &ground, &robot);
    assert!(off < 1e-12 && inside > 0.019, "{off} {inside}");
    terrain.validate().unwrap();
}

#[test]
fn a_step_a_far_floor_and_a_wall_are_left_alone() {
    let over = std::f64::consts::PI;
    let mut terrain = with(vec![
        scanned("step", [0.20, 0.60], [-0.4, 0.4], 0.05, 0.0),
        scanned("far", [0.90, 1.50], [-0.4, 0.4], 0.0, 0.0),
        scanned("slope", [0.20, 1.20], [-0.4, 0.4], 0.0, 0.1),
        scanned("underside", [-0.3, 0.3], [-0.4, 0.4], 0.0, over),
    ]);
    let before = terrain.faces.clone();
    let (ground, _) = standing(&mut terrain);
    assert_eq!(terrain.faces[..4], before);
    // Of the floor ahead it is said that what lies between was not seen.
    let [said] = &ground.notes[..] else {
        panic!("{:?}", ground.notes);
    };
    assert!(said.starts_with("warning: far continues"), "{said}");
}

#[test]
fn a_known_floor_under_the_feet_is_used_as_it_is() {
    let mut terrain = with(vec![rectangle("floor", [-1.0, 1.0], [-1.0, 1.0], 0.0, 0.0)]);
    let before = terrain.clone();
    let (ground, _) = standing(&mut terrain);
    assert_eq!(terrain, before);
    let mut faces = ground.contacts.iter().map(|(_, face)| face.as_str());
    assert!(faces.all(|face| face == "floor"));
}

#[test]
fn an_exact_floor_is_stood_on_to_half_a_millimetre_and_never_moved() {
    for (tilt, is_used) in [(0.001, true), (0.005, false)] {
        // Over the feet, 0.12 m from the middle to the toes: off by 0.12 mm and by 0.6 mm.
        let floor = rectangle("floor", [-1.0, 1.0], [-1.0, 1.0], 0.0, tilt);
        let mut terrain = with(vec![floor]);
        let before = terrain.faces.clone();
        let (ground, robot) = standing(&mut terrain);
        assert_eq!(terrain.faces[..1], before, "tilt {tilt}");
        assert_eq!(terrain.faces.len() == 1, is_used, "tilt {tilt}");
        let (off, inside) = fit(&terrain, &ground, &robot);
        assert!(off <= 5e-4 && inside > 0.019, "tilt {tilt}: {off} {inside}");
    }
}

#[test]
fn the_ground_takes_a_name_that_is_free() {
    let mut terrain = with(vec![rectangle("ground", [5.0, 6.0], [5.0, 6.0], 0.0, 0.0)]);
    standing(&mut terrain);
    assert_eq!(terrain.faces[1].id.as_str(), "ground'");
}

#[test]
fn feet_on_nothing_of_a_known_world_are_told_what_is_there() {
    let floor = |z, tilt| rectangle("floor", [-1.0, 1.0], [-1.0, 1.0], z, tilt);
    let turned = Isometry3::rotation(Vector3::x() * std::f64::consts::PI);
    let downward = Face {
        X_WF: turned,
        ..floor(0.0, 0.0)
    };
    let beside = rectangle("beside", [2.0, 3.0], [-1.0, 1.0], 0.2, 0.0);
    for (world, words) in [
        (
            floor(-0.5, 0.0),
            Some("floor is 0.500 m under that; --start @X,Y"),
        ),
        (floor(0.0, 0.14), Some("leans by 8°")),
        (downward, Some("floor is there and looks down")),
        (beside, Some("nothing is over or under that")),
        (floor(0.0, 0.0), None),
        // They stand at its border.
        (rectangle("floor", [0.0, 1.0], [-1.0, 1.0], 0.0, 0.0), None),
        (
            Face {
                source: Source::Scan,
                ..floor(-0.5, 0.0)
            },
            None,
        ),
    ] {
        let (ground, _) = standing(&mut with(vec![world]));
        let said = ground.notes.join("; ");
        match words {
            Some(words) => assert!(said.contains(words), "{said}"),
            None => assert_eq!(said, ""),
        }
    }
}
