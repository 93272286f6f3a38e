//! The hexapod sees low blocks through a camera of which the place was identified from the ground
//! alone, and steps onto and between them.
//!
//! Pass criteria: the mount that ships is within its own covariance of the true one; every top that
//! is seen through it lies within 10 mm and 1° of the truth, and through a mount that is 2° and
//! 20 mm off it does not, which the program says itself; the plan passes the verifier, keeps the body
//! level to 3° and ends on the goal.

use std::path::Path;

use nalgebra::{Isometry3, Matrix6, Point3, Translation3, UnitQuaternion, Vector3, Vector6};
use scandent::cli::Global;
use scandent::config::Config;
use scandent::environment::perceive;
use scandent::extrinsics::file::Extrinsics;
use scandent::extrinsics::placement::place;
use scandent::provenance::Inputs;
use scandent::report::Stages;
use scandent::scene::Scene;
use scenes::Truth;
use scenes::camera_set::published_extrinsics;
use surfaces::Face;
use tempfile::NamedTempFile;

use crate::support::program::{self, ends_with, succeeds};
use crate::support::shipped::shipped;

const SCENE: &str = "hexapod-obstacles";

fn truth() -> Truth {
    (scenes::builtin(SCENE).expect("it ships").truth)()
}

fn shipped_mount() -> Extrinsics {
    let scene = scenes::builtin(SCENE).expect("it ships");
    let bytes = scene.file("hexapod-obstacles_camera.toml");
    let bytes = bytes.expect("its mount");
    Extrinsics::parse(std::str::from_utf8(&bytes).expect("text")).expect("a mount")
}

#[test]
fn the_mount_that_ships_is_as_good_as_it_says() {
    let mount = shipped_mount();
    let (found, truth) = (mount.X_RV(), published_extrinsics());
    let turn = (found.rotation * truth.rotation.inverse()).scaled_axis();
    let shift = found.translation.vector - truth.translation.vector;
    let error = Vector6::new(turn.x, turn.y, turn.z, shift.x, shift.y, shift.z);
    let rows = mount.covariance.expect("a covariance");
    let covariance = Matrix6::from_fn(|i, j| rows[i][j]);
    let square = error.dot(&(covariance.try_inverse().expect("regular") * error));
    // χ² of six: 99 % are below 16.8.
    assert!(square < 16.8, "{square}: turn {turn} rad, shift {shift} m");
}

/// Surfaces that the scene shows through a mount.
fn surfaces(mount: Option<&Path>) -> Vec<Face> {
    let mut inputs = Inputs::default();
    let mut scene = Scene::open(SCENE, &mut inputs).expect("it ships");
    let global = Global::default();
    place(&mut scene, mount, &global, &mut inputs).expect("a mount on this robot");
    let config = Config::layered(Some((SCENE, &scene.settings)), &global).expect("settings");
    let mut stages = Stages::default();
    let (environment, files) = (&scene.environment, &scene.files);
    let perceived = perceive(environment, files, &config, &mut stages, &mut inputs);
    perceived.expect("the scan is there").terrain.faces
}

/// Greatest error of the tops and the floor in height (m) and tilt (rad), and how many of the true
/// tops were found at all: a surface whose middle is over the top and nearer than 60 mm to it.
fn errors(surfaces: &[Face]) -> (f64, f64, usize) {
    let truth = truth();
    let mut worst = (0.0_f64, 0.0_f64, 0);
    for body in &truth.boxes {
        let top = body.top();
        let to_body = body.X_WO().inverse();
        let half = Vector3::from(body.size_m) / 2.0;
        let over = |surface: &&Face| {
            let centre = Point3::from(surface.X_WF.translation.vector);
            let p = to_body * centre;
            let on_top = p.x.abs() < half.x && p.y.abs() < half.y;
            let covered = truth.boxes.iter().skip(1).any(|other| {
                let q = other.X_WO().inverse() * centre;
                body.name == "floor"
                    && q.x.abs() < other.size_m[0] / 2.0
                    && q.y.abs() < other.size_m[1] / 2.0
            });
            on_top && !covered && (p.z - half.z).abs() < 0.06 && surface.normal_W().z > 0.9
        };
        let mut found = false;
        for surface in surfaces.iter().filter(over) {
            found = true;
            for vertex in surface.vertices_W() {
                let height = top.normal_W.dot(&vertex.coords) - top.offset_m;
                worst.0 = worst.0.max(height.abs());
            }
            let cosine = surface.normal_W().dot(&top.normal_W).clamp(-1.0, 1.0);
            worst.1 = worst.1.max(cosine.acos());
        }
        worst.2 += usize::from(found);
    }
    worst
}

