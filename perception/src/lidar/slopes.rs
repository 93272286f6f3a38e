//! The slopes that stand on the ground.

use nalgebra::Vector3;

use super::config::LidarConfig;
use super::field::{Field, NONE};
use super::ground::{on_plane, refined};
use super::plane::Plane;
use super::prosac::{DISTANCE_M, Ordered, consensus};

/// Fewest points.
const POINTS_MIN: usize = 80;
/// Fewest rings that see it.
const RINGS_MIN: usize = 3;
/// Least extent in every direction, m.
const EXTENT_MIN_M: f64 = 0.35;
/// The same across where most rings end at what hides the rest, and points beside such an end among which it is.
const STRIP_MIN_M: f64 = 0.15;
const BESIDE: u32 = 3;
/// Points on a ring are of one patch over what hides it up to this far apart, m: a person 0.9 m away
/// hides 2 m of what is 4 m away.
const HIDDEN_MAX_M: f64 = 2.0;
/// Most height of its lowest point over the ground, m: rings leave its foot unseen.
const FOOT_MAX_M: f64 = 0.25;
/// Least part of the points between its edges that lie on it, of those that do not hide it, 0…1.
const FILLED_MIN: f64 = 0.75;
/// Most slopes.
const COUNT_MAX: usize = 8;

/// A plane patch in V: its plane, and the points on it that hang together.
pub(super) struct Patch {
    /// The plane.
    pub plane: Plane,
    /// Indices into the field, ascending.
    pub members: Vec<u32>,
}

/// A point's own normal may be off by this, rad: rings are few on a slope, and their biases tilt it.
const LOCAL_RAD: f64 = 0.14;
/// Planes that are tried for every slope that is found, and as many at first.
const TRIES: u64 = 4;

/// The slopes of a field over its ground, the largest consensus set first.
///
/// The ground is removed first, and what stands steeper than a slope: a consensus search by itself
/// settles on the ground or a wall. Of a plane's consensus set only what hangs together is a slope;
/// where that does not qualify, its points are set aside and the search goes on.
pub(super) fn slopes(field: &Field, ground: &Plane, config: &LidarConfig) -> Vec<Patch> {
    let inclination = |n: &Vector3<f64>| n.dot(&ground.normal).clamp(-1.0, 1.0).acos();
    let (low, high) = (config.inclination_min_rad, config.inclination_max_rad);
    let gate = |plane: &Plane| (low..=high).contains(&inclination(&plane.normal));

    // What is not ground, and of that what may lie on a slope by its own surroundings.
    let mut free: Vec<bool> = (0..field.len())
        .map(|i| ground.distance(&field.point(i)).abs() > DISTANCE_M)
        .collect();
    let wanted = PatchSearch {
        points_min: POINTS_MIN,
        count_max: COUNT_MAX,
        tries: TRIES,
        over: Some(ground),
    };
    let near = |n: &Vector3<f64>| {
        let angle = inclination(n);
        angle >= low - LOCAL_RAD && angle <= high + LOCAL_RAD
    };
    let is_slope = |patch: &Patch| gate(&patch.plane) && qualifies(field, patch, ground);
    patches(field, &mut free, &wanted, config, near, gate, is_slope)
}

/// How many patches are wanted, and of what size.
pub(super) struct PatchSearch<'a> {
    /// Fewest points.
    pub points_min: usize,
    /// Most patches.
    pub count_max: usize,
    /// Planes that are tried for every patch that is found, and as many at first.
    pub tries: u64,
    /// Where there is a ground, what stands over it before a patch hides the patch and does not end it.
    pub over: Option<&'a Plane>,
}

