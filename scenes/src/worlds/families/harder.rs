//! Families that ask for more than feet on level ground: something overhead, a narrow way that turns,
//! hands.

use nalgebra::{Rotation3, Vector3};

use super::world::{DEEP_M, World};
use super::{Drawn, walls};

/// A bar across the way, lower than the robot stands.
pub(super) fn bar(w: &mut World) -> Drawn {
    let (around, half, top) = (w.around_m(), w.half_way_m(), w.build.top_m);
    let at = around + w.between(0.2, 0.6) * w.build.height_m;
    let low = w.between(0.90, 0.98) * top;
    let thick = w.between(0.05, 0.12);
    w.put(
        [at, at + thick],
        [-half - 0.3, half + 0.3],
        low,
        low + thick,
    );
    let goal = at + thick + around + 0.3 * w.build.height_m;
    w.floor(goal, half);
    w.done([goal, 0.0], None)
}

/// A wall with a door, its lintel lower than the robot stands.
pub(super) fn low_door(w: &mut World) -> Drawn {
    let low = w.between(0.92, 1.0) * w.build.top_m;
    let drawn = walls(w, true);
    // The first two boxes are the wall beside the door, at both sides.
    let [one, other] = [0, 1].map(|i| drawn.boxes[i].clone());
    let (x, y) = (one.position_m[0], [one.position_m[1], other.position_m[1]]);
    let middle = Vector3::new(x, 0.5 * (y[0] + y[1]), low + 0.1);
    let size = [one.size_m[0] + 0.02, (y[1] - y[0]).abs(), 0.2];
    w.take(drawn.boxes);
    w.put_turned(middle, size, Rotation3::identity());
    w.done(drawn.goal_m, drawn.yaw_rad)
}

/// A gap with a bridge that turns by 90°.
pub(super) fn bridge_turn(w: &mut World) -> Drawn {
    let (height, around, [stance, long]) = (w.build.height_m, w.around_m(), w.build.stance_m);
    let half = w.half_way_m();
    let wide = 1.25 * stance + w.between(0.15, 0.3);
    // Where it turns there is room for every heading.
    let corner = stance.hypot(long) + w.between(0.15, 0.3);
    let (ahead, aside) = (w.between(0.4, 0.9) * height, w.between(0.6, 1.2) * height);
    let (side, begin) = (w.side(), 1.5 * around);
    let to_side = |y: [f64; 2]| {
        let y = y.map(|y| side * y);
        [y[0].min(y[1]), y[0].max(y[1])]
    };
    w.put([-around, begin], [-half, half], -DEEP_M, 0.0);
    let turn = begin + ahead;
    w.put([begin, turn], [-0.5 * wide, 0.5 * wide], -0.9 * DEEP_M, 0.0);
    let y = [-0.5 * corner, 0.5 * corner];
    w.put([turn, turn + corner], y, -0.8 * DEEP_M, 0.0);
    let middle = turn + 0.5 * corner;
    let x = [middle - 0.5 * wide, middle + 0.5 * wide];
    let end = 0.5 * corner + aside;
    w.put(x, to_side([0.5 * corner, end]), -0.7 * DEEP_M, 0.0);
    let x = [middle - around, middle + around];
    w.put(x, to_side([end, end + 2.5 * around]), -DEEP_M, 0.0);
    w.done([middle, side * (end + 1.2 * around)], None)
}

/// A high step beside a block that a hand can lean on.
pub(super) fn hand_step(w: &mut World) -> Drawn {
    let (height, around, half) = (w.build.height_m, w.around_m(), w.half_way_m());
    let (begin, rise) = (around, w.between(0.38, 0.50) * height);
    w.put([-around, begin], [-half, half], -DEEP_M, 0.0);
    let end = begin + 2.0 * around;
    w.put([begin, end], [-half, half], -0.9 * DEEP_M, rise);
    let beside = 0.5 * w.build.width_m + w.between(0.05, 0.15);
    let y = if w.side() > 0.0 {
        [beside, beside + 0.3]
    } else {
        [-beside - 0.3, -beside]
    };
    let top = rise + w.between(0.7, 1.1) * height;
    w.put([begin - 0.3, begin + 0.7], y, -0.8 * DEEP_M, top);
    w.done([begin + around, 0.0], None)
}

/// A ramp too slippery for the feet alone, between two walls for the hands.
pub(super) fn hand_corridor(w: &mut World) -> Drawn {
    let (height, around, half) = (w.build.height_m, w.around_m(), w.half_way_m());
    let angle = w.between(14.2, 15.5).to_radians();
    let (begin, length) = (around, w.between(0.9, 1.4) * height);
    w.put([-around, begin], [-half, half], -DEEP_M, 0.0);
    let rotation = Rotation3::from_euler_angles(0.0, -angle, 0.0);
    let along = Vector3::new(0.5 * length, 0.0, -0.5 * DEEP_M);
    let middle = Vector3::new(begin, 0.0, 0.0) + rotation * along;
    w.put_turned(middle, [length, 2.0 * half, DEEP_M], rotation);
    let (end, top) = (begin + length * angle.cos(), length * angle.sin());
    w.put([end, end + 2.0 * around], [-half, half], -0.9 * DEEP_M, top);
    let beside = 0.5 * w.build.width_m + w.between(0.02, 0.10);
    for y in [[beside, beside + 0.2], [-beside - 0.2, -beside]] {
        w.put(
            [begin - 0.3, end + 0.6],
            y,
            -0.8 * DEEP_M,
            top + 1.8 * height,
        );
    }
    Drawn {
        friction: Some([0.31, 0.6]),
        ..w.done([end + around, 0.0], None)
    }
}
