//! Where a plan moves through space that no view of its scans looked through.
//!
//! Beside the start, below and beyond the border of the views the robot goes through such space in nearly every plan:
//! that is told. Where a wall that the border of a view cuts would be met if it went straight on, the plan rests on
//! its ending there.

mod footholds;
mod walls;

use std::fmt;

use anyhow::Result;
use footholds::HiddenFoothold;
use nalgebra::{Point3, Vector3};
use plan::{Motion, Plan};
use robot_model::collision::{Hull, ShapeGeometry};
use robot_model::{Kinematics, Robot};
use schemars::JsonSchema;
use serde::Serialize;
use surfaces::{Face, LookedThrough};
use verify::World;
use walls::CutWalls;

pub use walls::walls;

/// Time between the samples of a motion that are looked at, s.
const EVERY_S: f64 = 0.2;
/// Places farther from what was seen are surely unseen, m: what was seen is known to so much.
pub const UNSEEN_M: f64 = 0.05;
/// The hull of the robot at its start leaves out what sticks out of it by less, m.
const START_M: f64 = 0.005;
const START_VERTICES: usize = 40;

/// A place of the robot on its way.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Place {
    /// The link.
    pub link: String,
    /// Index of the stance that the robot is in, or comes from.
    pub stance: usize,
    /// Time of the motion, s; of a stance where there is no motion.
    pub t_s: Option<f64>,
    /// The link's foremost point in W, m.
    pub p_W: [f64; 3],
    /// How far inside the unseen space, or behind the wall's plane, m.
    pub inside_m: f64,
}

/// A wall that would be met if it went on straight beyond the border of the view.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Wall {
    /// The face.
    pub face: String,
    /// How far beyond what was seen of it, m.
    pub beyond_m: f64,
    /// Where the robot would be farthest inside it: behind its plane.
    pub place: Place,
}

/// Where a robot moves through space that no view looked through.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Unseen {
    /// Part of the way's time (of its stances without a motion) at which some link is farther than 0.05 m inside.
    pub part: f64,
    /// Where it is farthest inside: from the nearest place that was looked through, and from the hull of the robot at
    /// its start.
    pub deepest: Option<Place>,
    /// Walls that the border of a view cuts, and that would be met if they went straight on.
    pub walls: Vec<Wall>,
    /// Faces that are touched where another one hides them from every view.
    pub hidden: Vec<HiddenFoothold>,
}

/// How a way was sought around walls that would be met if they went straight on beyond the border of a view.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Around {
    /// Searches with walls that went on.
    pub searches: usize,
    /// Contact sets with a posture in these.
    pub nodes_generated: usize,
    /// Walls that the plan as it was found first would meet, and that the plan now keeps off.
    pub kept_off: Vec<Wall>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.p_W;
        write!(f, "{} at ({x:.2}, {y:.2}, {z:.2}) m, ", self.link)?;
        match self.t_s {
            Some(t_s) => write!(f, "{t_s:.1} s, from stance {}", self.stance),
            None => write!(f, "stance {}", self.stance),
        }
    }
}

impl Unseen {
    /// Tells it of a plan's world: what the plan rests on, and what to know.
    pub fn tell(&self, world: &mut World) {
        for Wall {
            face,
            beyond_m,
            place,
        } in &self.walls
        {
            world.leaves_open(format!(
                "if {face}, which the border of the view cuts, does not go on straight for {beyond_m:.2} m: the robot would \
                 be {:.2} m inside it ({place})",
                place.inside_m
            ));
        }
        for HiddenFoothold {
            face,
            under,
            patch,
            stance,
        } in &self.hidden
        {
            world.leaves_open(format!(
                "if {face} goes on to below the edge of {under}, which hides it there from every view: {patch} rests on \
                 that in stance {stance}"
            ));
        }
        if let Some(deepest) = &self.deepest {
            world.tells(format!(
                "the robot goes through space that no view looked into: {:.0} % of the way, at most {:.2} m inside ({deepest})",
                100.0 * self.part,
                deepest.inside_m
            ));
        }
    }
}

/// Where a plan moves through space that none of the views looked through; `None` without views.
///
/// # Errors
/// A configuration that is not the robot's.
pub fn unseen(
    plan: &Plan,
    motion: Option<&Motion>,
    robot: &Robot,
    views: &[LookedThrough],
) -> Result<Option<Unseen>> {
    let moments = moments(plan, motion);
    match moments.is_empty() || views.is_empty() {
        true => Ok(None),
        false => {
            let mut found = along(&moments, robot, &plan.faces, views)?;
            found.hidden = footholds::hidden(plan);
            Ok(Some(found))
        }
    }
}

/// The points of every shape of a robot that are looked at, in its own frame, m.
struct Outlines(Vec<Vec<Point3<f64>>>);

impl Outlines {
    fn new(robot: &Robot) -> Self {
        let shapes = robot.collision.shapes().iter();
        Self(shapes.map(|shape| outline_G(&shape.geometry)).collect())
    }

