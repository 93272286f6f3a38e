use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;
use surfaces::{Face, Source};

use super::*;

/// A square of half a metre at a place, its normal turned from the vertical.
fn square(id: &str, at: [f64; 3], turn: [f64; 3]) -> Face {
    let (tilt, z) = (0.004_f64.powi(2), 0.003_f64.powi(2));
    Face {
        source: Source::Scan,
        plane_covariance: Some([[tilt, 0.0, 0.0], [0.0, tilt, 0.0], [0.0, 0.0, z]]),
        ..Face::rectangle(id, Isometry3::new(at.into(), turn.into()), [1.0, 1.0]).unwrap()
    }
}

const UPRIGHT: f64 = std::f64::consts::FRAC_PI_2;

/// Floor, two steps, a wall ahead and one beside.
fn room() -> Vec<Face> {
    vec![
        square("floor", [0.0, 0.0, 0.0], [0.0; 3]),
        square("step", [1.0, 0.0, 0.2], [0.0; 3]),
        square("ramp", [1.0, 1.2, 0.1], [0.0, -0.2, 0.0]),
        square("ahead", [2.0, 0.0, 1.0], [0.0, -UPRIGHT, 0.0]),
        square("beside", [0.5, 1.8, 1.0], [UPRIGHT, 0.0, 0.0]),
    ]
}

fn moved(faces: &[Face], by: &Isometry3<f64>) -> Vec<Face> {
    let one = |s: &Face| Face {
        X_WF: by * s.X_WF,
        ..s.clone()
    };
    faces.iter().map(one).collect()
}

/// Poses of which nothing is known, so that planes alone tell.
fn unknown() -> RegistrationConfig {
    RegistrationConfig {
        position_sigma_m: 100.0,
        direction_sigma_rad: 100.0,
        ..RegistrationConfig::default()
    }
}

#[test]
fn what_planes_leave_open_stays_as_it_was_given() {
    let room = room();
    let off = Isometry3::new(
        Vector3::new(0.03, -0.02, 0.025),
        Vector3::new(0.01, -0.015, 0.02),
    );
    let config = RegistrationConfig::default();
    let seen = |keep: &[usize]| {
        let some: Vec<Face> = keep.iter().map(|&i| room[i].clone()).collect();
        let found = register(&room, &moved(&some, &off), &Point3::origin(), &config).unwrap();
        let left = found.X_W * off;
        let shift = left * found.about_W - found.about_W;
        (found.open.join(", "), shift, left.rotation.scaled_axis())
    };
    // Floor and steps: height and tilt.
    let (open, shift, turn) = seen(&[0, 1]);
    assert!(open.contains("turn about z"), "{open}");
    assert!(
        open.contains("shift along x") && open.contains("shift along y"),
        "{open}"
    );
    assert!(
        shift.z.abs() < 2e-3 && turn.xy().norm() < 2e-3,
        "{shift} {turn}"
    );
    assert!((turn.z - 0.02).abs() < 2e-3, "{turn}");
    // And a wall ahead: all but the shift along it. The pose that was given keeps up to a twentieth.
    let (open, shift, turn) = seen(&[0, 1, 3]);
    assert_eq!(open, "the shift along y");
    assert!(
        shift.xz().norm() < 2e-3 && turn.norm() < 2e-3,
        "{shift} {turn}"
    );
    // All of it.
    let (open, shift, _) = seen(&[0, 1, 2, 3, 4]);
    assert!(open.is_empty() && shift.norm() < 2e-3, "{open} {shift}");
}

#[test]
fn planes_that_are_no_pairs_are_left_out() {
    let known = room();
    let shift = Isometry3::translation(0.03, -0.02, 0.04);
    let mut seen = moved(&known, &shift);
    // A table that was moved: within reach of the old one, far outside of its covariance.
    let mut others = known.clone();
    others.push(square("table", [-1.2, 0.0, 0.7], [0.0; 3]));
    seen.push(square("table", [-1.2, 0.0, 0.68], [0.0; 3]));
    let found = register(&others, &seen, &Point3::origin(), &unknown()).unwrap();
    assert_eq!(found.pairs.len(), known.len());
    let off = found.X_W.translation.vector + shift.translation.vector;
    assert!(off.norm() < 1e-6, "{off:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn a_scan_that_was_moved_is_moved_back(
        shift in prop::array::uniform3(-0.05..0.05_f64), turn in prop::array::uniform3(-0.03..0.03_f64),
    ) {
        let known = room();
        let off = Isometry3::new(Vector3::from(shift), Vector3::from(turn));
        let found = register(&known, &moved(&known, &off), &Point3::origin(), &unknown()).unwrap();
        let left = found.X_W * off;
        prop_assert!(left.translation.vector.norm() < 1e-6, "{}", left.translation);
        prop_assert!(left.rotation.angle() < 1e-6);
        prop_assert!(found.misfit < 1e-6 && found.offset_rms_m.1 < 1e-6);
    }

    /// Errors of a standard deviation at most leave the pose within its own covariance.
    #[test]
    fn errors_of_the_planes_stay_within_the_covariance(
        errors in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 5),
    ) {
        let known = room();
        let off = Isometry3::new(Vector3::new(0.02, -0.03, 0.01), Vector3::new(0.01, -0.02, 0.015));
        let mut seen = moved(&known, &off);
        for (s, e) in seen.iter_mut().zip(&errors) {
            let turn = Vector3::new(0.004 * e[0], 0.004 * e[1], 0.0);
            s.X_WF *= Isometry3::new(Vector3::z() * (0.003 * e[2]), turn);
        }
        let found = register(&known, &seen, &Point3::origin(), &unknown()).unwrap();
        let left = found.X_W * off;
        let about = found.about_W;
        let turn = left.rotation.scaled_axis();
        let shift = left * about - about;
        let error = nalgebra::Vector6::new(turn.x, turn.y, turn.z, shift.x, shift.y, shift.z);
        let square = error.dot(&(found.covariance.try_inverse().unwrap() * error));
        // At most one σ goes into each of 15 numbers: a projection of 15 onto 6, half of which
        // the other set's covariance takes.
        prop_assert!(square < 7.5, "{square}");
        prop_assert!(found.misfit < 1.0);
    }
}
