//! How much room there is about the base: for the trunk, for all of the robot, and under what hangs over it.

use std::cell::RefCell;
use std::collections::BTreeMap;

use nalgebra::{Isometry3, Point3, Vector2, Vector3};
use robot_model::Kinematics;
use robot_model::collision::{ShapeGeometry, closest};

use crate::context::SearchContext;
use crate::crouch::deepest_m;

/// What stands no higher over the ground than this part of the legs' height is stepped over.
pub(crate) const OVER_LEGS: f64 = 0.4;
/// Places nearer along the level plane than this part of the lattice's, and levels nearer than this part, have the
/// same room.
const PLACES: f64 = 0.5;
const LEVELS: f64 = 0.3;
/// Depths to which the base is lowered, from nothing to the deepest.
const DEPTHS: usize = 8;

/// How much room there is about the base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Room {
    /// Whether there is enough for all of the robot as it is carried usually, not for the trunk alone.
    pub is_wide: bool,
    /// How much lower than usual the base is to be, so that nothing overhead is in the way, m.
    pub crouch_m: f64,
}

/// The room about all places.
pub(crate) struct Rooms<'a> {
    context: &'a SearchContext<'a>,
    /// How much room there is, by cell and level.
    known: RefCell<BTreeMap<(i64, i64, i64), Option<Room>>>,
    trunk: Trunk,
    /// Height of the base over the ground, and of what is stepped over, m.
    legs_m: f64,
    over_m: f64,
    /// How much lower than usual the base can be, m.
    deepest_m: f64,
}

impl<'a> Rooms<'a> {
    pub fn new(context: &'a SearchContext<'a>, legs_m: f64, over_m: f64) -> Self {
        Self {
            context,
            known: RefCell::default(),
            trunk: Trunk::new(context, legs_m),
            legs_m,
            over_m,
            deepest_m: deepest_m(context, legs_m),
        }
    }

    /// The room about the base at a place; nothing where the trunk has none.
    pub fn at(&self, p: &Vector2<f64>, ground_m: f64) -> Option<Room> {
        let round = |x: f64, cell: f64| (x / cell).round() as i64;
        let cell_m = PLACES * self.context.places_m();
        let level_m = LEVELS * self.context.levels_m();
        let key = (
            round(p.x, cell_m),
            round(p.y, cell_m),
            round(ground_m, level_m),
        );
        if let Some(&room) = self.known.borrow().get(&key) {
            return room;
        }
        let room = self.look(p, ground_m);
        self.known.borrow_mut().insert(key, room);
        room
    }

    fn look(&self, p: &Vector2<f64>, ground_m: f64) -> Option<Room> {
        let low = ground_m + self.over_m;
        let base_m = ground_m + self.legs_m;
        let trunk = &self.trunk;
        // Where the head has room at no depth something stands beside it: that is the trunk's business.
        let depths = (0..=DEPTHS).map(|k| self.deepest_m * k as f64 / DEPTHS as f64);
        let crouch_m = depths
            .into_iter()
            .find(|depth| self.is_free(p, trunk.head_m, [low, base_m + trunk.tall_m - depth]))
            .unwrap_or(0.0);
        let heights = [low, base_m + trunk.top_m - crouch_m];
        let is_wide = self.is_free(p, trunk.wide_m, heights);
        (is_wide || self.is_free(p, trunk.half_m, heights)).then_some(Room { is_wide, crouch_m })
    }

    /// Whether no body is in the upright box of half a width about a place, between two heights.
    fn is_free(&self, p: &Vector2<f64>, half_m: f64, [low, high]: [f64; 2]) -> bool {
        let high = high.max(low + 0.02);
        let at = Point3::new(p.x, p.y, 0.5 * (low + high));
        let X_WP = Isometry3::translation(at.x, at.y, at.z);
        let world = self.context.request.environment.world();
        let half = Vector3::new(half_m, half_m, 0.5 * (high - low));
        let probe = ShapeGeometry::Box {
            half_extents_m: half,
        };
        let near = world.near(&(at - half), &(at + half), 0.0);
        near.iter().all(|&k| {
            let body = &world.obstacles()[k];
            closest(&probe, &X_WP, body.geometry(), body.pose(), 0.0)
                .is_none_or(|found| found.distance > 0.0)
        })
    }
}

/// What is over the feet, in the posture that is usual, m.
struct Trunk {
    /// Half the width of the base's own shapes, of all of the robot, and of what is over the base.
    half_m: f64,
    wide_m: f64,
    head_m: f64,
    /// Top of the base's own shapes and of all of the robot over the base's origin.
    top_m: f64,
    tall_m: f64,
}

impl Trunk {
    fn new(context: &SearchContext, legs_m: f64) -> Self {
        let robot = context.request.robot;
        let kinematics = Kinematics::new(robot, &context.upright);
        let (mut half_m, mut wide_m, mut top_m) = (f64::INFINITY, 0.0_f64, 0.0_f64);
        let mut tall_m = 0.0_f64;
        let collision = &robot.collision;
        for (i, shape) in collision.shapes().iter().enumerate() {
            let X_WG = collision.X_WG(&kinematics, i);
            let most = |direction: Vector3<f64>| {
                let support = shape
                    .geometry
                    .support(&(X_WG.rotation.inverse() * direction));
                (X_WG * support).coords.dot(&direction)
            };
            let top = most(Vector3::z());
            tall_m = tall_m.max(top);
            if shape.body == 0 {
                half_m = half_m.min(most(Vector3::y()).max(most(-Vector3::y())));
                top_m = top_m.max(top);
            }
            if top > (OVER_LEGS - 1.0) * legs_m {
                let axes = [Vector3::x(), Vector3::y()].into_iter();
                wide_m = axes.fold(wide_m, |m, d| m.max(most(d)).max(most(-d)));
            }
        }
        let feet = context.feet.iter();
        let apart_m = feet.fold(0.05, |m: f64, f| m.max(context.offset(*f).y.abs()));
        let (half_m, wide_m) = (half_m.clamp(0.0, apart_m), wide_m.max(apart_m));
        Self {
            half_m,
            wide_m,
            head_m: 0.5 * (half_m + wide_m),
            top_m,
            tall_m,
        }
    }
}
