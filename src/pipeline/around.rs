//! A way around walls that the border of a view cuts, where one is found.
//!
//! A plan through a place where such a wall would be, if it went on straight, is verified on the condition that it does
//! not. Its search goes on as if those walls, and no others, went on, from the stances and motions that keep off these:
//! nothing is lost where they end, and nothing is spent on plans that meet none.

use std::collections::BTreeSet;

use anyhow::Result;
use nalgebra::Point3;
use planner::{SearchResult, Status, Tree};
use posture::Environment;
use surfaces::{LookedThrough, Obstacle};

use super::attempt::{Run, Told};
use crate::start::assumed;
use crate::unseen::{Around, UNSEEN_M, Wall};

/// Searches at most: another way may meet other walls.
const SEARCHES_MAX: usize = 3;
/// Together they may spend so many times what the first one did, as far as the settings allow.
const SPENT_MAX: usize = 4;

impl Run<'_> {
    /// The plan that meets fewest walls that would go on, and these least, of those that are found once they do; and what
    /// was tried. A way is timed and verified where it is the best so far, or none is better.
    ///
    /// # Errors
    /// As [`Run::told`].
    pub fn around_walls(
        &mut self,
        (answer, tree): (SearchResult, Option<Tree>),
    ) -> Result<(Told, Option<Around>)> {
        let own = &self.posed.environment;
        let begun = Begun::new(&answer, tree);
        let met = self.walls(&answer)?;
        if !met.is_empty() {
            let (found, mut around) = self.kept_off(&met, begun)?;
            let mut best = match found {
                Some(found) => found,
                None => self.told(answer, own)?,
            };
            note(&mut best, &mut around, met);
            return Ok((best, Some(around)));
        }
        (self.options.stage)("verifying");
        let mut first = self.told(answer, own)?;
        if first.walls().is_empty() || !first.is_verified() {
            return Ok((first, None));
        }
        // Met between the moments that were looked at before.
        let met = first.walls().to_vec();
        let (found, mut around) = self.kept_off(&met, begun)?;
        first = found.unwrap_or(first);
        note(&mut first, &mut around, met);
        Ok((first, Some(around)))
    }

    /// A verified plan that meets fewer walls than these, or these less, if they go on; and what was tried.
    fn kept_off(&mut self, met: &[Wall], begun: Begun) -> Result<(Option<Told>, Around)> {
        (self.options.stage)("searching a way around walls that the view cuts");
        let mut planner = self.config.planner.clone();
        let Begun {
            mut spent,
            mut way_W,
            mut tree,
        } = begun;
        let mut left = spent.map(|n| SPENT_MAX * n);
        let mut around = Around {
            searches: 0,
            nodes_generated: 0,
            kept_off: Vec::new(),
        };
        let (mut least, mut straight, mut best) = (rests_on(met), ids(met), None);
        while around.searches < SEARCHES_MAX && least.0 > 0 && !left.contains(&0) {
            planner.nodes_max = planner.nodes_max.min(left[0]);
            planner.candidates_max = planner.candidates_max.min(left[1]);
            let environment = self.with_straight(&straight, &way_W)?;
            around.searches += 1;
            // A search that goes on counts what was spent before it.
            let before = if tree.is_some() { spent } else { [0; 2] };
            // That the robot cannot stand there says that there is no way around, and nothing of the plan.
            let Ok((other, grown)) = self.search(&environment, &planner, tree) else {
                break;
            };
            let other_begun = Begun::new(&other, grown);
            (spent, tree) = (other_begun.spent, other_begun.tree);
            around.nodes_generated += spent[0] - before[0];
            left = std::array::from_fn(|k| left[k].saturating_sub(spent[k] - before[k]));
            if other.status != Status::Found {
                break;
            }
            let walls = self.walls(&other)?;
            let known = straight.len();
            straight.extend(ids(&walls));
            way_W.extend(other_begun.way_W);
            if rests_on(&walls) < least {
                let other = self.told(other, &environment)?;
                straight.extend(ids(other.walls()));
                if other.is_verified() && rests_on(other.walls()) < least {
                    least = rests_on(other.walls());
                    best = Some(other);
                }
            }
            if straight.len() == known {
                break;
            }
        }
        Ok((best, around))
    }

    /// The scene's surroundings with bodies where walls of these names would go on about a way and nothing was seen, but
    /// not where the robot stands at its start.
    fn with_straight(
        &self,
        walls: &BTreeSet<String>,
        way_W: &[Point3<f64>],
    ) -> Result<Environment> {
        let (posed, config) = (self.posed, self.config);
        let is_unseen = |p_W: &Point3<f64>| {
            let far_m = |view: &LookedThrough| view.unseen_m(p_W);
            posed.looked.iter().all(|view| far_m(view) > UNSEEN_M)
        };
        let (clearance_m, raised_m) = (config.posture.clearance_m, config.motion.swing_height_m);
        let may_be = |body_W: &[Point3<f64>]| {
            !assumed::meets(body_W, &posed.robot, &posed.stand, clearance_m, raised_m)
        };
        let mut terrain = posed.terrain.clone();
        let cut = terrain.faces.iter();
        let cut = cut.filter(|face| walls.contains(face.id.as_str()));
        let bodies = cut.flat_map(|face| {
            let bodies = face.bodies_beyond_W(way_W, is_unseen, may_be).into_iter();
            bodies.enumerate().map(|(k, points_W)| Obstacle {
                id: format!("{}/straight{k}", face.id),
                points_W,
                surface: None,
                assumed: true,
            })
        });
        terrain.obstacles.extend(bodies.collect::<Vec<_>>());
        let thickness_m = config.surfaces.body.thickness_m;
        Ok(Environment::new(
            terrain,
            thickness_m,
            config.posture.edge_sigmas,
        )?)
    }
}

