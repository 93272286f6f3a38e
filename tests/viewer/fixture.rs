//! A small robot of boxes that climbs a step, and the plan of it: every kind of shape, of change
//! and of load that a page shows.
#![allow(non_snake_case)]

mod walker;

use motion::{MOTION_FORMAT, Motion, Phase, PhaseKind, Sample};
use nalgebra::{Isometry3, Point2, Point3};
use planner::plan::{
    Change, GoalRecord, Input, Margins, PLAN_FORMAT, Plan, Pose, Program, RequiredMargins,
    RobotSummary, SearchSummary, Stance, StanceContact,
};
use robot_model::GRAVITY_M_S2;
use surfaces::{ConvexPolygon, Obstacle, Source, Surface};

pub use walker::robot;
use walker::{FOOT_M, HIP_M, LEG_M};

const STEP_M: f64 = 0.15;
const COM_MARGIN_M: f64 = 0.02;
const FRICTION: f64 = 0.6;

#[derive(Clone)]
struct Foot {
    patch: &'static str,
    surface: &'static str,
    x: f64,
}

/// Both feet from the ground onto the step, one contact changed in each stance.
pub fn plan() -> Plan {
    let robot = robot();
    let left = |surface, x| Foot {
        patch: "left_foot",
        surface,
        x,
    };
    let right = |surface, x| Foot {
        patch: "right_foot",
        surface,
        x,
    };
    let add = |patch: &str, surface: &str| Change::Add {
        patch: patch.into(),
        surface: surface.into(),
    };
    let remove = |patch: &str, surface: &str| Change::Remove {
        patch: patch.into(),
        surface: surface.into(),
    };
    let (ground, step) = ("ground", "<step & 1>");
    let steps = [
        (Change::Start, vec![left(ground, 0.0), right(ground, 0.0)]),
        (
            remove("right_foot", ground),
            vec![left(ground, 0.0), right(ground, 0.0)],
        ),
        (
            add("right_foot", step),
            vec![left(ground, 0.0), right(step, 0.3)],
        ),
        (
            remove("left_foot", ground),
            vec![left(ground, 0.0), right(step, 0.3)],
        ),
        (
            add("left_foot", step),
            vec![left(step, 0.3), right(step, 0.3)],
        ),
        (Change::Goal, vec![left(step, 0.3), right(step, 0.3)]),
    ];
    let stances: Vec<_> = steps
        .into_iter()
        .enumerate()
        .map(|(index, (change, feet))| stance(index, change, &feet, robot.mass_kg * GRAVITY_M_S2))
        .collect();
    Plan {
        format: PLAN_FORMAT.to_owned(),
        program: Program {
            name: "scandent".into(),
            version: "0.1.0".into(),
        },
        scene: "</script><b>one step".to_owned(),
        seed: 7,
        config: serde_json::json!({}),
        inputs: vec![Input {
            role: "scene".into(),
            name: "one-step.toml".into(),
            sha256: "0".repeat(64),
        }],
        robot: RobotSummary {
            name: robot.name.clone(),
            joint_names: robot.joint_names().map(str::to_owned).collect(),
            mass_kg: robot.mass_kg,
        },
        surfaces: vec![
            surface(ground, [0.0, 0.0, 0.0], 0.25, Source::Robot),
            surface(step, [0.4, 0.0, STEP_M], 0.22, Source::Scan),
        ],
        obstacles: vec![Obstacle {
            id: "post".into(),
            points_W: (0..8)
                .map(|k| {
                    Point3::new(
                        0.4 + 0.1 * f64::from(k & 1),
                        0.5 + 0.1 * f64::from(k >> 1 & 1),
                        0.5 * f64::from(k >> 2),
                    )
                })
                .collect(),
            surface: None,
            assumed: false,
        }],
        thin_body_m: 0.1,
        required: RequiredMargins {
            friction_use: 0.8,
            torque_use: 0.8,
            joint_rad: 0.03,
            clearance_m: 0.01,
            self_clearance_m: 0.005,
            com_m: COM_MARGIN_M,
        },
        goal: GoalRecord {
            base_position_m: Some([Some(0.3), Some(0.0), None]),
            tolerance_m: 0.1,
            yaw_rad: Some(0.0),
            contacts: Vec::new(),
        },
        motion: None,
        search: SearchSummary {
            nodes_generated: 9,
            nodes_expanded: 6,
            candidates_solved: 21,
            path_stances: stances.len(),
        },
        stances,
    }
}

