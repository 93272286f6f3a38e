//! Parts of the robot keep away from each other and from the environment:
//!
//!   d(a, b) ≥ clearance,   ∇d = n·(J_a − J_b)        (n the unit normal from b to a)
//!
//! A link in contact is excepted from what lies wholly behind the plane it touches (the surface's
//! own body, its neighbours in the plane, the riser under a tread); from nothing else.

use nalgebra::Vector3;
use robot_model::Configuration;
use robot_model::collision::{BodyShape, Other, Proximity};

use crate::iterate::{Context, Iterate};
use crate::rows::{Rows, Tag};

/// Distance within which pairs of bodies are looked at, m.
const PREDICTION_M: f64 = 0.10;

/// Pairs whose distance is watched.
#[derive(Default)]
pub(crate) struct Clearances {
    pub own: Vec<Proximity>,
    pub world: Vec<Proximity>,
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
        let (collision, kin, within) = (&robot.collision, &it.kinematics, PREDICTION_M);
        collision.self_proximities(kin, within, &mut self.own);
        let environment = ctx.problem.environment;
        let touches = |shape: BodyShape, obstacle: usize| {
            let mut contacts = ctx.problem.contacts.iter().zip(&ctx.contacts);
            let behind = |face| environment.is_behind(face, obstacle);
            contacts.any(|(c, model)| model.body == shape.body && c.face.is_some_and(behind))
        };
        let world = environment.world();
        collision.world_proximities(kin, world, within, &touches, &mut self.world);
    }

    pub fn rows(&mut self, ctx: &Context, it: &Iterate, rows: &mut Rows) {
        self.update(ctx, it);
        for (pairs, clearance) in [
            (&self.own, ctx.config.self_clearance_m),
            (&self.world, ctx.config.clearance_m),
        ] {
            for pair in pairs {
                let tag = match pair.b {
                    Other::Shape(b) => Tag::SelfClearance(pair.a.shape, b.shape),
                    Other::Obstacle(o) => Tag::Clearance(pair.a.shape, o),
                };
                let row = rows.push(tag, pair.distance, clearance, f64::INFINITY);
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
}
