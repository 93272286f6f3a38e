#![allow(non_snake_case)]

use nalgebra::{Isometry3, Matrix3, Point2, Point3, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;

use super::*;
use crate::outline::Outline;
use crate::{ConvexPolygon, EdgeKind, SurfaceSet, ThinBody};

/// A level rectangle [x0, x1] × [y0, y1] at a height, with tilts and an offset added.
fn face(id: &str, [x0, x1, y0, y1]: [f64; 4], height: f64, error: [f64; 3]) -> Surface {
    let (cx, cy) = ((x0 + x1) / 2.0, (y0 + y1) / 2.0);
    let corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
    let corners: Vec<_> = (corners.iter())
        .map(|[x, y]| Point2::new(x - cx, y - cy))
        .collect();
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(error[0], error[1], 0.0));
    let X = Isometry3::from_parts(Translation3::new(cx, cy, height + error[2]), turn);
    let (tilt, z) = (0.005_f64.powi(2), 0.004_f64.powi(2));
    let outline = vec![corners.iter().map(|p| [p.x, p.y]).collect()];
    Surface {
        outline,
        source: Source::Scan,
        inliers: 100,
        plane_covariance: Some([[tilt, 0.0, 0.0], [0.0, tilt, 0.0], [0.0, 0.0, z]]),
        ..Surface::new(id, X, ConvexPolygon::new(corners).unwrap())
    }
}

fn view(surfaces: Vec<Surface>) -> View {
    View {
        surfaces,
        ..View::default()
    }
}

/// The area of the surfaces' union, seen from above.
fn area(surfaces: &[Surface]) -> f64 {
    let mut whole = Outline::default();
    for s in surfaces {
        let ring = s.vertices_W().iter().map(|p| [p.x, p.y]).collect();
        whole = whole.union(&Outline::from_rings(&[ring]));
    }
    whole.area()
}

/// Rays from an eye to points on a level lattice of 5 mm.
fn looking_at(eye: [f64; 3], [x0, x1, y0, y1]: [f64; 4], height: f64) -> Sight {
    let steps = |a: f64, b: f64| {
        (0..)
            .map(move |i| a + 0.005 * f64::from(i))
            .take_while(move |x| *x < b)
    };
    let points = steps(x0, x1).flat_map(|x| steps(y0, y1).map(move |y| [x, y]));
    let seen = |[x, y]: [f64; 2]| Seen {
        p_W: Point3::new(x, y, height),
        sigma_m: 0.002,
    };
    Sight {
        eye_W: Point3::from(eye),
        points: points.map(seen).collect(),
    }
}

#[test]
fn one_view_and_faces_apart_stay_bit_for_bit() {
    let a = face("a", [0.0, 1.0, 0.0, 1.0], 0.3, [0.001, 0.0, 0.0]);
    let b = face("b", [1.1, 2.0, 0.0, 1.0], 0.3, [0.0; 3]);
    let lower = face("c", [0.2, 0.8, 0.2, 0.8], 0.2, [0.0; 3]);
    let mut under = face("d", [0.0, 1.0, 0.0, 1.0], 0.3, [0.0; 3]);
    under.X_WS.rotation *=
        UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let config = Config::default();
    let alone = merge(vec![view(vec![a.clone()])], &config);
    assert_eq!((alone.surfaces, alone.changes), (vec![a.clone()], vec![]));
    let views = vec![
        view(vec![a.clone()]),
        view(vec![b.clone(), lower.clone(), under.clone()]),
    ];
    let merged = merge(views, &config);
    assert_eq!(merged.surfaces, vec![a, b, lower, under]);
    assert!(merged.changes.is_empty());
}

