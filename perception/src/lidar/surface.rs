//! Ground and slopes as surfaces that a robot may touch.

use nalgebra::{
    Isometry3, Matrix3, Point2, Point3, Rotation3, Translation3, UnitQuaternion, Vector2, Vector3,
};
use surfaces::{ConvexPolygon, EdgeKind, HalfPlane, Source, Surface};

use super::scan::{Slope, SlopeScan};

/// Most corners of a polygon.
pub(super) const VERTICES_MAX: usize = 16;
/// Half the footprint of a beam and half a step of it at 2 m: what an edge is off at least, m.
pub(super) const EDGE_M: f64 = 0.006;
/// Standard deviations by which uncertainty shrinks a polygon.
const SIGMAS: f64 = 2.0;
/// The smallest piece of ground that is kept, m².
const AREA_MIN_M2: f64 = 0.05;
/// Clearance of the ground's pieces from a slope, m.
const BESIDE_M: f64 = 0.01;

impl SlopeScan {
    /// The slopes `slope0`, … and the ground `ground0`, … as convex surfaces in W.
    ///
    /// A slope reaches from its start line, which is computed, over the hull of its points. The
    /// ground is the hull of its points and of the point below the sensor, where the robot stands and
    /// no beam reaches; what lies under slopes is cut out of it, and the rest covered by convex pieces
    /// of one face.
    pub fn surfaces(&self) -> Vec<Surface> {
        let mut surfaces: Vec<Surface> = self
            .slopes
            .iter()
            .enumerate()
            .filter_map(|(k, slope)| self.slope_surface(k, slope))
            .collect();
        surfaces.extend(self.ground_surfaces(&surfaces));
        surfaces
    }

    #[allow(non_snake_case)]
    fn slope_surface(&self, k: usize, slope: &Slope) -> Option<Surface> {
        let d = &slope.description;
        // x_S uphill, y_S to the left of it.
        let R_WS = Matrix3::from_columns(&[d.psi_W, d.normal_W.cross(&d.psi_W), d.normal_W]);
        let X_WS = pose(&R_WS, self.X_WV * Point3::from(slope.centre_V));
        let in_S = |p: &Point3<f64>| X_WS.inverse_transform_point(p).xy();
        let mut points: Vec<Point2<f64>> = (slope.members.iter())
            .map(|&i| in_S(&Point3::from(self.points_W[i as usize].map(f64::from))))
            .collect();
        let start = in_S(&d.p1_W).x.max(in_S(&d.p2_W).x);
        points.retain(|p| p.x > start);
        points.extend([in_S(&d.p1_W), in_S(&d.p2_W)]);
        let polygon = ConvexPolygon::hull(&points)
            .ok()?
            .simplified_inside(VERTICES_MAX);
        let across = slope.across_sigma_m[0].max(slope.across_sigma_m[1]);
        let along = slope.along_sigma_m[0].max(slope.along_sigma_m[1]);
        Some(Surface {
            polygon_edges: vec![EdgeKind::Unknown; polygon.vertices().len()],
            inset_m: EDGE_M + SIGMAS * across.max(along),
            inliers: slope.members.len(),
            rms_m: slope.rms_m,
            plane_covariance: Some(rows(&self.covariance_in(&X_WS, slope))),
            source: Source::Scan,
            ..Surface::new(format!("slope{k}"), X_WS, polygon)
        })
    }

    /// Covariance of (rotation about x_S, about y_S, offset along z_S) of a slope.
    #[allow(non_snake_case)]
    fn covariance_in(&self, X_WS: &Isometry3<f64>, slope: &Slope) -> Matrix3<f64> {
        let R_SV = X_WS.rotation.inverse() * self.X_WV.rotation;
        let n = slope.plane_V.normal;
        // A tilt θ along t is a rotation by θ about n × t; the plane moves against its normal.
        let [a, b] = slope.tangents_V.map(|t| R_SV * n.cross(&t));
        let turn = Matrix3::new(a.x, b.x, 0.0, a.y, b.y, 0.0, 0.0, 0.0, -1.0);
        turn * slope.covariance * turn.transpose()
    }

