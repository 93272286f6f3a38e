//! A floor with things on it, turns, and ways that are not straight.

use std::sync::atomic::AtomicBool;

use nalgebra::{UnitQuaternion, Vector3};
use planner::{Config, Request, SearchResult, Status};
use posture::Environment;
use surfaces::{Face, Obstacle, Terrain};

use crate::support::{self, face, humanoid, request, robot, search};

/// A rectangle in the level plane of that height.
fn level(id: &str, [x, y, z]: [f64; 3], half: [f64; 2]) -> Face {
    face(id, Vector3::new(x, y, z), Vector3::x(), Vector3::y(), half)
}

fn world(faces: Vec<Face>, obstacles: Vec<Obstacle>) -> Environment {
    support::world(Terrain::new(faces, obstacles).unwrap())
}

fn floor() -> Face {
    level("floor", [0.0; 3], [4.0, 4.0])
}

fn plan(request: &Request) -> SearchResult {
    search(request).unwrap()
}

/// Found, upright all the way, every foot clear of the bodies, with few nodes for each stance.
fn check(found: &SearchResult, nodes_a_stance: f64) {
    assert_eq!(found.status, Status::Found, "{:?}", found.blocked.first());
    for stance in &found.path {
        let up = stance.posture.q.R_WB * Vector3::z();
        let tilt_rad = up.z.clamp(-1.0, 1.0).acos();
        assert!(
            tilt_rad < Config::default().tilt_max_rad + 0.02,
            "{tilt_rad}"
        );
        let clearance_m = stance.posture.margins.clearance_m;
        assert!(clearance_m.is_none_or(|m| m > 0.019), "{clearance_m:?}");
    }
    assert!(found.motion.is_some());
    let nodes = found.summary.nodes_generated as f64 / found.path.len() as f64;
    assert!(nodes < nodes_a_stance, "{nodes} nodes a stance");
}

#[test]
fn what_lies_on_a_floor_is_stepped_over() {
    let robot = humanoid();
    for things in [
        vec![Obstacle::cuboid(
            "rib",
            [0.67, -1.0, 0.0],
            [0.73, 1.0, 0.03],
        )],
        vec![Obstacle::cuboid(
            "box",
            [0.55, 0.01, 0.0],
            [0.65, 0.15, 0.10],
        )],
    ] {
        let environment = world(vec![floor()], things);
        let found = plan(&request(&robot, &environment, Vector3::new(1.5, 0.0, 0.0)));
        check(&found, 3.0);
    }
}

#[test]
fn a_heading_is_reached_by_stepping() {
    let robot = humanoid();
    let environment = world(vec![floor()], Vec::new());
    for (yaw, steps) in [(1.57, 3), (3.1, 6)] {
        let mut request = request(&robot, &environment, Vector3::zeros());
        request.goal.base.yaw_rad = Some(yaw);
        let found = plan(&request);
        check(&found, 3.0);
        let last = &found.path[found.path.len() - 1];
        // The feet have turned with the base, to half of what a stride turns them by.
        for contact in &last.contacts {
            let x = contact.X_WC.rotation * Vector3::x();
            let off = x.y.atan2(x.x) - yaw;
            assert!(off.sin().atan2(off.cos()).abs() < 0.6, "{off}");
        }
        assert!(found.path.len() > 2 * steps, "{} stances", found.path.len());
    }
}

/// A leg on a ball turns about it: its neighbours' swings go by where it is, not where its contact's
/// axes would have it.
#[test]
fn six_legs_turn_on_the_spot() {
    let robot = robot("hexapod");
    let environment = world(vec![floor()], Vec::new());
    let mut request = request(&robot, &environment, Vector3::zeros());
    request.goal.base.yaw_rad = Some(1.57);
    check(&plan(&request), 3.0);
}

#[test]
fn a_start_that_faces_away_turns_and_walks() {
    let robot = humanoid();
    let environment = world(vec![floor()], Vec::new());
    let mut request = request(&robot, &environment, Vector3::new(3.0, 0.0, 0.0));
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 2.8);
    let base = &mut request.start.configuration;
    base.p_WB = turn * base.p_WB;
    base.R_WB = turn;
    let found = plan(&request);
    check(&found, 3.0);
    let ahead = found.path[found.path.len() - 1].posture.q.R_WB * Vector3::x();
    assert!(ahead.x > 0.8, "{ahead}");
}

