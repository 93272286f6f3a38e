//! Treads that go on under the edge of the step before them.
//!
//! Looking down a flight, the edge of each tread hides the back of the next one: a strip as wide as the ray over that
//! edge falls flat. A tread begins below the edge of the step before it, or farther back; so it is taken to go on to
//! there, and the step's body to go straight down from its edge instead of along the rays. Nothing was seen of either:
//! whoever uses such a strip has to say so ([`Face::hides`]).

use nalgebra::{Point2, Point3, Vector2};

use crate::conservative_bodies::{EDGE_M, fronts};
use crate::unseen::JAG_M;
use crate::{Edge, EdgeKind, Face, FaceId, Obstacle, Region, Source};

/// Treads face up to this (cosine of their tilt).
const LEVEL: f64 = 0.97;
/// A step is parallel to the tread that it hides (cosine of the angle between them).
const PARALLEL: f64 = 0.995;
/// A step rises so much over the next tread, m: what is less is no step, what is more is a table.
const RISE_M: std::ops::Range<f64> = 0.03..0.3;
/// A face that is deeper than this with what is hidden is no tread, m: there is room on what was seen of it.
const TREAD_MAX_M: f64 = 0.5;
/// The edge of a step hides a tread over so much of its length at least, m; it is straight but for its jags.
const LENGTH_MIN_M: f64 = 0.15;
/// A tread may be seen so much before it comes out of a step's shadow, m, by the errors of both, and so much behind it:
/// rays that graze an edge are lost.
const SHADOW_M: std::ops::Range<f64> = -0.03..0.08;

/// A tread that is taken to go on where nothing was seen.
#[derive(Clone, Debug, PartialEq)]
pub struct Continued {
    /// The tread.
    pub face: FaceId,
    /// The step before it, which hides it.
    pub under: FaceId,
    /// By how much at most, m.
    pub by_m: f64,
    /// How high the step is over it, m.
    pub rise_m: f64,
}

/// Makes treads go on for at most `most_m` to where the step that hides them ends, as seen from above, and the bodies of
/// these steps go straight down. Returns which, and those bodies.
///
/// A tread is hidden by a step where it ends as something nearer hides it, and where this is a face parallel to it, up
/// to 0.3 m higher, whose straight edge lies on the rays to there.
///
/// Units: m.  Frames: W, z up.
pub fn continue_under_steps(faces: &mut [Face], most_m: f64) -> (Vec<Continued>, Vec<Obstacle>) {
    let mut continued = Vec::new();
    let scanned = |face: &&Face| face.source == Source::Scan && face.normal_W().z > LEVEL;
    let steps = faces.iter().filter(scanned);
    let steps: Vec<(&Face, Point3<f64>)> = steps
        .map(|step| (step, step.point_W(&step.region.centroid())))
        .collect();
    let mut regions = Vec::new();
    for (number, tread) in faces.iter().enumerate() {
        if !scanned(&tread) || !is_hidden(&tread.region) {
            continue;
        }
        let mut whole = tread.clone();
        for (step, middle_W) in &steps {
            let rise_m = tread.height_of(middle_W);
            let is_parallel = step.normal_W().dot(&tread.normal_W()) > PARALLEL;
            if !is_parallel || !RISE_M.contains(&rise_m) {
                continue;
            }
            if let Some((region, by_m)) = under(&whole, step, most_m) {
                whole.region = region;
                continued.push(Continued {
                    face: tread.id.clone(),
                    under: step.id.clone(),
                    by_m,
                    rise_m,
                });
            }
        }
        regions.push((number, whole.region));
    }
    for (number, region) in regions {
        faces[number].region = region;
    }
    let mut bodies = Vec::new();
    for step in faces.iter_mut() {
        let over = continued.iter().filter(|found| found.under == step.id);
        let Some(rise_m) = over.map(|found| found.rise_m).reduce(f64::max) else {
            continue;
        };
        let depth_m = step.depth_m.max(rise_m);
        let fronts = fronts(step, EDGE_M);
        bodies.extend(fronts.iter().enumerate().map(|(k, front)| Obstacle {
            id: format!("{}/column{k}", step.id),
            points_W: step.prism_W(front, depth_m),
            surface: Some(step.id.to_string()),
            assumed: true,
        }));
        step.depth_m = 0.0;
    }
    (continued, bodies)
}

impl Face {
    /// Whether it hides a place from an eye.
    ///
    /// Units: m.  Frames: W.
    pub fn hides(&self, p_W: &Point3<f64>, eye_W: &Point3<f64>) -> bool {
        let [p, eye] = [p_W, eye_W].map(|at| self.X_WF.inverse_transform_point(at));
        if p.z * eye.z >= 0.0 {
            return false;
        }
        let at = eye + (p - eye) * (eye.z / (eye.z - p.z));
        self.region.contains(&at.xy())
    }
}

/// Whether something nearer hides how a region goes on.
fn is_hidden(region: &Region) -> bool {
    region.segments().any(|(edge, _)| hides(edge))
}

fn hides(edge: &Edge) -> bool {
    edge.kind == EdgeKind::Occluded
}

