//! Proofs as they are written down, for a checker that knows nothing of how they were found.

use plan::{ContactPlace, Multipliers, Near, PlaceFreedom, Pose, Proof, Refutation};

use super::{apart, colliding, convex, ranges};
use crate::contact::Freedom;
use crate::iterate::{Context, Relaxed};
use crate::rows::{Constraint, Tag};
use crate::{Config, Problem};

/// The proof that a problem has no posture, where one is found: of every [`crate::Outcome::Infeasible`].
pub fn refutation(problem: &Problem, config: &Config) -> Option<Refutation> {
    let ctx = Context::new(problem, config, Relaxed::default());
    let by_cones = || convex::multipliers(&ctx, &ranges(&ctx)).map(Proof::Multipliers);
    let proof = far_apart(&ctx).or_else(|| too_near(&ctx)).or_else(by_cones);
    let contacts = problem.contacts.iter().map(|contact| ContactPlace {
        patch: problem.robot.patches[contact.patch].name.clone(),
        X_WC: Pose::from(&contact.X_WC),
        freedom: match contact.freedom {
            Freedom::Fixed => PlaceFreedom::Fixed,
            Freedom::Yaw => PlaceFreedom::Yaw,
            Freedom::Within(_) => PlaceFreedom::Elsewhere,
        },
        friction: contact.friction,
        loaded: contact.loaded,
    });
    Some(Refutation {
        contacts: contacts.collect(),
        required: config.into(),
        proof: proof?,
    })
}

/// Two places along the line between which the robot is not long enough.
fn far_apart(ctx: &Context) -> Option<Proof> {
    let (_, [a, b]) = apart(ctx)?;
    let contacts = &ctx.problem.contacts;
    let [p_a, p_b] = [a, b].map(|i| contacts[i].X_WC.translation.vector);
    let along = 0.5 * (p_b - p_a).normalize();
    let joints = ctx.robot().bodies.len() - 1;
    let mut places = vec![[0.0; 3]; contacts.len()];
    (places[a], places[b]) = (along.into(), (-along).into());
    Some(Proof::Multipliers(Multipliers {
        places,
        force: [0.0; 3],
        moment: [0.0; 3],
        about: p_a.into(),
        torques: vec![0.0; joints],
        turns: vec![[[0.0; 3]; 3]; joints],
    }))
}

/// Links too near to each other, or to a body of the environment.
fn too_near(ctx: &Context) -> Option<Proof> {
    let (tag, _) = colliding::worst(ctx)?;
    let (link, other) = match (ctx.constraint(tag), tag) {
        (Constraint::SelfClearance(link, other), _) => (link, Near::Link(other)),
        (Constraint::Clearance(link, id), Tag::Clearance(_, body)) => {
            let body = &ctx.problem.environment.world().obstacles()[body];
            let vertices = body.geometry().vertices().into_iter();
            let points_W = vertices.map(|v| (body.pose() * v).into()).collect();
            (link, Near::Body { id, points_W })
        }
        _ => return None,
    };
    Some(Proof::Colliding { link, other })
}