#[test]
fn an_edge_where_one_view_ended_goes_on_as_far_as_another_saw() {
    let a = face("a", [0.0, 1.0, 0.0, 1.0], 0.3, [0.0, 0.0, 0.003]);
    let b = face("b", [0.8, 2.0, 0.0, 1.0], 0.3, [0.0, 0.0, -0.003]);
    let merged = merge(vec![view(vec![a]), view(vec![b])], &Config::default());
    let [one] = &merged.surfaces[..] else {
        panic!("{:?}", merged.surfaces)
    };
    assert_eq!(one.id, "a");
    approx::assert_relative_eq!(one.polygon.area(), 2.0, max_relative = 1e-3);
    // Equal covariances: the mean of both, known better than either.
    assert!((one.X_WS.translation.z - 0.3).abs() < 0.002);
    assert!(one.plane_covariance.unwrap()[2][2] < 0.004_f64.powi(2));
    assert_eq!(one.inliers, 200);
    one.validate().unwrap();
    let with = vec!["b".to_owned()];
    assert_eq!(
        merged.changes,
        [Change::Joined {
            id: "a".to_owned(),
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
    let merged = merge(views, &Config::default());
    assert_eq!(merged.surfaces.len(), 1);
    assert_eq!(merged.surfaces[0].id, "a");
    approx::assert_relative_eq!(area(&merged.surfaces), 1.5, max_relative = 1e-3);
}

#[test]
fn the_union_of_two_strips_is_pieces_of_one_face() {
    let a = face("a", [0.0, 1.0, 0.4, 0.6], 0.0, [0.0; 3]);
    let b = face("b", [0.4, 0.6, 0.0, 1.0], 0.0, [0.0; 3]);
    let merged = merge(vec![view(vec![a]), view(vec![b])], &Config::default());
    let ids: Vec<&str> = merged.surfaces.iter().map(|s| s.id.as_str()).collect();
    assert_eq!(ids.len(), 2);
    assert!(ids.contains(&"a") && ids.contains(&"b"), "{ids:?}");
    assert!(
        merged
            .surfaces
            .iter()
            .all(|s| s.face.as_deref() == Some("a"))
    );
    assert!(merged.surfaces[0].shares_outline(&merged.surfaces[1]));
    approx::assert_relative_eq!(area(&merged.surfaces), 0.36, max_relative = 1e-3);
}

#[test]
fn what_a_later_view_looks_through_is_cut_and_what_an_earlier_one_did_is_not() {
    let board = face("board", [0.0, 1.0, 0.0, 1.0], 0.5, [0.0; 3]);
    // The floor is seen through the right half of the board, and its left half itself.
    let mut sight = looking_at([0.5, 0.5, 1000.0], [0.5, 1.0, 0.0, 1.0], 0.0);
    let left = looking_at([0.5, 0.5, 1000.0], [0.0, 0.5, 0.0, 1.0], 0.5);
    sight.points.extend(left.points);
    let through = View {
        sight,
        ..View::default()
    };
    let first = view(vec![board.clone()]);
    let merged = merge(vec![first.clone(), through.clone()], &Config::default());
    let [half] = &merged.surfaces[..] else {
        panic!("{:?}", merged.surfaces)
    };
    assert_eq!(half.id, "board");
    let reach = half.vertices_W().iter().map(|p| p.x).fold(0.0, f64::max);
    // Cells of 20 mm, and half of one more.
    assert!((0.46..=0.5).contains(&reach), "{reach}");
    assert!(matches!(&merged.changes[..], [Change::Cut { area_m2, .. }] if *area_m2 > 0.45));
    let merged = merge(vec![through, first], &Config::default());
    assert_eq!(merged.surfaces, [board]);
}

#[test]
fn a_face_that_is_gone_is_dropped_and_one_that_is_only_hidden_stays() {
    let near = face("box", [0.0, 0.3, 0.0, 0.3], 0.2, [0.0; 3]);
    let beside = face("beside", [0.6, 0.9, 0.0, 0.3], 0.2, [0.0; 3]);
    let mut sight = looking_at([0.15, 0.15, 1000.0], [-0.1, 0.4, -0.1, 0.4], 0.0);
    // Something stands in front of the other one.
    let hidden = looking_at([0.15, 0.15, 1000.0], [0.6, 0.9, 0.0, 0.3], 0.7);
    sight.points.extend(hidden.points);
    let later = View {
        sight,
        ..View::default()
    };
    let merged = merge(
        vec![view(vec![near, beside.clone()]), later],
        &Config::default(),
    );
    assert_eq!(merged.surfaces, [beside]);
    assert_eq!(
        merged.changes,
        [Change::Dropped {
            id: "box".to_owned()
        }]
    );
}

#[test]
fn an_assumed_body_gives_way_to_what_another_view_saw() {
    let wall = face("wall", [0.0, 1.0, 0.0, 1.0], 0.0, [0.0; 3]);
    let beyond = face("beyond", [1.0, 1.5, 0.0, 1.0], 0.0, [0.0; 3]);
    let body = |assumed: bool| {
        let mut body = Obstacle::from(ThinBody::new(&beyond, 0.2));
        body.surface = None;
        body.assumed = assumed;
        body
    };
    let first = |assumed: bool| View {
        surfaces: vec![wall.clone()],
        obstacles: vec![body(assumed)],
        ..View::default()
    };
    let through = View {
        sight: looking_at([1.2, 0.5, 1000.0], [0.98, 1.3, -0.1, 1.1], -1.0),
        ..View::default()
    };
    let reach = |merged: &Merged| {
        let points = merged.obstacles.iter().flat_map(|o| &o.points_W);
        points.map(|p| p.x).fold(f64::INFINITY, f64::min)
    };
    let config = Config::default();
    assert_eq!(reach(&merge(vec![first(true)], &config)), 1.0);
    let left = merge(vec![first(true), through.clone()], &config);
    assert!(reach(&left) > 1.25, "{:?}", left.obstacles);
    // What was seen to be there is no assumption.
    let kept = merge(vec![first(false), through], &config);
    assert_eq!(reach(&kept), 1.0);
    // Another view saw the wall itself go on.
    let on = face("on", [0.9, 1.5, -0.1, 1.1], 0.0, [0.0; 3]);
    let merged = merge(vec![first(true), view(vec![on])], &config);
    assert!(merged.obstacles.is_empty(), "{:?}", merged.obstacles);
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
        (a.X_WS, b.X_WS) = (X * a.X_WS, X * b.X_WS);
        let merged = merge(vec![view(vec![a]), view(vec![b])], &Config::default());
        prop_assert_eq!(merged.surfaces.len(), 1);
        let mut one = merged.surfaces[0].clone();
        one.X_WS = X.inverse() * one.X_WS;
        prop_assert!((one.polygon.area() - 1.0).abs() < 0.01);
        let n = one.normal_W();
        let error = Vector3::new(-n.y / n.z, n.x / n.z, one.X_WS.translation.z);
        let rows = one.plane_covariance.unwrap();
        let sigma = Matrix3::from_fn(|i, j| rows[i][j]);
        // Errors of a standard deviation at most go in: less than χ²₃ of 3 comes out.
        prop_assert!(error.dot(&(sigma.try_inverse().unwrap() * error)) < 3.0);
        prop_assert!(SurfaceSet::new(merged.surfaces, merged.obstacles).is_ok());
    }
}

/// The kinds of the outline's edges toward −y, +x, +y, −x, each of the longest edge there.
fn kinds_around(surface: &Surface) -> [EdgeKind; 4] {
    let sides = [-Vector3::y(), Vector3::x(), Vector3::y(), -Vector3::x()];
    sides.map(|side| {
        let ring = &surface.outline[0];
        let toward = crate::edge::ring_edges(ring)
            .zip(&surface.outline_edges[0])
            .filter(|((a, b), _)| {
                let along = (b - a).normalize();
                let out = surface.X_WS * Vector3::new(along.y, -along.x, 0.0);
                out.dot(&side) > 0.9
            })
            .map(|((a, b), kind)| ((b - a).norm(), *kind));
        toward
            .reduce(|a, b| if b.0 > a.0 { b } else { a })
            .map(|(_, kind)| kind)
            .unwrap()
    })
}

#[test]
fn a_hidden_edge_vanishes_or_is_real_where_another_view_saw_so() {
    use EdgeKind::{FieldOfView, Occluded, Real};
    let mut a = face("a", [0.0, 1.0, 0.0, 1.0], 0.3, [0.0, 0.0, 0.001]);
    a.set_outline_edges(vec![vec![FieldOfView, Occluded, Occluded, Real]]);
    // It sees how the face goes on toward +x up to a hidden edge, and that it ends at y = 1.
    let mut b = face("b", [0.5, 1.8, 0.5, 1.01], 0.3, [0.0, 0.0, -0.001]);
    b.set_outline_edges(vec![vec![Occluded, Occluded, Real, Occluded]]);
    let merged = merge(vec![view(vec![a]), view(vec![b])], &Config::default());
    let first = &merged.surfaces[0];
    let longest = kinds_around(first);
    // The longest edge toward −y is the first view's, at y = 0.
    assert_eq!(longest[0], FieldOfView);
    assert_eq!((longest[2], longest[3]), (Real, Real));
    for s in &merged.surfaces {
        s.validate().unwrap();
        assert_eq!(s.polygon_edges.len(), s.polygon.vertices().len());
    }
}

#[test]
fn an_edge_is_real_beyond_which_a_view_looked_through_the_plane() {
    use EdgeKind::{Occluded, Real};
    let mut a = face("a", [0.0, 1.0, 0.0, 1.0], 0.3, [0.0; 3]);
    a.set_outline_edges(vec![vec![Occluded; 4]]);
    // Another view looks past its edge at x = 1 to something 0.3 m below.
    let past = View {
        sight: looking_at([1.5, 0.5, 2.0], [0.9, 1.4, -0.1, 1.1], 0.0),
        ..View::default()
    };
    let merged = merge(vec![view(vec![a.clone()]), past], &Config::default());
    let [one] = &merged.surfaces[..] else {
        panic!("{:?}", merged.surfaces)
    };
    assert_eq!(kinds_around(one), [Occluded, Real, Occluded, Occluded]);
    assert_eq!(one.polygon_edges, [Occluded, Real, Occluded, Occluded]);
    // Nothing else of it has changed.
    a.set_outline_edges(one.outline_edges.clone());
    assert_eq!(*one, a);
}
