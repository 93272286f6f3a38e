//! Worlds drawn from a seed, in families: what a planner is measured by.
//!
//! Every world is a few boxes, sized by the robot that is to cross it: all lengths are parts of the
//! height of its base, its stance or its width. Most are meant to be well within what such a robot
//! can do, of the others ([`Family::likely`]) it is not known; none is proved to be.

mod harder;
mod world;

use nalgebra::{Rotation3, Vector3};

use super::about_z;
use crate::truth::OrientedBox;
use world::{DEEP_M, World};

/// The measures of a robot that worlds are sized by, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Build {
    /// Height of the base over what it stands on.
    pub height_m: f64,
    /// Width and length of what its feet stand on.
    pub stance_m: [f64; 2],
    /// Width of the whole robot.
    pub width_m: f64,
    /// Length of a foot; of a ball its diameter.
    pub foot_m: f64,
    /// Height of its highest point over what it stands on.
    pub top_m: f64,
    /// Number of feet.
    pub feet: usize,
    /// Number of hands.
    pub hands: usize,
}

/// A world and what is asked in it: the robot stands upright at the origin and looks along x.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    /// The bodies; the ground under the start is at z = 0.
    pub boxes: Vec<OrientedBox>,
    /// Where the base shall go, x and y, m.
    pub goal_m: [f64; 2],
    /// The heading that it shall have there, rad.
    pub yaw_rad: Option<f64>,
    /// Coefficients of friction of feet and hands, where they are not the robot's.
    pub friction: Option<[f64; 2]>,
}

/// A kind of world.
#[derive(Clone, Copy, Debug)]
pub struct Family {
    /// Name.
    pub name: &'static str,
    /// Whether it is meant to be within what a robot of that build can do; else that is not known.
    pub likely: bool,
    /// Hands that a robot must have.
    pub hands: usize,
    build: fn(&mut World) -> Drawn,
}

/// All families.
pub const FAMILIES: [Family; 17] = [
    // Four to seven steps up, or down.
    family("stairs-up", |w| stairs(w, 1.0)),
    family("stairs-down", |w| stairs(w, -1.0)),
    // Blocks tilted by up to 8°.
    family("tilted-blocks", |w| blocks(w, 8.0, 0.05)),
    // Level stones with gaps between them.
    family("stones", |w| blocks(w, 0.0, 0.12)),
    // Floors with two or three gaps.
    family("gaps", gaps),
    // Three to six ribs across a floor.
    family("ribs", ribs),
    // Ten to twenty low boxes on a floor.
    family("clutter", clutter),
    // A wall that is open at one side.
    family("wall", |w| walls(w, false)),
    // A wall with a door.
    family("door", |w| walls(w, true)),
    // A gap with a bridge beside the straight way.
    family("bridge", bridge),
    // A turn by 90° or more on a floor.
    family("turn", turn),
    // A ramp of 5° to 12° onto a platform.
    family("ramp", ramp),
    // A gap with a bridge that turns by 90°.
    family("bridge-turn", harder::bridge_turn),
    // A bar, and a door, to duck under.
    unsure("bar", 0, harder::bar),
    unsure("low-door", 0, harder::low_door),
    // A high step beside a block for a hand.
    unsure("hand-step", 1, harder::hand_step),
    // A slippery ramp between walls for both hands.
    unsure("hand-corridor", 2, harder::hand_corridor),
];

const fn family(name: &'static str, build: fn(&mut World) -> Drawn) -> Family {
    Family {
        name,
        likely: true,
        hands: 0,
        build,
    }
}

const fn unsure(name: &'static str, hands: usize, build: fn(&mut World) -> Drawn) -> Family {
    Family {
        likely: false,
        hands,
        ..family(name, build)
    }
}

impl Family {
    /// The family of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        FAMILIES.iter().find(|family| family.name == name)
    }

    /// The world of a seed for a robot of this build.
    pub fn draw(&self, build: &Build, seed: u64) -> Drawn {
        (self.build)(&mut World::new(build, seed))
    }
}

