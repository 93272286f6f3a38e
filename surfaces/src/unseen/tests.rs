use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;

use super::*;
use crate::free_space::RayEnd;
use crate::{EdgeView, Region};

/// A scanned level face around W's origin, seen from an eye, whose edges all end it.
fn face(corners: &[[f64; 2]], eye: [f64; 3]) -> Face {
    let mut region =
        Region::new([corners.iter().map(|c| Point2::from(*c)).collect::<Vec<_>>()]).unwrap();
    let mut edges = region.edges_mut().flatten();
    edges.by_ref().for_each(|edge| edge.view = Some(0));
    drop(edges);
    let view = EdgeView {
        eye_W: eye.into(),
        sigma_rad: 0.0,
        plane_covariance: None,
    };
    Face {
        source: Source::Scan,
        views: vec![view],
        ..Face::new("f", Isometry3::identity(), region)
    }
}

const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

/// Rays to points one centimetre apart in a rectangle at a height.
fn looking(eye: [f64; 3], [x0, x1, y0, y1]: [i32; 4], height: f64) -> FreeSpace {
    let places = (x0..x1).flat_map(|x| (y0..y1).map(move |y| [x, y].map(|c| 0.01 * f64::from(c))));
    let seen = |[x, y]: [f64; 2]| RayEnd {
        p_W: Point3::new(x, y, height),
        sigma_m: 0.001,
    };
    FreeSpace {
        eye_W: eye.into(),
        points: places.map(seen).collect(),
        ..FreeSpace::default()
    }
}

proptest! {
    /// What is inside the body behind a face is hidden by it. Its back is a plane, as deep as asked for along the ray
    /// through the middle, so that parts of the face have parts of the body.
    #[test]
    fn a_body_is_where_its_face_hides_it(
        eye in (-3.0..3.0_f64, -3.0..3.0_f64, 0.3..3.0_f64),
        depth in 0.05..0.5_f64,
        weights in prop::collection::vec(0.0..1.0_f64, 12),
    ) {
        let mut faces = [face(&SQUARE, [eye.0, eye.1, eye.2])];
        prop_assert!(fill_unseen(&mut faces, &[], depth, 0.5).is_empty());
        let eye = Point3::new(eye.0, eye.1, eye.2);
        for body in faces[0].bodies_W(1e-9) {
            let weights = weights.iter().cycle().take(body.len());
            let sum: f64 = weights.clone().sum::<f64>() + 1e-9;
            let inside = body.iter().zip(weights).map(|(p, w)| p.coords * (w / sum)).sum::<Vector3<f64>>();
            let way = inside - eye.coords;
            let at = eye + way * (eye.z / (eye.z - inside.z));
            // Scanned edges may be 5 mm off.
            let region = Outline::from(&faces[0].region).bounds().unwrap();
            let near = |axis: usize| at[axis] >= region.0[axis] - 0.0051 && at[axis] <= region.1[axis] + 0.0051;
            prop_assert!(inside.z <= 0.0 && near(0) && near(1), "{inside} by {at}");
            let middle = Point3::new(0.5, 0.5, 0.0);
            let back = (depth * eye.z / (eye - middle).norm()).min(eye.z);
            let is_back = |p: &Point3<f64>| (p.z + back).abs() < 1e-9;
            prop_assert!(body[2 * body.len() / 3..].iter().all(is_back));
        }
    }
}

#[test]
fn what_another_view_saw_behind_a_face_ends_its_body() {
    let eye = [0.5, 0.5, 2.0];
    let own = looking(eye, [0, 100, 0, 100], 0.0);
    let deep = |other: FreeSpace| {
        let mut faces = [face(&SQUARE, eye)];
        fill_unseen(&mut faces, &[own.clone(), other], 0.3, 0.0);
        faces[0].depth_m
    };
    let low = [-3.0, 0.5, -0.2];
    approx::assert_relative_eq!(
        deep(looking(low, [50, 51, 50, 51], -0.1)),
        0.1,
        epsilon = 1e-9
    );
    // On the face but for noise, beside what it hides, or too deep.
    for (at, height) in [
        ([50, 60, 50, 60], -0.01),
        ([120, 130, 0, 100], -0.1),
        ([50, 60, 50, 60], -0.5),
    ] {
        assert_eq!(deep(looking(low, at, height)), 0.3);
    }
}

