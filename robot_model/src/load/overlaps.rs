//! Links whose shapes meet at rest: a flaw of the shapes, not of the posture.
//!
//! Hulls of meshes are larger than the meshes, and boxes larger than what they stand for. Where such
//! shapes meet between neighbours, or whatever the posture, their distance says nothing: these
//! pairs are not watched. Others that overlap at rest stay watched unless the settings say otherwise.

use nalgebra::{Matrix3, Vector3};

use super::Findings;
use crate::collision::CollidingPair;
use crate::{Config, Configuration, JointKind, Kinematics, Robot};

/// Shapes nearer than this meet, m: less than any posture keeps between two parts.
pub(crate) const NEAR_M: f64 = 0.008;
/// Axes meet that pass a point within this, m.
const IN_POINT_M: f64 = 1e-3;
/// Postures in which links are looked at that may meet in every one.
const POSTURES: u64 = 200;

/// Stops watching what cannot be told apart from a collision, and says which pairs overlap.
pub(super) fn except(robot: &mut Robot, config: &Config, findings: &mut Findings) {
    let resting = Kinematics::new(robot, &robot.resting());
    robot.collision.disable_overlapping_neighbours(&resting);
    let meeting = robot.pairs_within(&robot.resting(), NEAR_M);
    let body = |link: &str| robot.frame(link).map_or(0, |frame| frame.body);
    let are_neighbours = |pair: &CollidingPair| {
        are_neighbours(robot, &resting, body(&pair.link_a), body(&pair.link_b))
    };
    let (neighbours, mut others): (Vec<_>, Vec<_>) = meeting.into_iter().partition(are_neighbours);
    let mut always = others.clone();
    for number in 1..=POSTURES {
        if always.is_empty() || config.disable_colliding_at_rest {
            break;
        }
        let meeting = robot.pairs_within(&sampled(robot, number), NEAR_M);
        always.retain(|pair| {
            meeting
                .iter()
                .any(|now| now.is_of(&pair.link_a, &pair.link_b))
        });
    }
    others.retain(|pair| !always.contains(pair));
    let excepted = [neighbours, always].concat();
    robot
        .collision
        .disable(|a, b| excepted.iter().any(|pair| pair.is_of(a, b)));
    for (what, pairs) in [
        ("links that meet at rest are not watched", &excepted),
        (
            "links meet at rest and are watched all the same \
             (robot_model.disable_colliding_at_rest = true excepts them)",
            &others,
        ),
    ] {
        for CollidingPair {
            link_a,
            link_b,
            distance,
        } in pairs
        {
            findings.list(
                what,
                format!("{link_a} – {link_b} ({:.1} mm)", 1e3 * distance),
            );
        }
    }
    robot.meeting_at_rest = others;
}

/// Whether two bodies are neighbours: over at most two joints, or over as many as meet in one point, as those
/// of a hip or a shoulder do.
pub(crate) fn are_neighbours(robot: &Robot, at: &Kinematics, a: usize, b: usize) -> bool {
    let between: Vec<usize> = robot.joints_between(a, b).collect();
    robot.are_close(a, b) || meet_in_a_point(robot, at, &between)
}

/// Whether the axes of these bodies' joints pass through one point.
///
///   min over c of Σ |(1 − a aᵀ)(c − o)|²
fn meet_in_a_point(robot: &Robot, at: &Kinematics, joints: &[usize]) -> bool {
    let across = |k: usize| Matrix3::identity() - at.axis_W[k] * at.axis_W[k].transpose();
    let all: Matrix3<f64> = joints.iter().map(|&k| across(k)).sum();
    let moments: Vector3<f64> = joints.iter().map(|&k| across(k) * at.origin_W[k]).sum();
    let turns = |k: &usize| robot.bodies[*k].kind == JointKind::Revolute;
    let point = all.try_inverse().map(|inverse| inverse * moments);
    let through =
        |c: Vector3<f64>, k: usize| (across(k) * (c - at.origin_W[k])).norm() < IN_POINT_M;
    joints.iter().all(turns) && point.is_some_and(|c| joints.iter().all(|&k| through(c, k)))
}