fn stairs(w: &mut World, up: f64) -> Drawn {
    let height = w.build.height_m;
    let steps = w.count(4, 7);
    // Many legs stand on several steps at once.
    let steep = if w.build.feet > 2 { 0.6 } else { 1.0 };
    let rise = up * steep * w.between(0.10, 0.17) * height;
    let run = (w.between(0.40, 0.50) * height).max(w.build.foot_m + 0.06);
    let (around, half) = (w.around_m(), w.half_way_m());
    let begin = around + w.between(-0.2, 0.1);
    // Each step goes down to a depth of its own: no two share a corner.
    let bottom = -DEEP_M + rise.min(0.0) * (steps + 1) as f64;
    w.put([-around, begin], [-half, half], bottom, 0.0);
    for k in 1..steps {
        let x = begin + (k - 1) as f64 * run;
        w.put(
            [x, x + run],
            [-half, half],
            bottom - 0.01 * k as f64,
            rise * k as f64,
        );
    }
    let x = begin + (steps - 1) as f64 * run;
    let end = x + 2.0 * around;
    let low = bottom - 0.01 * steps as f64;
    w.put([x, end], [-half, half], low, rise * steps as f64);
    w.done([x + around, 0.0], None)
}

/// A field of blocks with gaps, on nothing.
fn blocks(w: &mut World, tilt_deg: f64, gap: f64) -> Drawn {
    let (height, around) = (w.build.height_m, w.around_m());
    let edge = (w.between(0.45, 0.60) * height).max(w.build.foot_m + 0.14);
    let half = w.half_way_m();
    w.put([-around, around], [-half, half], -DEEP_M, 0.0);
    let rows = w.count(3, 6);
    let columns = (2.0 * half / edge).ceil() as usize;
    let gap_m = gap * height;
    for row in 0..rows {
        for column in 0..columns {
            let x = around + gap_m + (row as f64 + 0.5) * (edge + gap_m);
            let y = (column as f64 + 0.5 - 0.5 * columns as f64) * (edge + gap_m);
            let top = w.between(-0.05, 0.05) * height;
            let mut tilt = || w.between(-tilt_deg, tilt_deg).to_radians();
            let rotation = Rotation3::from_euler_angles(tilt(), tilt(), 0.5 * tilt());
            let centre = Vector3::new(x, y, top) - rotation * Vector3::z() * (0.5 * DEEP_M);
            w.put_turned(centre, [edge, edge, DEEP_M], rotation);
        }
    }
    let begin = around + gap_m + rows as f64 * (edge + gap_m);
    w.put([begin, begin + 2.0 * around], [-half, half], -DEEP_M, 0.0);
    w.done([begin + around, 0.0], None)
}

fn gaps(w: &mut World) -> Drawn {
    let (height, around, half) = (w.build.height_m, w.around_m(), w.half_way_m());
    let count = w.count(2, 3);
    let mut from = -around;
    let mut to = around;
    for _ in 0..count {
        w.put([from, to], [-half, half], -DEEP_M, 0.0);
        from = to + w.between(0.12, 0.28) * height;
        to = from + w.between(0.5, 1.2) * height;
    }
    to = from + 2.0 * around;
    w.put([from, to], [-half, half], -DEEP_M, 0.0);
    w.done([to - around, 0.0], None)
}

fn ribs(w: &mut World) -> Drawn {
    let (height, around, half) = (w.build.height_m, w.around_m(), w.half_way_m());
    let count = w.count(3, 6);
    let mut x = around;
    for _ in 0..count {
        x += w.between(0.3, 0.9) * height;
        let (wide, high) = (w.between(0.03, 0.12), w.between(0.03, 0.10) * height);
        let turn = about_z(w.between(-20.0, 20.0));
        let centre = Vector3::new(x, 0.0, 0.5 * high - 0.05);
        w.put_turned(centre, [wide, 2.0 * half, high + 0.1], turn);
    }
    let goal = x + around;
    w.floor(goal, half);
    w.done([goal, 0.0], None)
}

fn clutter(w: &mut World) -> Drawn {
    let (height, around) = (w.build.height_m, w.around_m());
    let half = w.half_way_m() + 0.4;
    let goal = 2.0 * around + w.between(2.0, 3.5) * height;
    for _ in 0..w.count(10, 20) {
        let x = w.between(around, goal - around);
        let y = w.between(-half, half);
        let size = [0, 1].map(|_| w.between(0.08, 0.30) * height);
        let high = w.between(0.03, 0.16) * height;
        let turn = about_z(w.between(0.0, 90.0));
        let centre = Vector3::new(x, y, 0.5 * high - 0.05);
        w.put_turned(centre, [size[0], size[1], high + 0.1], turn);
    }
    w.floor(goal, half);
    w.done([goal, 0.0], None)
}

