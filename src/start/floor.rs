//! Where a robot starts that is to stand before the floor that a scan shows.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use robot_model::{Kinematics, Robot};
use surfaces::{EdgeKind, Face, Terrain};

use super::{StartState, flight};

/// How far before the floor's edge the toes stay, m.
const BEFORE_M: f64 = 0.02;
/// And before the edge of what rises there: the robot goes up it with its legs in front.
const BEFORE_STEP_M: f64 = 0.05;
/// Faces that begin this near to the soles' height may be the floor, m.
const HEIGHT_M: f64 = 0.03;
/// And that lean by no more than this, rad.
const LEAN_RAD: f64 = 0.25;
/// A lean that the user should know of, rad.
const NOTED_RAD: f64 = 0.01;

/// Moves a robot that stands over W's origin, x ahead, along x until its toes are just before the floor
/// that was seen, and onto that floor's plane. Where something rises before any floor is seen, they stay level and go just
/// before it: the floor before a tread may all lie below the view. Where the view cuts that tread, it is taken to be as deep
/// as the treads behind it, and what was not seen of it becomes a body of `terrain` that is kept away from. Nothing where
/// there is neither floor nor such a tread.
///
/// What a scan on a robot shows begins some way ahead of the feet: there the robot's own ground and the
/// floor that is seen are one. A floor may lean against the treads by which the scan was levelled, by what
/// the sensor bends: the soles stand on it as it was seen. Says so where it does.
pub fn stand_before(
    stand: &mut StartState,
    robot: &Robot,
    terrain: &mut Terrain,
) -> Option<String> {
    let kinematics = Kinematics::new(robot, &stand.configuration);
    let soles = stand.patches.iter().flat_map(|&patch| {
        let patch = &robot.patches[patch];
        let X_WC = kinematics.X_WC(patch);
        let radius = patch.point_radius_m().unwrap_or(0.0);
        let corners = patch.polygon.iter();
        corners.map(move |v| (X_WC * Point3::new(v.x, v.y, 0.0), radius))
    });
    // The lowest point of a ball is what touches, and its front is its toe.
    let soles: Vec<(Point3<f64>, f64)> = soles.collect();
    let [low, high] = [f64::min, f64::max].map(|pick| {
        let across = soles.iter().map(|(p, _)| p.y);
        across.reduce(pick).unwrap_or_default()
    });
    let toes_x = soles.iter().map(|(p, radius)| p.x + radius);
    let toes_x = toes_x.fold(f64::NEG_INFINITY, f64::max);
    let height = soles.iter().map(|(p, radius)| p.z - radius);
    let height = height.fold(f64::INFINITY, f64::min);
    let lean = |face: &Face| face.normal_W().angle(&Vector3::z());
    // Where each face's edges that are ahead of the feet begin.
    let level = terrain.faces.iter().filter(|face| lean(face) < LEAN_RAD);
    let edges = level.flat_map(|face| {
        let segments = face.region.segments();
        segments.map(move |(edge, ends)| (face, edge.kind, ends.map(|p| face.point_W(p))))
    });
    let begins = edges.flat_map(|(face, kind, ends)| {
        let ahead = ahead(ends, [low, high]).into_iter().flatten();
        ahead.map(move |p| (face, kind, p))
    });
    // What begins first: a floor that is seen behind something that rises is not the one before the feet. Nothing that is
    // as high as the base, such as a table or the robot's own hands, is gone up from there.
    let base_m = stand.configuration.p_WB.z - height;
    let begins: Vec<_> = begins.collect();
    let within = |(.., p): &&(_, _, Point3<f64>)| (-HEIGHT_M..base_m).contains(&(p.z - height));
    let low_enough = begins.iter().filter(within);
    let &(first, kind, edge) = low_enough.min_by(|a, b| a.2.x.total_cmp(&b.2.x))?;
    if edge.z - height >= HEIGHT_M {
        let begins_m = match kind {
            EdgeKind::Real => edge.x,
            EdgeKind::FieldOfView | EdgeKind::Unknown => {
                let front = |face: &Face| {
                    let own = begins.iter().filter(|(of, ..)| of.id == face.id);
                    let (_, kind, p) = own.min_by(|a, b| a.2.x.total_cmp(&b.2.x))?;
                    (*kind == EdgeKind::Real).then_some(*p)
                };
                let fronts = terrain.faces.iter().filter_map(front).collect();
                flight::begins_m(&edge, fronts, height)?
            }
            _ => return None,
        };
        let by_m = begins_m - BEFORE_STEP_M - toes_x;
        if by_m <= 0.0 {
            return None;
        }
        stand.configuration.p_WB.x += by_m;
        stand.X_WG = Translation3::new(by_m, 0.0, 0.0) * stand.X_WG;
        let said = match kind {
            EdgeKind::Real => format!(
                "no floor is seen before {}: the robot starts {:.0} cm from its edge, on level ground",
                first.id,
                100.0 * BEFORE_STEP_M
            ),
            _ => format!(
                "warning: the view cuts {}, and no floor is seen before it: as deep as the treads behind it, it begins at \
                 x = {begins_m:.2} m; the robot starts {:.0} cm from there, on level ground",
                first.id,
                100.0 * BEFORE_STEP_M
            ),
        };
        if begins_m < edge.x {
            let unseen = flight::unseen_part(first, [begins_m, edge.x], height);
            terrain.obstacles.push(unseen);
        }
        return Some(said);
    }
    let floor = first;

    // Soles on z = height → soles on the floor's plane, toes before its edge.
    let n = floor.normal_W();
    let toes = Point3::new(toes_x, 0.5 * (low + high), height);
    let mut to = Point3::new(edge.x - BEFORE_M, toes.y, height);
    to.z -= floor.height_of(&to) / n.z;
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), &n)?;
    let moved = Translation3::from(to) * turn * Translation3::from(-toes.coords);
    let base = &mut stand.configuration;
    let X_WB = moved * Isometry3::from_parts(base.p_WB.into(), base.R_WB);
    (base.p_WB, base.R_WB) = (X_WB.translation.vector, X_WB.rotation);
    stand.X_WG = Isometry3::from_parts(to.into(), turn);
    let lean = lean(floor);
    (lean > NOTED_RAD).then(|| {
        format!(
            "the floor that is seen ({}) leans by {:.1}° from level: the robot starts on it",
            floor.id,
            lean.to_degrees()
        )
    })
}

