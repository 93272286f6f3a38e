//! The robot of the tests, standing.

use nalgebra::{DMatrix, DVector, Isometry3, Matrix3};
use robot_model::{Configuration, GRAVITY_M_S2, Kinematics, Robot};

use simulation::reference::{ReferenceContact, ReferenceState};

/// The robot hrp2 that ships.
pub fn hrp2() -> Robot {
    let builtin = scenes::builtin_robot("hrp2").expect("it ships");
    let loaded = builtin.load(&robot_model::Config::default());
    loaded.expect("it loads")
}

/// Half sitting with the soles in the plane z = 0.
pub fn half_sitting(robot: &Robot) -> Configuration {
    let mut configuration = robot.posture("half_sitting").expect("it has one");
    let kinematics = Kinematics::new(robot, &configuration);
    let sole = robot.patch("left_foot").expect("it has one");
    configuration.p_WB.z -= kinematics.X_WC(sole).translation.vector.z;
    configuration
}

/// A configuration held by patches, with the forces of least norm that balance it.
pub fn standing(robot: &Robot, configuration: Configuration, patches: &[&str]) -> ReferenceState {
    let contacts = balanced(robot, &configuration, patches);
    ReferenceState::standing(configuration, contacts)
}

/// The contacts of [`standing`].
pub fn balanced(
    robot: &Robot,
    configuration: &Configuration,
    patches: &[&str],
) -> Vec<ReferenceContact> {
    let kinematics = Kinematics::new(robot, configuration);
    let pose = |name: &&str| {
        let index = robot.patch_index(name).expect("a patch");
        (index, kinematics.X_WC(&robot.patches[index]))
    };
    let poses: Vec<(usize, Isometry3<f64>)> = patches.iter().map(pose).collect();
    let mut grasp = DMatrix::zeros(6, 6 * poses.len());
    for (k, (_, X_WC)) in poses.iter().enumerate() {
        let r = X_WC.translation.vector - kinematics.com_W;
        let mut block = grasp.view_mut((0, 6 * k), (6, 6));
        // Moments count ten times: soles are small.
        let moment = Matrix3::identity() * 0.1;
        block.view_mut((0, 0), (3, 3)).fill_with_identity();
        block.view_mut((3, 0), (3, 3)).copy_from(&r.cross_matrix());
        block.view_mut((3, 3), (3, 3)).copy_from(&moment);
    }
    let weight = robot.mass_kg * GRAVITY_M_S2;
    let wrench = DVector::from_vec(vec![0.0, 0.0, weight, 0.0, 0.0, 0.0]);
    let x = grasp.pseudo_inverse(1e-9).expect("a pseudo-inverse") * wrench;
    let contact = |(k, (patch, X_WC))| ReferenceContact {
        patch,
        X_WC,
        friction: robot.patches[patch].friction,
        force_W: x.fixed_rows::<3>(6 * k).into(),
        moment_W: x.fixed_rows::<3>(6 * k + 3) * 0.1,
    };
    poses.into_iter().enumerate().map(contact).collect()
}
