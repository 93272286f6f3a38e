//! How far a slope reaches along its start line.

use nalgebra::Vector3;

use super::field::Field;
use super::plane::Plane;
use super::prosac::DISTANCE_M;
use super::refine::CLEAR_M;
use super::slopes::before;
use super::surroundings::bounds;

/// The ends of a slope along a direction, the lower coordinate first.
pub(super) struct Edges {
    pub ends: [End; 2],
}

/// One of them.
#[derive(Clone, Copy)]
pub(super) struct End {
    /// Coordinate along the direction, m.
    pub at: f64,
    /// Its standard deviation, m.
    pub sigma: f64,
    /// Whether something hides where the slope ends, so that `at` is as far as it was seen.
    pub hidden: bool,
    /// The middle of the places where it was seen.
    pub middle: Vector3<f64>,
}

/// A slope, and how far up from its start line its points are.
struct Seen<'a> {
    field: &'a Field,
    plane: &'a Plane,
    ground: &'a Plane,
    ahead: Vector3<f64>,
    origin: &'a Vector3<f64>,
    depth: [f64; 2],
}

/// Where a ring leaves the slope.
struct RingEnd {
    /// Coordinate outward, m.
    at: f64,
    /// The point.
    p: Vector3<f64>,
    /// The ring's step there, m.
    step: f64,
    /// Whether something hides the slope beyond.
    hidden: bool,
    /// Where that ends, m, outward.
    hidden_to: f64,
    /// Whether the slope, would it reach there, had been seen there.
    told: bool,
    /// Whether the ring comes so near to the ground there that it may leave the slope across its foot.
    foot: bool,
}

/// Ends of rings that lie within this of the farthest but one are the edge's, m.
const EDGE_M: f64 = 0.025;
/// Standard deviation of what the ends of all rings have in common, in steps: a footprint is wider than one.
const SHARED: f64 = 0.25;
/// Ends of rings lower than this over the ground may be where they leave across the slope's foot, m.
const FOOT_M: f64 = CLEAR_M + 0.02;
/// Part of the points beyond the ends where there are no rings, on either side.
const QUANTILE: f64 = 0.005;
/// Points of a ring beyond its end among which one that hides the slope is looked for: those next to
/// it may be mixed of both.
const BEYOND: usize = 3;

/// The ends of the points `members` of a slope along the unit vector `l` (coordinates q·l of points q).
///
/// Every ring that crosses the slope ends at its edges, half a step short on average. A ring that
/// leaves it across its foot or its top ends before them, so that the farthest ends count; the very
/// farthest alone may be a stray. Where what stands before the slope hides it beyond the farthest ends,
/// the slope ends anywhere there. Without rings the ends are quantiles.
/// Source: [meng] Eq. 11; deviation: max and min of q_x + q_y degenerate for lines at 135°.
pub(super) fn along(
    field: &Field,
    members: &[u32],
    l: &Vector3<f64>,
    plane: &Plane,
    ground: &Plane,
    origin: &Vector3<f64>,
) -> Option<Edges> {
    if field.ring.is_empty() {
        let middle = members.iter().map(|&i| field.point(i as usize));
        let middle = middle.sum::<Vector3<f64>>() / members.len() as f64;
        let mut values: Vec<f64> = members
            .iter()
            .map(|&i| field.point(i as usize).dot(l))
            .collect();
        values.sort_by(f64::total_cmp);
        let n = values.len();
        let cut = (n as f64 * QUANTILE) as usize;
        let (low, high) = (*values.get(cut)?, *values.get(n.checked_sub(1 + cut)?)?);
        let ends = [low, high].map(|at| End {
            at,
            // The points' mean distance along the line.
            sigma: (high - low) / (n as f64).sqrt(),
            hidden: false,
            middle,
        });
        return Some(Edges { ends });
    }
    let ahead = l.cross(&ground.normal);
    let up = |p: Vector3<f64>| ahead.dot(&(p - origin));
    let seen = Seen {
        field,
        plane,
        ground,
        ahead,
        origin,
        depth: bounds(members.iter().map(|&i| up(field.point(i as usize)))),
    };
    let end = |outward: Vector3<f64>| {
        let runs = field.runs(members).into_iter().filter(|run| run.len() >= 5);
        edge(runs.map(|run| seen.ring_end(run, &outward)).collect())
    };
    let (mut low, high) = (end(-l)?, end(*l)?);
    low.at = -low.at;
    Some(Edges { ends: [low, high] })
}