/// The ends of the part of an edge that lies between two places across the way.
fn ahead([a, b]: [Point3<f64>; 2], [low, high]: [f64; 2]) -> Option<[Point3<f64>; 2]> {
    if (b.y - a.y).abs() < 1e-9 {
        return (a.y >= low && a.y <= high).then_some([a, b]);
    }
    let at = |y: f64| ((y - a.y) / (b.y - a.y)).clamp(0.0, 1.0);
    let ends = [at(low), at(high)];
    (ends[0] != ends[1]).then(|| ends.map(|t| a + t * (b - a)))
}

#[cfg(test)]
mod tests {
    use posture::Environment;
    use surfaces::Source;

    use super::*;
    use crate::scene::Start;
    use crate::start::{self, ground};

    /// A floor ahead that leans by 3.2° against the level, as in `k2_stairs_0001_depth.png`.
    fn leaning() -> Terrain {
        let pose = Isometry3::new(Vector3::new(0.9, 0.0, 0.02), Vector3::y() * -0.056);
        let floor = Face {
            source: Source::Scan,
            ..Face::rectangle("floor", pose, [1.0, 1.0]).unwrap()
        };
        Terrain {
            faces: vec![floor],
            obstacles: Vec::new(),
        }
    }

    /// Balls do not tell how the ground under them leans: it is as the floor that is seen.
    #[test]
    fn soles_and_balls_stand_on_a_floor_that_leans() {
        for name in ["hrp2", "quadruped", "hexapod"] {
            let robot = scenes::robot(name).unwrap();
            let config = posture::Config::default();
            let nothing = Environment::default();
            let mut stand = start::stand(&robot, &Start::default(), &nothing, &config).unwrap();
            let mut terrain = leaning();
            let said = stand_before(&mut stand, &robot, &mut terrain).unwrap();
            assert!(said.contains("leans by 3.2°"), "{name}: {said}");
            let config = ground::Config::default();
            let on =
                ground::add_ground(&mut terrain, &robot, (&stand, true), &config, 2.0).unwrap();
            let first = &on.contacts[0].1;
            assert!(on.contacts.iter().all(|(_, face)| face == first), "{name}");
            let kinematics = Kinematics::new(&robot, &stand.configuration);
            let face = terrain.get(first).unwrap();
            for (patch, _) in &on.contacts {
                let patch = &robot.patches[*patch];
                let touches =
                    kinematics.X_WC(patch) * Point3::from(patch.polygon[0].coords.push(0.0));
                let radius = patch.point_radius_m().unwrap_or(0.0);
                assert!((face.height_of(&touches) - radius).abs() < 1e-3, "{name}");
                let toe = touches.x + radius - (0.4 - BEFORE_M);
                assert!(toe < 1e-3, "{name}: {toe} m over the edge");
            }
        }
    }