#[test]
fn the_way_goes_round_a_wall_and_over_a_bridge() {
    let robot = humanoid();
    // Open beyond y = −0.9 only.
    let wall = Obstacle::cuboid("wall", [1.1, -0.9, 0.0], [1.25, 3.9, 1.0]);
    let environment = world(vec![floor()], vec![wall]);
    let found = plan(&request(&robot, &environment, Vector3::new(2.4, 0.4, 0.0)));
    check(&found, 1.5);

    let banks = [
        level("floor", [-0.5, 0.0, 0.0], [1.0, 2.0]),
        level("other", [2.6, 0.0, 0.0], [1.0, 2.0]),
        level("bridge", [1.05, 1.2, 0.0], [0.6, 0.25]),
    ];
    let environment = world(banks.to_vec(), Vec::new());
    let found = plan(&request(&robot, &environment, Vector3::new(2.4, -0.3, 0.0)));
    // Feet of 0.13 m on 0.25 m: many a step fails there.
    check(&found, 4.0);
    let bridge = environment.face("bridge").unwrap();
    let mut contacts = found.path.iter().flat_map(|stance| &stance.contacts);
    assert!(contacts.any(|c| c.face == Some(bridge)));
}

/// A floor of a scan in millimetres that was read as metres: what is looked at is what is near the way.
#[test]
fn a_floor_as_wide_as_a_city_takes_no_more_than_a_room() {
    let robot = humanoid();
    let wide = level("floor", [0.0; 3], [9e3, 9e3]);
    let rib = Obstacle::cuboid("rib", [0.67, -9e3, 0.0], [0.73, 9e3, 0.03]);
    let environment = world(vec![wide], vec![rib]);
    let way = request(&robot, &environment, Vector3::new(1.5, 0.0, 0.0));
    check(&plan(&way), 3.0);
}

#[test]
fn what_lengths_exclude_is_refused_with_the_place() {
    let robot = humanoid();
    let floor = level("floor", [0.0; 3], [1.0, 1.0]);
    let island = level("island", [5.0, 0.0, 0.0], [1.0, 1.0]);
    let environment = world(vec![floor, island], Vec::new());
    for (x, word) in [
        (5.0, "island is 3.00 m from floor"),
        (3.0, "no face is within"),
    ] {
        let refused = plan(&request(&robot, &environment, Vector3::new(x, 0.0, 0.0)));
        assert_eq!(refused.status, Status::NoPlan, "{:?}", refused.blocked);
        assert!(
            refused.blocked[0].reason.contains(word),
            "{:?}",
            refused.blocked
        );
        assert_eq!(refused.summary.candidates_solved, 0);
    }
    // The weight is over a sole while the other foot lands: 1.3 m apart is too far, two legs span it.
    let banks = |gap_m: f64| {
        let near = level("near", [1.5 + gap_m, 0.0, 0.0], [0.5, 1.0]);
        world(vec![level("floor", [0.0; 3], [1.0, 1.0]), near], Vec::new())
    };
    let goal = |gap_m: f64| Vector3::new(1.7 + gap_m, 0.0, 0.0);
    let environment = banks(1.2);
    let refused = plan(&request(&robot, &environment, goal(1.2)));
    assert_eq!(refused.status, Status::NoPlan, "{:?}", refused.blocked);
    let reason = &refused.blocked[0].reason;
    assert!(
        reason.contains("near is 1.20 m from floor") && reason.contains("weight"),
        "{reason}"
    );

    // A gap that is too wide for steps and not for lengths is none that is proved; it is named, and
    // little is spent on it.
    let environment = banks(0.8);
    let open = plan(&request(&robot, &environment, goal(0.8)));
    assert!(matches!(
        open.status,
        Status::BudgetSpent | Status::Exhausted
    ));
    let reason = &open.blocked[0].reason;
    assert!(reason.contains("floor to near: 0.80 m apart"), "{reason}");
    assert!(open.summary.candidates_solved < 300, "{:?}", open.summary);
}

