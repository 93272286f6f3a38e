//! Ways to break a plan, each with the check that must notice.
//!
//! They work on any plan with a start, a stance that adds a contact, surfaces and loaded contacts,
//! so that every plan that is written can be put through them.

use nalgebra::{Point2, Point3, Vector3};
use plan::{Change, Contact, Plan, Stance};
use robot_model::Robot;
use surfaces::outline::Outline;
use surfaces::{Face, Obstacle};
use verify::{Check, Options, verify};

/// One way to break a plan.
struct Mutation {
    /// What is done.
    name: &'static str,
    /// Does it.
    apply: fn(&mut Plan),
    /// The check that must fail.
    expected: Check,
    /// Checks that may fail with it, because the same flaw shows in them.
    may_also: &'static [Check],
}

impl Mutation {
    /// What is wrong with the verdict on the broken plan: that the check did not notice, or that
    /// an unrelated one failed.
    fn objection(&self, failed: &[Check]) -> Option<String> {
        let unrelated = failed
            .iter()
            .any(|check| *check != self.expected && !self.may_also.contains(check));
        let noticed = failed.contains(&self.expected);
        (!noticed || unrelated).then(|| {
            format!(
                "{}: {} expected, failed: {failed:?}",
                self.name, self.expected
            )
        })
    }
}

