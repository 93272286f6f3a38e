//! A goal where nobody said one.

use nalgebra::{Point2, Point3};
use surfaces::{Face, Region, Terrain};

use super::{apart_m, middle_W};
use crate::config::Config;
use crate::roles::why_not;

/// How far apart two faces may be for a step from one to the other, m.
const STEP_M: f64 = 0.3;
/// Two soles of a humanoid and a little around them need this area of what is left of a face inside its edges, m².
const ROOM_M2: f64 = 0.1;

/// A place for the base, m to centimetres, where nobody said one yet: the middle of the face that lies farthest
/// straight ahead of W's origin, of those with room for feet that are come to by steps from the one nearest to it.
pub fn suggested(terrain: &Terrain, config: &Config) -> Option<[f64; 2]> {
    let (roles, sigmas) = (&config.surfaces.roles, config.posture.edge_sigmas);
    let ground_m = roles.ground_m(&terrain.faces, sigmas);
    let faces = terrain.faces.iter();
    let mut left: Vec<&Face> = faces
        .filter(|face| why_not("foot", face, roles, sigmas, ground_m).is_none())
        .collect();
    let origin = Point3::origin();
    let beside = |face: &Face| {
        let below = origin - face.normal_W() * face.height_of(&origin);
        apart_m(face, &below)
    };
    let first = left
        .iter()
        .copied()
        .min_by(|a, b| beside(a).total_cmp(&beside(b)))?;
    left.retain(|face| face.id != first.id);
    let (mut reached, mut next) = (vec![first], 0);
    while let Some(&from) = reached.get(next) {
        let is_near = |face: &&Face| face.vertices_W().iter().any(|v| apart_m(from, v) < STEP_M);
        let (near, far): (Vec<_>, Vec<_>) = left.into_iter().partition(is_near);
        reached.extend(near);
        left = far;
        next += 1;
    }
    let has_room = |face: &&&Face| {
        let regions = face.inset_region(sigmas, 0.0).regions();
        regions.iter().map(Region::area).sum::<f64>() >= ROOM_M2
    };
    let roomy = reached.iter().filter(has_room);
    let middles = roomy.map(|face| middle_W(face).xy().into());
    let ahead = |p: &Point2<f64>| p.x - p.y.abs();
    let far = middles.max_by(|a, b| ahead(a).total_cmp(&ahead(b)))?;
    Some([far.x, far.y].map(|m| (100.0 * m).round() / 100.0))
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::*;

    #[test]
    fn the_goal_that_is_suggested_is_ahead_and_come_to_by_steps() {
        let rectangle = |id: &str, [x, y, z]: [f64; 3], size: [f64; 2]| {
            Face::rectangle(id, Isometry3::translation(x, y, z), size).unwrap()
        };
        let mut terrain = Terrain {
            faces: vec![
                rectangle("floor", [0.6, 0.0, 0.0], [0.6, 1.0]),
                rectangle("tread", [1.05, 0.1, 0.15], [0.3, 1.0]),
                rectangle("narrow", [1.3, 0.1, 0.3], [0.15, 1.0]),
                rectangle("aside", [1.0, 1.2, 0.0], [0.6, 1.0]),
                rectangle("beyond", [3.0, 0.0, 0.2], [1.0, 1.0]),
            ],
            obstacles: Vec::new(),
        };
        let config = Config::default();
        assert_eq!(suggested(&terrain, &config), Some([1.3, 0.1]));
        // Too narrow for two feet.
        terrain.faces[2] = rectangle("narrow", [1.3, 0.1, 0.3], [0.05, 1.0]);
        assert_eq!(suggested(&terrain, &config), Some([1.05, 0.1]));
        terrain.faces.clear();
        assert_eq!(suggested(&terrain, &config), None);
    }
}
