use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

use crate::cli::Global;
use crate::config::Config;
use crate::pipeline::{self, PlanOutcome, RunOptions};
use crate::provenance::Inputs;
use crate::robot_files::Robots;
use crate::scene::Scene;
use crate::unseen::room::half_a_room;

/// The plan of the quadruped in a room with a wall at y = 0.3 m, which the camera sees ahead of it alone, to a place.
fn led_to([x, y]: [f64; 2]) -> PlanOutcome {
    let (image, X_WV) = half_a_room(0.3, -0.4);
    let (t, q) = (X_WV.translation, X_WV.rotation.coords);
    let text = format!(
        "name = \"room\"\n\
         [[scan]]\ndepth = \"room.png\"\nsensor = \"xtion\"\nposition_m = [{}, {}, {}]\nquat_xyzw = [{}, {}, {}, {}]\n\
         [robot]\nurdf = \"builtin:quadruped\"\n\
         [goal]\nbase_position_m = [{x}, {y}]\ntolerance_m = 0.1\n",
        t.x, t.y, t.z, q.x, q.y, q.z, q.w
    );
    let png = image.png().unwrap();
    let files = [("room.toml", text.into_bytes()), ("room.png", png)];
    let files: BTreeMap<_, _> = files.map(|(name, bytes)| (name.to_owned(), bytes)).into();
    let mut inputs = Inputs::default();
    let scene = Scene::at_hand("room.toml", files, &mut inputs).unwrap();
    let config = Config::layered(None, &Global::default()).unwrap();
    let options = RunOptions {
        threads: None,
        stage: &|_| {},
        progress: &|_| {},
        cancel: &AtomicBool::new(false),
        robots: &Robots::default(),
    };
    let planned = pipeline::plan(&scene, &config, &options, inputs).unwrap();
    assert!(planned.verified());
    planned
}

#[test]
fn a_wall_that_the_view_cuts_is_gone_around_where_there_is_room() {
    let planned = led_to([1.4, 0.0]);
    let around = planned.report.around.unwrap();
    assert_eq!((around.searches, around.kept_off.len()), (1, 1));
    assert_eq!(planned.report.unseen.unwrap().walls, vec![]);
    let certificate = &planned.certificate;
    assert_eq!(certificate.conditions, Vec::<String>::new());
    let notes = certificate.notes.join("; ");
    assert!(notes.contains("planned again, to keep off"), "{notes}");
    // The bodies that it was planned with are nothing that the plan says of its world.
    let obstacles = &planned.plan.obstacles;
    assert!(obstacles.iter().all(|body| !body.id.contains("straight")));
}

#[test]
fn a_plan_to_where_such_a_wall_would_be_stays_with_its_condition() {
    let planned = led_to([0.2, 0.2]);
    assert_eq!(planned.report.around.unwrap().kept_off, vec![]);
    assert_eq!(planned.report.unseen.unwrap().walls.len(), 1);
    let certificate = &planned.certificate;
    assert_eq!(certificate.conditions.len(), 1);
    let notes = certificate.notes.join("; ");
    assert!(notes.contains("no way was found around"), "{notes}");
}
