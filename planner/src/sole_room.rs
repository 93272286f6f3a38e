//! Which way a sole has to be turned to have room where it lands, and whether a hand has room at all: treads and ledges
//! may be narrower than a sole is long, rails than a hand is wide.

use nalgebra::{Point2, Rotation2, Unit, Vector2, Vector3};
use posture::Area;
use surfaces::HalfPlane;

use crate::route::wrap;

/// Turns that are tried, rad, and how many to either side: up to a right angle, at which a sole is as narrow as it gets.
const TURN_RAD: f64 = std::f64::consts::FRAC_PI_2 / TURNS as f64;
const TURNS: u32 = 30;
/// A sole that sticks out by less than this may have room between two of the turns, m.
const SLACK_M: f64 = 1e-4;

/// The heading in W next to a wanted one, rad, at which a sole fits into an area with a margin, m, around it; nothing
/// where it fits at none. Of two turns that are as large the one that ends nearer to `others_rad` goes first.
pub(crate) fn heading_with_room(
    sole: &[Point2<f64>],
    area: &Area,
    margin_m: f64,
    wanted_rad: f64,
    others_rad: f64,
) -> Option<f64> {
    let fits = |heading_rad: &f64| {
        let ahead = Vector3::new(heading_rad.cos(), heading_rad.sin(), 0.0);
        let x_F = area.X_WF.inverse_transform_vector(&ahead).xy();
        let Some(x_F) = Unit::try_new(x_F, 1e-9) else {
            return true;
        };
        let turn = Rotation2::rotation_between(&Vector2::x(), &x_F);
        fits(sole, area, margin_m - SLACK_M, &turn)
    };
    let nearer = wrap(others_rad - wanted_rad);
    let side = if nearer < 0.0 { -1.0 } else { 1.0 };
    let turns = (0..=TURNS).map(|k| TURN_RAD * f64::from(k) * side);
    let headings = turns.flat_map(|turn| [wanted_rad + turn, wanted_rad - turn]);
    headings.into_iter().find(fits)
}

/// Whether a palm fits into an area with a margin, m, around it in some way; what is narrower than it by less than it sticks
/// out between two of the turns is taken for room.
pub(crate) fn has_room(palm: &[Point2<f64>], area: &Area, margin_m: f64) -> bool {
    let reach_m = palm.iter().map(|p| p.coords.norm()).fold(0.0, f64::max);
    let slack_m = SLACK_M + reach_m * (0.5 * TURN_RAD).sin();
    let mut turns = (0..4 * TURNS).map(|k| Rotation2::new(TURN_RAD * f64::from(k)));
    turns.any(|turn| fits(palm, area, margin_m - slack_m, &turn))
}

/// Whether a patch that is so turned in the area's frame fits into it with a margin, m, around it.
fn fits(patch: &[Point2<f64>], area: &Area, margin_m: f64, turn: &Rotation2<f64>) -> bool {
    // Where the patch's origin may be: in the area less what the patch reaches beyond it.
    let inside = area.polygon.half_planes().into_iter().map(|edge| {
        let beyond_m = patch.iter().map(|p| edge.n.dot(&(turn * p).coords));
        let beyond_m = beyond_m.fold(f64::NEG_INFINITY, f64::max);
        HalfPlane {
            n: edge.n,
            b: edge.b - beyond_m - margin_m,
        }
    });
    let inside: Vec<HalfPlane> = inside.collect();
    area.polygon.clip_all(&inside).is_some()
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;
    use surfaces::ConvexPolygon;

    use super::*;

    /// A strip so deep along x and 1 m long along y.
    fn tread(depth_m: f64) -> Area {
        let (x, y) = (0.5 * depth_m, 0.5);
        let corners = [[-x, -y], [x, -y], [x, y], [-x, y]].map(Point2::from);
        Area {
            X_WF: Isometry3::identity(),
            polygon: ConvexPolygon::new(corners.to_vec()).unwrap(),
            toward: None,
            yaw_rad: None,
        }
    }

    #[test]
    fn a_sole_turns_as_far_as_it_has_to_and_no_farther() {
        let sole = [[-0.11, -0.06], [0.12, -0.06], [0.12, 0.07], [-0.11, 0.07]].map(Point2::from);
        let heading = |depth_m, wanted_rad, others_rad| {
            heading_with_room(&sole, &tread(depth_m), 0.01, wanted_rad, others_rad)
        };
        // Room for 23 cm and a little more for the turn by 0.1 rad: as it was wanted.
        assert_eq!(heading(0.27, 0.1, 0.0), Some(0.1));
        // 20 cm: ahead no longer; the projection of the sole on x is 0.23 |cos θ| + 0.13 |sin θ|.
        for (others_rad, side) in [(0.8, 1.0), (-0.8, -1.0)] {
            let turned = heading(0.20, 0.0, others_rad).unwrap();
            let reach_m = |angle: f64| 0.23 * angle.cos() + 0.13 * angle.sin().abs();
            assert!(turned * side > 0.0, "{turned}");
            assert!(reach_m(turned) <= 0.18 + 2.0 * SLACK_M, "{turned}");
            assert!(reach_m(turned - side * TURN_RAD) > 0.18, "{turned}");
        }
        // Narrower than the sole is wide.
        assert_eq!(heading(0.14, 0.0, 0.0), None);
    }

    /// A rail, level or on a wall, lying any way: a palm of 6 by 12 cm has room on 9 cm, and on 6 it has none.
    #[test]
    fn a_palm_has_room_where_it_fits_in_some_way() {
        let palm = [[-0.03, -0.06], [0.03, -0.06], [0.03, 0.06], [-0.03, 0.06]].map(Point2::from);
        let wall = Isometry3::rotation(Vector3::y() * std::f64::consts::FRAC_PI_2);
        for X_WF in [Isometry3::identity(), wall] {
            for turn in [0.0, 0.31, 1.0, 2.2] {
                let turned = |depth_m: f64| {
                    let corners = tread(depth_m).polygon;
                    let corners = corners.vertices().iter().map(|p| Rotation2::new(turn) * p);
                    Area {
                        X_WF,
                        polygon: ConvexPolygon::new(corners.collect()).unwrap(),
                        ..tread(depth_m)
                    }
                };
                assert!(has_room(&palm, &turned(0.09), 0.01), "{turn}");
                assert!(!has_room(&palm, &turned(0.06), 0.01), "{turn}");
            }
        }
    }
}
