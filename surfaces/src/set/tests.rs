use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;

use super::*;
use crate::polygon::tests::polygons;
use crate::{ConvexPolygon, Source};

fn square() -> ConvexPolygon {
    let corners = vec![[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
    corners.try_into().unwrap()
}

fn surface(id: &str) -> Surface {
    Surface::new(id, Isometry3::translation(1.0, 0.0, 0.25), square())
}

const FILE: &str = r#"{
  "format": "scandent-surfaces/1",
  "surfaces": [
    {"id": "floor", "X_WS": {"p": [0, 0, 0], "quat_xyzw": [0, 0, 0, 1]},
     "polygon": [[-1, -1], [1, -1], [1, 1], [-1, 1]]},
    {"id": "step", "X_WS": {"p": [1, 0, 0.2], "quat_xyzw": [0, 0, 0.7071068, 0.7071068]},
     "polygon": [[-0.2, -0.3], [0.2, -0.3], [0.2, 0.3], [-0.2, 0.3]], "inset_m": 0.01}
  ],
  "obstacles": [{"id": "post", "points_W": [[0,0,0],[1,0,0],[0,1,0],[0,0,1]]}]
}"#;

#[test]
fn a_file_written_by_hand_is_read() {
    let set = SurfaceSet::from_json(FILE).unwrap();
    assert_eq!(set.surfaces.len(), 2);
    let step = set.get("step").unwrap();
    assert_eq!(
        (step.inset_m, step.source, &step.face),
        (0.01, Source::File, &None)
    );
    // Seven decimals of a quaternion are a unit quaternion after the rounding is taken off.
    approx::assert_relative_eq!(step.X_WS.rotation.norm(), 1.0, epsilon = 1e-15);
    assert_eq!(set.obstacles[0].points_W[3].z, 1.0);
}

#[test]
fn whatever_is_wrong_in_a_file_is_named() {
    let change = |from: &str, to: &str| {
        assert!(FILE.contains(from), "{from}");
        SurfaceSet::from_json(&FILE.replacen(from, to, 1))
            .unwrap_err()
            .to_string()
    };
    let step = r#""polygon": [[-0.2, -0.3], [0.2, -0.3], [0.2, 0.3], [-0.2, 0.3]]"#;
    let cases = [
        (
            "scandent-surfaces/1",
            "scandent-surfaces/2",
            "the format is `scandent-surfaces/2`",
        ),
        (
            step,
            r#""polygon": [[-0.2,-0.3],[-0.2,0.3],[0.2,0.3],[0.2,-0.3]]"#,
            "surface `step`: the vertices run clockwise",
        ),
        (
            step,
            r#""polygon": [[-0.2,-0.3],[0.2,-0.3],[0.2,-0.3],[0.2,0.3]]"#,
            "surface `step`: vertex 2 repeats vertex 1",
        ),
        (
            step,
            r#""polygon": [[0,0],[2,0],[0.5,0.5],[0,2]]"#,
            "surface `step`: not convex: the boundary turns right",
        ),
        (
            step,
            r#""polygon": [[0,0],[1,0]]"#,
            "surface `step`: a polygon needs at least 3",
        ),
        (
            step,
            r#""polygon": [[0,0],[1,0],[null,1]]"#,
            "surface `step` (number 1): invalid type: null",
        ),
        (
            step,
            r#""polygons": []"#,
            "surface `step` (number 1): unknown field `polygons`",
        ),
        (
            "0.7071068, 0.7071068",
            "0.8, 0.7",
            "surface `step`: quat_xyzw has the norm 1.06",
        ),
        (
            r#""inset_m": 0.01"#,
            r#""inset_m": -1"#,
            "surface `step`: inset_m is -1, which is not",
        ),
        (
            r#""inset_m": 0.01"#,
            r#""polygon_edges": ["real"]"#,
            "surface `step`: polygon_edges: 1 kinds for 4 edges",
        ),
        (
            r#""inset_m": 0.01"#,
            r#""outline": [[[0,0],[1,0],[0,1]]], "outline_edges": [["real", "occluded"]]"#,
            "surface `step`: outline_edges of ring 0: 2 kinds for 3 edges",
        ),
        (
            r#""inset_m": 0.01"#,
            r#""outline_edges": [["real"]]"#,
            "surface `step`: outline_edges: kinds of 1 rings for 0 rings",
        ),
        (
            r#""inset_m": 0.01"#,
            r#""outline": [[[0,0],[1,0],[0,1]]], "outline_edges": [["real", "seam", "real"]]"#,
            "surface `step`: outline_edges of ring 0: edge 1 is a seam",
        ),
        (
            r#""inset_m": 0.01"#,
            r#""inset_m": 0.01, "edge_insets_m": [0.01]"#,
            "surface `step`: edge_insets_m: 1 insets for 4 edges",
        ),
        (
            r#""inset_m": 0.01"#,
            r#""inset_m": 0.01, "edge_insets_m": [0.01, 0, 0.02, 0]"#,
            "surface `step`: edge_insets_m is 0.02, which is not between 0 and inset_m",
        ),
        (
            r#""inset_m": 0.01"#,
            r#""polygon_edges": ["sharp"]"#,
            "surface `step` (number 1): unknown variant `sharp`",
        ),
        (
            r#""id": "step""#,
            r#""id": "floor""#,
            "surface number 1 repeats the id `floor` of number 0",
        ),
        (
            r#""id": "step""#,
            r#""id": """#,
            "surface number 1 has an empty id",
        ),
        (
            r#""id": "step", "#,
            "",
            "surface number 1: missing field `id`",
        ),
        (
            "[0,0,1]]",
            "[0,0,1]], \"surface\": \"wall\"",
            "obstacle `post`: no surface `wall`; there are: floor, step",
        ),
        (
            "[[0,0,0],[1,0,0],[0,1,0],[0,0,1]]",
            "[[0,0,0],[1,0,0]]",
            "obstacle `post`: a convex body needs at least 4",
        ),
        (
            "[1, 0, 0.2]",
            "[1, 0, 1e999]",
            "number out of range at line 6",
        ),
        ("\"obstacles\": [", "\"obstacles\": ", "at line 9"),
    ];
    for (from, to, message) in cases {
        let error = change(from, to);
        assert!(error.contains(message), "{to}: {error}");
    }
}

#[test]
fn numbers_that_json_cannot_hold_are_not_written() {
    let mut bad = surface("s");
    bad.rms_m = f64::NAN;
    let set = SurfaceSet {
        surfaces: vec![bad],
        obstacles: vec![],
    };
    let error = set.to_json().unwrap_err().to_string();
    assert!(error.starts_with("surface `s`: rms_m is NaN"), "{error}");
}

#[test]
fn bad_covariances_and_outlines_are_named() {
    let with = |covariance, outline| {
        let mut s = surface("s");
        s.plane_covariance = covariance;
        s.outline = outline;
        s.validate().unwrap_err().to_string()
    };
    let (o, i) = (0.0, 1.0);
    let skew = with(Some([[i, 0.5, o], [o, i, o], [o, o, i]]), vec![]);
    assert!(
        skew.contains("entry (0, 1) is 0.5, entry (1, 0) is 0"),
        "{skew}"
    );
    let indefinite = with(Some([[i, 2.0, o], [2.0, i, o], [o, o, i]]), vec![]);
    assert!(
        indefinite.contains("smallest eigenvalue is -1"),
        "{indefinite}"
    );
    let nan = with(Some([[f64::NAN; 3]; 3]), vec![]);
    assert!(nan.contains("not finite"), "{nan}");
    let outline = with(None, vec![vec![[o, o], [i, o], [i, i]], vec![[o, o]]]);
    assert!(
        outline.contains("outline ring 1: a polygon needs at least 3"),
        "{outline}"
    );
}

#[test]
fn seams_are_not_taken_back_and_edges_have_insets_of_their_own() {
    let with = |fields: &str| {
        let text = FILE.replacen(r#""inset_m": 0.01"#, fields, 1);
        let set = SurfaceSet::from_json(&text).unwrap();
        // What is written is what was read.
        assert_eq!(SurfaceSet::from_json(&set.to_json().unwrap()).unwrap(), set);
        set.get("step").unwrap().effective_polygon().unwrap()
    };
    // 0.4 m by 0.6 m; the edges are those toward −y, +x, +y, −x.
    let seam = with(r#""inset_m": 0.01, "polygon_edges": ["real", "seam", "occluded", "unknown"]"#);
    approx::assert_relative_eq!(seam.area(), 0.39 * 0.58, max_relative = 1e-12);
    let own = with(r#""inset_m": 0.02, "edge_insets_m": [0.02, 0, 0.01, 0]"#);
    approx::assert_relative_eq!(own.area(), 0.4 * 0.57, max_relative = 1e-12);
}

#[test]
fn surfaces_without_an_obstacle_get_a_body() {
    let wedge = Obstacle {
        id: "wedge".into(),
        points_W: surface("a").thin_body(0.1).points_W,
        surface: Some("a".into()),
        assumed: false,
    };
    let mut b = surface("b");
    b.X_WS.translation.x = 3.0;
    let set = SurfaceSet::new(vec![surface("a"), b], vec![wedge.clone()]).unwrap();
    let config = thin_body::Config::default();
    let bodies = set.bodies(&[], &config);
    assert_eq!(bodies.len(), 2);
    assert_eq!(bodies[0], wedge);
    assert_eq!(bodies[1].surface.as_deref(), Some("b"));
    let lowest = bodies[1]
        .points_W
        .iter()
        .map(|p| p.z)
        .fold(f64::INFINITY, f64::min);
    approx::assert_relative_eq!(lowest, 0.25 - config.depth_max_m, epsilon = 1e-12);
}

proptest! {
    #[test]
    fn what_is_written_is_what_is_read(
        polygon in polygons(), p in prop::array::uniform3(-9.0..9.0),
        turn in prop::array::uniform3(-2.0..2.0), inset in 0.0..0.1, face in prop::option::of("[a-z]{1,4}"),
    ) {
        let pose = Isometry3::new(Vector3::from(p), Vector3::from(turn));
        let mut surface = Surface::new("s", pose, polygon);
        surface.inset_m = inset;
        surface.face = face;
        surface.outline = vec![vec![[0.1, 0.2], [inset, 0.3], [1.0, 1.0 / 3.0]]];
        surface.plane_covariance = Some([[1e-4, 1e-5, 0.0], [1e-5, 2e-4, 0.0], [0.0, 0.0, inset]]);
        surface.source = Source::Scan;
        let obstacle = surface.thin_body(0.05).into();
        let set = SurfaceSet::new(vec![surface], vec![obstacle]).unwrap();
        let text = set.to_json().unwrap();
        let again = SurfaceSet::from_json(&text).unwrap();
        prop_assert_eq!(&again, &set);
        prop_assert_eq!(again.to_json().unwrap(), text);
    }

    #[test]
    fn no_text_makes_the_reader_panic(cut in 0..FILE.len(), byte in 0..FILE.len(), with in "[\\[\\]{},:0-9\"a-z-]") {
        let _ = SurfaceSet::from_json(&FILE[..cut]);
        let mut text = FILE.to_string();
        text.replace_range(byte..byte + 1, &with);
        if let Ok(set) = SurfaceSet::from_json(&text) {
            prop_assert!(set.validate().is_ok());
        }
    }
}
