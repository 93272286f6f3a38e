//! Which joint moves what, and that moving costs no allocation.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use nalgebra::{DMatrix, DVector, Vector3};
use robot_model::{Body, Configuration, Kinematics, Robot};

use crate::support;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

/// Counts this thread's allocations.
struct Counting;

// SAFETY: hands every call on to the system's allocator, unchanged.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn kinematics_do_not_allocate() {
    let robot = support::test_tree();
    let configuration = robot.neutral();
    let mut kinematics = Kinematics::new(&robot, &configuration);
    let mut J = DMatrix::zeros(3, robot.nv());
    let mut g = DVector::zeros(robot.nv());
    let before = ALLOCATIONS.get();
    kinematics.update(&robot, &configuration);
    kinematics.point_jacobian(&robot, 2, &Vector3::zeros(), &mut J);
    kinematics.angular_jacobian(&robot, 2, &mut J);
    kinematics.com_jacobian(&robot, &mut J);
    kinematics.gravity_torques(&robot, &mut g);
    assert_eq!(ALLOCATIONS.get(), before);
    // The counter does count.
    drop(Kinematics::new(&robot, &configuration));
    assert!(ALLOCATIONS.get() > before);
}

#[test]
fn joints_support_what_hangs_on_them() {
    let robot = support::test_tree();
    let names: Vec<&str> = robot.bodies.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(names, ["root", "thigh", "shank", "wheel", "tooth"]);
    for (joint_body, _) in robot.bodies.iter().enumerate() {
        for body in 0..robot.bodies.len() {
            let mut above = Some(body);
            while above.is_some_and(|i| i != joint_body) {
                above = above.and_then(|i| robot.bodies[i].parent);
            }
            assert_eq!(robot.supports(joint_body, body), above.is_some());
            assert_eq!(robot.subtree(joint_body).contains(&body), above.is_some());
        }
    }
}

#[test]
fn bodies_out_of_order_are_refused() {
    let robot = support::test_tree();
    let build = |edit: &dyn Fn(&mut Vec<Body>)| {
        let mut bodies = robot.bodies.clone();
        edit(&mut bodies);
        let built = Robot::new("r".into(), bodies, Vec::new(), Default::default());
        built.err().map_or(String::new(), |error| error.to_string())
    };
    assert_eq!(build(&|_| {}), "");
    assert!(build(&|bodies| bodies.clear()).contains("no floating base"));
    assert!(build(&|bodies| bodies.swap(0, 1)).contains("no floating base"));
    assert!(build(&|bodies| bodies[3].parent = None).contains("floats"));
    assert!(build(&|bodies| bodies[2].parent = Some(4)).contains("depth-first"));
    assert!(build(&|bodies| bodies[2].parent = Some(2)).contains("depth-first"));
    // The shank's subtree would be in two pieces.
    assert!(build(&|bodies| bodies[4].parent = Some(2)).contains("depth-first"));
}

#[test]
fn configurations_of_another_length_are_refused() {
    let robot = support::test_tree();
    let mut q = Configuration::zero(robot.nj()).to_q();
    assert!(robot.configuration(&q).is_ok());
    q.push(0.0);
    let complaint = robot.configuration(&q).unwrap_err().to_string();
    let wanted = "12 values, 11 wanted for \"test_tree\"";
    assert!(complaint.contains(wanted), "{complaint}");
    assert!(robot.check_joints(&[0.0; 4], 1e-9).is_ok());
    let outside = robot.check_joints(&[0.0, 0.3, 0.0, 0.0], 1e-9);
    let complaint = outside.unwrap_err().to_string();
    let wanted = "\"slide\" at 0.3 is outside";
    assert!(complaint.contains(wanted), "{complaint}");
}
