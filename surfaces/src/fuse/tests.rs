use nalgebra::{Isometry3, Matrix3, Point2, Point3, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;

use super::*;
use crate::free_space::RayEnd;
use crate::{EdgeKind, EdgeView};

/// A level rectangle [x0, x1] × [y0, y1] at a height, with tilts and an offset added.
fn face(id: &str, [x0, x1, y0, y1]: [f64; 4], height: f64, error: [f64; 3]) -> Face {
    let (cx, cy) = ((x0 + x1) / 2.0, (y0 + y1) / 2.0);
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(error[0], error[1], 0.0));
    let X = Isometry3::from_parts(Translation3::new(cx, cy, height + error[2]), turn);
    let (tilt, z) = (0.005_f64.powi(2), 0.004_f64.powi(2));
    Face {
        source: Source::Scan,
        fit: Some(crate::Fit {
            points: 100,
            rms_m: 0.0,
        }),
        plane_covariance: Some([[tilt, 0.0, 0.0], [0.0, tilt, 0.0], [0.0, 0.0, z]]),
        ..Face::rectangle(id, X, [x1 - x0, y1 - y0]).unwrap()
    }
}

/// What ends it toward −y, +x, +y, −x.
fn ended(mut face: Face, kinds: [EdgeKind; 4]) -> Face {
    let edges = face.region.edges_mut().flatten().zip(kinds);
    edges.for_each(|(edge, kind)| edge.kind = kind);
    face
}

fn view(faces: Vec<Face>) -> View {
    View {
        faces,
        ..View::default()
    }
}

/// Rays from an eye to points on a level lattice of 5 mm.
fn looking_at(eye: [f64; 3], [x0, x1, y0, y1]: [f64; 4], height: f64) -> FreeSpace {
    let steps = |a: f64, b: f64| {
        (0..)
            .map(move |i| a + 0.005 * f64::from(i))
            .take_while(move |x| *x < b)
    };
    let points = steps(x0, x1).flat_map(|x| steps(y0, y1).map(move |y| [x, y]));
    let seen = |[x, y]: [f64; 2]| RayEnd {
        p_W: Point3::new(x, y, height),
        sigma_m: 0.002,
    };
    FreeSpace {
        eye_W: Point3::from(eye),
        points: points.map(seen).collect(),
        ..FreeSpace::default()
    }
}

#[test]
fn one_view_and_faces_apart_stay_bit_for_bit() {
    let a = face("a", [0.0, 1.0, 0.0, 1.0], 0.3, [0.001, 0.0, 0.0]);
    let b = face("b", [1.1, 2.0, 0.0, 1.0], 0.3, [0.0; 3]);
    let lower = face("c", [0.2, 0.8, 0.2, 0.8], 0.2, [0.0; 3]);
    let mut under = face("d", [0.0, 1.0, 0.0, 1.0], 0.3, [0.0; 3]);
    under.X_WF.rotation *=
        UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let alone = fuse(vec![view(vec![a.clone()])]);
    assert_eq!(
        (alone.terrain.faces, alone.changes),
        (vec![a.clone()], vec![])
    );
    let views = vec![
        view(vec![a.clone()]),
        view(vec![b.clone(), lower.clone(), under.clone()]),
    ];
    let fused = fuse(views);
    assert_eq!(fused.terrain.faces, vec![a, b, lower, under]);
    assert!(fused.changes.is_empty());
}

#[test]
fn an_edge_where_one_view_ended_goes_on_as_far_as_another_saw() {
    let a = face("a", [0.0, 1.0, 0.0, 1.0], 0.3, [0.0, 0.0, 0.003]);
    let b = face("b", [0.8, 2.0, 0.0, 1.0], 0.3, [0.0, 0.0, -0.003]);
    let fused = fuse(vec![view(vec![a]), view(vec![b])]);
    let [one] = &fused.terrain.faces[..] else {
        panic!("{:?}", fused.terrain.faces)
    };
    assert_eq!(one.id.as_str(), "a");
    approx::assert_relative_eq!(one.region.area(), 2.0, max_relative = 1e-3);
    // Equal covariances: the mean of both, known better than either.
    assert!((one.X_WF.translation.z - 0.3).abs() < 0.002);
    assert!(one.plane_covariance.unwrap()[2][2] < 0.004_f64.powi(2));
    assert_eq!(one.fit.unwrap().points, 200);
    one.validate().unwrap();
    let with = vec!["b".into()];
    assert_eq!(
        fused.changes,
        [Change::Joined {
            id: "a".into(),
            with
        }]
    );
}

#[test]
fn a_third_view_joins_what_two_saw_apart_and_the_oldest_name_stays() {
    let a = face("a", [0.0, 0.5, 0.0, 1.0], 0.0, [0.0; 3]);
    let b = face("b", [1.0, 1.5, 0.0, 1.0], 0.0, [0.0; 3]);
    let across = face("c", [0.3, 1.2, 0.0, 1.0], 0.0, [0.0; 3]);
    let views = vec![view(vec![a]), view(vec![b]), view(vec![across])];
    let fused = fuse(views);
    assert_eq!(fused.terrain.faces.len(), 1);
    assert_eq!(fused.terrain.faces[0].id.as_str(), "a");
    approx::assert_relative_eq!(
        fused.terrain.faces[0].region.area(),
        1.5,
        max_relative = 1e-3
    );
}

