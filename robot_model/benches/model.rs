//! How long kinematics and distances take on the test tree, and on JVRC-1 where it is there.
#![allow(missing_docs)]

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{DMatrix, DVector, Point3, Vector3};
use robot_model::collision::World;
use robot_model::{Kinematics, Robot, RobotFiles, load};

fn robots() -> Vec<Robot> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let shared = std::env::var("SCANDENT_SHARED").map_or(root.join("../../shared"), Into::into);
    let urdfs = [
        root.join("tests/golden/test_tree.urdf"),
        shared.join("robots/jvrc1/jvrc1.urdf"),
    ];
    urdfs
        .iter()
        .filter_map(|urdf| load(&RobotFiles::new(urdf)).ok())
        .collect()
}

/// A floor and nine steps, each a box extruded half a metre down.
fn stairs() -> World {
    let steps: Vec<Vec<Point3<f64>>> = (0..10)
        .map(|i| {
            let (x, z) = (0.3 * f64::from(i), 0.15 * f64::from(i) - 1.0);
            let corner = |k: u8| {
                let pick = |bit: u8, low: f64, high: f64| if k & bit == 0 { low } else { high };
                Point3::new(pick(1, x, x + 0.3), pick(2, -1.0, 1.0), pick(4, z - 0.5, z))
            };
            (0..8).map(corner).collect()
        })
        .collect();
    World::new(&steps).unwrap_or_default()
}

fn model(criterion: &mut Criterion) {
    for robot in robots() {
        let mut group = criterion.benchmark_group(&robot.name);
        let configuration = robot.resting();
        let mut kinematics = Kinematics::new(&robot, &configuration);
        group.bench_function("update", |b| {
            b.iter(|| kinematics.update(&robot, black_box(&configuration)))
        });
        let mut J = DMatrix::zeros(3, robot.nv());
        let p_W = Vector3::new(0.1, 0.2, 0.3);
        let last = robot.bodies.len() - 1;
        group.bench_function("point_jacobian", |b| {
            b.iter(|| kinematics.point_jacobian(&robot, last, black_box(&p_W), &mut J))
        });
        group.bench_function("com_jacobian", |b| {
            b.iter(|| black_box(&kinematics).com_jacobian(&robot, &mut J))
        });
        let mut g = DVector::zeros(robot.nv());
        group.bench_function("gravity_torques", |b| {
            b.iter(|| black_box(&kinematics).gravity_torques(&robot, &mut g))
        });
        let mut near = Vec::new();
        for prediction_m in [0.0, 0.05, 0.2] {
            group.bench_function(format!("self_proximities within {prediction_m} m"), |b| {
                b.iter(|| {
                    near.clear();
                    let model = &robot.collision;
                    model.self_proximities(black_box(&kinematics), prediction_m, &mut near);
                })
            });
        }
        let world = stairs();
        group.bench_function("world_proximities within 0.05 m", |b| {
            b.iter(|| {
                near.clear();
                let (model, skip) = (&robot.collision, |_, _| false);
                model.world_proximities(&kinematics, &world, 0.05, &skip, &mut near);
            })
        });
        group.finish();
    }
}

criterion_group!(benches, model);
criterion_main!(benches);