/// What another search begins with.
struct Begun {
    /// Contact sets and posture problems so far.
    spent: [usize; 2],
    /// Where the base is in the stances found so far, m.
    way_W: Vec<Point3<f64>>,
    tree: Option<Tree>,
}

impl Begun {
    fn new(answer: &SearchResult, tree: Option<Tree>) -> Self {
        let summary = &answer.summary;
        let path = answer.path.iter();
        Self {
            spent: [summary.nodes_generated, summary.candidates_solved],
            way_W: path.map(|stance| stance.posture.q.p_WB.into()).collect(),
            tree,
        }
    }
}

/// Notes in a plan's certificate which of the walls that the first one would meet it keeps off, and which not.
fn note(plan: &mut Told, around: &mut Around, met_first: Vec<Wall>) {
    let met = ids(plan.walls());
    around.kept_off = met_first;
    around.kept_off.retain(|wall| !met.contains(&wall.face));
    let notes = &mut plan.certificate.notes;
    notes.extend(around.kept_off.iter().map(|wall| {
        format!(
            "planned again, to keep off {} where it may go straight on beyond the border of the view: the way that was \
             found first would be {:.2} m inside it",
            wall.face, wall.place.inside_m
        )
    }));
    if !met.is_empty() {
        let met: Vec<String> = met.into_iter().collect();
        notes.push(format!(
            "no way was found around {} as if straight on beyond the border of the view ({} contact sets)",
            met.join(", "),
            around.nodes_generated
        ));
    }
}

/// Their names.
fn ids(walls: &[Wall]) -> BTreeSet<String> {
    walls.iter().map(|wall| wall.face.clone()).collect()
}

/// What a plan rests on, to be the least: how many walls it would meet, and how far inside one it would be at most, m.
fn rests_on(walls: &[Wall]) -> (usize, f64) {
    let inside_m = walls.iter().map(|wall| wall.place.inside_m);
    (walls.len(), inside_m.fold(0.0, f64::max))
}

#[cfg(test)]
mod tests;
