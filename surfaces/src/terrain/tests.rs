use proptest::prelude::*;

use super::*;
use crate::face::faces;
use crate::{Edge, EdgeKind, EdgeView, Fit, Source};

const FILE: &str = r#"{
  "format": "scandent-surfaces/2",
  "faces": [
    {"id": "floor", "X_WF": {"p": [0, 0, 0], "quat_xyzw": [0, 0, 0, 1]},
     "polygon": [[-1, -1], [1, -1], [1, 1], [-1, 1]]},
    {"id": "step", "X_WF": {"p": [1, 0, 0.2], "quat_xyzw": [0, 0, 0.7071068, 0.7071068]},
     "region": [{"vertices": [[-0.2, -0.3], [0.2, -0.3], [0.2, 0.3], [-0.2, 0.3]],
                 "edges": [{"kind": "occluded"}, {"further_m": 0.01}, {}, {}]},
                {"vertices": [[0, 0], [0.1, 0], [0.1, 0.1]]}]}
  ],
  "obstacles": [{"id": "post", "points_W": [[0,0,0],[1,0,0],[0,1,0],[0,0,1]], "surface": "step"}]
}"#;

#[test]
fn a_file_written_by_hand_is_read_and_written_back() {
    let terrain = Terrain::from_json(FILE).unwrap();
    let [floor, step] = &terrain.faces[..] else {
        panic!("{terrain:?}")
    };
    assert_eq!((floor.source, floor.region.area()), (Source::File, 4.0));
    approx::assert_relative_eq!(step.region.area(), 0.24 - 0.005, epsilon = 1e-12);
    assert_eq!(
        step.region.rings()[0].edges[0],
        Edge::new(EdgeKind::Occluded)
    );
    assert_eq!(
        step.edge_insets_m(2.0),
        [vec![0.0, 0.01, 0.0, 0.0], vec![0.0; 3]]
    );
    assert_eq!(terrain.index_of(&"step".into()), Ok(1));
    let text = terrain.to_json().unwrap();
    assert_eq!(Terrain::from_json(&text).unwrap(), terrain);
}

#[test]
fn whatever_is_wrong_in_a_file_is_named() {
    let polygon = r#""polygon": [[-1, -1], [1, -1], [1, 1], [-1, 1]]"#;
    let ring = r#""edges": [{"kind": "occluded"}, {"further_m": 0.01}, {}, {}]"#;
    let cases = [
        (
            "scandent-surfaces/2",
            "scandent-surfaces/3",
            "the format is `scandent-surfaces/3`",
        ),
        (
            polygon,
            r#""polygon": [[0,0],[1,0]]"#,
            "face `floor`: outline ring 0: a polygon needs",
        ),
        (
            polygon,
            r#""polygon": [[0,0],[1,1],[1,0],[0,1]]"#,
            "face `floor`: the outline crosses",
        ),
        (
            polygon,
            r#""depth_m": 1"#,
            "face `floor`: it needs either `region`",
        ),
        (
            polygon,
            r#""polygons": 1"#,
            "face `floor` (number 0): unknown field `polygons`",
        ),
        (
            ring,
            r#""edges": [{}]"#,
            "face `step`: outline ring 0: edges: 1 edges for 4 vertices",
        ),
        (
            "0.01}",
            "-1}",
            "face `step`: outline ring 0: further_m is -1, which is not",
        ),
        (
            r#"kind": "occluded"#,
            r#"kind": "seam"#,
            "face `step` (number 1): unknown variant `seam`",
        ),
        (
            r#""id": "step""#,
            r#""id": "floor""#,
            "face number 1 repeats the id `floor`",
        ),
        (
            r#""id": "step""#,
            r#""id": """#,
            "face number 1 has an empty id",
        ),
        (
            r#""surface": "step""#,
            r#""surface": "x""#,
            "obstacle `post`: no face `x`; there are: floor",
        ),
        (
            "0.7071068, 0.7071068",
            "0.8, 0.7",
            "face `step`: quat_xyzw has the norm 1.06",
        ),
    ];
    for (from, to, expected) in cases {
        assert!(FILE.contains(from), "{from}");
        let error = Terrain::from_json(&FILE.replacen(from, to, 1))
            .unwrap_err()
            .to_string();
        assert!(error.starts_with(expected), "{error}");
    }
}