#[test]
fn a_plan_that_is_improved_is_no_longer_and_no_shorter_than_lengths_allow() {
    let robot = humanoid();
    let rib = Obstacle::cuboid("rib", [0.67, -1.0, 0.0], [0.73, 1.0, 0.03]);
    let environment = world(vec![floor()], vec![rib]);
    let request = request(&robot, &environment, Vector3::new(1.9, 0.0, 0.0));
    let plan = |improve: usize| {
        let config = Config {
            improve,
            heuristic_weight: 4.0,
            ..Config::default()
        };
        let (margins, motion) = (posture::Config::default(), motion::Config::default());
        let cancel = AtomicBool::new(false);
        planner::search(&request, &config, &margins, &motion, &|_| {}, &cancel).unwrap()
    };
    let [first, best] = [0, 60].map(plan);
    check(&first, 3.0);
    assert_eq!(best.status, Status::Found);
    assert!(best.motion.is_some());
    let changes = |found: &SearchResult| found.summary.path_stances - 1;
    assert!(
        changes(&best) <= changes(&first),
        "{:?} {:?}",
        best.summary,
        first.summary
    );
    assert!(best.summary.nodes_generated > first.summary.nodes_generated);
    // Both feet have to leave and to land once.
    assert!(
        (4..=changes(&best)).contains(&best.summary.changes_min),
        "{:?}",
        best.summary
    );
}

#[test]
fn a_face_holds_by_its_own_friction() {
    let robot = humanoid();
    let (sin, cos) = 10.0_f64.to_radians().sin_cos();
    let planned = |friction: f64| {
        let along = Vector3::new(cos, 0.0, sin);
        let middle = Vector3::new(0.3, 0.0, 0.0) + 2.0 * along;
        let ramp = Face {
            friction: Some(friction),
            ..face("ramp", middle, along, Vector3::y(), [2.0, 1.0])
        };
        let floor = level("floor", [-1.7, 0.0, 0.0], [2.0, 1.0]);
        let environment = world(vec![floor, ramp], Vec::new());
        let request = request(&robot, &environment, Vector3::new(2.0, 0.0, 0.0));
        (plan(&request), environment.face("ramp").unwrap())
    };
    let (found, ramp) = planned(0.3);
    assert_eq!(found.status, Status::Found, "{:?}", found.blocked.first());
    let own = robot.patches.iter().map(|patch| patch.friction);
    assert!(own.reduce(f64::min) > Some(0.3));
    let contacts = || found.path.iter().flat_map(|stance| &stance.contacts);
    assert!(contacts().any(|c| c.face == Some(ramp)));
    assert!(contacts().all(|c| (c.friction == 0.3) == (c.face == Some(ramp))));
    let (refused, _) = planned(0.15);
    assert_eq!(refused.status, Status::NoPlan);
    assert!(refused.blocked[0].reason.contains("ramp is too steep"));
}

#[test]
fn what_does_not_hold_is_walked_round() {
    // An icy roof on the straight way, and a floor around it.
    let robot = humanoid();
    let (sin, cos) = 10.0_f64.to_radians().sin_cos();
    let icy = |id: &str, from: f64, up: f64| Face {
        friction: Some(0.15),
        ..face(
            id,
            Vector3::new(from + up, -0.5, sin),
            Vector3::new(cos, 0.0, up * sin),
            Vector3::y(),
            [1.0, 1.5],
        )
    };
    let environment = world(
        vec![
            level("floor", [0.0, 2.0, 0.0], [1.0, 4.0]),
            level("beside", [3.0, 4.5, 0.0], [4.0, 1.5]),
            level("beyond", [6.0, 2.0, 0.0], [1.0, 4.0]),
            icy("up", 1.1, 1.0),
            icy("down", 4.9, -1.0),
        ],
        Vec::new(),
    );
    let request = request(&robot, &environment, Vector3::new(6.0, 0.0, 0.0));
    let found = plan(&request);
    assert_eq!(found.status, Status::Found, "{:?}", found.blocked.first());
}

#[test]
fn stairs_that_turn_back_are_turned_on_the_landing() {
    let robot = humanoid();
    let (rise, going) = (0.09, 0.3);
    let tread = |k: usize, y: f64| {
        let x = 1.0 + (k as f64 + 0.5) * going;
        ([x, y], [0.5 * going, 0.6])
    };
    let mut faces = vec![level("floor", [0.0, 0.0, 0.0], [1.0, 1.0])];
    for k in 0..5 {
        let ([x, y], half) = tread(k, -0.3);
        let up = [x, y, (k + 1) as f64 * rise];
        faces.push(level(&format!("up{k}"), up, half));
        let ([x, y], half) = tread(4 - k, 1.3);
        let on = [x, y, (k + 6) as f64 * rise];
        faces.push(level(&format!("on{k}"), on, half));
    }
    faces.push(level("landing", [3.3, 0.5, 5.0 * rise], [0.8, 1.4]));
    faces.push(level("top", [0.2, 1.3, 10.0 * rise], [0.8, 0.6]));
    let environment = world(faces, Vec::new());
    let request = request(&robot, &environment, Vector3::new(0.3, 1.3, 0.0));
    check(&plan(&request), 2.0);
}

