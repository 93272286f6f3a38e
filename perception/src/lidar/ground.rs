//! The plane that the robot stands on.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use super::config::LidarConfig;
use super::field::Field;
use super::plane::Plane;
use super::prosac::{DISTANCE_M, Ordered, consensus};

/// Without a calibration: most that the sensor may lean, rad.
const TILT_MAX_RAD: f64 = 0.61;
/// With one: most that the ground may lean to the calibrated one, rad.
const LEAN_MAX_RAD: f64 = 0.12;
/// With one: most that the ground under the sensor may be off the calibrated one, m.
const HEIGHT_OFF_MAX_M: f64 = 0.15;
/// Least height of the sensor over the ground, m.
const HEIGHT_MIN_M: f64 = 0.10;
/// Most height of the sensor over the ground, m.
const HEIGHT_MAX_M: f64 = 3.0;
/// Fewest points.
const POINTS_MIN: usize = 100;
/// Least area that the points stand for, m².
const AREA_MIN_M2: f64 = 0.3;

/// Most planes that are tried for the ground.
const TRIES: u64 = 4;
/// Solid angle of a beam: the steps of a VLP-16 at 10 Hz do for a comparison.
const STEP: f64 = 0.0035 * 0.035;
/// Edge of the cells that area is counted in where there are no rings, m.
const CELL_M: f64 = 0.1;
/// Normals of points on a plane differ from its own by less than this, rad.
const NORMAL_RAD: f64 = 0.35;

/// The ground in V; `None` where nothing is ground.
///
/// With a calibrated ground the plane is looked for near it. Without one, it is of the planes that
/// are about level under the sensor the one of which the most area is seen: a ramp that is nearer
/// shows more points than the ground, but less of itself.
pub(super) fn ground(
    field: &Field,
    calibrated: Option<&Plane>,
    config: &LidarConfig,
) -> Option<Plane> {
    let up = calibrated.map_or(Vector3::z(), |plane| plane.normal);
    let lean = calibrated.map_or(TILT_MAX_RAD, |_| LEAN_MAX_RAD);
    let gate = |plane: &Plane| {
        let height = calibrated.map_or(
            (HEIGHT_MIN_M..=HEIGHT_MAX_M).contains(&plane.offset_m),
            |known| (plane.offset_m - known.offset_m).abs() <= HEIGHT_OFF_MAX_M,
        );
        height && plane.normal.dot(&up) >= lean.cos()
    };
    // Candidates: points under the sensor whose surroundings lie about level, the most even first.
    let least = (lean + NORMAL_RAD).min(1.5).cos() as f32;
    let up32 = up.map(|c| c as f32);
    let mut left: Vec<u32> = (0..field.len() as u32)
        .filter(|&i| {
            let i = i as usize;
            let n = Vector3::from(field.normal[i]);
            let below = Vector3::from(field.points[i]).dot(&up32) < 0.0;
            let near = calibrated.is_none_or(|plane| {
                plane.distance(&field.point(i)).abs()
                    <= HEIGHT_OFF_MAX_M + lean.tan() * f64::from(field.range[i])
            });
            below && near && n.dot(&up32) >= least
        })
        .collect();
    field.sort_by_coherence(&mut left);
    let mut best: Option<(Plane, f64)> = None;
    for number in 0..TRIES {
        if left.len() < POINTS_MIN {
            break;
        }
        let mut ordered = Ordered::default();
        left.iter()
            .for_each(|&i| ordered.push(field.points[i as usize], field.normal[i as usize]));
        let Some((plane, _)) = consensus(&ordered, config, number, gate) else {
            break;
        };
        let plane = refined(field, plane, &left, DISTANCE_M)
            .filter(&gate)
            .unwrap_or(plane);
        let on = |i: &u32| on_plane(field, *i as usize, &plane, DISTANCE_M);
        let members: Vec<u32> = left.iter().copied().filter(on).collect();
        let area = seen_area(field, &members, &plane);
        if members.len() >= POINTS_MIN
            && area >= AREA_MIN_M2
            && best.is_none_or(|(_, most)| area > most)
        {
            best = Some((plane, area));
        }
        if members.is_empty() {
            break;
        }
        left.retain(|&i| plane.distance(&field.point(i as usize)).abs() > 2.0 * DISTANCE_M);
    }
    best.map(|(plane, _)| plane)
}

/// Whether a point lies on a plane and its surroundings do not say otherwise.
pub(super) fn on_plane(field: &Field, i: usize, plane: &Plane, distance_m: f64) -> bool {
    plane.distance(&field.point(i)).abs() <= distance_m
        && field
            .normal(i)
            .is_none_or(|n| n.dot(&plane.normal) > NORMAL_RAD.cos() - 0.1)
}

/// The plane fitted to its points, weighted by their errors, twice.
pub(super) fn refined(
    field: &Field,
    plane: Plane,
    members: &[u32],
    distance_m: f64,
) -> Option<Plane> {
    use super::joint_fit::{BiasPrior, Observation, joint_fit};
    let mut plane = plane;
    let none = BiasPrior::unknown(0);
    for _ in 0..2 {
        let observations: Vec<Observation> = members
            .iter()
            .filter(|&&i| on_plane(field, i as usize, &plane, distance_m))
            .map(|&i| Observation {
                plane: 0,
                ring: None,
                p: field.point(i as usize),
            })
            .collect();
        plane = *joint_fit(&observations, &[plane], &none)?.planes.first()?;
    }
    Some(plane)
}

/// The area of a plane that points stand for, m²: on rings of each its share of the solid angle, at
/// most a tenth of a square metre where the plane is seen at a flat angle; else the cells of the
/// plane that hold a point.
fn seen_area(field: &Field, members: &[u32], plane: &Plane) -> f64 {
    if field.ring.is_empty() {
        let [a, b] = plane.tangents();
        let cell = |x: f64| (x / CELL_M).floor() as i64;
        let cells: BTreeSet<(i64, i64)> = members
            .iter()
            .map(|&i| field.point(i as usize))
            .map(|p| (cell(a.dot(&p)), cell(b.dot(&p))))
            .collect();
        return cells.len() as f64 * CELL_M * CELL_M;
    }
    members
        .iter()
        .map(|&i| {
            let p = field.point(i as usize);
            let r = p.norm();
            let cosine = (plane.normal.dot(&p) / r).abs().max(1e-3);
            (r * r * STEP / cosine).min(0.1)
        })
        .sum()
}
