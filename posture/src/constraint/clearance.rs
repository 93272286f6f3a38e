//! Parts of the robot keep away from each other and from the environment:
//!
//!   d(a, b) ≥ clearance,   ∇d = n·(J_a − J_b)        (n the unit normal from b to a)
//!
//! A link in contact may touch what lies wholly behind the plane it touches (the surface's own body,
//! its neighbours in the plane, the riser under a tread), with a ball also ground that rises gently beside it, and
//! nothing else; links that carry a sole or a palm may come as near to it as to each other.

use nalgebra::{Point3, Vector3};
use robot_model::Configuration;
use robot_model::collision::{BodyShape, Other, Proximity};

use crate::PlacedShape;
use crate::iterate::{Context, Iterate};
use crate::rows::{Rows, Tag};

/// Distance within which pairs of bodies are looked at, or twice what they keep where that is more, m.
const PREDICTION_M: f64 = 0.10;
/// A distance to what a link in contact may touch is a row from here on to its bound, m; where it is to stay off, from
/// twice that on.
const CONTACT_PREDICTION_M: f64 = 2e-3;

/// Pairs whose distance is watched.
#[derive(Default)]
pub(crate) struct Clearances {
    pub own: Vec<Proximity>,
    pub world: Vec<Proximity>,
    /// What a link in contact may touch, each with its least distance, m.
    touching: Vec<(Proximity, f64)>,
    /// Whether there is ground beside a ball among it that rises over its contact.
    is_beside: bool,
    /// Where they were looked for.
    at: Option<Configuration>,
}

impl Clearances {
    /// Looks for the pairs that are nearer than the prediction distance, once a configuration.
    pub fn update(&mut self, ctx: &Context, it: &Iterate) {
        if self.at.as_ref() == Some(&it.q) {
            return;
        }
        self.at = Some(it.q.clone());
        let robot = ctx.robot();
        self.own.clear();
        self.world.clear();
        self.touching.clear();
        self.is_beside = false;
        let (collision, kin) = (&robot.collision, &it.kinematics);
        let most_m = ctx.config.clearance_m.max(ctx.config.self_clearance_m);
        let within = PREDICTION_M.max(2.0 * most_m);
        collision.self_proximities(kin, within, &mut self.own);
        let environment = ctx.problem.environment;
        let contacts = ctx.problem.contacts.iter();
        let touches = contacts.filter_map(|c| Some((&robot.patches[c.patch], c.face?)));
        let apart_m = ctx.config.carrying_clearance_m();
        let behind = |shape: BodyShape, obstacle: usize| {
            let shape = &collision.shapes()[shape.shape];
            let least_m = touches.clone().filter_map(|touch| {
                environment.contact_distance_m(robot, touch, shape, obstacle, apart_m)
            });
            least_m.min_by(f64::total_cmp)
        };
        let beside = |pair: &Proximity, obstacle: usize| {
            let (shape, X_WG) = (
                &collision.shapes()[pair.a.shape],
                collision.X_WG(kin, pair.a.shape),
            );
            let placed = PlacedShape {
                geometry: &shape.geometry,
                X_BG: &shape.X_BG,
                X_WG: &X_WG,
                is_pad: shape.is_pad,
                nearest_W: Point3::from(pair.p_a_W),
                normal_W: pair.normal_W,
            };
            let own = touches
                .clone()
                .filter(|(patch, _)| patch.body == pair.a.body);
            let least_m = own.filter_map(|on| environment.beside_contact_m(on, &placed, obstacle));
            least_m.min_by(f64::total_cmp)
        };
        let never = |shape, obstacle| behind(shape, obstacle) == Some(f64::NEG_INFINITY);
        let mut found = Vec::new();
        collision.world_proximities(kin, environment.world(), within, &never, &mut found);
        for pair in found {
            let Other::Obstacle(obstacle) = pair.b else {
                continue;
            };
            let may_touch = behind(pair.a, obstacle).or_else(|| {
                let least_m = beside(&pair, obstacle)?;
                self.is_beside = true;
                Some(least_m)
            });
            match may_touch {
                None => self.world.push(pair),
                Some(least_m) if pair.distance < least_m + CONTACT_PREDICTION_M.max(least_m) => {
                    self.touching.push((pair, least_m));
                }
                Some(_) => {}
            }
        }
    }

    /// The least distance of what is to be kept away from, m. Whether it is ground beside a ball or a thing depends on the
    /// pieces that bodies are cut into: where there is any, no more is said than what is kept from things, `clearance_m`.
    pub fn clearance_m(&self, clearance_m: f64) -> Option<f64> {
        let world = self.world.iter().map(|pair| pair.distance);
        let beside = self.is_beside.then_some(clearance_m);
        world.chain(beside).min_by(f64::total_cmp)
    }

    pub fn rows(&mut self, ctx: &Context, it: &Iterate, rows: &mut Rows) {
        self.update(ctx, it);
        let own = self.own.iter().map(|p| (p, ctx.config.self_clearance_m));
        let world = self.world.iter().map(|p| (p, ctx.config.clearance_m));
        let touching = self.touching.iter().map(|(p, least_m)| (p, *least_m));
        for (pair, least_m) in own.chain(world).chain(touching) {
            let tag = match pair.b {
                Other::Shape(b) => Tag::SelfClearance(pair.a.shape, b.shape),
                Other::Obstacle(o) => Tag::Clearance(pair.a.shape, o),
            };
            let row = rows.push(tag, pair.distance, least_m, f64::INFINITY);
            if row.is_empty() {
                continue;
            }
            let n: Vector3<f64> = pair.normal_W;
            ctx.add_point_gradient(it, pair.a.body, &pair.p_a_W, &n, row);
            if let Other::Shape(b) = pair.b {
                ctx.add_point_gradient(it, b.body, &pair.p_b_W, &-n, row);
            }
        }
    }
}