/// Stones with room for a sole's width and not for its length: where the shortest way leads to no plan, others keep off
/// where the search got stuck.
#[test]
fn a_way_that_leads_nowhere_is_left_for_a_longer_one() {
    let robot = humanoid();
    let mut faces = vec![
        level("floor", [-0.5, 1.0, 0.0], [1.0, 2.4]),
        level("other", [2.9, 1.0, 0.0], [1.0, 2.4]),
        level("bridge", [1.2, 2.4, 0.0], [0.9, 0.8]),
    ];
    for (i, j) in (0..6).flat_map(|i| (0..4).map(move |j| (i, j))) {
        let at = [0.62 + 0.21 * f64::from(i), 0.21 * (f64::from(j) - 1.5), 0.0];
        faces.push(level(&format!("stone{i}-{j}"), at, [0.1, 0.1]));
    }
    let environment = world(faces, Vec::new());
    let found = plan(&request(&robot, &environment, Vector3::new(2.6, 0.0, 0.0)));
    check(&found, 4.0);
    // No posture is sought where a sole has no room: 363 were where each stone was tried.
    let problems = found.summary.candidates_solved;
    assert!(problems < 300, "{problems} posture problems");
    let bridge = environment.face("bridge").ok();
    let mut contacts = found.path.iter().flat_map(|stance| &stance.contacts);
    assert!(contacts.any(|contact| contact.face == bridge));
}

#[test]
fn a_search_goes_on_from_what_is_clear_of_added_bodies_on_any_number_of_threads() {
    let robot = humanoid();
    let open = world(vec![floor()], Vec::new());
    let thing = Obstacle::cuboid("box", [0.95, 0.01, 0.0], [1.05, 0.15, 0.10]);
    let strewn = world(vec![floor()], vec![thing]);
    let (config, margins, moves) = (
        Config::default(),
        posture::Config::default(),
        motion::Config::default(),
    );
    let to = Vector3::new(1.5, 0.0, 0.0);
    let [before, now] = [&open, &strewn].map(|environment| request(&robot, environment, to));
    let cancel = AtomicBool::new(false);
    let gone_on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let found = planner::grow(&before, &config, &margins, &moves, &|_| {}, &cancel);
            let (first, tree) = found.unwrap();
            let told = |_| {};
            let found = planner::search_on(
                tree.unwrap(),
                &now,
                &config,
                &margins,
                &moves,
                &told,
                &cancel,
            );
            (first, found.unwrap().0.timed(&now, &margins, &moves))
        })
    };
    let (first, second) = gone_on(1);
    assert_eq!(second.status, Status::Found);
    let context = motion::MotionContext {
        robot: &robot,
        environment: &strewn,
        posture: &margins,
        config: &moves,
    };
    let bodies = open.world().obstacles().len()..strewn.world().obstacles().len();
    let is_clear = |found: &SearchResult| {
        let postures = found.path.iter().map(|stance| &stance.posture.q);
        motion::keeps_off(&context, postures, &bodies)
            && found
                .segments
                .iter()
                .all(|way| way.keeps_off(&context, &bodies))
    };
    assert!(!is_clear(&first));
    assert!(is_clear(&second));
    // It begins where the first way came too near, and not at the start.
    let anew = plan(&now).summary.nodes_generated;
    let more = second.summary.nodes_generated - first.summary.nodes_generated;
    assert!(2 * more < anew, "{more} of {anew}");
    let (_, other) = gone_on(3);
    assert_eq!(second.motion, other.motion);
}

/// Treads without risers over a floor: a foot finds ground under a tread and on it, and the base has room over the one only.
#[test]
fn stairs_with_open_risers_are_climbed() {
    let robot = robot("quadruped");
    let tread = |k: usize| {
        let half_m = if k < 4 { 0.15 } else { 0.6 };
        let at = [0.5 + 0.3 * k as f64 + half_m, 0.0, 0.12 * (k + 1) as f64];
        level(&format!("tread{k}"), at, [half_m, 0.8])
    };
    let mut faces: Vec<Face> = (0..5).map(tread).collect();
    faces.push(floor());
    let environment = world(faces, Vec::new());
    let request = request(&robot, &environment, Vector3::new(2.2, 0.0, 0.6));
    check(&plan(&request), 3.0);
}