/// A posture within the joint limits: the point of a number in an additive recurrence, whose
/// fractional parts fill the cube of the joints evenly.
pub fn sampled(robot: &Robot, number: u64) -> Configuration {
    let mut posture = Configuration::zero(robot.nj());
    for (j, (q, body)) in posture
        .joints
        .iter_mut()
        .zip(robot.joint_bodies())
        .enumerate()
    {
        // √(j + 2.5) is irrational for every j.
        let step = f64::sqrt((j + 2) as f64 + 0.5);
        let part = (number as f64 * step).fract();
        *q = body.lower + part * (body.upper - body.lower);
    }
    posture
}

#[cfg(test)]
mod tests {
    use crate::load::{load_from_strings, no_meshes};
    use crate::{Config, Robot};

    /// A chain of boxes 0.1 m long, `width` wide, each turning by up to ±`range` rad on the one before.
    fn chain(links: usize, width: f64, range: f64) -> Robot {
        read(&text(links, width, range))
    }

    fn text(links: usize, width: f64, range: f64) -> String {
        let mut urdf = String::from("<robot name=\"chain\">");
        for i in 0..links {
            urdf += &format!(
                "<link name=\"l{i}\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" \
                 izz=\"1\"/></inertial><collision><geometry><box size=\"{width} 0.1 0.1\"/>\
                 </geometry></collision></link>"
            );
            if i > 0 {
                urdf += &format!(
                    "<joint name=\"j{i}\" type=\"revolute\"><parent link=\"l{}\"/><child \
                     link=\"l{i}\"/><origin xyz=\"0.1 0 0\"/><axis xyz=\"0 0 1\"/><limit \
                     lower=\"-{range}\" upper=\"{range}\" effort=\"1\" velocity=\"1\"/></joint>",
                    i - 1
                );
            }
        }
        urdf + "</robot>"
    }

    fn read(urdf: &str) -> Robot {
        let config = Config::default();
        load_from_strings(urdf, None, None, "chain", &no_meshes, &config).unwrap()
    }

    fn watched(robot: &Robot) -> Vec<(usize, usize)> {
        robot.collision.pairs().to_vec()
    }

    #[test]
    fn neighbours_that_overlap_are_not_watched() {
        assert_eq!(watched(&chain(4, 0.15, 1.0)), [(0, 2), (0, 3), (1, 3)]);
        let wide = chain(4, 0.25, 1.0);
        assert_eq!(watched(&wide), [(0, 3)]);
        let note = &wide.notes[0];
        assert!(
            note.contains("not watched: l0 – l2 (-50.0 mm), l1 – l3"),
            "{note}"
        );
    }

    #[test]
    fn others_are_where_they_can_come_apart() {
        // Three joints apart, 50 mm deep: they always meet where joints hardly turn.
        assert_eq!(watched(&chain(4, 0.35, 0.1)), []);
        let robot = chain(4, 0.35, 1.5);
        assert_eq!(watched(&robot), [(0, 3)]);
        assert_eq!(robot.meeting_at_rest[0].link_b, "l3");
        let note = robot.notes.join("\n");
        assert!(
            note.contains("robot_model.disable_colliding_at_rest"),
            "{note}"
        );
    }

    #[test]
    fn a_hip_of_three_joints_makes_neighbours() {
        // The first joint is 0.3 m out; the next two are where it is, across it and each other.
        let mut urdf = text(4, 0.35, 1.5);
        let (offset, along) = ("xyz=\"0.1 0 0\"", "axis xyz=\"0 0 1\"");
        for (joint, place, axis) in [
            ("j1", "0.3 0 0", "0 0 1"),
            ("j2", "0 0 0", "0 1 0"),
            ("j3", "0 0 0", "1 0 0"),
        ] {
            let at = urdf.find(&format!("<joint name=\"{joint}\"")).unwrap();
            let rest = urdf.split_off(at);
            let rest = rest.replacen(offset, &format!("xyz=\"{place}\""), 1);
            urdf += &rest.replacen(along, &format!("axis xyz=\"{axis}\""), 1);
        }
        assert_eq!(watched(&read(&urdf)), []);
        // Where the last two are aside, the axes meet no more.
        let aside = urdf.replacen("xyz=\"0 0 0\"", "xyz=\"0 0.05 0\"", 1);
        assert_eq!(watched(&read(&aside)), [(0, 3)]);
    }
}
