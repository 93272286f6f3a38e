//! What a run shows: contacts, slip, deviations, torques.

use std::collections::BTreeMap;

use nalgebra::{DVector, Point2, Vector3};
use robot_model::{Configuration, ContactPatch, Kinematics, Robot};
use surfaces::ConvexPolygon;

use crate::criteria::{Criterion, Unit};
use crate::observed::{ClosureObserved, Peaks, Unplanned};
use crate::plant::{Side, Touch};
use crate::reference::ReferenceState;
use crate::schedule::Closure;
use crate::whole_body::kept;
use crate::world::WorldBody;

/// A touched point is the patch's where it is this near to its plane and polygon, m.
const NEAR_M: f64 = 0.010;
/// A patch in the air that touches this near to where it is to be put down has landed early, m.
const LANDING_M: f64 = 0.030;
/// A patch whose reference is this near to its place lands in time, m.
const EARLY_M: f64 = 0.003;
/// Contacts that press less are not felt, N: parallel faces that graze come and go with rounding.
const FELT_N: f64 = 1.0;
/// And where the contact's normal is this near to the patch's, cos 20°; at a steeper angle it is
/// the edge of the sole that meets a riser.
const ALONG: f64 = 0.94;

/// One state of a run, as the monitor is shown it.
pub(crate) struct Seen<'s> {
    pub t_s: f64,
    pub configuration: &'s Configuration,
    pub wanted: &'s ReferenceState,
    pub touches: &'s [Touch],
    pub torques: &'s [f64],
}

/// Follows one run.
pub(crate) struct Monitor<'a> {
    robot: &'a Robot,
    world: &'a [WorldBody],
    closures: Vec<Closure>,
    grace_s: f64,
    load_n: f64,
    polygons: Vec<Option<ConvexPolygon>>,
    kinematics: Kinematics,
    reference: Kinematics,
    /// What was seen, by closure.
    observed: Vec<ClosureObserved>,
    /// Largest values since the last [`Self::forget`].
    pub peaks: Peaks,
    /// The patch in the air, how far it was off its way when it left, whence and when.
    left: Option<(usize, Vector3<f64>, Vector3<f64>, f64)>,
    /// Contacts that nothing asked for, by the names of the two.
    unplanned: BTreeMap<(String, String), Unplanned>,
    /// Normal force of each patch now, N.
    pub normal_n: Vec<f64>,
    /// Those forces along the normals of what is touched, N.
    pressed_W: Vec<Vector3<f64>>,
    /// Vertical force of the world on the robot now, N.
    pub vertical_n: f64,
    /// Centre of mass now.
    pub com_W: Vector3<f64>,
    /// Deviation of the centre of mass from its reference now, m.
    pub com_error_m: f64,
    /// Angle of the base to its reference now, rad.
    pub tilt_rad: f64,
}

impl<'a> Monitor<'a> {
    /// A monitor of a reference with these closures. A contact may be `grace_s` early or late, and
    /// is loaded from `load_n` on.
    pub fn new(
        robot: &'a Robot,
        world: &'a [WorldBody],
        closures: Vec<Closure>,
        grace_s: f64,
        load_n: f64,
    ) -> Self {
        let start = robot.neutral();
        let polygon = |patch: &ContactPatch| ConvexPolygon::new(patch.polygon.clone()).ok();
        Self {
            polygons: robot.patches.iter().map(polygon).collect(),
            observed: vec![ClosureObserved::default(); closures.len()],
            normal_n: vec![0.0; robot.patches.len()],
            pressed_W: vec![Vector3::zeros(); robot.patches.len()],
            kinematics: Kinematics::new(robot, &start),
            reference: Kinematics::new(robot, &start),
            robot,
            world,
            closures,
            grace_s,
            load_n,
            peaks: Peaks::default(),
            left: None,
            unplanned: BTreeMap::new(),
            vertical_n: 0.0,
            com_W: Vector3::zeros(),
            com_error_m: 0.0,
            tilt_rad: 0.0,
        }
    }

    /// The closures it follows, with what was seen of each.
    pub fn pairs(&self) -> impl Iterator<Item = (&Closure, &ClosureObserved)> {
        self.closures.iter().zip(&self.observed)
    }

    /// Forgets everything seen so far: the robot has settled.
    pub fn forget(&mut self) {
        self.observed.fill(ClosureObserved::default());
        self.peaks = Peaks::default();
        self.unplanned.clear();
    }