/// The mount that ships, pitched by 2° and 20 mm too high, in a file.
fn moved_mount() -> NamedTempFile {
    let off = Isometry3::from_parts(
        Translation3::new(0.0, 0.0, 0.02),
        UnitQuaternion::from_euler_angles(0.0, 2.0_f64.to_radians(), 0.0),
    );
    let right = shipped_mount();
    let moved = off * right.X_RV();
    written(&Extrinsics {
        position_m: moved.translation.vector.into(),
        quat_xyzw: moved.rotation.coords.into(),
        ..right
    })
}

fn written(mount: &Extrinsics) -> NamedTempFile {
    let file = NamedTempFile::new().expect("a temporary file");
    std::fs::write(&file, mount.to_toml().expect("TOML")).expect("written");
    file
}

#[test]
fn a_mount_that_is_off_puts_the_obstacles_elsewhere() {
    let bodies = truth().boxes.len();
    let (height, tilt, found) = errors(&surfaces(None));
    assert_eq!(found, bodies);
    assert!(
        height < 0.010 && tilt < 1.0_f64.to_radians(),
        "{height} m, {tilt} rad"
    );
    let (height, tilt, found) = errors(&surfaces(Some(moved_mount().path())));
    // It would tread 30 mm beside a height, or not see the obstacle where it is at all.
    let notices = height > 0.030 || found < bodies;
    assert!(notices, "{height} m, {tilt} rad, {found} found");
}

/// The greatest height between a foothold of the plan and what really is below it, m.
fn foothold_error_m(plan: &plan::Plan) -> f64 {
    let robot = program::robot("hexapod");
    let boxes = truth().boxes;
    let height = |x: f64, y: f64| {
        let over = boxes.iter().filter(|b| {
            let p = b.X_WO().inverse() * Point3::new(x, y, 0.0);
            p.x.abs() <= b.size_m[0] / 2.0 && p.y.abs() <= b.size_m[1] / 2.0
        });
        over.map(|b| b.top().vertices_W[0].z)
            .fold(f64::NEG_INFINITY, f64::max)
    };
    let mut worst = 0.0_f64;
    for stance in &plan.stances {
        let q = robot.configuration(&stance.q).expect("a configuration");
        let kinematics = robot_model::Kinematics::new(&robot, &q);
        for contact in &stance.contacts {
            let patch = robot.patch(&contact.patch).expect("a patch");
            let ball = kinematics.X_WC(patch).translation.vector;
            let radius = patch.point_radius_m().expect("a ball");
            worst = worst.max((ball.z - radius - height(ball.x, ball.y)).abs());
        }
    }
    worst
}

#[test]
fn the_plan_through_the_identified_camera_is_verified() {
    let shipped = shipped(SCENE);
    let (plan, said) = (&shipped.plan, &shipped.said);
    assert!(said.contains("verified"), "{said}");
    // It steps onto something that is higher than the floor.
    let up = plan
        .stances
        .iter()
        .flat_map(|stance| &stance.contacts)
        .filter_map(|contact| plan.faces.iter().find(|s| s.id == contact.face))
        .any(|surface| surface.X_WF.translation.z > 0.04);
    assert!(up, "{said}");
    let last = plan.stances.last().expect("a stance");
    // The goal's tolerance holds along each axis.
    let off = (last.q[0] - 1.0).abs().max(last.q[1].abs());
    assert!(off <= 0.1 + 1e-6, "{:?}", last.q);
    // The body stays level, from stance to stance as well.
    let stances = plan.stances.iter().map(|stance| &stance.q);
    let between = shipped.motion.samples.iter().map(|sample| &sample.q);
    let tilts = stances.chain(between).map(|q| {
        let up = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(q[6], q[3], q[4], q[5]));
        (up * Vector3::z()).z.min(1.0).acos().to_degrees()
    });
    let tilt = tilts.fold(0.0, f64::max);
    assert!(tilt < 3.0, "{tilt}°");
    assert!(!said.contains("warning"), "{said}");
    // Its feet come down where something is; through a mount that is off they would not.
    let right = foothold_error_m(plan);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mount = moved_mount();
    // The ground that is seen is not the one under the feet, and it says so.
    let out = folder.path();
    let said = succeeds(
        &format!("run {SCENE} -o @ --extrinsics @"),
        &[out, mount.path()],
    );
    assert!(
        said.contains("warning: the ground that") && said.contains("mount"),
        "{said}"
    );
    let astray = serde_json::from_value(program::json(out.join(SCENE).join("plan.json")));
    let wrong = foothold_error_m(&astray.expect("a plan"));
    assert!(right < 0.012 && wrong > 0.020, "{right} m, {wrong} m");
}

#[test]
fn a_mount_on_another_robot_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mount = written(&shipped_mount());
    let line = "run irregular-stairs --extrinsics @ -o @";
    ends_with(
        line,
        &[mount.path(), folder.path()],
        1,
        &["hexapod", "hrp2"],
    );
}
