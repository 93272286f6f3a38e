//! Ways to break a plan, each with the check that must notice.
//!
//! They work on any plan with a start, a stance that adds a contact, surfaces and loaded contacts,
//! so that every plan that is written can be put through them.

use std::f64::consts::TAU;

use nalgebra::{Point2, Point3, UnitQuaternion, Vector3};
use plan::{Change, Contact, Plan, Stance};
use robot_model::Robot;
use serde_json::json;
use surfaces::outline::Outline;
use surfaces::{Face, Obstacle};
use verify::{Check, verify};

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
        let (name, expected) = (self.name, self.expected);
        let related = |check: &Check| *check == expected || self.may_also.contains(check);
        // What is stated of a posture is seldom true of a broken one.
        let related = |check: &Check| *check == Check::StatedMargin || related(check);
        let right = failed.contains(&expected) && failed.iter().all(related);
        (!right).then(|| format!("{name}: {expected} expected, failed: {failed:?}"))
    }
}

/// Breaks a plan in every way of the table and asserts that the check that is meant to notice fails,
/// and none that has nothing to do with it.
#[track_caller]
pub fn assert_noticed(plan: &Plan, robot: &Robot) {
    let objections = MUTATIONS.iter().filter_map(|mutation| {
        let mut broken = plan.clone();
        (mutation.apply)(&mut broken);
        let certificate = verify(&broken, None, robot);
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
    "robot 5 mm above its surfaces": |p| translate(adding(p), [0.0, 0.0, 0.005]) => Closure
        (Kept Goal Inclusion);
    "surface tilted under the foot": surface_tilted => Normal
        (Closure Inclusion Clearance ContactDepth Friction Unilateral);
    "foot half over the edge": surface_cut => Inclusion;
    "foot over an edge that is taken back": edge_taken_back => Inclusion;
    "more friction than surfaces have": |p| p.faces.iter_mut().for_each(|f| f.friction = Some(0.1)) => Names;
    "contact on a surface that is not there": |p| p.stances[0].contacts[0].face = "nowhere".into()
        => Names (Sequence);
    "surfaces that nothing may touch": |p| p.faces.iter_mut().for_each(|f| f.roles = Some(Vec::new()))
        => Role;
    "surfaces that are too low for feet and hands": |p| p.config = json!({"surfaces": {"roles": {
        "foot": {"height_min_m": 50.0}, "hand": {"height_min_m": 50.0}}}}) => Role;
    // Forces.
    "missing force": |p| *largest(p) = [0.0; 3] => BalanceForce (BalanceMoment Torque);
    "two feet squeeze": feet_squeeze => Friction (Torque Unilateral);
    "a corner pulls": corner_pulls => Unilateral (Friction);
    "force far from the patch": force_off_patch => ForcePoint;
    "transition contact bears": transition_bears => Unloaded;
    "transition contact said to be loaded": |p| unloaded(adding(p)).loaded = true => Sequence;
    "nothing to stand on": |p| adding(p).contacts.clear() => Equilibrium
        (Sequence BalanceForce BalanceMoment Torque ComMargin Clearance);
    // Joints. A whole turn leaves every link where it is.
    "joint turned once round": |p| *last_joint(p) += TAU => JointLimit;
    "more joint margin promised than kept": |p| p.required.joint_rad = 0.499 => JointLimit;
    "more torque margin promised than kept": |p| p.required.torque_use = 0.02 => Torque;
    // Collisions.
    "obstacle in the torso": obstacle_in_torso => Clearance;
    "obstacle in the foot, said to be the ground": obstacle_in_foot => ContactDepth
        (Clearance);
    "more distance between links promised than kept": |p| p.required.self_clearance_m = 0.499
        => SelfClearance;
    // From stance to stance.
    "contact moved between stances": |p| translate(adding(p), [0.0, 0.005, 0.0]) => Kept
        (Inclusion Closure Goal Clearance ContactDepth);
    "two contacts changed at once": stance_skipped => Sequence;
    "stance out of place": |p| adding(p).index += 1 => Sequence;
    "no stances": |p| p.stances.clear() => Sequence (PathLength);
    "goal elsewhere": goal_moved => Goal;
    "length of the path wrong": |p| p.search.path_stances += 1 => PathLength;
    // What is stated and what is.
    "centre of mass wrong": |p| p.stances[0].com_W[0] += 0.01 => Com;
    "contact pose stated wrong": |p| p.stances.last_mut().unwrap().contacts[0].X_WC.p[1] += 0.003
        => Pose (Kept);
    "quaternion not of unit length": |p| p.stances[0].q[3..7].iter_mut().for_each(|x| *x *= 1.01)
        => Quaternion;
    "joint names in another order": |p| p.robot.joint_names.swap(0, 1) => Robot;
    "another robot's mass": |p| p.robot.mass_kg += 1.0 => Robot;
    "margins stated better than they are": |p| p.stances[0].margins.torque_use = 0.0 => StatedMargin;
    "q truncated": |p| { p.stances[0].q.pop(); } => Numbers;
    "q not a number": |p| *last_joint(p) = f64::NAN => Numbers;
    "force not a number": |p| largest(p)[1] = f64::NAN => Numbers;
    "patch listed twice": |p| p.stances[0].contacts.extend_from_within(..1) => Names (Sequence);
    "friction of ice cream on velcro": |p| contacts(p).for_each(|c| c.friction = 3.0) => Names;
    // What is promised.
    "friction use of 5": |p| p.required.friction_use = 5.0 => Required;
    "negative clearance": |p| p.required.clearance_m = -0.1 => Required;
    "margin not a number": |p| p.required.com_m = f64::NAN => Required (ForcePoint ComMargin);
    "bodies behind surfaces without thickness": |p| p.thin_body_m = 0.0 => Required;
    "two surfaces of one name": |p| p.faces.extend_from_within(..1) => Environment;
    "another format": |p| p.format = "scandent-plan/0".to_owned() => Format;
};

/// The first stance that adds a contact.
fn adding(plan: &mut Plan) -> &mut Stance {
    let adds = |s: &&mut Stance| matches!(s.change, Change::Add { .. });
    let stance = plan.stances.iter_mut().find(adds);
    stance.expect("it adds a contact")
}

fn contacts(plan: &mut Plan) -> impl Iterator<Item = &mut Contact> {
    plan.stances.iter_mut().flat_map(|s| &mut s.contacts)
}

/// The first contact of a stance that bears nothing.
fn unloaded(stance: &mut Stance) -> &mut Contact {
    let contact = stance.contacts.iter_mut().find(|c| !c.loaded);
    contact.expect("a contact that bears nothing")
}

/// The largest force of the first stance.
fn largest(plan: &mut Plan) -> &mut [f64; 3] {
    let contacts = plan.stances[0].contacts.iter_mut();
    let forces = contacts.flat_map(|c| &mut c.forces_W);
    let largest = forces.max_by(|a, b| a[2].total_cmp(&b[2]));
    largest.expect("a force")
}

fn last_joint(plan: &mut Plan) -> &mut f64 {
    plan.stances[0].q.last_mut().expect("a joint")
}

/// The surface under the first contact of the start, and where that is in W.
fn under_start(plan: &mut Plan) -> (&mut Face, Point3<f64>) {
    let contact = &plan.stances[0].contacts[0];
    let (id, place) = (contact.face.clone(), Point3::from(contact.X_WC.p));
    let face = plan.faces.iter_mut().find(|face| face.id == id);
    (face.expect("its surface"), place)
}

fn surface_sunk(plan: &mut Plan) {
    let (face, _) = under_start(plan);
    let normal = face.normal_W();
    face.X_WF.translation.vector -= 0.005 * normal;
}

/// About the contact, so that its centre stays in the plane.
fn surface_tilted(plan: &mut Plan) {
    let (face, about) = under_start(plan);
    let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 0.02);
    let pose = &mut face.X_WF;
    pose.translation.vector = about.coords + turn * (pose.translation.vector - about.coords);
    pose.rotation = turn * pose.rotation;
}

/// Moves all that a stance states by the same.
fn translate(stance: &mut Stance, by: [f64; 3]) {
    let add = |p: &mut [f64]| p.iter_mut().zip(by).for_each(|(p, by)| *p += by);
    add(&mut stance.q[..3]);
    add(&mut stance.com_W);
    for contact in &mut stance.contacts {
        add(&mut contact.X_WC.p);
        let points = contact.vertices_W.iter_mut();
        let points = points.chain(&mut contact.force_points_W);
        points.for_each(|p| add(p));
    }
}

/// Everything beyond the middle of the foot falls off.
fn surface_cut(plan: &mut Plan) {
    let (face, place) = under_start(plan);
    let x = face.X_WF.inverse_transform_point(&place).x;
    let far = 100.0_f64.copysign(x);
    let beyond = [(x, -100.0), (far, -100.0), (far, 100.0), (x, 100.0)];
    let beyond = beyond.map(|(x, y)| Point2::new(x, y)).to_vec();
    let rest = Outline::from(&face.region).minus_all([beyond]).regions();
    let rest = rest.into_iter();
    let largest = rest.max_by(|a, b| a.area().total_cmp(&b.area()));
    face.region = largest.expect("a rest");
}

/// Takes the nearest edge of the face back until the foot is over it.
fn edge_taken_back(plan: &mut Plan) {
    let (face, place) = under_start(plan);
    let centre = face.X_WF.inverse_transform_point(&place).xy();
    let away_m: Vec<f64> = (face.region.segments())
        .map(|(_, [a, b])| {
            let part = (b - a).dot(&(centre - a)) / (b - a).norm_squared();
            (a + (b - a) * part.clamp(0.0, 1.0) - centre).norm()
        })
        .collect();
    let least = away_m.iter().copied().fold(f64::INFINITY, f64::min);
    for (edge, away) in face.region.edges_mut().flatten().zip(away_m) {
        if away == least {
            (edge.view, edge.further_m) = (None, away);
        }
    }
}

/// Equal and opposite forces along the line between their points: neither force nor moment.
fn feet_squeeze(plan: &mut Plan) {
    let mut loaded = plan.stances[0].contacts.iter_mut().filter(|c| c.loaded);
    let (a, b) = (loaded.next().unwrap(), loaded.next().unwrap());
    let between = Vector3::from(b.force_points_W[0]) - Vector3::from(a.force_points_W[0]);
    let along = 300.0 * between.normalize();
    for k in 0..3 {
        a.forces_W[0][k] += along[k];
        b.forces_W[0][k] -= along[k];
    }
}

/// At the corners of a parallelogram in turn: neither force nor moment.
fn corner_pulls(plan: &mut Plan) {
    let contacts = plan.stances[0].contacts.iter_mut();
    let forces = (contacts.filter(|c| c.loaded).map(|c| &mut c.forces_W))
        .find(|forces| forces.len() == 4)
        .expect("four forces");
    let pull = 50.0 + forces.iter().map(|f| f[2].abs()).fold(0.0, f64::max);
    for (force, sign) in forces.iter_mut().zip([1.0, -1.0, 1.0, -1.0]) {
        force[2] += sign * pull;
    }
}

fn force_off_patch(plan: &mut Plan) {
    let mut contacts = plan.stances[0].contacts.iter_mut();
    let contact = contacts.find(|c| c.loaded).unwrap();
    let [x, y, z] = contact.force_points_W[0];
    contact.force_points_W.push([x + 1.0, y, z]);
    contact.forces_W.push([0.0; 3]);
}

fn transition_bears(plan: &mut Plan) {
    let contact = unloaded(adding(plan));
    contact.force_points_W = vec![contact.X_WC.p];
    contact.forces_W = vec![[0.0, 0.0, 20.0]];
}

/// A cube of 60 mm.
fn obstacle(plan: &mut Plan, centre: Point3<f64>, surface: Option<String>) {
    let [low, high] = [-0.03, 0.03].map(|side| (centre.coords.add_scalar(side)).into());
    plan.obstacles.push(Obstacle {
        surface,
        ..Obstacle::cuboid("planted", low, high)
    });
}

fn obstacle_in_torso(plan: &mut Plan) {
    let q = &plan.stances[0].q;
    let centre = Point3::new(q[0], q[1], q[2] + 0.1);
    obstacle(plan, centre, None);
}

fn obstacle_in_foot(plan: &mut Plan) {
    let (face, place) = under_start(plan);
    let face = face.id.to_string();
    obstacle(plan, place, Some(face));
}

fn stance_skipped(plan: &mut Plan) {
    let index = adding(plan).index;
    plan.stances.remove(index);
    plan.search.path_stances -= 1;
    for (k, stance) in plan.stances.iter_mut().enumerate() {
        stance.index = k;
    }
}

fn goal_moved(plan: &mut Plan) {
    let [x, ..] = plan.goal.base_position_m.unwrap_or_default();
    plan.goal.base_position_m = Some([Some(x.unwrap_or(0.0) + 10.0), None, None]);
}