/// The patches among the free points, one after the other: `near` says of a point's normal whether
/// it may begin one, `gate` of a plane, `is_wanted` of the whole patch. Their points are free no more.
#[allow(clippy::too_many_arguments)]
pub(super) fn patches(
    field: &Field,
    free: &mut [bool],
    wanted: &PatchSearch,
    config: &LidarConfig,
    near: impl Fn(&Vector3<f64>) -> bool,
    gate: impl Fn(&Plane) -> bool,
    is_wanted: impl Fn(&Patch) -> bool,
) -> Vec<Patch> {
    let mut left: Vec<u32> = (0..field.len() as u32)
        .filter(|&i| free[i as usize] && field.normal(i as usize).is_some_and(|n| near(&n)))
        .collect();
    field.sort_by_coherence(&mut left);
    let mut found: Vec<Patch> = Vec::new();
    let mut tries = 0;
    while found.len() < wanted.count_max
        && left.len() >= wanted.points_min
        && tries < wanted.tries * (found.len() as u64 + 1)
    {
        tries += 1;
        let mut ordered = Ordered::default();
        left.iter()
            .for_each(|&i| ordered.push(field.points[i as usize], field.normal[i as usize]));
        let Some((plane, count)) = consensus(&ordered, config, 100 + tries, &gate) else {
            break;
        };
        if count < wanted.points_min {
            break;
        }
        let Some(patch) = grown(field, plane, &left, free, wanted) else {
            // Too little of it hangs together: its points lead to nothing else either.
            left.retain(|&i| plane.distance(&field.point(i as usize)).abs() > DISTANCE_M);
            continue;
        };
        let keep = is_wanted(&patch);
        for &i in &patch.members {
            free[i as usize] = false;
        }
        left.retain(|&i| free[i as usize]);
        if keep {
            found.push(patch);
        }
    }
    found
}

/// The largest connected part of a plane's points, its plane fitted to it; twice, so that the part is
/// that of its own plane.
fn grown(
    field: &Field,
    plane: Plane,
    seeds: &[u32],
    free: &[bool],
    wanted: &PatchSearch,
) -> Option<Patch> {
    let mut plane = plane;
    let mut members = Vec::new();
    for pass in 0..3 {
        let mut on = vec![false; field.len()];
        if pass == 0 {
            // Candidates only: the rest of the cloud meets the plane in lines.
            for &i in seeds {
                on[i as usize] = on_plane(field, i as usize, &plane, DISTANCE_M);
            }
        } else {
            for (i, free) in free.iter().enumerate() {
                on[i] = *free && on_plane(field, i, &plane, DISTANCE_M);
            }
        }
        // Points of the plane that are not marked, and what stands before it.
        let passes = |i: usize| {
            wanted.over.is_some_and(|ground| {
                plane.distance(&field.point(i)).abs() <= DISTANCE_M
                    || before(field, i, &plane, ground)
            })
        };
        members = largest_part(field, &on, passes);
        if members.len() < wanted.points_min {
            return None;
        }
        plane = refined(field, plane, &members, DISTANCE_M)?;
    }
    Some(Patch { plane, members })
}

/// Whether a point lies before a plane, as the sensor sees it, and over the ground.
pub(super) fn before(field: &Field, i: usize, plane: &Plane, ground: &Plane) -> bool {
    let p = field.point(i);
    plane.distance(&p) > DISTANCE_M && ground.distance(&p) > DISTANCE_M
}

/// The largest set of marked points that are linked with each other, or on a ring with only points
/// between them that may be passed over, in ascending order.
pub(super) fn largest_part(field: &Field, on: &[bool], passes: impl Fn(usize) -> bool) -> Vec<u32> {
    // Union by the least index, with path halving.
    let mut root: Vec<u32> = (0..field.len() as u32).collect();
    fn find(root: &mut [u32], mut i: u32) -> u32 {
        while root[i as usize] != i {
            root[i as usize] = root[root[i as usize] as usize];
            i = root[i as usize];
        }
        i
    }
    for i in (0..field.len()).filter(|&i| on[i]) {
        for &j in &field.links[field.per_point * i..field.per_point * (i + 1)] {
            if j != NONE && on[j as usize] {
                let (a, b) = (find(&mut root, i as u32), find(&mut root, j));
                root[a.max(b) as usize] = a.min(b);
            }
        }
    }
    let mut last: Option<usize> = None;
    for (i, &marked) in on.iter().enumerate().take(field.ring.len()) {
        if marked {
            if let Some(j) = last
                && j + 1 < i
                && field.ring[i] == field.ring[j]
                && (field.point(i) - field.point(j)).norm() < HIDDEN_MAX_M
            {
                let (a, b) = (find(&mut root, i as u32), find(&mut root, j as u32));
                root[a.max(b) as usize] = a.min(b);
            }
            last = Some(i);
        } else if !passes(i) {
            last = None;
        }
    }
    let mut sizes = vec![0_u32; field.len()];
    for i in (0..field.len()).filter(|&i| on[i]) {
        sizes[find(&mut root, i as u32) as usize] += 1;
    }
    // The first of the largest.
    let Some(best) = (0..field.len()).max_by_key(|&i| (sizes[i], std::cmp::Reverse(i))) else {
        return Vec::new();
    };
    (0..field.len() as u32)
        .filter(|&i| on[i as usize] && find(&mut root, i) == best as u32)
        .collect()
}

