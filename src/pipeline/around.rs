//! A way around walls that the border of a view cuts, where one is found.
//!
//! A plan through a place where such a wall would be, if it went on straight, is verified on the condition that it does
//! not. It is planned again as if those walls, and no others, went on: nothing is lost where they end, and nothing is
//! spent on plans that meet none.

use std::collections::BTreeSet;

use anyhow::Result;
use nalgebra::Point3;
use planner::Status;
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
    /// was tried.
    ///
    /// # Errors
    /// As [`Run::told`].
    pub fn around_walls(&mut self, first: Told) -> Result<(Told, Option<Around>)> {
        if first.walls().is_empty() || !first.is_verified() {
            return Ok((first, None));
        }
        (self.options.stage)("searching a way around walls that the view cuts");
        let mut planner = self.config.planner.clone();
        let spent = &first.answer.summary;
        let mut left = [spent.nodes_generated, spent.candidates_solved].map(|n| SPENT_MAX * n);
        let mut around = Around {
            searches: 0,
            nodes_generated: 0,
            kept_off: Vec::new(),
        };
        let met_first = first.walls().to_vec();
        let ids = |walls: &[Wall]| -> BTreeSet<String> {
            walls.iter().map(|wall| wall.face.clone()).collect()
        };
        let mut way_W = way_W(&first);
        let (mut best, mut straight) = (first, ids(&met_first));
        while around.searches < SEARCHES_MAX && !best.walls().is_empty() && !left.contains(&0) {
            planner.nodes_max = planner.nodes_max.min(left[0]);
            planner.candidates_max = planner.candidates_max.min(left[1]);
            let environment = self.with_straight(&straight, &way_W)?;
            around.searches += 1;
            // That the robot cannot stand there says that there is no way around, and nothing of the plan.
            let Ok(answer) = self.search(&environment, &planner) else {
                break;
            };
            let spent = &answer.summary;
            around.nodes_generated += spent.nodes_generated;
            left[0] = left[0].saturating_sub(spent.nodes_generated);
            left[1] = left[1].saturating_sub(spent.candidates_solved);
            if answer.status != Status::Found {
                break;
            }
            let other = self.told(answer)?;
            let before = straight.len();
            straight.extend(ids(other.walls()));
            way_W.extend(self::way_W(&other));
            if other.is_verified() && rests_on(&other) < rests_on(&best) {
                best = other;
            }
            if straight.len() == before {
                break;
            }
        }
        let met = ids(best.walls());
        around.kept_off = met_first;
        around.kept_off.retain(|wall| !met.contains(&wall.face));
        let notes = &mut best.certificate.notes;
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
        Ok((best, Some(around)))
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

/// What a plan rests on, to be the least: how many walls it would meet, and how far inside one it would be at most, m.
fn rests_on(told: &Told) -> (usize, f64) {
    let inside_m = told.walls().iter().map(|wall| wall.place.inside_m);
    (told.walls().len(), inside_m.fold(0.0, f64::max))
}

/// Where the base is in its stances, m.
fn way_W(told: &Told) -> Vec<Point3<f64>> {
    let path = told.answer.path.iter();
    path.map(|stance| stance.posture.q.p_WB.into()).collect()
}

#[cfg(test)]
mod tests;