/// Breaks a plan in every way of the table and asserts that the check that is meant to notice fails,
/// and none that has nothing to do with it.
#[track_caller]
pub fn assert_noticed(plan: &Plan, robot: &Robot) {
    let objections = MUTATIONS.iter().filter_map(|mutation| {
        let mut broken = plan.clone();
        (mutation.apply)(&mut broken);
        let certificate = verify(&broken, robot, &Options::default());
        let objection = mutation.objection(&certificate.failed_checks())?;
        let why: Vec<String> = certificate.failures().map(|row| row.sentence()).collect();
        Some(format!("{objection}\n  {}", why.join("\n  ")))
    });
    let wrong: Vec<String> = objections.collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Rows of the table: what is done, the function that does it, the check that must fail, and in
/// brackets those that may fail with it, because the same flaw shows in them.
macro_rules! table {
    ($($name:literal: $apply:expr => $expected:ident $(($($may_also:ident)*))?;)*) => {
        &[$(Mutation {
            name: $name,
            apply: $apply,
            expected: Check::$expected,
            may_also: &[$($(Check::$may_also),*)?],
        }),*]
    };
}

const MUTATIONS: &[Mutation] = table! {
    // Contacts on their surfaces.
    "surface 5 mm below the foot": surface_sunk => Closure;
    "robot 5 mm above its surfaces": robot_lifted => Closure (Kept Goal Inclusion StatedMargin);
    "surface tilted under the foot": surface_tilted => Normal
        (Closure Inclusion Clearance ContactDepth Friction Unilateral StatedMargin);
    "foot half over the edge": surface_cut => Inclusion;
    "foot over an edge that is taken back": edge_taken_back => Inclusion;
    "contact on a surface that is not there": surface_unknown => Names (Sequence);
    // Forces.
    "missing force": force_missing => BalanceForce (BalanceMoment Torque);
    "two feet squeeze": feet_squeeze => Friction (Torque StatedMargin Unilateral);
    "a corner pulls": corner_pulls => Unilateral (Friction StatedMargin);
    "force far from the patch": force_off_patch => ForcePoint;
    "transition contact bears": transition_bears => Unloaded;
    "transition contact said to be loaded": transition_loaded => Sequence;
    "nothing to stand on": contacts_gone => Equilibrium
        (Sequence BalanceForce BalanceMoment Torque ComMargin Clearance StatedMargin);
    // Joints.
    "joint turned once round": joint_round => JointLimit (StatedMargin);
    "more joint margin promised than kept": |p| p.required.joint_rad = 0.499 => JointLimit;
    "more torque margin promised than kept": |p| p.required.torque_use = 0.02 => Torque;
    // Collisions.
    "obstacle in the torso": obstacle_in_torso => Clearance (StatedMargin);
    "obstacle in the foot, said to be the ground": obstacle_in_foot => ContactDepth
        (Clearance StatedMargin);
    "more distance between links promised than kept": |p| p.required.self_clearance_m = 0.499 => SelfClearance;
    // From stance to stance.
    "contact moved between stances": contact_moved => Kept
        (Inclusion Closure Goal Clearance ContactDepth StatedMargin);
    "two contacts changed at once": stance_skipped => Sequence;
    "stance out of place": index_wrong => Sequence;
    "no stances": |p| p.stances.clear() => Sequence (PathLength);
    "goal elsewhere": goal_moved => Goal;
    "length of the path wrong": |p| p.search.path_stances += 1 => PathLength;
    // What is stated and what is.
    "centre of mass wrong": com_wrong => Com;
    "contact pose stated wrong": pose_wrong => Pose (Kept);
    "quaternion not of unit length": quaternion_long => Quaternion;
    "joint names in another order": |p| p.robot.joint_names.swap(0, 1) => Robot;
    "another robot's mass": |p| p.robot.mass_kg += 1.0 => Robot;
    "margins stated better than they are": margins_boasted => StatedMargin;
    "q truncated": q_truncated => Numbers;
    "q not a number": q_nan => Numbers;
    "force not a number": force_nan => Numbers;
    "patch listed twice": contact_twice => Names (Sequence);
    "friction of ice cream on velcro": friction_claim => Names;
    // What is promised.
    "friction use of 5": |p| p.required.friction_use = 5.0 => Required;
    "negative clearance": |p| p.required.clearance_m = -0.1 => Required;
    "margin not a number": |p| p.required.com_m = f64::NAN => Required (ForcePoint ComMargin);
    "bodies behind surfaces without thickness": |p| p.thin_body_m = 0.0 => Required;
    "two surfaces of one name": surface_doubled => Environment;
    "another format": |p| p.format = "scandent-plan/0".to_owned() => Format;
};

/// The first stance that adds a contact.
fn adding(plan: &mut Plan) -> Option<(usize, &mut Stance)> {
    plan.stances
        .iter_mut()
        .enumerate()
        .find(|(_, s)| matches!(s.change, Change::Add { .. }))
}

fn loaded(stance: &mut Stance) -> impl Iterator<Item = &mut Contact> {
    stance.contacts.iter_mut().filter(|c| c.loaded)
}

fn surface_of_start(plan: &Plan) -> Option<(usize, Contact)> {
    let contact = plan.stances.first()?.contacts.first()?.clone();
    let index = plan.faces.iter().position(|s| s.id == contact.face)?;
    Some((index, contact))
}

/// The same surface, and where the contact is in its frame.
fn under_start(plan: &mut Plan) -> Option<(&mut Face, Point3<f64>)> {
    let (i, contact) = surface_of_start(plan)?;
    let face = &mut plan.faces[i];
    let place = Point3::from(contact.X_WC.p);
    let centre = face.X_WF.inverse_transform_point(&place);
    Some((face, centre))
}

fn surface_sunk(plan: &mut Plan) {
    let Some((i, _)) = surface_of_start(plan) else {
        return;
    };
    let normal = plan.faces[i].normal_W();
    plan.faces[i].X_WF.translation.vector -= 0.005 * normal;
}

fn surface_tilted(plan: &mut Plan) {
    let Some((i, contact)) = surface_of_start(plan) else {
        return;
    };
    let turn = nalgebra::UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 0.02);
    // About the contact, so that its centre stays in the plane.
    let about = Vector3::from(contact.X_WC.p);
    let pose = &mut plan.faces[i].X_WF;
    pose.translation.vector = about + turn * (pose.translation.vector - about);
    pose.rotation = turn * pose.rotation;
}

/// Moves all that a stance states by the same.
fn translate(stance: &mut Stance, by: [f64; 3]) {
    for k in 0..3 {
        stance.q[k] += by[k];
        stance.com_W[k] += by[k];
        for contact in &mut stance.contacts {
            contact.X_WC.p[k] += by[k];
            for p in contact
                .vertices_W
                .iter_mut()
                .chain(&mut contact.force_points_W)
            {
                p[k] += by[k];
            }
        }
    }
}

fn robot_lifted(plan: &mut Plan) {
    if let Some((_, stance)) = adding(plan) {
        translate(stance, [0.0, 0.0, 0.005]);
    }
}

fn contact_moved(plan: &mut Plan) {
    if let Some((_, stance)) = adding(plan) {
        translate(stance, [0.0, 0.005, 0.0]);
    }
}

