//! Where no way leads on, in words that name the place.

use nalgebra::{Point3, Vector3};
use posture::FaceIndex;

use crate::lattice::Lattice;
use crate::route::Pose;
use crate::shortest::Found;

/// What is about a place on the ground belongs to it, m.
const ABOUT_M: f64 = 0.3;

/// Why no way leads from the places that are come to on to a point of the guide.
pub(crate) fn gap(lattice: &Lattice, here: &[Vector3<f64>], to: &Vector3<f64>) -> String {
    let there = beyond(lattice, to);
    let nearest = |from: &Vector3<f64>| {
        let apart = |p: &&Vector3<f64>| (*p - from).norm();
        let places = there.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        places.map(|p| (*from, *p))
    };
    let apart = |(a, b): &(Vector3<f64>, Vector3<f64>)| (b - a).norm();
    let pairs = here.iter().filter_map(nearest);
    let Some((a, b)) = pairs.min_by(|a, b| apart(a).total_cmp(&apart(b))) else {
        let rest = |p: &&Vector3<f64>| (to - *p).xy().norm();
        let nearest = here.iter().min_by(|a, b| rest(a).total_cmp(&rest(b)));
        let nearest = nearest.copied().unwrap_or_default();
        let rest_m = rest(&&nearest);
        return if rest_m < ABOUT_M {
            // What stands there stands elsewhere than at the height that is asked for.
            format!(
                "the base cannot be at {:.2} m about ({:.2}, {:.2}): over feet that stand there it is at about {:.2} m",
                to.z,
                to.x,
                to.y,
                nearest.z + lattice.legs_m
            )
        } else {
            format!(
                "no feet can stand about ({:.2}, {:.2}): the base comes to ({:.2}, {:.2}), {rest_m:.2} m from it",
                to.x, to.y, nearest.x, nearest.y
            )
        };
    };
    let (steps, up_m) = (&lattice.steps, b.z - a.z);
    let environment = lattice.context.request.environment;
    let place = |p: &Vector3<f64>| format!("({:.2}, {:.2})", p.x, p.y);
    match (under(lattice, &a), under(lattice, &b)) {
        (Some(from), Some(onto)) if from != onto => format!(
            "{} to {}: {:.2} m apart and {:.2} m {}; the longest step is {:.2} m, the highest {:.2} m",
            environment[from].id,
            environment[onto].id,
            apart_m(lattice, from, onto),
            up_m.abs(),
            if up_m < 0.0 { "down" } else { "up" },
            steps.length_m(),
            steps.climb_m
        ),
        (face, _) => format!(
            "no way was found{} from {} to {}: what is between is too high or too narrow",
            face.map_or_else(String::new, |f| format!(" on {}", environment[f].id)),
            place(&a),
            place(&b)
        ),
    }
}

/// The places from where a point of the guide can be come to.
fn beyond(lattice: &Lattice, to: &Vector3<f64>) -> Vec<Vector3<f64>> {
    let start = lattice.context.route.at(0.0);
    let ground_m = to.z - lattice.legs_m;
    let headings = (0..8).map(|k| k as f64 * std::f64::consts::FRAC_PI_4);
    let levels = (0..=20).map(|k| ground_m + 0.5 * steps_of(k) * lattice.steps.climb_m);
    let founded = levels.flat_map(|level| headings.clone().map(move |h| (level, h)));
    let mut founded = founded.filter(|(level, h)| lattice.founded(&to.xy(), *h, *level).is_some());
    let Some((level_m, heading)) = founded.next() else {
        return Vec::new();
    };
    let from = Pose {
        p: *to,
        heading,
        crouch_m: 0.0,
    };
    match lattice.shortest(&from, level_m, &start.p, 0.0, None, None) {
        Found::Reached(places) => places,
        Found::Way(_) | Found::Unknown => Vec::new(),
    }
}

/// 0, 1, −1, 2, −2, …
fn steps_of(k: i32) -> f64 {
    let step = f64::from((k + 1) / 2);
    if k % 2 == 1 { step } else { -step }
}

/// The face that feet stand on about a place on the ground.
fn under(lattice: &Lattice, place: &Vector3<f64>) -> Option<FaceIndex> {
    let context = lattice.context;
    let (p, about) = (Point3::from(*place), Vector3::repeat(ABOUT_M));
    let near = context
        .request
        .environment
        .faces_near(&(p - about), &(p + about));
    let near = near
        .into_iter()
        .filter(|&face| context.feet.iter().any(|&f| context.may_touch(f, face)));
    let far = |face: FaceIndex| {
        let apart = context.request.environment.distances_m(face, &p);
        apart.map_or(f64::INFINITY, |(beside, over)| beside.hypot(over))
    };
    near.min_by(|a, b| far(*a).total_cmp(&far(*b)))
}

/// How far two faces are apart, seen from above the one, m.
fn apart_m(lattice: &Lattice, a: FaceIndex, b: FaceIndex) -> f64 {
    let environment = lattice.context.request.environment;
    let beside = |from: FaceIndex, to: FaceIndex| {
        let corners = environment[from].vertices_W();
        let beside = corners
            .iter()
            .filter_map(|p| environment.distances_m(to, p));
        beside
            .map(|(beside, _)| beside)
            .fold(f64::INFINITY, f64::min)
    };
    beside(a, b).min(beside(b, a))
}
