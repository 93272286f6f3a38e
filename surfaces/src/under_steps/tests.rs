use nalgebra::Isometry3;

use super::*;
use crate::EdgeView;

/// The camera, over the landing.
const EYE: Point3<f64> = Point3::new(0.0, 0.0, 1.2);

/// A face of z = `z`, from `from` to `to` along x and 1 m wide about y = 0, of which what is nearer to the eye is hidden.
fn level(id: &str, [from, to]: [f64; 2], z: f64) -> Face {
    let X_WF = Isometry3::translation(0.5 * (from + to), 0.0, z);
    let mut face = Face::rectangle(id, X_WF, [to - from, 1.0]).unwrap();
    face.source = Source::Scan;
    face.depth_m = 0.1;
    face.views = vec![EdgeView {
        eye_W: EYE,
        sigma_rad: 0.001,
        plane_covariance: None,
    }];
    let ring = face.region.rings()[0].clone();
    let near: Vec<bool> = ring
        .segments()
        .map(|(_, [a, b])| a.x < 0.0 && b.x < 0.0)
        .collect();
    for (edge, near) in face.region.edges_mut().flatten().zip(near) {
        edge.view = Some(0);
        edge.kind = if near {
            EdgeKind::Occluded
        } else {
            EdgeKind::Real
        };
    }
    face
}

/// A landing that ends at x = 1 and two treads 0.3 m deep below it, `rise` apart, as the eye sees them.
fn flight(rise: f64) -> Vec<Face> {
    // Over the edge at x and z = 0 the ray comes down at x h / (h - rise).
    let comes_down = |x: f64, z: f64| x * (EYE.z - z + rise) / (EYE.z - z);
    vec![
        level("landing", [0.4, 1.0], 0.0),
        level("first", [comes_down(1.0, 0.0), 1.3], -rise),
        level("second", [comes_down(1.3, -rise), 1.6], -2.0 * rise),
    ]
}

#[test]
fn treads_go_on_to_below_the_steps_that_hide_them() {
    let mut faces = flight(0.12);
    let (continued, columns) = continue_under_steps(&mut faces, 0.3);
    let by: Vec<(&str, &str)> = (continued.iter())
        .map(|tread| (tread.face.as_str(), tread.under.as_str()))
        .collect();
    assert_eq!(by, [("first", "landing"), ("second", "first")]);
    assert!((continued[0].by_m - 0.1).abs() < 1e-9, "{continued:?}");
    for (face, begins) in faces.iter().zip([0.4, 1.0, 1.3]) {
        let low = face
            .vertices_W()
            .iter()
            .map(|p| p.x)
            .fold(f64::INFINITY, f64::min);
        assert!((low - begins).abs() < 1e-9, "{}: {low}", face.id);
        let kinds = face.region.segments().map(|(edge, _)| edge.kind);
        let hidden = kinds.filter(|kind| *kind == EdgeKind::Occluded).count();
        assert_eq!(hidden, if begins > 0.5 { 3 } else { 1 });
    }
    // What stood over the strips along the rays now stands straight below the steps.
    let over_strip = Point3::new(1.02, 0.0, -0.05);
    assert!(flight(0.12)[0].hides(&over_strip, &EYE) && !faces[2].hides(&over_strip, &EYE));
    assert_eq!(
        (faces[0].depth_m, faces[1].depth_m, faces[2].depth_m),
        (0.0, 0.0, 0.1)
    );
    let ids: Vec<&str> = columns.iter().map(|body| body.id.as_str()).collect();
    assert_eq!(ids, ["landing/column0", "first/column0"]);
    let landing = columns[0].points_W.iter();
    let (far, deep) = landing.fold((0.0_f64, 0.0_f64), |(x, z), p| (x.max(p.x), z.min(p.z)));
    assert!(
        (far - 1.005).abs() < 1e-9 && (deep + 0.12).abs() < 1e-9,
        "{far} {deep}"
    );
}

#[test]
fn what_no_step_hides_ends_where_it_was_seen_to() {
    let unchanged = |faces: Vec<Face>, most_m: f64| {
        let mut after = faces.clone();
        let (continued, columns) = continue_under_steps(&mut after, most_m);
        assert_eq!((after, columns), (faces, vec![]), "{continued:?}");
    };
    // More is hidden than may be.
    unchanged(flight(0.12), 0.05);
    // A table, not a step.
    unchanged(flight(0.4), 0.3);
    // Something else than the landing hides the tread: it comes in sight far behind the landing's shadow.
    let late = level("late", [1.25, 1.4], -0.12);
    unchanged(vec![level("landing", [0.4, 1.0], 0.0), late], 0.3);
    // A floor has room enough where it was seen.
    let floor = level("floor", [1.0 / 0.9, 2.0], -0.12);
    unchanged(vec![level("landing", [0.4, 1.0], 0.0), floor], 0.3);
    // The step is askew to it.
    let mut askew = flight(0.12);
    askew.truncate(2);
    askew[0].X_WF.rotation = nalgebra::UnitQuaternion::from_euler_angles(0.0, 0.15, 0.0);
    unchanged(askew, 0.3);
}
