//! Where a robot starts that is to stand before the floor that a scan shows.
#![allow(non_snake_case)]

use nalgebra::Point3;
use robot_model::{Kinematics, Robot};
use surfaces::{Face, Terrain};

use super::StartState;

/// How far before the floor's edge the toes stay, m.
const BEFORE_M: f64 = 0.02;
/// Faces this near to the soles' height may be the floor, m.
const HEIGHT_M: f64 = 0.03;

/// Moves a robot that stands over W's origin, x ahead, along x until its toes are just before the floor
/// that was seen; nothing where there is none ahead of its feet.
///
/// What a scan on a robot shows begins some way ahead of the feet: there the robot's own ground and the
/// floor that is seen meet without a gap.
pub fn stand_before(stand: &mut StartState, robot: &Robot, terrain: &Terrain) {
    let kinematics = Kinematics::new(robot, &stand.configuration);
    let soles = stand.patches.iter().flat_map(|&patch| {
        let patch = &robot.patches[patch];
        let X_WC = kinematics.X_WC(patch);
        let corners = patch.polygon.iter();
        corners.map(move |v| X_WC * Point3::new(v.x, v.y, 0.0))
    });
    let soles: Vec<_> = soles.collect();
    let [low, high] = [f64::min, f64::max].map(|pick| {
        let across = soles.iter().map(|p| p.y);
        across.reduce(pick).unwrap_or_default()
    });
    let toes_x = soles.iter().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max);
    let height = soles.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
    let is_floor = |face: &&Face| {
        let level = face.normal_W().z > 1.0 - HEIGHT_M;
        level && (face.X_WF.translation.z - height).abs() < HEIGHT_M
    };
    // Along each edge, the part that is ahead of the feet.
    let edges = terrain.faces.iter().filter(is_floor).flat_map(|face| {
        let segments = face.region.segments();
        segments.map(|(_, ends)| ends.map(|p| face.point_W(p)))
    });
    let nearest = edges.filter_map(|[a, b]| {
        let at = |y: f64| (y - a.y) / (b.y - a.y);
        let [from, to] = if (b.y - a.y).abs() < 1e-9 {
            let inside = a.y >= low && a.y <= high;
            return inside.then(|| a.x.min(b.x));
        } else {
            [at(low), at(high)].map(|t| t.clamp(0.0, 1.0))
        };
        let x = |t: f64| a.x + t * (b.x - a.x);
        (from != to).then(|| x(from).min(x(to)))
    });
    if let Some(edge_x) = nearest.reduce(f64::min) {
        let base = &mut stand.configuration.p_WB;
        base.x += edge_x - BEFORE_M - toes_x;
    }
}
