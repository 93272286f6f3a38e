//! What a page shows: the biped's plan with names that must not break out of the page, a motion and
//! a cloud.

use plan::{
    Alternative, Barrier, Change, Choice, Input, Limits, MOTION_FORMAT, Motion, Phase, PhaseKind,
    Plan, Refusal, Sample, Trace, TracedNode,
};
use surfaces::Obstacle;

use super::biped;
pub use super::biped::robot;

/// Both feet from the ground onto the step, beside a post.
pub fn plan() -> Plan {
    let text = serde_json::to_string(&biped::plan()).expect("JSON");
    let named = text.replace("\"step\"", "\"<step & 1>\"");
    Plan {
        scene: "</script><b>one step".to_owned(),
        inputs: vec![Input {
            role: "scene".into(),
            name: "one-step.toml".into(),
            sha256: "0".repeat(64),
        }],
        obstacles: vec![Obstacle::cuboid("post", [0.4, 0.5, 0.0], [0.5, 0.6, 0.5])],
        ..serde_json::from_str(&named).expect("a plan")
    }
}

/// A tree that is the way of the plan, where every foot was refused a nearer place.
pub fn trace() -> Trace {
    let plan = plan();
    let stances = plan.stances.iter();
    let nodes = stances.map(|stance| TracedNode {
        parent: stance.index.checked_sub(1),
        base_W: [stance.q[0], stance.q[1], stance.q[2]],
        cut: false,
    });
    let choices = plan.stances.iter().skip(1).map(|stance| Choice {
        stance: stance.index,
        node: stance.index - 1,
        price: Some(4.0),
        alternatives: vec![Alternative {
            change: stance.change.clone(),
            price: 3.0,
            by: Some(Barrier::Collision),
            reason: "<the shin> is too near to the post by 3.0 mm".to_owned(),
        }],
        more: 2,
    });
    Trace {
        nodes: nodes.collect(),
        refused: vec![Refusal {
            node: 0,
            at_W: [0.2, 0.1, 0.0],
            by: Barrier::Collision,
        }],
        choices: choices.collect(),
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
            v: vec![0.0; a.len() - 1],
            a: vec![0.0; a.len() - 1],
            tau: vec![0.0; a.len() - 7],
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
        limits: Limits {
            joint_speed_use: 1.0,
            joint_acceleration_rad_s2: 50.0,
            torque_use: 1.0,
            friction_use: 1.0,
            margin_use: 0.0,
        },
        phases: phases.collect(),
        samples: samples.collect(),
    }
}

/// Points on the ground and the step, and one that no sensor saw.
pub fn cloud() -> Vec<[f32; 3]> {
    let grid = (0..60)
        .flat_map(|i| (0..80).map(move |j| (i as f32 * 0.015 - 0.25, j as f32 * 0.0125 - 0.5)));
    let height = |x: f32| if x > 0.13 { 0.08 } else { 0.0 };
    let mut points: Vec<_> = grid.map(|(x, y)| [x, y, height(x)]).collect();
    points.push([f32::NAN; 3]);
    points
}