/// A tread that two views saw, one from above its front edge and one from behind: the space before the riser is hidden from
/// the latter alone.
#[test]
fn a_body_goes_on_along_the_rays_that_leave_it_deepest() {
    let (behind, before) = ([3.0, 0.5, 2.0], [-2.0, 0.5, 2.0]);
    let mut faces = [face(&SQUARE, behind)];
    faces[0].views.push(EdgeView {
        eye_W: before.into(),
        ..faces[0].views[0]
    });
    faces[0].region.edges_mut().flatten().last().unwrap().view = Some(1);
    // The floor below the front edge.
    let views = [
        looking(behind, [0, 100, 0, 100], 0.0),
        looking(before, [-40, -2, 0, 100], -0.1),
    ];
    fill_unseen(&mut faces, &views, 0.3, 0.0);
    let cosine = 2.0 / Vector3::new(2.5, 0.0, 2.0).norm();
    approx::assert_relative_eq!(faces[0].depth_m, 0.3 * cosine, epsilon = 1e-9);
    assert_eq!(faces[0].views[0].eye_W, before.into());
    let edges = faces[0]
        .region
        .edges_mut()
        .flatten()
        .map(|edge| edge.view.unwrap());
    assert_eq!(edges.collect::<Vec<_>>(), [1, 1, 1, 0]);
}

/// By errors of its pose a view that grazed a face may look from behind its plane: its rays would lead a body to the front.
#[test]
fn a_view_from_behind_the_plane_tells_nothing_of_what_a_face_hides() {
    let (below, above) = ([-3.0, 0.5, -0.01], [0.5, 0.5, 2.0]);
    let mut faces = [face(&SQUARE, below)];
    faces[0].views.push(EdgeView {
        eye_W: above.into(),
        ..faces[0].views[0]
    });
    fill_unseen(&mut faces, &[], 0.3, 0.0);
    assert_eq!(faces[0].views[0].eye_W, above.into());
    let mut alone = [face(&SQUARE, below)];
    fill_unseen(&mut alone, &[], 0.3, 0.0);
    let bodies = alone[0].bodies_W(0.03);
    assert!(bodies.iter().flatten().all(|p| p.z < 1e-9));
}

/// Outlines on the plane z = 0 of the fronts of bodies.
fn fronts(bodies: &[Obstacle]) -> Outline {
    let ring = |body: &Obstacle| {
        let front = body.points_W[..body.points_W.len() / 2].iter();
        assert!(body.assumed && front.clone().all(|p| p.z.abs() < 1e-9));
        let behind = &body.points_W[body.points_W.len() / 2..];
        assert!(behind.iter().all(|p| p.z < -0.01));
        Outline::from_rings(&[front.map(|p| [p.x, p.y]).collect()])
    };
    bodies
        .iter()
        .map(ring)
        .fold(Outline::default(), |all, one| all.union(&one))
}

/// The face with the border of the view at edge `cut`, and what is assumed of it then.
fn beyond(corners: &[[f64; 2]], cut: &[usize], views: &[FreeSpace]) -> Outline {
    let mut face = face(corners, [0.5, -2.0, 1.5]);
    let edges = face.region.edges_mut().flatten().enumerate();
    edges
        .filter(|(i, _)| cut.contains(i))
        .for_each(|(_, edge)| edge.kind = EdgeKind::FieldOfView);
    fronts(&fill_unseen(&mut [face], views, 0.2, 0.5))
}

fn same(a: &Outline, corners: &[[f64; 2]]) {
    let b = Outline::from_rings(&[corners.to_vec()]);
    let apart = a.minus(&b).area() + b.minus(a).area();
    assert!(apart < 1e-6, "{apart} m²: {a:?}");
}