    /// A tread whose front edge is seen, nothing of the floor before it, and some behind it.
    #[test]
    fn a_robot_stands_before_a_tread_where_the_floor_is_below_the_view() {
        let robot = scenes::robot("hrp2").unwrap();
        let config = posture::Config::default();
        let nothing = Environment::default();
        let stand = start::stand(&robot, &Start::default(), &nothing, &config).unwrap();
        let starts = |rise_m: f64, kind: EdgeKind| {
            let at = Isometry3::translation(0.9, 0.0, rise_m);
            let mut tread = Face::rectangle("tread", at, [0.15, 0.5]).unwrap();
            let edges = tread.region.edges_mut().flatten();
            edges.for_each(|edge| edge.kind = kind);
            let behind = Isometry3::translation(2.0, 0.0, 0.0);
            let floor = Face::rectangle("floor", behind, [1.0, 1.0]).unwrap();
            let mut terrain = Terrain {
                faces: vec![tread, floor],
                obstacles: Vec::new(),
            };
            let mut moved = stand.clone();
            let said = stand_before(&mut moved, &robot, &mut terrain);
            (moved.configuration.p_WB - stand.configuration.p_WB, said)
        };
        let (by, said) = starts(0.14, EdgeKind::Real);
        assert!(said.unwrap().contains("before tread"));
        assert!(
            by.x > 0.3 && by.x < 0.75 && by.y == 0.0 && by.z == 0.0,
            "{by}"
        );
        // Where the view cuts it, it may begin anywhere.
        let (by, said) = starts(0.14, EdgeKind::FieldOfView);
        assert_eq!((by, said), (Vector3::zeros(), None));
        // Under a table the robot goes to the floor that is seen.
        let (by, said) = starts(0.75, EdgeKind::Real);
        assert!(by.x > 1.2 && said.is_none(), "{by}");
    }

    /// The first of four treads, of which the view shows the farther half.
    #[test]
    fn a_robot_stands_before_a_cut_tread_where_the_flight_behind_it_says_that_it_begins() {
        let robot = scenes::robot("hrp2").unwrap();
        let (config, nothing) = (posture::Config::default(), Environment::default());
        let mut stand = start::stand(&robot, &Start::default(), &nothing, &config).unwrap();
        let (run, rise) = (0.26, 0.15);
        let treads = (0..4).map(|k| {
            let k = f64::from(k);
            let seen = if k == 0.0 { 0.5 * run } else { run };
            let at =
                Isometry3::translation(0.9 + (k + 1.0) * run - 0.5 * seen, 0.0, (k + 1.0) * rise);
            let mut tread = Face::rectangle(format!("t{k}"), at, [seen, 1.0]).unwrap();
            let edges = tread.region.edges_mut().flatten();
            let cut = EdgeKind::FieldOfView;
            edges.for_each(|edge| edge.kind = if k == 0.0 { cut } else { EdgeKind::Real });
            tread
        });
        let mut terrain = Terrain {
            faces: treads.collect(),
            obstacles: Vec::new(),
        };
        let before = stand.configuration.p_WB.x;
        let said = stand_before(&mut stand, &robot, &mut terrain).unwrap();
        assert!(said.contains("begins at x = 0.90 m"), "{said}");
        assert!(stand.configuration.p_WB.x > before + 0.4);
        // What was not seen of it is in the way, under its plane and from there on.
        let [body] = &terrain.obstacles[..] else {
            panic!("{:?}", terrain.obstacles);
        };
        let along = |pick: fn(f64, f64) -> f64| body.points_W.iter().map(|p| p.x).reduce(pick);
        let (from, to) = (along(f64::min).unwrap(), along(f64::max).unwrap());
        assert!(
            (from - 0.9).abs() < 1e-6 && (to - 1.03).abs() < 1e-6,
            "{from} to {to}"
        );
        let height = |p: &Point3<f64>| terrain.faces[0].height_of(p);
        assert!(body.points_W.iter().all(|p| height(p) < 0.0) && body.assumed);
    }
}
