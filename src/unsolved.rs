//! How a search ended without a verified plan, in words: for the terminal, the files and the page.

use std::collections::BTreeSet;

use plan::{Change, Plan, Unsolved};
use planner::{Blocked, Status};
use posture::Group;
use surfaces::FaceId;
use verify::Certificate;

use crate::config::Config;

/// How many reasons are given: those of which the search says what would help.
const REASONS: usize = planner::TOLD;
/// How much more of a budget is worth trying.
const MORE: usize = 10;

/// What is tried of the torque limits beyond what one posture takes.
const TORQUE_MORE: f64 = 0.05;
/// The least clearance that is proposed, m.
const CLEARANCE_MIN_M: f64 = 0.001;

/// How it ended, what blocks the way and what to try; nothing where there is a verified plan.
pub fn unsolved(
    status: Status,
    blocked: &[Blocked],
    plan: &Plan,
    certificate: &Certificate,
    config: &Config,
) -> Option<Unsolved> {
    // The search names a gap of the way without contacts.
    let gap = blocked.iter().any(|one| one.held.is_empty());
    let (status, sentence) = match status {
        Status::Found if certificate.pass => return None,
        Status::Found => ("refused", "a plan was found, and the verifier refuses it"),
        Status::NoPlan => (
            "no_plan",
            "there is no plan on these faces: every refusal is a proof",
        ),
        Status::Exhausted => (
            "exhausted",
            "no plan was found where everything was tried, and none is excluded",
        ),
        Status::BudgetSpent if gap => (
            "budget_spent",
            "no way is known to the goal, and a short search found none",
        ),
        Status::BudgetSpent => ("budget_spent", "the budget is spent"),
        Status::Interrupted => ("interrupted", "interrupted"),
    };
    let failures = certificate.failures().take(REASONS);
    let reasons = match status {
        "refused" => failures.map(|row| row.sentence()).collect(),
        _ => reasons(blocked, plan.search.nodes_generated),
    };
    let planner = &config.planner;
    let budget = format!(
        "--set planner.nodes_max={} --set planner.candidates_max={}",
        MORE * planner.nodes_max,
        MORE * planner.candidates_max
    );
    let restarts = config.posture.restarts.max(1) * 4;
    let mut to_try = match status {
        "refused" => vec!["report this scene: what is found should pass".to_owned()],
        "no_plan" => vec![
            "another start or goal, or a world without what the reasons name".to_owned(),
            "a robot that may do more: friction, contact patches, roles of faces".to_owned(),
        ],
        "exhausted" => vec![
            format!("--set posture.restarts={restarts}: more attempts at each posture"),
            "--guide X,Y,Z: places that the base should pass".to_owned(),
            match plan.goal.joints {
                None => "--goal-tolerance-m: a goal that need not be met as exactly".to_owned(),
                Some(_) => "joint_tolerance_rad of the scene's [goal]: joints that need not be met as exactly".to_owned(),
            },
        ],
        "budget_spent" if gap => vec![
            "another goal, or --goal-tolerance-m: a goal that need not be met as exactly"
                .to_owned(),
            "--guide X,Y,Z: places that the base should pass".to_owned(),
        ],
        _ => vec![
            format!("{budget}: {MORE} times the budget"),
            "--guide X,Y,Z: places that the base should pass".to_owned(),
        ],
    };
    let is_open = matches!(status, "exhausted" | "budget_spent");
    if is_open {
        to_try.splice(0..0, eased(blocked, &config.posture));
    }
    if is_open && plan.obstacles.iter().any(|obstacle| obstacle.assumed) {
        to_try.push(
            "another view, or --set perception.unseen_reach_m=0: nothing stands beyond the view's border"
                .to_owned(),
        );
    }
    Some(Unsolved {
        blocked: blocked_faces(status, blocked),
        status: status.to_owned(),
        sentence: sentence.to_owned(),
        reasons,
        to_try,
    })
}

/// Limits that let through what blocks the way, as settings.
fn eased(blocked: &[Blocked], config: &posture::Config) -> Vec<String> {
    let amounts = |group: Group| {
        let remedies = blocked.iter().filter_map(|one| one.remedy.as_ref());
        let of_group = remedies.filter(move |remedy| remedy.group == group);
        of_group.map(|remedy| remedy.amount)
    };
    let torques = || amounts(Group::Torques);
    let mut eased = Vec::new();
    if let Some(needed) = torques().filter(|part| *part <= 1.0).reduce(f64::max) {
        let part = (needed + TORQUE_MORE).min(1.0);
        eased.push(format!(
            "--set posture.torque_use={part:.2} --set motion.torque_use=1: more of what the joints can do"
        ));
    } else if let Some(needed) = torques().reduce(f64::min) {
        let percent = 100.0 * needed;
        eased.push(format!(
            "a robot with stronger joints: {percent:.0} % of their torques are needed"
        ));
    }
    let less =
        amounts(Group::Clearance).filter(|less| *less < config.clearance_m - CLEARANCE_MIN_M);
    if let Some(less) = less.reduce(f64::max) {
        let kept = (1e3 * (config.clearance_m - less)).floor() / 1e3;
        eased.push(format!(
            "--set posture.clearance_m={kept:.3}: less room to what is around"
        ));
    }
    eased
}

/// The faces where contacts could not be made, nearest to the goal first.
fn blocked_faces(status: &str, blocked: &[Blocked]) -> Vec<FaceId> {
    let mut faces = Vec::new();
    for one in blocked.iter().filter(|_| status != "refused") {
        if let Change::Add { face, .. } = &one.change
            && !faces.contains(face)
        {
            faces.push(face.clone());
        }
    }
    faces.truncate(REASONS);
    faces
}

/// The constraints that block contacts, nearest to the goal first, one for each change.
fn reasons(blocked: &[Blocked], nodes: usize) -> Vec<String> {
    if blocked.is_empty() {
        return vec![match nodes {
            0..=1 => "nothing was tried: no surface is within reach of a free patch".to_owned(),
            _ => format!(
                "no change failed: {nodes} contact sets have a posture, none is at the goal"
            ),
        }];
    }
    let mut said = BTreeSet::new();
    let once = blocked
        .iter()
        .filter(|one| said.insert(one.change.to_string()));
    let in_words = |one: &Blocked| {
        let (what, why, distance) = (&one.change, &one.reason, one.distance_m);
        match one.held.as_str() {
            "" => format!("{what}: {why}"),
            held => format!("{what}: {why} (holding {held}; {distance:.2} m to go)"),
        }
    };
    once.map(in_words).take(REASONS).collect()
}