#[test]
fn what_a_face_cannot_be_is_refused() {
    let good = Terrain::from_json(FILE).unwrap().faces.remove(0);
    let eye = |z: f64| EdgeView {
        eye_W: [0.0, 0.0, z].into(),
        sigma_rad: 0.001,
        plane_covariance: None,
    };
    let refused = |change: &dyn Fn(&mut Face), expected: &str| {
        let mut face = good.clone();
        change(&mut face);
        let error = face.validate().unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    };
    refused(
        &|face| {
            face.region
                .edges_mut()
                .flatten()
                .for_each(|edge| edge.view = Some(0))
        },
        "view is 0, which is not the index of one of the views",
    );
    refused(&|face| face.depth_m = -1.0, "face `floor`: depth_m is -1");
    refused(
        &|face| face.views = vec![eye(-0.1)],
        "which is not above the face",
    );
    refused(
        &|face| {
            face.views = vec![EdgeView {
                sigma_rad: f64::NAN,
                ..eye(1.0)
            }]
        },
        "sigma_rad",
    );
    refused(
        &|face| {
            face.fit = Some(Fit {
                points: 1,
                rms_m: -1.0,
            })
        },
        "rms_m is -1",
    );
    refused(
        &|face| face.plane_covariance = Some([[0.0, 1.0, 0.0], [0.0; 3], [0.0; 3]]),
        "entry (0, 1) is 1",
    );
    refused(
        &|face| face.plane_covariance = Some([[-1.0, 0.0, 0.0], [0.0; 3], [0.0; 3]]),
        "smallest eigenvalue is -1",
    );
}

/// An L of two pieces as version 1 kept it, beside a surface with the four fields written by hand.
const VERSION_1: &str = r#"{
  "format": "scandent-surfaces/1",
  "surfaces": [
    {"id": "l.0", "X_WS": {"p": [1, 0, 0], "quat_xyzw": [0, 0, 0, 1]},
     "polygon": [[-1, -0.5], [1, -0.5], [1, 0.5], [-1, 0.5]],
     "outline": [[[-1, -0.5], [1, -0.5], [1, 0.5], [0, 0.5], [0, 1.5], [-1, 1.5]]],
     "outline_edges": [["occluded", "real", "real", "real", "real", "real"]],
     "polygon_edges": ["occluded", "real", "real", "real"],
     "inset_m": 0.02, "edge_insets_m": [0.02, 0.01, 0.01, 0.01], "face": "l",
     "inliers": 100, "rms_m": 0.001},
    {"id": "l.1", "X_WS": {"p": [0.5, 0.5, 0], "quat_xyzw": [0, 0, 0, 1]},
     "polygon": [[-0.5, -1], [0.5, -1], [0.5, 1], [-0.5, 1]],
     "outline": [[[-0.5, -1], [1.5, -1], [1.5, 0], [0.5, 0], [0.5, 1], [-0.5, 1]]],
     "inset_m": 0.015, "face": "l"},
    {"id": "floor", "X_WS": {"p": [0, 0, 0], "quat_xyzw": [0, 0, 0, 1]},
     "polygon": [[-1, -1], [1, -1], [1, 1], [-1, 1]]}
  ],
  "obstacles": [{"id": "b", "points_W": [[0,0,0],[1,0,0],[0,1,0],[0,0,1]], "surface": "l.1"}]
}"#;

#[test]
fn pieces_of_version_1_that_share_an_outline_are_one_face() {
    let terrain = Terrain::from_json(VERSION_1).unwrap();
    let [l, floor] = &terrain.faces[..] else {
        panic!("{terrain:?}")
    };
    assert_eq!((l.id.as_str(), floor.id.as_str()), ("l", "floor"));
    assert_eq!(terrain.obstacles[0].surface.as_deref(), Some("l"));
    approx::assert_relative_eq!(l.region.area(), 3.0, epsilon = 1e-9);
    assert_eq!(
        l.fit,
        Some(Fit {
            points: 100,
            rms_m: 0.001
        })
    );
    let ring = &l.region.rings()[0];
    assert_eq!(ring.edges[0].kind, EdgeKind::Occluded);
    assert!(
        ring.edges[1..]
            .iter()
            .all(|edge| edge.kind == EdgeKind::Real)
    );
    // The most that a piece along the edge is taken back.
    let insets: Vec<f64> = ring.edges.iter().map(|edge| edge.further_m).collect();
    assert_eq!(insets, [0.02, 0.01, 0.01, 0.015, 0.015, 0.015]);
}

proptest! {
    #[test]
    fn a_terrain_comes_back_from_its_text(face in faces(), kinds in prop::collection::vec(0..4_usize, 9)) {
        let mut face = face;
        let all = [EdgeKind::Real, EdgeKind::Occluded, EdgeKind::FieldOfView, EdgeKind::Unknown];
        let edges = face.region.edges_mut().flatten().zip(kinds.iter().cycle());
        edges.for_each(|(edge, kind)| edge.kind = all[*kind]);
        face.plane_covariance = Some([[1e-4, 0.0, 1e-5], [0.0, 2e-4, 0.0], [1e-5, 0.0, 1e-5]]);
        let terrain = Terrain::new(vec![face], Vec::new()).unwrap();
        let text = terrain.to_json().unwrap();
        prop_assert_eq!(Terrain::from_json(&text).unwrap(), terrain);
    }
}