    /// In W, by shape, at a configuration.
    fn at_W(&self, robot: &Robot, q: &[f64]) -> Result<Vec<Vec<Point3<f64>>>> {
        let kinematics = Kinematics::new(robot, &robot.configuration(q)?);
        let placed = self.0.iter().enumerate().map(|(shape, points)| {
            let X_WG = robot.collision.X_WG(&kinematics, shape);
            points.iter().map(|p| X_WG * p).collect()
        });
        Ok(placed.collect())
    }
}

/// Stance, time of the motion and configuration.
type Moment<'a> = (usize, Option<f64>, &'a [f64]);

/// Where a robot moves through space that none of the views looked through, from its start on.
fn along(
    moments: &[Moment<'_>],
    robot: &Robot,
    faces: &[Face],
    views: &[LookedThrough],
) -> Result<Unseen> {
    let outlines = Outlines::new(robot);
    let shapes_W = |q: &[f64]| outlines.at_W(robot, q);
    let start_W: Vec<Point3<f64>> = match moments.first() {
        Some((_, _, q)) => shapes_W(q)?.concat(),
        None => return Ok(Unseen::default()),
    };
    let start = StartHull::new(&start_W);
    let mut walls = CutWalls::new(faces, &start_W);
    let mut found = Unseen::default();
    let mut inside = 0_usize;
    for (stance, t_s, q) in moments {
        let mut is_inside = false;
        for (shape, points) in robot.collision.shapes().iter().zip(shapes_W(q)?) {
            for p_W in points {
                let far_m = |view: &LookedThrough| view.unseen_m(&p_W);
                let unseen_m = || views.iter().map(far_m).fold(f64::INFINITY, f64::min);
                let place = |inside_m: f64| Place {
                    link: shape.link.clone(),
                    stance: *stance,
                    t_s: *t_s,
                    p_W: p_W.into(),
                    inside_m,
                };
                // Views are asked only where they may tell more than is known.
                let deepest_m = found.deepest.as_ref().map_or(UNSEEN_M, |at| at.inside_m);
                let outside_m = start.outside_m(&p_W);
                if outside_m > if is_inside { deepest_m } else { UNSEEN_M } {
                    let inside_m = outside_m.min(unseen_m());
                    is_inside |= inside_m > UNSEEN_M;
                    if inside_m > deepest_m {
                        found.deepest = Some(place(inside_m));
                    }
                }
                walls.look(&p_W, unseen_m, place);
            }
        }
        inside += usize::from(is_inside);
    }
    found.part = inside as f64 / moments.len() as f64;
    found.walls = walls.met();
    Ok(found)
}

/// Stance, time and configuration of each moment that is looked at.
fn moments<'a>(plan: &'a Plan, motion: Option<&'a Motion>) -> Vec<Moment<'a>> {
    let Some(motion) = motion else {
        let stances = plan.stances.iter();
        return stances
            .map(|stance| (stance.index, None, &stance.q[..]))
            .collect();
    };
    let step = (EVERY_S / motion.dt_s).round().max(1.0) as usize;
    let stance = |t_s| {
        motion
            .phase_at(t_s)
            .map_or(0, |phase| motion.phases[phase].from_stance)
    };
    let samples = motion.samples.iter().step_by(step);
    samples
        .map(|sample| (stance(sample.t_s), Some(sample.t_s), &sample.q[..]))
        .collect()
}

/// The points of a shape that lie farthest along the axes and between them.
fn outline_G(shape: &ShapeGeometry) -> Vec<Point3<f64>> {
    let steps = || [-1.0, 0.0, 1.0].into_iter();
    let ways = steps()
        .flat_map(|x| steps().flat_map(move |y| steps().map(move |z| Vector3::new(x, y, z))));
    let mut points: Vec<Point3<f64>> = Vec::new();
    for way in ways.filter(|way| way.norm() > 0.0) {
        let point = shape.support(&way);
        if !points.contains(&point) {
            points.push(point);
        }
    }
    points
}

/// The hull of the robot at its start: outward normals in W, and the distances of its planes from the origin, m.
struct StartHull(Vec<(Vector3<f64>, f64)>);

impl StartHull {
    /// Of a robot that has none everything is outside.
    fn new(points_W: &[Point3<f64>]) -> Self {
        let Ok(hull) = Hull::simplified(points_W, START_M, START_VERTICES) else {
            return Self(Vec::new());
        };
        let planes = hull.triangles().iter().zip(hull.face_normals());
        let planes = planes.map(|(triangle, normal)| {
            let corner = hull.vertices()[triangle[0] as usize];
            (normal, normal.dot(&corner.coords) + hull.shortfall_m())
        });
        Self(planes.collect())
    }

    /// About how far outside a point is, m: the least that it may be.
    fn outside_m(&self, p_W: &Point3<f64>) -> f64 {
        let off = self
            .0
            .iter()
            .map(|(normal, far_m)| normal.dot(&p_W.coords) - far_m);
        match self.0.is_empty() {
            true => f64::INFINITY,
            false => off.fold(f64::NEG_INFINITY, f64::max),
        }
    }
}

#[cfg(test)]
pub(crate) mod room;
#[cfg(test)]
mod tests;