/// The region of a tread with the strip that a step hides of it, and how wide that is at most, m.
fn under(tread: &Face, step: &Face, most_m: f64) -> Option<(Region, f64)> {
    let rings = tread.region.rings();
    let (ring, holes) = rings.split_first()?;
    let count = ring.edges.len();
    let edge_of_step = |at: usize| {
        // A vertex between two edges that something hides, or at the end of one.
        let edge = [&ring.edges[at], &ring.edges[(at + count - 1) % count]];
        let view = edge.into_iter().find(|edge| hides(edge))?.view?;
        let eye_W = tread.views.get(view)?.eye_W;
        edge_over(tread, step, &ring.vertices[at], &eye_W, most_m)
    };
    let over: Vec<Option<Point2<f64>>> = (0..count).map(edge_of_step).collect();
    let (first, last) = longest_run(&over)?;
    let places: Vec<Point2<f64>> = (first..=last).filter_map(|k| over[k % count]).collect();
    let (line, inward) = line_along(&places)?;
    // How far from the step's edge the tread begins and ends.
    let behind = |k: usize| inward.dot(&(ring.vertices[k % count] - line[0]));
    let begins_m = || (first..=last).map(behind);
    let by_m = begins_m().fold(0.0, f64::max);
    let deep_m = (0..count).map(behind).fold(0.0, f64::max);
    if begins_m().any(|m| m <= 0.0) || deep_m > TREAD_MAX_M {
        return None;
    }
    let mut outer = ring.clone();
    outer.vertices.rotate_left(first % count);
    outer.edges.rotate_left(first % count);
    let view = outer.edges.iter().find_map(|edge| edge.view);
    let hidden_edge = Edge {
        kind: EdgeKind::Occluded,
        inside_rad: 0.0,
        further_m: EDGE_M,
        view,
    };
    let run = last - first;
    outer.vertices.splice(1..run, line);
    outer.edges.splice(..run, [hidden_edge; 3]);
    let rings = std::iter::once(outer).chain(holes.iter().cloned());
    Some((Region::new(rings).ok()?, by_m))
}

/// The line along the edge of a step by places of it, on the tread's side of all of them, and the direction in which
/// the tread is: on the left. None where the edge is short or not straight.
fn line_along(places: &[Point2<f64>]) -> Option<([Point2<f64>; 2], Vector2<f64>)> {
    let (a, b) = (places.first()?, places.last()?);
    if (b - a).norm() < LENGTH_MIN_M {
        return None;
    }
    let along = (b - a).normalize();
    let inward = Vector2::new(-along.y, along.x);
    let offs = places.iter().map(|p| inward.dot(&(p - a)));
    let (low_m, high_m) = offs.fold((0.0_f64, 0.0_f64), |(low, high), off| {
        (low.min(off), high.max(off))
    });
    (high_m - low_m <= JAG_M).then(|| ([a, b].map(|p| p + inward * high_m), inward))
}

/// Where the edge of a step is, seen from above, that hides how a tread goes on at a vertex `p` of its ring: the first
/// place of the step on the way from there to below the eye. None where the rays over it do not come down at `p`.
///
/// Frames: the tread's F.
fn edge_over(
    tread: &Face,
    step: &Face,
    p: &Point2<f64>,
    eye_W: &Point3<f64>,
    most_m: f64,
) -> Option<Point2<f64>> {
    let eye = tread.X_WF.inverse_transform_point(eye_W);
    let way = eye.xy() - p;
    let far_m = way.norm();
    let X_FS = tread.X_WF.inverse() * step.X_WF;
    let corner = |v: &Point2<f64>| X_FS * Point3::new(v.x, v.y, 0.0);
    let mut first: Option<(f64, f64, &Edge)> = None;
    for (edge, [a, b]) in step.region.segments() {
        let (a, b) = (corner(a), corner(b));
        let along = b.xy() - a.xy();
        let across = way.perp(&along);
        if across.abs() < 1e-12 {
            continue;
        }
        let from = a.xy() - p;
        let (s, t) = (from.perp(&along) / across, from.perp(&way) / across);
        if (0.0..=1.0).contains(&t) && s > 0.0 && first.is_none_or(|(least, ..)| s < least) {
            first = Some((s, a.z + t * (b.z - a.z), edge));
        }
    }
    let (part, rise_m, edge) = first?;
    let height_m = eye.z - rise_m;
    let from_eye_m = far_m * (1.0 - part);
    // The ring lies inside the true edge.
    let inside_m = edge.inside_rad * (from_eye_m.powi(2) / height_m + height_m);
    let hidden_m = far_m * part - inside_m;
    // The ray over the edge comes down so far behind it.
    let shadow_m = rise_m / height_m * (far_m - hidden_m);
    let is_shadow = height_m > 0.0 && SHADOW_M.contains(&(hidden_m - shadow_m));
    (is_shadow && (0.0..=most_m).contains(&hidden_m)).then(|| p + way * (hidden_m / far_m))
}

/// The first and the last of the longest row of places that follow each other around a ring.
fn longest_run<T>(places: &[Option<T>]) -> Option<(usize, usize)> {
    let count = places.len();
    let goes_on = |k: usize| places[k % count].is_some() && places[(k + 1) % count].is_some();
    let starts = (0..count).filter(|k| goes_on(*k) && !goes_on(k + count - 1));
    let runs = starts.map(|k| (k, (k..k + count).find(|k| !goes_on(*k)).unwrap_or(k)));
    // The first of equal ones.
    runs.reduce(|best, run| {
        if run.1 - run.0 > best.1 - best.0 {
            run
        } else {
            best
        }
    })
}

#[cfg(test)]
mod tests;