    /// Takes in one state.
    pub fn see(&mut self, seen: &Seen) {
        self.kinematics.update(self.robot, seen.configuration);
        let wanted = &seen.wanted.configuration;
        self.reference.update(self.robot, wanted);
        self.com_W = self.kinematics.com_W;
        self.com_error_m = (self.com_W - self.reference.com_W).norm();
        self.tilt_rad = seen.configuration.R_WB.angle_to(&wanted.R_WB);
        let t = seen.t_s;
        let at = || format!("at {t:.2} s");
        self.peaks.com_error_m.see(self.com_error_m, at);
        self.peaks.tilt_rad.see(self.tilt_rad, at);
        self.see_torques(seen);
        self.see_touches(seen);
        self.see_patches(seen);
        self.peaks.vertical_sum_n += self.vertical_n;
        self.peaks.steps += 1;
    }

    fn see_torques(&mut self, seen: &Seen) {
        for (torque, body) in seen.torques.iter().zip(self.robot.joint_bodies()) {
            let at = || format!("{} at {:.2} s", body.joint, seen.t_s);
            self.peaks.torque_use.see(torque.abs() / body.effort, at);
        }
    }

    fn see_touches(&mut self, seen: &Seen) {
        self.normal_n.fill(0.0);
        self.pressed_W.fill(Vector3::zeros());
        self.vertical_n = 0.0;
        for touch in seen.touches {
            if matches!(touch.other, Side::World(_)) {
                self.vertical_n += touch.force_W.z;
            }
            match self.patch_of(touch, seen) {
                Some((patch, normal_W)) => {
                    let normal_n = touch.force_W.dot(&normal_W);
                    self.normal_n[patch] += normal_n;
                    self.pressed_W[patch] += normal_W * normal_n;
                    let name = &self.robot.patches[patch].name;
                    let at = || format!("{name} at {:.2} s", seen.t_s);
                    self.peaks.penetration_m.see(touch.depth_m, at);
                }
                None if touch.force_W.norm() >= FELT_N => self.see_unplanned(touch, seen.t_s),
                None => {}
            }
        }
    }

    /// The patch that a touch belongs to, and the patch's normal in W; `None` where it is not
    /// planned.
    fn patch_of(&self, touch: &Touch, seen: &Seen) -> Option<(usize, Vector3<f64>)> {
        let Side::World(_) = touch.other else {
            return None;
        };
        let body = self.robot.collision.shapes()[touch.shape].body;
        for (index, patch) in self.robot.patches.iter().enumerate() {
            if patch.body != body {
                continue;
            }
            let X_WC = self.kinematics.X_WC(patch);
            let timely = self.closures.iter().any(|closure| {
                let soon = seen.t_s < closure.start_s
                    && seen.wanted.swing == Some(index)
                    && (X_WC.translation.vector - closure.place_W).norm() <= LANDING_M;
                closure.patch == index
                    && (soon || seen.t_s >= closure.start_s - self.grace_s)
                    && seen.t_s <= closure.end_s + self.grace_s
            });
            if !timely {
                continue;
            }
            let p_C = X_WC.inverse_transform_vector(&(touch.p_W - X_WC.translation.vector));
            let (near, normal_W) = match (patch.point_radius_m(), &self.polygons[index]) {
                (Some(radius), _) => ((p_C.norm() - radius).abs() <= NEAR_M, touch.normal_W),
                (None, Some(polygon)) => (
                    p_C.z.abs() <= NEAR_M && polygon.contains(&Point2::new(p_C.x, p_C.y), NEAR_M),
                    X_WC.rotation * Vector3::z(),
                ),
                (None, None) => (false, touch.normal_W),
            };
            if near && touch.normal_W.dot(&normal_W) >= ALONG {
                return Some((index, normal_W));
            }
        }
        None
    }

    fn see_unplanned(&mut self, touch: &Touch, t_s: f64) {
        let link = |shape: usize| self.robot.collision.shapes()[shape].link.clone();
        let other = match touch.other {
            Side::Shape(shape) => link(shape),
            Side::World(body) => self.world[body].name.clone(),
        };
        let entry = self.unplanned.entry((link(touch.shape), other));
        let entry = entry.or_insert(Unplanned {
            first_s: t_s,
            steps: 0,
            peak_n: 0.0,
        });
        entry.steps += 1;
        entry.peak_n = entry.peak_n.max(touch.force_W.norm());
    }

