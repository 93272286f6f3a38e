//! Points over the ground on no plane, gathered into upright bodies.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector2, Vector3};

use super::{BEYOND_M, CLEAR_M, ObstacleCluster, Upright, View, bounds, obstacle};

/// Points this near to each other in the ground plan are of one cluster, m.
const GAP_M: f64 = 0.1;
/// Fewest points of a cluster.
const POINTS_MIN: usize = 6;
/// Wider clusters are cut into bodies of this width, m.
const WIDTH_M: f64 = 0.4;
/// Most depth that is assumed behind what is seen, m: a cluster is taken to be as deep as wide.
const DEPTH_MAX_M: f64 = 0.25;
/// Least depth of a body, m.
const DEPTH_MIN_M: f64 = 0.03;
/// Half the footprint of a beam and half a step of it at 2 m, m.
const EDGE_M: f64 = 0.01;

/// The things among the free points, from the nearest.
pub(super) fn obstacle_clusters(view: &View, free: &[bool]) -> Vec<ObstacleCluster> {
    let members: Vec<u32> = (0..free.len() as u32)
        .filter(|&i| free[i as usize])
        .collect();
    let places: Vec<Vector2<f64>> = view.in_W(&members).iter().map(|p| p.coords.xy()).collect();
    let mut groups: Vec<Vec<u32>> = Vec::new();
    for group in gathered(&places, GAP_M) {
        if group.len() < POINTS_MIN {
            continue;
        }
        let group: Vec<u32> = group.into_iter().map(|k| members[k as usize]).collect();
        groups.extend(tiles(view, group));
    }
    let mut found: Vec<(f64, Vec<u32>)> = groups
        .into_iter()
        .map(|group| {
            let ranges = group
                .iter()
                .map(|&i| f64::from(view.field.range[i as usize]));
            (bounds(ranges)[0], group)
        })
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| a.1.cmp(&b.1)));
    (found.iter().enumerate())
        .filter_map(|(number, (_, group))| obstacle_cluster(view, group, number))
        .collect()
}

/// Places of the ground plan in cells of this width, gathered where their cells touch: indices of the
/// places of every group, ascending within it; groups by their first cell.
pub fn gathered(places: &[Vector2<f64>], cell_m: f64) -> Vec<Vec<u32>> {
    let cell = |p: &Vector2<f64>| ((p.x / cell_m).floor() as i64, (p.y / cell_m).floor() as i64);
    let mut cells: BTreeMap<(i64, i64), Vec<u32>> = BTreeMap::new();
    for (i, p) in places.iter().enumerate() {
        cells.entry(cell(p)).or_default().push(i as u32);
    }
    let mut groups = Vec::new();
    while let Some((first, mut group)) = cells.pop_first() {
        let mut open = vec![first];
        while let Some((x, y)) = open.pop() {
            for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
                let beside = (x + dx, y + dy);
                if let Some(more) = cells.remove(&beside) {
                    group.extend(more);
                    open.push(beside);
                }
            }
        }
        group.sort_unstable();
        groups.push(group);
    }
    groups
}

/// A group as it is, or cut along a grid where it is wider than a body.
fn tiles(view: &View, group: Vec<u32>) -> Vec<Vec<u32>> {
    let places = view.in_W(&group);
    let wide = |axis: usize| {
        let [low, high] = bounds(places.iter().map(|p| p[axis]));
        high - low > 1.5 * WIDTH_M
    };
    if !wide(0) && !wide(1) {
        return vec![group];
    }
    let mut tiles: BTreeMap<(i64, i64), Vec<u32>> = BTreeMap::new();
    for (i, p) in group.iter().zip(&places) {
        let at = |x: f64| (x / WIDTH_M).floor() as i64;
        tiles.entry((at(p.x), at(p.y))).or_default().push(*i);
    }
    tiles.into_values().collect()
}

/// The upright body of a group, as deep as it is wide.
fn obstacle_cluster(view: &View, members: &[u32], number: usize) -> Option<ObstacleCluster> {
    let places = view.in_W(members);
    let n = places.len() as f64;
    let centre = Point3::from(places.iter().map(|p| p.coords).sum::<Vector3<f64>>() / n);
    // 1. Along the ray and across it.
    let mut u = centre - view.eye();
    u.z = 0.0;
    let u = u.try_normalize(1e-6)?;
    let v = Vector3::z().cross(&u);
    let along = bounds(places.iter().map(|p| u.dot(&p.coords)));
    let across = bounds(places.iter().map(|p| v.dot(&p.coords)));
    let width = across[1] - across[0];
    let depth = width.clamp(DEPTH_MIN_M, DEPTH_MAX_M);
    let along = [along[0] - EDGE_M, along[1].max(along[0] + depth) + EDGE_M];
    let sides = [across[0] - EDGE_M, across[1] + EDGE_M];
    // 2. Up and down to where the next beam would have met it.
    let gap = view.gap_m(members);
    let [low, high] = bounds(places.iter().map(|p| p.z));
    let heights_m = bounds(places.iter().map(|p| view.height(p)));
    let ground = low - heights_m[0];
    let grounded = view.ground_V.is_some();
    let stands = grounded && heights_m[0] <= gap + CLEAR_M;
    let from = if stands { ground } else { low - gap };
    let to = high + gap;
    let id = format!("thing{number}");
    let upright = |z: [f64; 2]| {
        let across = sides;
        Upright {
            u,
            along,
            across,
            z,
        }
        .corners_W()
    };
    let body = obstacle(id.clone(), upright([from, to]), None, true);
    // 3. Beyond the view.
    let [lowest, uppermost] = view.ends(members);
    let mut beyond = Vec::new();
    if lowest && grounded && !stands {
        let below = upright([ground, from]);
        beyond.push(obstacle(format!("{id}/below"), below, None, false));
    }
    if uppermost {
        let above = upright([to, to + BEYOND_M]);
        beyond.push(obstacle(format!("{id}/above"), above, None, false));
    }
    Some(ObstacleCluster {
        body,
        beyond,
        centre_W: centre,
        width_m: width,
        heights_m,
        points: members.len(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_gathered_where_their_cells_touch() {
        let row =
            |from: f64, n: u32| (0..n).map(move |k| Vector2::new(from + 0.05 * f64::from(k), 0.0));
        let places: Vec<_> = row(1.0, 5)
            .chain(row(-2.0, 3))
            .chain(row(1.25, 2))
            .collect();
        let groups = gathered(&places, 0.1);
        assert_eq!(groups, [vec![5, 6, 7], vec![0, 1, 2, 3, 4, 8, 9]]);
        assert!(gathered(&[], 0.1).is_empty());
    }
}