impl Seen<'_> {
    /// Where a ring's run ends outward, and as far as what hides the slope beyond it lets nothing be
    /// seen.
    fn ring_end(&self, run: &[u32], outward: &Vector3<f64>) -> RingEnd {
        let field = self.field;
        let coordinate = |i: u32| field.point(i as usize).dot(outward);
        let (first, last) = (run[0], run[run.len() - 1]);
        let farthest = run
            .iter()
            .max_by(|a, b| coordinate(**a).total_cmp(&coordinate(**b)));
        let end = *farthest.unwrap_or(&last);
        let [low, high] = bounds(run.iter().map(|&i| coordinate(i)));
        // Along the ring, away from the run.
        let ring = field.ring[first as usize];
        let on_ring = |i: &usize| field.ring[*i] == ring;
        let beyond: Vec<usize> = if coordinate(last) >= coordinate(first) {
            (last as usize + 1..field.len())
                .take_while(on_ring)
                .collect()
        } else {
            (0..first as usize).rev().take_while(on_ring).collect()
        };
        let hides = |i: &usize| before(field, *i, self.plane, self.ground);
        let mut found = RingEnd {
            at: high,
            p: field.point(end as usize),
            step: (high - low) / (run.len() - 1) as f64,
            hidden: false,
            hidden_to: high,
            told: false,
            foot: self.ground.distance(&field.point(end as usize)).abs() < FOOT_M,
        };
        if let Some(begins) = beyond.iter().take(BEYOND).position(hides) {
            let hiding = beyond[begins..].iter().take_while(|i| hides(i)).count();
            found.hidden = true;
            // Where the beam beside it meets the slope's plane.
            let free = beyond.get(begins + hiding).copied();
            let u = field
                .point(free.unwrap_or(beyond[begins + hiding - 1]))
                .normalize();
            let range = -self.plane.offset_m / self.plane.normal.dot(&u);
            if range > 0.0 && range.is_finite() {
                let q = u * range;
                let up = self.ahead.dot(&(q - self.origin));
                found.hidden_to = q.dot(outward);
                // Near the foot, what lies beside the slope is as near to its plane.
                let off = |i| self.plane.distance(&field.point(i)).abs() > DISTANCE_M;
                let reaches = (self.depth[0]..=self.depth[1]).contains(&up);
                found.told = free.is_some_and(off) && reaches;
            }
        }
        found
    }
}

/// The end of a slope from those of its rings.
///
/// The edge is at the farthest end beside which another is; where a ring may leave across the foot counts
/// only where no other ends.
/// The slope ends beyond the farthest end that is hidden. Where ends that are seen are as far, they are
/// the edge's; else the edge is anywhere behind what hides it, of which the root mean square distance
/// from where the slope was last seen is told.
fn edge(mut ends: Vec<RingEnd>) -> Option<End> {
    ends.sort_by(|a, b| b.at.total_cmp(&a.at));
    let hidden = ends.iter().find(|end| end.hidden);
    let seen: Vec<&RingEnd> = ends.iter().filter(|end| !end.hidden).collect();
    let beside = |end: &RingEnd| {
        let near = seen
            .iter()
            .filter(|other| (other.at - end.at).abs() <= EDGE_M);
        near.count() > 1
    };
    let by_foot = seen.iter().all(|end| end.foot);
    let own = || seen.iter().filter(|end| by_foot || !end.foot);
    let first = own().find(|end| beside(end)).or(own().next());
    let reference = first.map_or(f64::NEG_INFINITY, |end| end.at);
    if let Some(hidden) = hidden
        && hidden.at > reference + EDGE_M
    {
        let beyond = ends.iter().filter(|end| end.hidden_to > hidden.at);
        let [_, any] = bounds(beyond.clone().map(|end| end.hidden_to));
        let [told, _] = bounds(beyond.filter(|end| end.told).map(|end| end.hidden_to));
        let to = if told.is_finite() {
            told
        } else {
            any.max(hidden.at)
        };
        return Some(End {
            at: hidden.at,
            sigma: ((to - hidden.at) / 3.0_f64.sqrt()).max(hidden.step),
            hidden: true,
            middle: hidden.p,
        });
    }
    let agreeing: Vec<&&RingEnd> = own()
        .filter(|end| (end.at - reference).abs() <= EDGE_M)
        .collect();
    // One ring alone may have met something else there.
    let next = seen.iter().find(|end| end.at < reference);
    let alone = match first.is_some_and(|end| beside(end)) {
        true => 0.0,
        false => next.map_or(0.0, |end| (reference - end.at) / 3.0_f64.sqrt()),
    };
    let n = agreeing.len() as f64;
    if agreeing.is_empty() {
        return None;
    }
    let step = agreeing.iter().map(|end| end.step).sum::<f64>() / n;
    let mean = agreeing.iter().map(|end| end.at).sum::<f64>() / n + step / 2.0;
    let squares = agreeing
        .iter()
        .map(|end| (end.at + step / 2.0 - mean).powi(2));
    let variance = squares.sum::<f64>() / n;
    Some(End {
        at: mean,
        // Not less than that of a step's even spread; what a footprint on both sides gives, all rings share.
        sigma: (variance.max(step * step / 12.0) / n + (SHARED * step).powi(2) + alone * alone)
            .sqrt(),
        hidden: false,
        middle: agreeing.iter().map(|end| end.p).sum::<Vector3<f64>>() / n,
    })
}