/// A wall across the way, with room to pass at one side or through a door.
fn walls(w: &mut World, door: bool) -> Drawn {
    let (height, around, width) = (w.build.height_m, w.around_m(), w.build.width_m);
    let room = 1.3 * width + 0.3;
    let at = around + w.between(0.3, 0.8) * height;
    let thick = w.between(0.08, 0.2);
    let high = w.between(1.2, 2.0) * height;
    let (side, off) = (w.side(), w.between(0.0, 0.8) * width);
    let opening = if door { off - 0.5 * room } else { off };
    let half = opening + room + if door { 0.6 * width } else { 0.0 };
    let mut wall = |from: f64, to: f64| {
        let y = [from * side, to * side];
        let y = [y[0].min(y[1]), y[0].max(y[1])];
        w.put([at, at + thick], y, -0.05, high);
    };
    wall(-half, opening);
    if door {
        wall(opening + room, half);
    }
    let goal = at + thick + around + w.between(0.3, 0.8) * height;
    w.floor(goal, half);
    w.done([goal, 0.0], None)
}

fn bridge(w: &mut World) -> Drawn {
    let (height, around, stance) = (w.build.height_m, w.around_m(), w.build.stance_m[0]);
    let gap = w.between(1.0, 1.6) * height;
    let wide = 1.25 * stance + w.between(0.15, 0.3);
    let (side, off) = (w.side(), w.between(0.4, 1.2) * stance);
    let half = off + wide;
    let begin = 1.5 * around;
    w.put([-around, begin], [-half, half], -DEEP_M, 0.0);
    let middle = side * off;
    let y = [middle - 0.5 * wide, middle + 0.5 * wide];
    w.put([begin, begin + gap], y, -0.9 * DEEP_M, 0.0);
    let end = begin + gap + 2.5 * around;
    w.put([begin + gap, end], [-half, half], -DEEP_M, 0.0);
    w.done([end - around, 0.0], None)
}

fn turn(w: &mut World) -> Drawn {
    let ahead = w.between(0.0, 1.0) * w.build.height_m;
    let yaw = w.side() * w.between(90.0, 180.0).to_radians();
    let half = w.around_m() + 0.5 * w.build.stance_m[1];
    w.floor(ahead, half);
    w.done([ahead, 0.0], Some(yaw))
}

fn ramp(w: &mut World) -> Drawn {
    let (height, around, half) = (w.build.height_m, w.around_m(), w.half_way_m());
    let angle = w.between(5.0, 12.0).to_radians();
    let length = w.between(1.5, 3.0) * height;
    let begin = around + w.between(0.0, 0.3);
    w.put([-around, begin], [-half, half], -DEEP_M, 0.0);
    let rotation = Rotation3::from_euler_angles(0.0, -angle, 0.0);
    let middle =
        Vector3::new(begin, 0.0, 0.0) + rotation * Vector3::new(0.5 * length, 0.0, -0.5 * DEEP_M);
    w.put_turned(middle, [length, 2.0 * half, DEEP_M], rotation);
    let (end, top) = (begin + length * angle.cos(), length * angle.sin());
    w.put([end, end + 2.0 * around], [-half, half], -0.9 * DEEP_M, top);
    w.done([end + around, 0.0], None)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A robot like HRP-2.
    const BUILD: Build = Build {
        height_m: 0.65,
        stance_m: [0.33, 0.24],
        width_m: 0.7,
        foot_m: 0.24,
        top_m: 1.4,
        feet: 2,
        hands: 2,
    };

    #[test]
    fn a_seed_gives_one_world_with_ground_under_start_and_goal() {
        for family in FAMILIES {
            for seed in 0..20 {
                let drawn = family.draw(&BUILD, seed);
                assert_eq!(drawn, family.draw(&BUILD, seed), "{}", family.name);
                let under = |[x, y]: [f64; 2]| {
                    drawn.boxes.iter().any(|b| {
                        let p = b.X_WO().inverse_transform_vector(
                            &(Vector3::new(x, y, b.position_m[2]) - Vector3::from(b.position_m)),
                        );
                        (0..2).all(|k| p[k].abs() < 0.5 * b.size_m[k])
                    })
                };
                assert!(
                    under([0.0, 0.0]) && under(drawn.goal_m),
                    "{} {seed}",
                    family.name
                );
            }
            assert_ne!(
                family.draw(&BUILD, 1),
                family.draw(&BUILD, 2),
                "{}",
                family.name
            );
        }
    }
}
