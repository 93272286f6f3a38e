//! Parts of the robot keep away from each other and from the environment:
//!
//!   d(a, b) ≥ clearance,   ∇d = n·(J_a − J_b)        (n the unit normal from b to a)
//!
//! A body in contact is excepted from the surface it touches and from the surfaces in the same
//! plane; from nothing else.

use nalgebra::Vector3;
use robot_model::collision::{BodyShape, Other, Proximity};

use crate::iterate::{Context, Iterate};
use crate::rows::{Constraint, Rows};

/// Pairs whose distance is watched.
#[derive(Default)]
pub(crate) struct Clearances {
    pub own: Vec<Proximity>,
    pub world: Vec<Proximity>,
}

/// Surfaces whose planes agree within this are one face to a patch that stands on one of them.
const SAME_PLANE_M: f64 = 0.015;
/// Cosine of the largest angle between their normals (5°).
const SAME_PLANE_COS: f64 = 0.9962;

impl Clearances {
    /// Looks for the pairs that are nearer than the prediction distance.
    pub fn update(&mut self, ctx: &Context, it: &Iterate) {
        let robot = ctx.robot();
        let prediction = ctx.config.prediction_m;
        self.own.clear();
        self.world.clear();
        robot
            .collision
            .self_proximities(robot, &it.kinematics, prediction, &mut self.own);
        let surfaces = &ctx.problem.environment.surfaces;
        let touches = |shape: BodyShape, obstacle: usize| {
            let Some(other) = surfaces.get(obstacle) else {
                return false;
            };
            ctx.problem
                .contacts
                .iter()
                .zip(&ctx.contacts)
                .any(|(contact, model)| {
                    model.body == shape.body
                        && contact
                            .place
                            .surface()
                            .is_some_and(|s| s == obstacle || same_plane(&surfaces[s], other))
                })
        };
        robot.collision.world_proximities(
            robot,
            &it.kinematics,
            &ctx.problem.environment.world,
            prediction,
            &touches,
            &mut self.world,
        );
    }

    pub fn rows(&mut self, ctx: &Context, it: &Iterate, rows: &mut Rows) {
        self.update(ctx, it);
        let robot = ctx.robot();
        let shapes = robot.collision.shapes();
        for (pairs, clearance) in [
            (&self.own, ctx.config.self_clearance_m),
            (&self.world, ctx.config.clearance_m),
        ] {
            for pair in pairs {
                let link = shapes[pair.a.shape].link.clone();
                let tag = match pair.b {
                    Other::Shape(b) => {
                        Constraint::SelfClearance(link, shapes[b.shape].link.clone())
                    }
                    Other::Obstacle(o) => {
                        Constraint::Clearance(link, ctx.problem.environment.body_names[o].clone())
                    }
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

/// Whether two surfaces are pieces of one plane, as far as a patch can tell.
pub(crate) fn same_plane(a: &surfaces::Surface, b: &surfaces::Surface) -> bool {
    let n = a.normal_W();
    let between = b.X_WS.translation.vector - a.X_WS.translation.vector;
    n.dot(&b.normal_W()) > SAME_PLANE_COS
        && n.dot(&between).abs() < SAME_PLANE_M
        && b.normal_W().dot(&between).abs() < SAME_PLANE_M
}