fn surface_cut(plan: &mut Plan) {
    let Some((face, centre)) = under_start(plan) else {
        return;
    };
    // Everything beyond the middle of the foot falls off.
    let far = if centre.x > 0.0 { 100.0 } else { -100.0 };
    let corners = [
        (centre.x, -100.0),
        (far, -100.0),
        (far, 100.0),
        (centre.x, 100.0),
    ];
    let beyond = corners.map(|(x, y)| Point2::new(x, y)).to_vec();
    let rest = Outline::from(&face.region).minus_all([beyond]).regions();
    let largest = rest
        .into_iter()
        .max_by(|a, b| a.area().total_cmp(&b.area()));
    if let Some(region) = largest {
        face.region = region;
    }
}

/// Takes the nearest edge of the face back until the foot is over it.
fn edge_taken_back(plan: &mut Plan) {
    let Some((face, centre)) = under_start(plan) else {
        return;
    };
    let away_m: Vec<f64> = (face.region.segments())
        .map(|(_, [a, b])| {
            let part = (b - a).dot(&(centre.xy() - a)) / (b - a).norm_squared();
            (a + (b - a) * part.clamp(0.0, 1.0) - centre.xy()).norm()
        })
        .collect();
    let least = away_m.iter().copied().fold(f64::INFINITY, f64::min);
    for (edge, away) in face.region.edges_mut().flatten().zip(away_m) {
        if away == least {
            (edge.view, edge.further_m) = (None, away);
        }
    }
}

fn surface_unknown(plan: &mut Plan) {
    if let Some(contact) = plan
        .stances
        .first_mut()
        .and_then(|s| s.contacts.first_mut())
    {
        contact.face = "nowhere".into();
    }
}

/// The largest force of the first stance.
fn largest(plan: &mut Plan) -> Option<&mut [f64; 3]> {
    let forces = plan
        .stances
        .first_mut()?
        .contacts
        .iter_mut()
        .flat_map(|c| &mut c.forces_W);
    forces.max_by(|a, b| a[2].total_cmp(&b[2]))
}

fn force_missing(plan: &mut Plan) {
    if let Some(force) = largest(plan) {
        *force = [0.0; 3];
    }
}

fn force_nan(plan: &mut Plan) {
    if let Some(force) = largest(plan) {
        force[1] = f64::NAN;
    }
}

fn feet_squeeze(plan: &mut Plan) {
    let Some(stance) = plan.stances.first_mut() else {
        return;
    };
    let mut contacts = loaded(stance);
    let (Some(a), Some(b)) = (contacts.next(), contacts.next()) else {
        return;
    };
    let (Some(p), Some(q)) = (a.force_points_W.first(), b.force_points_W.first()) else {
        return;
    };
    // Equal and opposite along the line between the points: neither force nor moment.
    let along = (Vector3::from(*q) - Vector3::from(*p)).normalize();
    let (Some(f), Some(g)) = (a.forces_W.first_mut(), b.forces_W.first_mut()) else {
        return;
    };
    for k in 0..3 {
        f[k] += 300.0 * along[k];
        g[k] -= 300.0 * along[k];
    }
}

fn corner_pulls(plan: &mut Plan) {
    let Some(stance) = plan.stances.first_mut() else {
        return;
    };
    let Some(contact) = loaded(stance).find(|c| c.forces_W.len() == 4) else {
        return;
    };
    let pull = 50.0
        + contact
            .forces_W
            .iter()
            .map(|f| f[2].abs())
            .fold(0.0, f64::max);
    // At the corners of a parallelogram in turn: neither force nor moment.
    for (force, sign) in contact.forces_W.iter_mut().zip([1.0, -1.0, 1.0, -1.0]) {
        force[2] += sign * pull;
    }
}

fn force_off_patch(plan: &mut Plan) {
    let Some(stance) = plan.stances.first_mut() else {
        return;
    };
    if let Some(contact) = loaded(stance).next()
        && let Some(&[x, y, z]) = contact.force_points_W.first()
    {
        contact.force_points_W.push([x + 1.0, y, z]);
        contact.forces_W.push([0.0; 3]);
    }
}