/// Whether a patch is large, full and low enough for a slope.
fn qualifies(field: &Field, patch: &Patch, ground: &Plane) -> bool {
    let members = &patch.members;
    if members.len() < POINTS_MIN {
        return false;
    }
    let mut extent_m = EXTENT_MIN_M;
    // Seen by enough rings, and nothing but the slope between its edges on them.
    if !field.ring.is_empty() {
        let (mut between, mut cut, runs) = (0, 0, field.runs(members));
        let hides = |i: &u32| before(field, *i as usize, &patch.plane, ground);
        // Near its foot the slope is as near to the ground, and its points were taken for that.
        let foot = |i: &u32| {
            let p = field.point(*i as usize);
            let off = [&patch.plane, ground].map(|plane| plane.distance(&p).abs());
            off.iter().all(|off| *off <= DISTANCE_M) && members.binary_search(i).is_err()
        };
        for run in &runs {
            let (first, last) = (run[0], run[run.len() - 1]);
            between += (first..=last).filter(|i| !hides(i) && !foot(i)).count();
            let mut beside = (first.saturating_sub(BESIDE)..first)
                .chain(last + 1..(last + 1 + BESIDE).min(field.len() as u32));
            cut += usize::from(beside.any(|i| hides(&i)));
        }
        // Something that hides most of it leaves a strip.
        if 2 * cut > runs.len() {
            extent_m = STRIP_MIN_M;
        }
        let (filled, rings) = (members.len() as f64 / between as f64, runs.len());
        if rings < RINGS_MIN || filled < FILLED_MIN {
            return false;
        }
    }
    // Wide enough both ways, its foot near the ground. The normals of its edges are not its own.
    let all = with_edges(field, patch);
    let up = patch.plane.normal.cross(&ground.normal).normalize();
    let along = [up, patch.plane.normal.cross(&up)];
    let wide = (along.iter().zip([extent_m, EXTENT_MIN_M])).all(|(direction, least_m)| {
        let values = all.iter().map(|&i| direction.dot(&field.point(i as usize)));
        let (low, high) = spread(values.collect());
        high - low >= least_m
    });
    let heights = members
        .iter()
        .map(|&i| ground.distance(&field.point(i as usize)));
    let (low, high) = spread(heights.collect());
    wide && low.abs().min(high.abs()) <= FOOT_MAX_M
}

/// The points of a patch with those beside them on their rings that lie on its plane.
fn with_edges(field: &Field, patch: &Patch) -> Vec<u32> {
    let mut all = patch.members.clone();
    for run in field.runs(&patch.members) {
        let on = |i: &u32| {
            field.ring[*i as usize] == field.ring[run[0] as usize]
                && patch.plane.distance(&field.point(*i as usize)).abs() <= DISTANCE_M
        };
        all.extend((run[run.len() - 1] + 1..field.len() as u32).take_while(on));
        all.extend((0..run[0]).rev().take_while(on));
    }
    all
}

/// The values between which all but one in fifty lie on either side.
fn spread(mut values: Vec<f64>) -> (f64, f64) {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    match n {
        0 => (0.0, 0.0),
        _ => (values[n / 50], values[n - 1 - n / 50]),
    }
}
