//! The walls that the border of a view cuts, and that would be met if they went straight on.

use std::f64::consts::PI;

use anyhow::Result;
use nalgebra::{Point3, Vector3};
use robot_model::Robot;
use surfaces::{EdgeKind, Face, LookedThrough, Source, WALL_RAD};

use super::{Outlines, Place, UNSEEN_M, Wall};

/// Of the samples of a way that is not in time, every so manieth is looked at: the ends of phases and their middles.
const EVERY_SAMPLES: usize = 40;

/// The walls that would be met on a way, not in time yet, if they went straight on: stances that it goes out from, each with
/// a configuration, from the start on.
///
/// # Errors
/// A configuration that is not the robot's.
pub fn walls<'q>(
    way: impl Iterator<Item = (usize, &'q [f64])>,
    robot: &Robot,
    faces: &[Face],
    views: &[LookedThrough],
) -> Result<Vec<Wall>> {
    if views.is_empty() || !faces.iter().any(is_cut_wall) {
        return Ok(Vec::new());
    }
    let outlines = Outlines::new(robot);
    let mut walls: Option<CutWalls> = None;
    for (stance, q) in way.step_by(EVERY_SAMPLES) {
        let shapes_W = outlines.at_W(robot, q)?;
        let walls = walls.get_or_insert_with(|| CutWalls::new(faces, &shapes_W.concat()));
        for (shape, points) in robot.collision.shapes().iter().zip(shapes_W) {
            for p_W in points {
                let far_m = |view: &LookedThrough| view.unseen_m(&p_W);
                let unseen_m = || views.iter().map(far_m).fold(f64::INFINITY, f64::min);
                let place = |inside_m: f64| Place {
                    link: shape.link.clone(),
                    stance,
                    t_s: None,
                    p_W: p_W.into(),
                    inside_m,
                };
                walls.look(&p_W, unseen_m, place);
            }
        }
    }
    Ok(walls.map_or_else(Vec::new, CutWalls::met))
}

/// The walls that borders of views cut, and where each would be met the deepest.
pub(super) struct CutWalls<'a>(Vec<CutWall<'a>>);

struct CutWall<'a> {
    face: &'a Face,
    normal_W: Vector3<f64>,
    far_m: f64,
    /// How far behind its plane the robot is at its start, m.
    at_start_m: f64,
    met: Option<Wall>,
}

impl<'a> CutWalls<'a> {
    /// Of these faces, those that the robot does not surely stand in at its start.
    pub fn new(faces: &'a [Face], start_W: &[Point3<f64>]) -> Self {
        let walls = faces.iter().filter(|face| is_cut_wall(face)).map(|face| {
            let normal_W = face.normal_W();
            let far_m = normal_W.dot(&face.X_WF.translation.vector);
            let behind = start_W.iter().map(|p| far_m - normal_W.dot(&p.coords));
            CutWall {
                face,
                normal_W,
                far_m,
                at_start_m: behind.fold(0.0, f64::max),
                met: None,
            }
        });
        Self(walls.filter(|wall| wall.at_start_m <= UNSEEN_M).collect())
    }

    /// Looks at a point of the robot.
    pub fn look(
        &mut self,
        p_W: &Point3<f64>,
        unseen_m: impl Fn() -> f64,
        place: impl Fn(f64) -> Place,
    ) {
        for wall in &mut self.0 {
            let behind_m = wall.far_m - wall.normal_W.dot(&p_W.coords);
            let deepest_m = wall
                .met
                .as_ref()
                .map_or(wall.at_start_m, |met| met.place.inside_m);
            if behind_m > deepest_m
                && let Some(beyond_m) = wall.face.goes_on_m(p_W)
                && unseen_m() > UNSEEN_M
            {
                wall.met = Some(Wall {
                    face: wall.face.id.to_string(),
                    beyond_m,
                    place: place(behind_m),
                });
            }
        }
    }

    pub fn met(self) -> Vec<Wall> {
        self.0.into_iter().filter_map(|wall| wall.met).collect()
    }
}

/// Whether a face is a scanned wall that the border of a view cuts.
fn is_cut_wall(face: &Face) -> bool {
    let tilt = face.normal_W().z.clamp(-1.0, 1.0).acos();
    let mut edges = face.region.rings()[0].edges.iter();
    face.source == Source::Scan
        && (WALL_RAD..=PI - WALL_RAD).contains(&tilt)
        && edges.any(|edge| edge.kind == EdgeKind::FieldOfView)
}