#[test]
fn a_face_goes_on_beyond_the_border_straight_along_its_edges() {
    same(
        &beyond(&SQUARE, &[1], &[]),
        &[[1.0, 0.0], [1.5, 0.0], [1.5, 1.0], [1.0, 1.0]],
    );
    // The border cuts it at a slant: it goes on along its sides, and not before the near one.
    let slant = [[0.0, 0.0], [0.5, 0.0], [1.0, 1.0], [0.0, 1.0]];
    same(
        &beyond(&slant, &[1], &[]),
        &[[0.5, 0.0], [1.0, 0.0], [1.5, 1.0], [1.0, 1.0]],
    );
    // Sides that lead together end it where they meet.
    let pointed = [[0.0, 0.0], [1.0, 0.4], [1.0, 0.6], [0.0, 1.0]];
    same(
        &beyond(&pointed, &[1], &[]),
        &[[1.0, 0.4], [1.25, 0.5], [1.0, 0.6]],
    );
    // Where the border runs flat along the near side, the face ends with that side, jagged as it was seen.
    let jags = (0..8).map(|i| [0.075 * f64::from(i), 0.004 * f64::from(i % 2)]);
    let rest = [[0.6, 0.0], [1.0, 0.1], [1.0, 1.0], [0.0, 1.0]];
    let flat: Vec<[f64; 2]> = jags.chain(rest).collect();
    same(
        &beyond(&flat, &[8], &[]),
        &[[0.6, 0.0], [1.0, 0.0], [1.0, 0.1]],
    );
    // A corner that is rounded off is one all the same.
    let rounded = [[0.0, 0.0], [0.99, 0.0], [1.0, 0.01], [1.0, 1.0], [0.0, 1.0]];
    same(
        &beyond(&rounded, &[2], &[]),
        &[[1.0, 0.0], [1.5, 0.0], [1.5, 1.0], [1.0, 1.0]],
    );
    // In the corner of the view nothing is left between what lies beyond its two sides.
    let corner = beyond(&SQUARE, &[1, 2], &[]);
    assert!(corner.contains(&Point2::new(1.2, 1.2)) && corner.contains(&Point2::new(0.1, 1.2)));
    assert!(beyond(&SQUARE, &[], &[]).is_empty());
}

#[test]
fn a_jagged_edge_leads_along_the_line_that_leaves_all_of_it_inside() {
    let right = [
        [1.0, 0.0],
        [0.98, 0.3],
        [1.0, 0.33],
        [0.995, 0.6],
        [0.97, 0.9],
        [0.97, 1.0],
    ];
    let corners: Vec<[f64; 2]> = right.into_iter().chain([[0.0, 1.0], [0.0, 0.0]]).collect();
    let left = beyond(&corners, &[5], &[]);
    let at = |x: f64| left.contains(&Point2::new(x, 1.4));
    assert!(at(0.01) && at(0.97) && !at(1.01), "{left:?}");
    // What hides a part of it in between does not lead anywhere.
    let hidden = [[0.7, 0.4], [0.7, 0.6]];
    let corners: Vec<[f64; 2]> = (right[..3].iter().chain(&hidden).chain(&right[3..]))
        .copied()
        .chain([[0.0, 1.0], [0.0, 0.0]])
        .collect();
    assert_eq!(left, beyond(&corners, &[7], &[]));
}

#[test]
fn what_another_view_looked_through_is_not_assumed() {
    let through = looking([1.2, 0.5, 1000.0], [98, 130, -10, 110], -1.0);
    let left = beyond(&SQUARE, &[1], &[FreeSpace::default(), through]);
    let (low, high) = left.bounds().unwrap();
    assert!(low.x > 1.25 && high.x > 1.49, "{left:?}");
    let beside = looking([1.2, 0.5, 1000.0], [200, 230, -10, 110], -1.0);
    same(
        &beyond(&SQUARE, &[1], &[beside]),
        &[[1.0, 0.0], [1.5, 0.0], [1.5, 1.0], [1.0, 1.0]],
    );
}