/// A second from each stance to the next, straight.
pub fn motion() -> Motion {
    const DT_S: f64 = 0.05;
    let plan = plan();
    let steps = (1.0 / DT_S).round() as usize;
    let count = steps * (plan.stances.len() - 1);
    let samples = (0..=count).map(|i| {
        let from = (i / steps).min(plan.stances.len() - 2);
        let part = i as f64 / steps as f64 - from as f64;
        let (a, b) = (&plan.stances[from].q, &plan.stances[from + 1].q);
        Sample {
            t_s: i as f64 * DT_S,
            q: a.iter().zip(b).map(|(a, b)| a + part * (b - a)).collect(),
            com_W: plan.stances[from].com_W,
            forces_W: Vec::new(),
        }
    });
    let phases = plan.stances.windows(2).map(|pair| {
        let swing = match &pair[1].change {
            Change::Add { patch, .. } => Some(patch.clone()),
            _ => None,
        };
        Phase {
            kind: if swing.is_some() {
                PhaseKind::Swing
            } else {
                PhaseKind::Shift
            },
            t_start_s: pair[0].index as f64,
            t_end_s: pair[1].index as f64,
            from_stance: pair[0].index,
            to_stance: pair[1].index,
            contacts: Vec::new(),
            swing,
        }
    });
    Motion {
        format: MOTION_FORMAT.to_owned(),
        robot: plan.robot.name.clone(),
        dt_s: DT_S,
        phases: phases.collect(),
        samples: samples.collect(),
    }
}

fn surface(id: &str, [x, y, z]: [f64; 3], half_m: f64, source: Source) -> Surface {
    let corners = [
        [-half_m, -2.0 * half_m],
        [half_m, -2.0 * half_m],
        [half_m, 2.0 * half_m],
        [-half_m, 2.0 * half_m],
    ];
    let polygon = ConvexPolygon::new(corners.map(Point2::from).to_vec()).expect("convex");
    let mut surface = Surface::new(id, Isometry3::translation(x, y, z), polygon);
    surface.source = source;
    surface.inset_m = 0.01;
    surface.outline = vec![corners.to_vec()];
    surface
}

/// The base above the middle of the loaded feet, the weight shared evenly between their corners.
fn stance(index: usize, change: Change, feet: &[Foot], weight_N: f64) -> Stance {
    let moving = match &change {
        Change::Add { patch, .. } | Change::Remove { patch, .. } => Some(patch.clone()),
        _ => None,
    };
    let is_loaded = |foot: &Foot| moving.as_deref() != Some(foot.patch);
    let side = |foot: &Foot| {
        if foot.patch == "left_foot" {
            HIP_M
        } else {
            -HIP_M
        }
    };
    let height = |foot: &Foot| {
        if foot.surface == "ground" {
            0.0
        } else {
            STEP_M
        }
    };
    let loaded: Vec<_> = feet.iter().filter(|f| is_loaded(f)).collect();
    let mean =
        |of: &dyn Fn(&Foot) -> f64| loaded.iter().map(|f| of(f)).sum::<f64>() / loaded.len() as f64;
    let base = [mean(&|f| f.x), 0.0, LEG_M + 0.05 + mean(&height).min(0.1)];

    let mut q = vec![base[0], base[1], base[2], 0.0, 0.0, 0.0, 1.0];
    let contacts = feet.iter().map(|foot| {
        q.extend([foot.x - base[0], base[2] - LEG_M - height(foot)]);
        let at = |[x, y]: [f64; 2], share: f64| {
            [foot.x + share * x, side(foot) + share * y, height(foot)]
        };
        let force = if is_loaded(foot) {
            weight_N / (4.0 * loaded.len() as f64)
        } else {
            0.0
        };
        StanceContact {
            patch: foot.patch.to_owned(),
            link: foot.patch.replace("foot", "leg"),
            surface: foot.surface.to_owned(),
            X_WC: Pose {
                p: at([0.0; 2], 0.0),
                quat_xyzw: [0.0, 0.0, 0.0, 1.0],
            },
            friction: FRICTION,
            loaded: is_loaded(foot),
            vertices_W: FOOT_M.map(|v| at(v, 1.0)).to_vec(),
            force_points_W: FOOT_M.map(|v| at(v, 0.5)).to_vec(),
            forces_W: vec![[0.0, 0.0, force]; 4],
        }
    });
    let contacts = contacts.collect();
    Stance {
        index,
        change,
        contacts,
        q,
        com_W: [base[0], mean(&side), base[2]],
        margins: Margins {
            closure_m: 1e-5,
            inclusion_m: Some(0.03),
            equilibrium: 1e-9,
            friction_use: 0.1,
            torque_use: 0.4 + 0.08 * index as f64,
            joint_rad: 0.05,
            clearance_m: index.is_multiple_of(2).then_some(0.02),
            self_clearance_m: Some(0.004),
        },
    }
}

/// Points on the ground and the step, and one that no sensor saw.
pub fn cloud() -> Vec<[f32; 3]> {
    let grid = (0..60)
        .flat_map(|i| (0..80).map(move |j| (i as f32 * 0.015 - 0.25, j as f32 * 0.0125 - 0.5)));
    let mut points: Vec<_> = grid
        .map(|(x, y)| [x, y, if x > 0.18 { STEP_M as f32 } else { 0.0 }])
        .collect();
    points.push([f32::NAN; 3]);
    points
}