fn transition_bears(plan: &mut Plan) {
    let Some((_, stance)) = adding(plan) else {
        return;
    };
    if let Some(contact) = stance.contacts.iter_mut().find(|c| !c.loaded) {
        contact.force_points_W = vec![contact.X_WC.p];
        contact.forces_W = vec![[0.0, 0.0, 20.0]];
    }
}

fn transition_loaded(plan: &mut Plan) {
    let Some((_, stance)) = adding(plan) else {
        return;
    };
    if let Some(contact) = stance.contacts.iter_mut().find(|c| !c.loaded) {
        contact.loaded = true;
    }
}

fn contacts_gone(plan: &mut Plan) {
    if let Some((_, stance)) = adding(plan) {
        stance.contacts.clear();
    }
}

fn joint_round(plan: &mut Plan) {
    // A whole turn leaves every link where it is.
    if let Some(angle) = plan.stances.first_mut().and_then(|s| s.q.last_mut()) {
        *angle += std::f64::consts::TAU;
    }
}

fn obstacle(plan: &mut Plan, centre: [f64; 3], half: f64, surface: Option<String>) {
    let points_W = (0..8)
        .map(|k| {
            let sign = |bit: usize| if k & bit == 0 { -half } else { half };
            Point3::from(centre) + Vector3::new(sign(1), sign(2), sign(4))
        })
        .collect();
    plan.obstacles.push(Obstacle {
        id: "planted".to_owned(),
        points_W,
        surface,
        assumed: false,
    });
}

fn obstacle_in_torso(plan: &mut Plan) {
    let Some([x, y, z, ..]) = plan.stances.first().map(|s| s.q.as_slice()) else {
        return;
    };
    let centre = [*x, *y, *z + 0.1];
    obstacle(plan, centre, 0.03, None);
}

fn obstacle_in_foot(plan: &mut Plan) {
    let Some((_, contact)) = surface_of_start(plan) else {
        return;
    };
    obstacle(plan, contact.X_WC.p, 0.03, Some(contact.face.to_string()));
}

fn stance_skipped(plan: &mut Plan) {
    if let Some((index, _)) = adding(plan) {
        plan.stances.remove(index);
        plan.search.path_stances -= 1;
        for (k, stance) in plan.stances.iter_mut().enumerate() {
            stance.index = k;
        }
    }
}

fn index_wrong(plan: &mut Plan) {
    if let Some((_, stance)) = adding(plan) {
        stance.index += 1;
    }
}

fn goal_moved(plan: &mut Plan) {
    let [x, ..] = plan.goal.base_position_m.unwrap_or_default();
    plan.goal.base_position_m = Some([Some(x.unwrap_or(0.0) + 10.0), None, None]);
}

fn com_wrong(plan: &mut Plan) {
    if let Some(stance) = plan.stances.first_mut() {
        stance.com_W[0] += 0.01;
    }
}

fn pose_wrong(plan: &mut Plan) {
    if let Some(contact) = plan.stances.last_mut().and_then(|s| s.contacts.first_mut()) {
        contact.X_WC.p[1] += 0.003;
    }
}

fn quaternion_long(plan: &mut Plan) {
    if let Some(stance) = plan.stances.first_mut() {
        stance.q[3..7].iter_mut().for_each(|x| *x *= 1.01);
    }
}

fn margins_boasted(plan: &mut Plan) {
    if let Some(stance) = plan.stances.first_mut() {
        stance.margins.torque_use = 0.0;
    }
}

fn q_truncated(plan: &mut Plan) {
    if let Some(stance) = plan.stances.first_mut() {
        stance.q.pop();
    }
}

fn q_nan(plan: &mut Plan) {
    if let Some(last) = plan.stances.first_mut().and_then(|s| s.q.last_mut()) {
        *last = f64::NAN;
    }
}

fn contact_twice(plan: &mut Plan) {
    if let Some(stance) = plan.stances.first_mut() {
        let again = stance.contacts.first().cloned();
        stance.contacts.extend(again);
    }
}

fn friction_claim(plan: &mut Plan) {
    plan.stances
        .iter_mut()
        .flat_map(|s| &mut s.contacts)
        .for_each(|c| c.friction = 3.0);
}

fn surface_doubled(plan: &mut Plan) {
    let again = plan.faces.first().cloned();
    plan.faces.extend(again);
}