#[test]
fn the_union_of_two_strips_is_one_face() {
    let a = face("a", [0.0, 1.0, 0.4, 0.6], 0.0, [0.0; 3]);
    let b = face("b", [0.4, 0.6, 0.0, 1.0], 0.0, [0.0; 3]);
    let fused = fuse(vec![view(vec![a]), view(vec![b])]);
    let [cross] = &fused.terrain.faces[..] else {
        panic!("{:?}", fused.terrain.faces)
    };
    assert_eq!(cross.id.as_str(), "a");
    assert_eq!(cross.region.rings()[0].vertices.len(), 12);
    approx::assert_relative_eq!(cross.region.area(), 0.36, max_relative = 1e-3);
}

#[test]
fn edges_keep_the_errors_with_which_their_views_saw_them() {
    let seen = |id: &str, at: [f64; 4], eye: [f64; 3], sigma_rad: f64| {
        let mut face = face(id, at, 0.3, [0.0; 3]);
        face.views = vec![EdgeView {
            eye_W: eye.into(),
            sigma_rad,
            plane_covariance: None,
        }];
        let edges = face.region.edges_mut().flatten();
        edges.for_each(|edge| edge.view = Some(0));
        face
    };
    let a = seen("a", [0.0, 1.0, 0.0, 1.0], [-1.0, 0.5, 1.5], 0.002);
    let b = seen("b", [0.8, 2.0, 0.0, 1.0], [3.0, 0.5, 1.5], 0.004);
    let (left, right) = (a.edge_insets_m(2.0)[0][3], b.edge_insets_m(2.0)[0][1]);
    let fused = fuse(vec![view(vec![a]), view(vec![b])]);
    let one = &fused.terrain.faces[0];
    assert_eq!(one.views.len(), 2);
    one.validate().unwrap();
    let insets = one.edge_insets_m(2.0);
    for (side, expected) in [(-Vector3::x(), left), (Vector3::x(), right)] {
        let along = one.region.rings()[0].segments().position(|(_, [a, b])| {
            let along = b - a;
            (one.X_WF * Vector3::new(along.y, -along.x, 0.0)).dot(&side) > 0.9 * along.norm()
        });
        approx::assert_relative_eq!(insets[0][along.unwrap()], expected, max_relative = 1e-6);
    }
    // A part that was cut off later is known to half a cell there.
    let through = View {
        free_space: looking_at([0.5, 0.5, 1000.0], [1.5, 2.1, -0.1, 1.1], 0.0),
        ..View::default()
    };
    let a = face("a", [0.0, 2.0, 0.0, 1.0], 0.3, [0.0; 3]);
    let cut = fuse(vec![view(vec![a]), through]).terrain.faces.remove(0);
    assert!(
        cut.edge_insets_m(2.0)[0].contains(&0.01),
        "{:?}",
        cut.region
    );
}

#[test]
fn what_a_later_view_looks_through_is_cut_and_what_an_earlier_one_did_is_not() {
    let board = face("board", [0.0, 1.0, 0.0, 1.0], 0.5, [0.0; 3]);
    // The floor is seen through the right half of the board, and its left half itself.
    let mut free_space = looking_at([0.5, 0.5, 1000.0], [0.5, 1.0, 0.0, 1.0], 0.0);
    let left = looking_at([0.5, 0.5, 1000.0], [0.0, 0.5, 0.0, 1.0], 0.5);
    free_space.points.extend(left.points);
    let through = View {
        free_space,
        ..View::default()
    };
    let first = view(vec![board.clone()]);
    let fused = fuse(vec![first.clone(), through.clone()]);
    let [half] = &fused.terrain.faces[..] else {
        panic!("{:?}", fused.terrain.faces)
    };
    assert_eq!(half.id.as_str(), "board");
    let reach = half.vertices_W().iter().map(|p| p.x).fold(0.0, f64::max);
    // Cells of 20 mm, and half of one more.
    assert!((0.46..=0.5).contains(&reach), "{reach}");
    assert!(matches!(&fused.changes[..], [Change::Cut { area_m2, .. }] if *area_m2 > 0.45));
    let fused = fuse(vec![through, first]);
    assert_eq!(fused.terrain.faces, [board]);
}

