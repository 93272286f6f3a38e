use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Isometry3, Vector3};

use super::*;
use crate::Face;

fn tilted(tilt_rad: f64, height_m: f64) -> Face {
    let pose = Isometry3::new([0.0, 0.0, height_m].into(), Vector3::x() * tilt_rad);
    Face::rectangle("s", pose, [0.4, 0.2]).unwrap()
}

#[test]
fn floors_are_for_feet_and_walls_for_hands() {
    let config = Config::default();
    let serves = |role: &str, face: &Face| {
        config
            .filter(role)
            .unwrap()
            .serves(face, 2.0, [0.0; 2])
            .is_ok()
    };
    for (tilt, height, foot, hand) in [
        (0.0, 0.0, true, false),
        (0.0, 0.7, true, true),
        (0.55, 0.2, true, false),
        (0.65, 0.7, false, true),
        (FRAC_PI_2, 0.9, false, true),
        (FRAC_PI_2, 2.5, false, false),
        (PI, 1.2, false, false),
    ] {
        let face = tilted(tilt, height);
        assert_eq!(
            serves("foot", &face),
            foot,
            "foot at {tilt} rad, {height} m"
        );
        assert_eq!(
            serves("hand", &face),
            hand,
            "hand at {tilt} rad, {height} m"
        );
    }
}

#[test]
fn every_rejection_says_what_was_wrong() {
    let some = Filter::default();
    let facing = Filter {
        facing_W: Some([0.0, 0.0, -2.0]),
        ..some.clone()
    };
    let cases = [
        (
            Filter::walkable(0.2),
            tilted(0.3, 0.0),
            "tilted by 0.300 rad, not 0.000 … 0.200",
        ),
        (
            Filter {
                tilt_min_rad: Some(1.0),
                ..some.clone()
            },
            tilted(0.3, 0.0),
            "not 1.000",
        ),
        (
            Filter {
                height_min_m: Some(0.5),
                ..some.clone()
            },
            tilted(0.0, 0.4),
            "at 0.400 m, below",
        ),
        (
            Filter {
                height_max_m: Some(0.5),
                ..some.clone()
            },
            tilted(0.0, 0.6),
            "at 0.600 m, above",
        ),
        (facing, tilted(0.0, 0.0), "3.142 rad off"),
        (
            Filter {
                radius_min_m: Some(0.2),
                ..some.clone()
            },
            tilted(0.0, 0.0),
            "radius of 0.200 m",
        ),
        (
            Filter {
                area_min_m2: Some(0.2),
                ..some.clone()
            },
            tilted(0.0, 0.0),
            "area is 0.0800",
        ),
    ];
    for (filter, face, message) in cases {
        let rejection = filter.serves(&face, 2.0, [0.0; 2]).unwrap_err().to_string();
        assert!(rejection.contains(message), "{rejection}");
    }
    let mut vanished = tilted(0.0, 0.0);
    let edges = vanished.region.edges_mut().flatten();
    edges.for_each(|edge| edge.further_m = 0.11);
    assert_eq!(some.serves(&vanished, 2.0, [0.0; 2]), Err(Rejection::Empty));
}

#[test]
fn a_tilted_face_is_in_a_height_range_it_reaches() {
    // A wall from 0.4 to 0.6 m.
    let wall = tilted(FRAC_PI_2, 0.5);
    let range = |min, max| Filter {
        height_min_m: Some(min),
        height_max_m: Some(max),
        ..Filter::default()
    };
    assert!(range(0.55, 1.0).serves(&wall, 2.0, [0.0; 2]).is_ok());
    assert!(range(0.0, 0.45).serves(&wall, 2.0, [0.0; 2]).is_ok());
    assert!(range(0.65, 1.0).serves(&wall, 2.0, [0.0; 2]).is_err());
}

#[test]
fn a_file_changes_what_it_names_and_nothing_else() {
    let text = r#"{"hand": {"height_max_m": 1.2}, "knee": {"tilt_max_rad": 0.1}}"#;
    let config: Config = serde_json::from_str(text).unwrap();
    let default = Config::default();
    assert_eq!(
        config.filter("foot").unwrap(),
        default.filter("foot").unwrap()
    );
    let hand = Filter {
        height_max_m: Some(1.2),
        over_ground_max_m: None,
        ..default.filter("hand").unwrap().clone()
    };
    assert_eq!(config.filter("hand").unwrap(), &hand);
    assert_eq!(config.filter("knee").unwrap(), &Filter::walkable(0.1));
    let written = serde_json::to_string(&config).unwrap();
    assert_eq!(serde_json::from_str::<Config>(&written).unwrap(), config);
    let misspelt = serde_json::from_str::<Config>(r#"{"hand": {"height_m": 1.2}}"#);
    assert!(
        misspelt
            .unwrap_err()
            .to_string()
            .contains("unknown field `height_m`")
    );
    let unknown = config.filter("elbow").unwrap_err().to_string();
    assert_eq!(unknown, "no role `elbow`; there are: foot, hand, knee");
}

#[test]
fn hands_reach_over_the_ground_wherever_it_is() {
    let config = Config::default();
    // A floor on the second storey, another a flight of stairs higher, and walls on both.
    let faces = [4.0, 6.5].map(|height_m| tilted(0.0, height_m));
    let ground_m = config.ground_m(&faces, 2.0);
    assert_eq!(ground_m, [4.0, 6.5]);
    let hand = config.filter("hand").unwrap();
    for (tilt, height_m, serves) in [
        (FRAC_PI_2, 5.0, true),
        (FRAC_PI_2, 7.5, true),
        (FRAC_PI_2, 8.5, false),
        (0.0, 4.0, false),
        (FRAC_PI_2, 0.9, false),
    ] {
        let face = tilted(tilt, height_m);
        let verdict = hand.serves(&face, 2.0, ground_m);
        assert_eq!(verdict.is_ok(), serves, "{tilt} rad, {height_m} m");
    }
    // No ground for feet: W's level. A height in W takes the place of the one over the ground.
    assert_eq!(config.ground_m(&[tilted(FRAC_PI_2, 3.0)], 2.0), [0.0; 2]);
    let config: Config = serde_json::from_str(r#"{"hand": {"height_max_m": 5.2}}"#).unwrap();
    let hand = config.filter("hand").unwrap();
    assert!(hand.serves(&tilted(FRAC_PI_2, 7.5), 2.0, ground_m).is_err());
    assert!(hand.serves(&tilted(0.0, 4.0), 2.0, ground_m).is_err());
}
