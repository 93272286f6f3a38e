//! Where a robot's limbs may touch the world: soles, balls, fists.

use nalgebra::{Isometry3, Point2, Point3, Vector3};

use super::flat::{Flat, doubled_area, flat};
use super::limb::{Limb, LimbKind};
use super::palm;
use super::rsdf::Surface;
use crate::collision::Shape;
use crate::collision::ball::{self, Ball};
use crate::{Configuration, ContactPatch, Kinematics, PatchKind, Robot};

/// Joints that it takes to hold a sole flat where it is wanted: three for the place, two for the tilt.
const FLAT_JOINTS: usize = 5;
/// A ball is one that fits as well as this, m.
const BALL_OFF_M: f64 = 0.0015;
/// Least half width of a flat patch, m.
const HALF_WIDTH_M: f64 = 0.01;
/// A hand is what is beyond this part of an arm's length.
const HAND: f64 = 0.7;
/// Friction of soles and balls, and of hands: rubber and plastic on what is built.
const FRICTION: [f64; 2] = [0.6, 0.5];

/// What is looked for beside feet and hands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kinds {
    /// The front of the knees.
    pub knees: bool,
    /// The elbows.
    pub elbows: bool,
}

/// A patch that was found.
#[derive(Clone, Debug)]
pub struct Proposed {
    /// The patch, with one role.
    pub patch: ContactPatch,
    /// Pose of C in the link.
    pub X_LC: Isometry3<f64>,
    /// How it was found, in a few words.
    pub why: String,
    /// Joints of its fingers and where they are to be held for it, rad or m.
    pub held: Vec<(String, f64)>,
}

/// The patches of every limb, and what is to be told of those that have none.
///
/// `at` is a configuration with the base upright in which feet are as they shall stand: what looks
/// down there is what they stand on. Hands are looked at with all joints neutral: a wrist bent where the
/// robot stands does not change what a hand ends in. Surfaces of an RSDF go before what shapes tell.
pub fn patches(
    robot: &Robot,
    limbs: &[Limb],
    at: &Configuration,
    rsdf: &[Surface],
    kinds: Kinds,
) -> (Vec<Proposed>, Vec<String>) {
    let finder = |at: &Configuration| Finder {
        robot,
        limbs,
        kinematics: Kinematics::new(robot, at),
    };
    let finders = [finder(at), finder(&robot.neutral())];
    let (mut found, mut notes) = (Vec::new(), Vec::new());
    for (limb, of) in limbs.iter().enumerate() {
        let finder = &finders[usize::from(of.kind == LimbKind::Arm)];
        // A neck or a tail has few joints.
        if of.mirror.is_none() && of.bodies.len() < FLAT_JOINTS {
            let end = &robot.bodies[of.end()].name;
            let joints = of.bodies.len();
            notes.push(format!(
                "the limb that ends with {end} has no other side, and too few joints ({joints}) for an arm: it gets no patch"
            ));
            continue;
        }
        let shipped: Vec<Proposed> = rsdf
            .iter()
            .filter_map(|s| finder.shipped(limb, s))
            .collect();
        if !shipped.is_empty() {
            found.extend(shipped.into_iter().take(1));
        } else {
            match finder.end(limb) {
                Ok(proposed) => {
                    notes.extend(finder.flush(limb, &proposed.patch));
                    found.push(proposed);
                }
                Err(why) => notes.push(format!("{}: no patch: {why}", finder.name(limb))),
            }
        }
        let middle = match of.kind {
            LimbKind::Leg => kinds.knees,
            LimbKind::Arm => kinds.elbows,
        };
        if middle && let Some(patch) = finder.bend(limb) {
            found.push(patch);
        }
    }
    told_apart(&mut found);
    (found, notes)
}

/// Numbers the patches that have the name of one before: of a leg of two branches both end at one place.
fn told_apart(found: &mut [Proposed]) {
    for k in 1..found.len() {
        let (before, rest) = found.split_at_mut(k);
        let name = rest[0].patch.name.clone();
        let is_taken = |name: &String| before.iter().any(|of| of.patch.name == *name);
        let numbered = (2..).map(|n| format!("{name}_{n}"));
        let mut names = std::iter::once(name.clone()).chain(numbered);
        rest[0].patch.name = names.find(|name| !is_taken(name)).unwrap_or(name);
    }
}