#[test]
fn a_face_that_is_gone_is_dropped_and_one_that_is_only_hidden_stays() {
    let near = face("box", [0.0, 0.3, 0.0, 0.3], 0.2, [0.0; 3]);
    let beside = face("beside", [0.6, 0.9, 0.0, 0.3], 0.2, [0.0; 3]);
    let mut free_space = looking_at([0.15, 0.15, 1000.0], [-0.1, 0.4, -0.1, 0.4], 0.0);
    // Something stands in front of the other one.
    let hidden = looking_at([0.15, 0.15, 1000.0], [0.6, 0.9, 0.0, 0.3], 0.7);
    free_space.points.extend(hidden.points);
    let later = View {
        free_space,
        ..View::default()
    };
    let fused = fuse(vec![view(vec![near, beside.clone()]), later]);
    assert_eq!(fused.terrain.faces, [beside]);
    assert_eq!(fused.changes, [Change::Dropped { id: "box".into() }]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// Two noisy views of one rectangle, in any pose: one face, its plane within its covariance of
    /// the truth, its outline the union, whatever the pose.
    #[test]
    fn two_views_of_a_rectangle_are_one_face(
        pose in prop::array::uniform6(-2.0..2.0_f64),
        errors in prop::array::uniform6(-1.0..1.0_f64),
        (low, high) in (0.2..0.45_f64, 0.55..0.8_f64),
    ) {
        let X = Isometry3::new(
            Vector3::new(pose[0], pose[1], pose[2]),
            Vector3::new(pose[3], pose[4], pose[5]),
        );
        let scaled = |e: &[f64]| [0.004 * e[0], 0.004 * e[1], 0.003 * e[2]];
        let mut a = face("a", [0.0, high, 0.0, 1.0], 0.0, scaled(&errors[..3]));
        let mut b = face("b", [low, 1.0, 0.0, 1.0], 0.0, scaled(&errors[3..]));
        (a.X_WF, b.X_WF) = (X * a.X_WF, X * b.X_WF);
        let fused = fuse(vec![view(vec![a]), view(vec![b])]);
        prop_assert_eq!(fused.terrain.faces.len(), 1);
        let mut one = fused.terrain.faces[0].clone();
        one.X_WF = X.inverse() * one.X_WF;
        prop_assert!((one.region.area() - 1.0).abs() < 0.01);
        let n = one.normal_W();
        let error = Vector3::new(-n.y / n.z, n.x / n.z, one.X_WF.translation.z);
        let rows = one.plane_covariance.unwrap();
        let sigma = Matrix3::from_fn(|i, j| rows[i][j]);
        // Errors of a standard deviation at most go in; where those of both views are the same, they are √2
        // deviations of the two together, in each of three directions.
        prop_assert!(error.dot(&(sigma.try_inverse().unwrap() * error)) < 6.0 + 1e-3);
        prop_assert!(fused.terrain.validate().is_ok());
    }
}

/// The kinds of the edges toward −y, +x, +y, −x, each of the longest edge there.
fn kinds_around(face: &Face) -> [EdgeKind; 4] {
    let sides = [-Vector3::y(), Vector3::x(), Vector3::y(), -Vector3::x()];
    sides.map(|side| {
        let toward = face.region.rings()[0].segments().filter(|(_, [a, b])| {
            let along = (*b - *a).normalize();
            (face.X_WF * Vector3::new(along.y, -along.x, 0.0)).dot(&side) > 0.9
        });
        let length = |(_, [a, b]): &(_, [&Point2<f64>; 2])| (*b - *a).norm();
        let longest = toward.max_by(|a, b| length(a).total_cmp(&length(b)));
        longest.unwrap().0.kind
    })
}

#[test]
fn a_hidden_edge_vanishes_or_is_real_where_another_view_saw_so() {
    use EdgeKind::{FieldOfView, Occluded, Real};
    let a = face("a", [0.0, 1.0, 0.0, 1.0], 0.3, [0.0, 0.0, 0.001]);
    let a = ended(a, [FieldOfView, Occluded, Occluded, Real]);
    // It sees how the face goes on toward +x up to a hidden edge, and that it ends at y = 1.
    let b = face("b", [0.5, 1.8, 0.5, 1.01], 0.3, [0.0, 0.0, -0.001]);
    let b = ended(b, [Occluded, Occluded, Real, Occluded]);
    let fused = fuse(vec![view(vec![a]), view(vec![b])]);
    let longest = kinds_around(&fused.terrain.faces[0]);
    // The longest edge toward −y is the first view's, at y = 0.
    assert_eq!(longest[0], FieldOfView);
    assert_eq!((longest[2], longest[3]), (Real, Real));
}

#[test]
fn an_edge_is_real_beyond_which_a_view_looked_through_the_plane() {
    use EdgeKind::{Occluded, Real};
    let a = ended(
        face("a", [0.0, 1.0, 0.0, 1.0], 0.3, [0.0; 3]),
        [Occluded; 4],
    );
    // Another view looks past its edge at x = 1 to something 0.3 m below.
    let past = View {
        free_space: looking_at([1.5, 0.5, 2.0], [0.9, 1.4, -0.1, 1.1], 0.0),
        ..View::default()
    };
    let fused = fuse(vec![view(vec![a.clone()]), past]);
    // Nothing else of it has changed.
    assert_eq!(
        fused.terrain.faces,
        [ended(a, [Occluded, Real, Occluded, Occluded])]
    );
}
