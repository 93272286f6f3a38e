//! The identification against the figures of [chai2015].

use crate::support::values;
use calibration::GroundPlane;
use calibration::camera::{Agreement, Observability, PaperParameters, PlanePair, closed_form};
use nalgebra::{Isometry3, Matrix3, Unit, Vector3};

/// A plane a x + b y + c z + d = 0 in the paper's axes of a sensor (x forward, y up, z right), in
/// the optical frame.
fn in_V([a, b, c, d]: [f64; 4]) -> GroundPlane {
    let scale = Vector3::new(a, b, c).norm();
    GroundPlane::exact(Unit::new_normalize(Vector3::new(c, -b, a)), d / scale)
}

/// [chai2015] Tables 2 and 3 with the labels put right (the rows printed as 1, 10, 15, 29, 34, 49
/// are poses 1, 15, 8, 25, 37, 45 of Table A1), the heights that Table 3 implies, and the sign of
/// c in row 10 as in Table 3: β, γ (degrees), height (m); measured; theoretical.
const EQUATIONS: [([f64; 3], [f64; 4], [f64; 4]); 6] = [
    (
        [2.0, 20.0, 0.617],
        [-0.5515, 0.7802, -0.2952, 0.9916],
        [-0.5449, 0.7827, -0.3009, 0.9894],
    ),
    (
        [-15.0, -12.0, 0.635],
        [-0.7778, 0.5839, 0.2324, 0.8372],
        [-0.7783, 0.5826, 0.2341, 0.8363],
    ),
    (
        [19.0, 6.0, 0.645],
        [-0.3068, 0.9504, -0.0504, 1.1626],
        [-0.3132, 0.9483, -0.0510, 1.1632],
    ),
    (
        [17.0, 11.0, 0.661],
        [-0.3388, 0.9312, -0.1345, 1.1656],
        [-0.3391, 0.9309, -0.1354, 1.1639],
    ),
    (
        [-17.0, -7.0, 0.651],
        [-0.8102, 0.5668, 0.1490, 0.8378],
        [-0.8081, 0.5698, 0.1493, 0.8390],
    ),
    (
        [11.0, 5.0, 0.713],
        [-0.4428, 0.8957, -0.0393, 1.1721],
        [-0.4430, 0.8957, -0.0395, 1.1733],
    ),
];

/// [chai2015] Eq. 32.
fn published() -> PaperParameters {
    PaperParameters {
        angles_rad: [-0.4398_f64, -37.4072, -3.0471].map(f64::to_radians),
        position_m: [0.527_888_5, 0.364_800_7, -0.033_400_3],
    }
}

fn ground(stance: [f64; 3]) -> GroundPlane {
    GroundPlane::ground(&scenes::stances::X_GR(stance), Matrix3::zeros())
}

#[test]
fn six_equations_give_the_mount_that_minimises_the_papers_function() {
    let pairs =
        EQUATIONS.map(|(stance, measured, _)| PlanePair::new(ground(stance), in_V(measured)));
    let got = values(&closed_form(&pairs).unwrap());
    // Computed from the same six equations by a numerical minimiser of Eq. 31, not by this code.
    let expected = [-0.527, -37.415, -3.122, 525.4, 364.8, -39.5];
    println!("α β γ (°), p (mm): {got:.3?}; expected {expected:?}");
    for (k, (got, expected)) in got.iter().zip(expected).enumerate() {
        let (off, tolerance) = ((got - expected).abs(), if k < 3 { 0.01 } else { 0.2 });
        assert!(off <= tolerance, "{k}: {got} against {expected}");
    }
}

#[test]
fn predicted_planes_are_those_of_table_3() {
    let X_RV: Isometry3<f64> = published().X_RV();
    for (stance, measured, theoretical) in EQUATIONS {
        let robot = ground(stance);
        let predicted = robot.seen_from(&X_RV);
        let printed = in_V(theoretical);
        // The poses are whole degrees and heights whole millimetres, the robot's own were not: the
        // paper's residuals of 0.2° on average bound how far they were off.
        let angle = predicted.angle_to(&printed).to_degrees();
        let distance = (predicted.distance_m - printed.distance_m).abs();
        let near = angle < 0.1 && distance < 0.002;
        assert!(near, "{stance:?}: {angle}°, {distance} m");
        let pair = PlanePair::new(robot, in_V(measured));
        let agreement = Agreement::of(&pair, &X_RV, 1.0);
        // Fig. 17's greatest angle, 0.52°, and Fig. 18's greatest distance, 3.24 mm.
        assert!(agreement.theta_rad.to_degrees() < 0.53, "{agreement:?}");
        assert!(agreement.distance_error_m < 0.0035, "{agreement:?}");
    }
}

#[test]
fn the_52_poses_observe_all_six_parameters() {
    let X_RV = published().X_RV();
    let pairs = scenes::stances::TABLE_A1.map(|stance| {
        let robot = ground(stance);
        PlanePair::new(robot, robot.seen_from(&X_RV))
    });
    let told = Observability::of(&pairs, 0.017).at(&pairs, &X_RV);
    println!("{told:?}");
    // Computed numerically from Eq. 31, not by this code; rad and m.
    let (values, expected) = (told.singular_values, [7.08, 6.86, 5.74, 2.16, 2.06, 0.87]);
    for (got, expected) in values.iter().zip(expected) {
        assert!((got - expected).abs() < 0.01, "{values:?}");
    }
    assert_eq!((told.rank, told.degeneracy), (6, None));
}