    #[allow(non_snake_case)]
    fn ground_surfaces(&self, slopes: &[Surface]) -> Vec<Surface> {
        let ground = &self.ground;
        if !ground.seen {
            return Vec::new();
        }
        // x_S ahead, in the plane.
        let n_W = self.X_WV * ground.plane_V.normal;
        let y_W = n_W.cross(&Vector3::x()).normalize();
        let R_WS = Matrix3::from_columns(&[y_W.cross(&n_W), y_W, n_W]);
        let X_WS = pose(&R_WS, ground.centre_W);
        let in_S = |p: &Point3<f64>| X_WS.inverse_transform_point(p).xy();
        let mut points: Vec<Point2<f64>> = (ground.members.iter())
            .map(|&i| in_S(&Point3::from(self.points_W[i as usize].map(f64::from))))
            .collect();
        points.push(in_S(&Point3::from(Vector3::new(
            0.0,
            0.0,
            ground.centre_W.z,
        ))));
        let Ok(hull) = ConvexPolygon::hull(&points) else {
            return Vec::new();
        };

        // Less what the slopes cover.
        let mut pieces = vec![hull.simplified_inside(VERTICES_MAX)];
        for slope in slopes {
            let d = slope.X_WS.rotation * Vector3::x();
            let ahead = in_S(&(ground.centre_W + d)).coords;
            let vertices: Vec<Point2<f64>> = slope.vertices_W().iter().map(in_S).collect();
            let sides = around(&vertices, &ahead, BESIDE_M);
            pieces = pieces
                .iter()
                .flat_map(|piece| without(piece, &sides))
                .collect();
        }
        let covariance = {
            // From W's axes to S's: both z up, the same origin.
            let R_SW = R_WS.transpose();
            rows(&(R_SW * ground.covariance * R_SW.transpose()))
        };
        let mut surfaces: Vec<Surface> = pieces
            .into_iter()
            .map(|polygon| Surface {
                polygon_edges: vec![EdgeKind::Unknown; polygon.vertices().len()],
                inset_m: EDGE_M,
                inliers: ground.members.len(),
                rms_m: ground.rms_m,
                plane_covariance: Some(covariance),
                source: Source::Scan,
                face: Some("ground".to_owned()),
                ..Surface::new("", X_WS, polygon)
            })
            .collect();
        surfaces.sort_by(|a, b| b.polygon.area().total_cmp(&a.polygon.area()));
        for (k, surface) in surfaces.iter_mut().enumerate() {
            surface.id = format!("ground{k}");
        }
        surfaces
    }
}

/// The half planes whose common part is the rectangle along `ahead` around the points, wider by
/// `border_m`.
fn around(points: &[Point2<f64>], ahead: &Vector2<f64>, border_m: f64) -> [HalfPlane; 4] {
    let x = ahead.normalize();
    let y = Vector2::new(-x.y, x.x);
    [x, -x, y, -y].map(|n| HalfPlane {
        n,
        b: points
            .iter()
            .map(|p| n.dot(&p.coords))
            .fold(f64::NEG_INFINITY, f64::max)
            + border_m,
    })
}

/// The largest convex parts of a polygon outside a convex region: one beyond each of its sides. They
/// overlap, so that there is no seam that a foot could not stand on.
fn without(polygon: &ConvexPolygon, sides: &[HalfPlane]) -> Vec<ConvexPolygon> {
    if polygon.clip_all(sides).is_none() {
        return vec![polygon.clone()];
    }
    sides
        .iter()
        .filter_map(|side| polygon.clip(&side.flipped()))
        .filter(|part| part.area() >= AREA_MIN_M2)
        .collect()
}

#[allow(non_snake_case)]
fn pose(R: &Matrix3<f64>, p: Point3<f64>) -> Isometry3<f64> {
    let rotation = Rotation3::from_matrix_unchecked(*R);
    Isometry3::from_parts(
        Translation3::from(p.coords),
        UnitQuaternion::from_rotation_matrix(&rotation),
    )
}

/// A symmetric matrix, row by row.
fn rows(matrix: &Matrix3<f64>) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| (matrix[(i, j)] + matrix[(j, i)]) / 2.0))
}