struct Finder<'a> {
    robot: &'a Robot,
    limbs: &'a [Limb],
    kinematics: Kinematics,
}

impl Finder<'_> {
    fn name(&self, limb: usize) -> String {
        let limb = &self.limbs[limb];
        let what = match limb.kind {
            LimbKind::Leg => "foot",
            LimbKind::Arm => "hand",
        };
        format!("{}_{what}", limb.place)
    }

    /// The shapes of these bodies, placed in W.
    fn placed(&self, bodies: &[usize]) -> Vec<(Isometry3<f64>, &Shape)> {
        let shapes = self.robot.collision.shapes().iter();
        let of = shapes.filter(|s| bodies.contains(&s.body));
        of.map(|s| (self.kinematics.X_WB[s.body] * s.X_BG, s))
            .collect()
    }

    /// What a limb touches with at its end.
    fn end(&self, number: usize) -> Result<Proposed, String> {
        let (robot, limb) = (self.robot, &self.limbs[number]);
        let origins = &self.kinematics.origin_W;
        // A foot is the last body; a hand all that is beyond most of the arm's length, fingers too.
        let bodies = match limb.kind {
            LimbKind::Leg => vec![limb.end()],
            LimbKind::Arm => {
                let mut along = 0.0;
                let far = limb.bodies.iter().skip(1).find(|&&b| {
                    along += robot.bodies[b].X_PJ.translation.vector.norm();
                    along > HAND * limb.length_m
                });
                let hand = robot.subtree(far.copied().unwrap_or(limb.end()));
                // What weighs nothing is not there to bear.
                hand.filter(|&b| robot.bodies[b].mass_kg > 0.0).collect()
            }
        };
        let shapes = self.placed(&bodies);
        if shapes.is_empty() || bodies.is_empty() {
            let end = &robot.bodies[limb.end()].name;
            return Err(format!("{end} has no collision shape"));
        }
        let toward = match limb.kind {
            LimbKind::Leg => -Vector3::z(),
            LimbKind::Arm => {
                // Along the forearm: from the elbow to the hand.
                let hand = origins[bodies[0]];
                // Where an arm is folded its shoulder is near to the hand as well.
                let inner = limb.bodies.iter().take_while(|&&b| b != bodies[0]);
                let apart = |p: &Vector3<f64>| (hand - p).norm() > 0.15 * limb.length_m;
                let elbow = inner.map(|&b| origins[b]).filter(apart).last();
                let along = elbow.and_then(|p| (hand - p).try_normalize(1e-6));
                along.ok_or("its forearm has no length")?
            }
        };
        let ball = ball::fit(&|d| foremost(&shapes, d), &toward);
        let face = flat(&shapes, &toward, &Vector3::x()).filter(|f| half_width_m(f) > HALF_WIDTH_M);
        let holds_flat = limb.kind == LimbKind::Arm || limb.bodies.len() >= FLAT_JOINTS;
        // A wrist that is bent where its joints are neutral shows its side to where the forearm leads.
        let is_end = |face: &Flat| {
            limb.kind == LimbKind::Leg
                || limb.mirror.is_some()
                || shapes[face.shape].1.body >= limb.end()
        };
        let is_ball = |b: &Ball| b.off_m < BALL_OFF_M && b.radius_m > BALL_OFF_M;
        match (ball, face) {
            (Some(ball), _) if is_ball(&ball) => Ok(self.of_ball(number, &bodies, ball)),
            (_, Some(face)) if holds_flat && is_end(&face) => {
                let shape = shapes[face.shape].1;
                let found = self.of_flat(number, &face, shape, "the flat face at its end");
                let held = match limb.kind {
                    LimbKind::Leg => Vec::new(),
                    LimbKind::Arm => self.between(&bodies, &face, &shapes),
                };
                Ok(Proposed { held, ..found })
            }
            (Some(ball), _) if limb.kind == LimbKind::Leg => {
                Ok(self.of_ball(number, &bodies, ball))
            }
            _ => self
                .side(number, &bodies, limb.end(), &toward)
                .ok_or_else(|| {
                    "its end is neither flat nor a ball, and no flat side of it stands out of the arm".to_owned()
                }),
        }
    }

    /// What is to be told of a hand that the rest of its arm is too near to for it to touch anything.
    fn flush(&self, number: usize, patch: &ContactPatch) -> Option<String> {
        let limb = &self.limbs[number];
        if limb.kind != LimbKind::Arm || patch.kind != PatchKind::Area {
            return None;
        }
        let (spare_m, link) = palm::spare_m(self.robot, limb, patch.body, &patch.X_BC);
        (spare_m < 0.0).then(|| {
            format!(
                "{}: {link} is in its way, by {:.0} mm however its arm is held: it touches only with a smaller \
                 posture.clearance_m or posture.self_clearance_m",
                patch.name,
                -1e3 * spare_m
            )
        })
    }

    /// The side of a hand, palm or back, its fingers held out of the way; `along`: where its forearm leads.
    fn side(
        &self,
        number: usize,
        hand: &[usize],
        palm: usize,
        along: &Vector3<f64>,
    ) -> Option<Proposed> {
        let fingers = self.robot.subtree(palm).skip(1);
        let fingers: Vec<usize> = fingers.filter(|b| hand.contains(b)).collect();
        let shapes = self.placed(&[palm]);
        let along = palm::pointing(&shapes, &self.kinematics.origin_W[palm], *along)?;
        let is_usable = |face: &Flat| {
            let X_BC = self.kinematics.X_WB[palm].inverse() * face.X_BC;
            let limb = &self.limbs[number];
            half_width_m(face) > HALF_WIDTH_M
                && palm::spare_m(self.robot, limb, palm, &X_BC).0 > 0.0
        };
        let at = &self.kinematics;
        let (face, held) = palm::side(self.robot, at, (&shapes, &along), &fingers, &is_usable)?;
        let why = match held.is_empty() {
            true => "the largest flat side of its hand",
            false => {
                "the largest flat side of its hand that its fingers, held, do not stand out of"
            }
        };
        let found = self.of_flat(number, &face, shapes[face.shape].1, why);
        Some(Proposed { held, ..found })
    }

    /// The joints between the bodies that have a face, and where they are: to be held, for it to be one.
    fn between(
        &self,
        hand: &[usize],
        face: &Flat,
        shapes: &[(Isometry3<f64>, &Shape)],
    ) -> Vec<(String, f64)> {
        let bodies = || face.of.iter().map(|&k| shapes[k].1.body);
        let (Some(first), Some(last)) = (bodies().min(), bodies().max()) else {
            return Vec::new();
        };
        if first == last {
            return Vec::new();
        }
        let neutral = self.robot.neutral();
        let beyond = self
            .robot
            .subtree(first)
            .skip(1)
            .filter(|b| hand.contains(b));
        let held = beyond.map(|b| (self.robot.bodies[b].joint.clone(), neutral.joints[b - 1]));
        held.collect()
    }

    /// The bend of a limb, a ball: where a robot kneels or leans on its elbows.
    fn bend(&self, number: usize) -> Option<Proposed> {
        let limb = &self.limbs[number];
        let origins = &self.kinematics.origin_W;
        let (first, last) = (origins[limb.bodies[0]], origins[limb.end()]);
        let middle = |b: &usize| {
            (origins[*b] - first)
                .norm()
                .min((origins[*b] - last).norm())
        };
        let bend = *limb
            .bodies
            .iter()
            .max_by(|a, b| middle(a).total_cmp(&middle(b)))?;
        let toward = match limb.kind {
            LimbKind::Leg => Vector3::x(),
            LimbKind::Arm => (origins[bend] - first).try_normalize(1e-6)?,
        };
        let shapes = self.placed(&[bend]);
        let ball =
            (!shapes.is_empty()).then(|| ball::fit(&|d| foremost(&shapes, d), &toward))??;
        let mut found = self.of_ball(number, &[bend], ball);
        let what = match limb.kind {
            LimbKind::Leg => "knee",
            LimbKind::Arm => "elbow",
        };
        found.patch.name = format!("{}_{what}", limb.place);
        found.patch.roles = vec![what.to_owned()];
        Some(found)
    }

    fn of_flat(&self, limb: usize, face: &Flat, shape: &Shape, why: &str) -> Proposed {
        let (link, X_WC, polygon) = (shape.link.clone(), face.X_BC, face.polygon.clone());
        let kind = PatchKind::Area;
        self.on(
            limb,
            link,
            shape.body,
            X_WC,
            (kind, polygon),
            why.to_owned(),
        )
    }

    fn of_ball(&self, limb: usize, bodies: &[usize], ball: Ball) -> Proposed {
        // The shape whose middle is nearest.
        let off = |shape: &&Shape| {
            let X_WG = self.kinematics.X_WB[shape.body] * shape.X_BG;
            (X_WG.translation.vector - ball.centre.coords).norm()
        };
        let shapes = self.robot.collision.shapes().iter();
        let nearest = shapes
            .filter(|s| bodies.contains(&s.body))
            .min_by(|a, b| off(a).total_cmp(&off(b)));
        let name = || self.robot.bodies[bodies[0]].name.clone();
        let (body, link) = nearest.map_or((bodies[0], name()), |s| (s.body, s.link.clone()));
        let X_WC = Isometry3::translation(ball.centre.x, ball.centre.y, ball.centre.z);
        // Tenths of a millimetre are enough, and read well.
        let radius_m = (ball.radius_m * 1e4).round() / 1e4;
        let why = format!(
            "the ball that its end is nearest to, {:.1} mm off at most",
            1e3 * ball.off_m
        );
        let touches = (PatchKind::Point { radius_m }, vec![Point2::origin()]);
        self.on(limb, link, body, X_WC, touches, why)
    }

    /// A surface of an RSDF that is on this limb.
    fn shipped(&self, number: usize, surface: &Surface) -> Option<Proposed> {
        let frame = self.robot.frame(&surface.link).ok()?;
        if !self.limbs[number].bodies.contains(&frame.body) {
            return None;
        }
        let X_WC = self.kinematics.X_WB[frame.body] * frame.X_BL * surface.X_LC;
        let why = format!("planar surface {} of {}", surface.name, surface.file);
        let (link, touches) = (&surface.link, (PatchKind::Area, surface.polygon.clone()));
        Some(self.on(number, link.clone(), frame.body, X_WC, touches, why))
    }

    fn on(
        &self,
        limb: usize,
        link: String,
        body: usize,
        X_WC: Isometry3<f64>,
        (kind, polygon): (PatchKind, Vec<Point2<f64>>),
        why: String,
    ) -> Proposed {
        let X_BC = self.kinematics.X_WB[body].inverse() * X_WC;
        let frame = self
            .robot
            .frame(&link)
            .map_or(Isometry3::identity(), |f| f.X_BL);
        let is_leg = self.limbs[limb].kind == LimbKind::Leg;
        let patch = ContactPatch {
            name: self.name(limb),
            link,
            body,
            X_BC,
            kind,
            polygon,
            roles: vec![if is_leg { "foot" } else { "hand" }.to_owned()],
            friction: FRICTION[usize::from(!is_leg)],
        };
        Proposed {
            patch,
            X_LC: frame.inverse() * X_BC,
            why,
            held: Vec::new(),
        }
    }
}

/// The point of placed shapes that is foremost along `d`.
fn foremost(shapes: &[(Isometry3<f64>, &Shape)], d: &Vector3<f64>) -> Point3<f64> {
    let points = shapes
        .iter()
        .map(|(X_WG, shape)| X_WG * shape.geometry.support(&(X_WG.rotation.inverse() * d)));
    let first = points.max_by(|a, b| a.coords.dot(d).total_cmp(&b.coords.dot(d)));
    first.unwrap_or_else(Point3::origin)
}

/// Twice the area over the circumference: the radius of the inscribed circle of a polygon that has one.
fn half_width_m(face: &Flat) -> f64 {
    let polygon = &face.polygon;
    let next = polygon.iter().cycle().skip(1);
    let around: f64 = polygon.iter().zip(next).map(|(a, b)| (b - a).norm()).sum();
    doubled_area(polygon) / around.max(1e-9)
}