    /// Slip and load of closed patches, deviation of the one in the air.
    fn see_patches(&mut self, seen: &Seen) {
        for (closure, observed) in self.closures.iter().zip(&mut self.observed) {
            if seen.t_s < closure.start_s || seen.t_s >= closure.end_s {
                continue;
            }
            let normal = self.normal_n[closure.patch];
            observed.force_sum_n += normal;
            observed.steps += 1;
            if normal < self.load_n {
                let due = closure.loaded_from_s.is_some_and(|due_s| seen.t_s >= due_s);
                observed.late_steps += usize::from(due && observed.anchor.is_none());
                continue;
            }
            let patch = &self.robot.patches[closure.patch];
            let X_WC = self.kinematics.X_WC(patch);
            let anchor = observed.anchor.get_or_insert(X_WC);
            let mut moved = X_WC.translation.vector - anchor.translation.vector;
            if let Some(radius) = patch.point_radius_m() {
                // A ball rolls: what it slides beyond rolling, from one state to the next, on what it touches, which
                // may be beside the face that was planned.
                //   s += Δp − r Δθ × n
                let turn = (X_WC.rotation * anchor.rotation.inverse()).scaled_axis();
                let n = self.pressed_W[closure.patch].normalize();
                observed.slid_W += moved - radius * turn.cross(&n);
                *anchor = X_WC;
                moved = observed.slid_W;
            }
            observed.slip_m = observed.slip_m.max(moved.norm());
        }
        if let Some(swing) = seen.wanted.swing {
            let patch = &self.robot.patches[swing];
            let there = self.kinematics.X_WC(patch).translation.vector;
            let wanted = self.reference.X_WC(patch).translation.vector;
            let at = || format!("{} at {:.2} s", patch.name, seen.t_s);
            // It leaves from where it stands: what that is off is gone after a while.
            let off = there - wanted;
            let left = self.left.filter(|left| left.0 == swing);
            let (_, first, from_W, from_s) = left.unwrap_or((swing, off, wanted, seen.t_s));
            self.left = Some((swing, first, from_W, from_s));
            let kept = kept(seen.t_s - from_s, (wanted - from_W).norm());
            let error = (off - first * kept).norm();
            self.peaks.swing_error_m.see(error, at);
        } else {
            self.left = None;
        }
    }

    /// Whether the patch in the air is near the place where it is to touch, while its reference is
    /// still on the way.
    pub fn nears_landing(&self, wanted: &ReferenceState) -> bool {
        wanted.landing.as_ref().is_some_and(|landing| {
            let patch = &self.robot.patches[landing.patch];
            let to = landing.X_WC.translation.vector;
            let away = |k: &Kinematics| (k.X_WC(patch).translation.vector - to).norm();
            away(&self.kinematics) <= LANDING_M && away(&self.reference) >= EARLY_M
        })
    }

    /// Speed of all joints, rad/s.
    pub fn joint_speed(v: &DVector<f64>) -> f64 {
        v.rows(6, v.len() - 6).norm()
    }

    /// The criterion that nothing touches that was not asked to.
    pub fn none_unplanned(&self) -> Criterion {
        let word = |((a, b), u): (&(String, String), &Unplanned)| {
            let (from, steps, peak) = (u.first_s, u.steps, u.peak_n);
            format!("{a} and {b} from {from:.2} s ({steps} steps, up to {peak:.0} N)")
        };
        let words: Vec<String> = self.unplanned.iter().map(word).collect();
        let count = words.len() as f64;
        let words = (!words.is_empty()).then(|| words.join("; "));
        Criterion::at_most("unplanned contacts", count, 0.0, Unit::Plain("")).on(words)
    }

    /// The criterion that no contact that is to bear slips by more than `bound_m`; `said` names a closure.
    pub fn slip(&self, bound_m: f64, said: impl Fn(&Closure) -> String) -> Criterion {
        let bear = self.pairs().filter(|(c, _)| c.loaded_from_s.is_some());
        let most = bear.max_by(|a, b| a.1.slip_m.total_cmp(&b.1.slip_m));
        let slip_m = most.map_or(0.0, |(_, observed)| observed.slip_m);
        let said = most.map(|(closure, _)| said(closure));
        Criterion::at_most("slip", slip_m, bound_m, Unit::Millimetre).on(said)
    }
}
