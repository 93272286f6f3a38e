//! The promises that the scenes' geometry makes to a planner.

use scenes::worlds::{irregular_stairs, slope_and_hand};
use scenes::{OrientedBox, SceneFile, Truth};

/// Edges of hrp2's sole, m.
const SOLE_M: [f64; 2] = [0.23, 0.131];

fn truth(name: &str) -> Truth {
    (scenes::builtin(name).unwrap().truth)()
}

/// Ranges of a box's top in x, y, z.
fn top_ranges(body: &OrientedBox) -> [[f64; 2]; 3] {
    let corners = body.top().vertices_W;
    [0, 1, 2].map(|i| {
        let values = corners.iter().map(|p| p[i]);
        [
            values.clone().fold(f64::INFINITY, f64::min),
            values.fold(f64::NEG_INFINITY, f64::max),
        ]
    })
}

#[test]
fn every_step_leaves_a_sole_40_mm_to_each_edge() {
    for step in irregular_stairs::STEPS {
        for (edge, sole) in step.size_m.iter().zip(SOLE_M) {
            assert!((edge - sole) / 2.0 >= 0.04, "{}: {edge} m", step.name);
        }
    }
}

#[test]
fn the_stairs_rise_evenly_to_the_table() {
    let tops: Vec<f64> = irregular_stairs::STEPS.iter().map(|s| s.top_m).collect();
    assert_eq!(irregular_stairs::TABLE.block.top_m, 0.71);
    for pair in tops.windows(2).chain([&[tops[3], 0.71][..]]) {
        assert!((0.12..=0.16).contains(&(pair[1] - pair[0])), "{pair:?}");
    }
    // Six faces look up that a sole fits on: the floor, four steps, the table.
    let truth = truth("irregular-stairs");
    let treads = truth.boxes.iter().filter(|b| {
        let size = b.size_m;
        b.top().normal_W.z > 0.99 && size[0].min(size[1]) > SOLE_M[1]
    });
    assert_eq!(treads.count(), 6);
}

#[test]
fn the_board_is_too_steep_for_the_soles_and_not_for_their_whole_friction() {
    let friction = SceneFile::parse(scenes::builtin("slope-and-hand").unwrap().toml)
        .unwrap()
        .friction;
    let sole = friction.default.unwrap();
    let board = truth("slope-and-hand").body("board").unwrap().top();
    let slope = board.normal_W.z.acos();
    assert!((slope.to_degrees() - slope_and_hand::BOARD.slope_deg).abs() < 1e-9);
    // 0.8 of the friction falls short by a degree (a scan measures the slope to half of that).
    assert!((slope - (0.8 * sole).atan()).to_degrees() > 1.0);
    assert!(slope < sole.atan());
    assert!(friction.patch["left_hand"] > sole);
}

#[test]
fn no_foot_reaches_the_step_but_over_the_board() {
    let truth = truth("slope-and-hand");
    let [step_x, step_y, _] = top_ranges(truth.body("step").unwrap());
    let [board_x, board_y, board_z] = top_ranges(truth.body("board").unwrap());
    // Nearest centre of a sole on the step, from the sole at the start (its centre 25 mm ahead of
    // the base); 0.85 m is more than the longest stride that the legs can make on level ground.
    assert!(step_x[0] + SOLE_M[1] / 2.0 - 0.025 > 1.0);
    assert!(step_x[0] - board_x[0] + SOLE_M[1] > 0.85);
    // The board fills the way between the cabinet and where the sensor sees no floor any more.
    let [_, cabinet_y, _] = top_ranges(truth.body("cabinet").unwrap());
    assert!(cabinet_y[0] - board_y[1] < SOLE_M[1]);
    assert!(board_y[0] < -0.3 && step_y[0] < -0.3);
    // Its lowest corner lies on the floor.
    assert!(board_z[0].abs() < 1e-2);
}

#[test]
fn what_stands_on_the_board_plane_has_the_height_it_says() {
    let board = slope_and_hand::BOARD;
    let top = truth("slope-and-hand").body("board").unwrap().top();
    for p in &top.vertices_W {
        assert!((board.height_m(p.x, p.y) - p.z).abs() < 1e-9);
    }
}

#[test]
fn bodies_have_unique_names_and_the_truth_survives_json() {
    for name in scenes::names() {
        let truth = truth(name);
        let mut names: Vec<&str> = truth.boxes.iter().map(|b| b.name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), truth.boxes.len());
        let text = serde_json::to_string(&truth).unwrap();
        assert_eq!(serde_json::from_str::<Truth>(&text).unwrap(), truth);
    }
}
