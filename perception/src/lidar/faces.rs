//! Ground and slopes as faces that a robot may touch.

use nalgebra::{
    Isometry3, Matrix3, Point2, Point3, Rotation3, Translation3, UnitQuaternion, Vector2, Vector3,
};
use surfaces::outline::Outline;
use surfaces::{ConvexPolygon, Edge, EdgeKind, Face, Fit, Source};

use super::scan::{Slope, SlopeScan};
use crate::face::convex;

/// Most corners of a polygon.
pub(super) const VERTICES_MAX: usize = 16;
/// Half the footprint of a beam and half a step of it at 2 m: what an edge is off at least, m.
pub(super) const EDGE_M: f64 = 0.006;
/// Standard deviations by which uncertainty shrinks a face.
const SIGMAS: f64 = 2.0;
/// The smallest part of the ground that is kept, m².
const AREA_MIN_M2: f64 = 0.05;
/// Clearance of the ground from a slope, m.
const BESIDE_M: f64 = 0.01;

impl SlopeScan {
    /// The slopes `slope0`, … and the ground `ground0`, …, its largest part first, in W.
    ///
    /// A slope reaches from its start line, which is computed, over the hull of its points. The
    /// ground is the hull of its points and of the point below the sensor, where the robot stands and
    /// no beam reaches, less what lies under slopes.
    pub fn faces(&self) -> Vec<Face> {
        let numbered = self.slopes.iter().enumerate();
        let mut faces: Vec<Face> = numbered
            .filter_map(|(k, slope)| self.slope_face(k, slope))
            .collect();
        faces.extend(self.ground_faces(&faces));
        faces
    }

    /// A slope as a convex face, its x_F uphill.
    pub(super) fn slope_face(&self, k: usize, slope: &Slope) -> Option<Face> {
        let d = &slope.description;
        let R_WF = Matrix3::from_columns(&[d.psi_W, d.normal_W.cross(&d.psi_W), d.normal_W]);
        let X_WF = pose(&R_WF, self.X_WV * Point3::from(slope.centre_V));
        let in_F = |p: &Point3<f64>| X_WF.inverse_transform_point(p).xy();
        let mut points = self.points_in(&X_WF, &slope.members);
        let start = in_F(&d.p1_W).x.max(in_F(&d.p2_W).x);
        points.retain(|p| p.x > start);
        points.extend([in_F(&d.p1_W), in_F(&d.p2_W)]);
        let polygon = ConvexPolygon::hull(&points)
            .ok()?
            .simplified_inside(VERTICES_MAX);
        // As far as it was seen it is a slope, whatever is hidden beyond.
        let seen = [0, 1].map(|end| (!slope.hidden[end]).then_some(slope.along_sigma_m[end]));
        let along = seen.into_iter().flatten().fold(0.0, f64::max);
        let across = slope.across_sigma_m.into_iter().fold(0.0, f64::max);
        Some(Face {
            plane_covariance: Some(rows(&self.covariance_in(&X_WF, slope))),
            fit: Some(Fit {
                points: slope.members.len(),
                rms_m: slope.rms_m,
            }),
            source: Source::Scan,
            ..Face::new(
                format!("slope{k}"),
                X_WF,
                convex(&polygon, edge(EDGE_M + SIGMAS * across.max(along))),
            )
        })
    }

    /// The points of a plane with the frame F, in it.
    fn points_in(&self, X_WF: &Isometry3<f64>, members: &[u32]) -> Vec<Point2<f64>> {
        let place = |&i: &u32| Point3::from(self.points_W[i as usize].map(f64::from));
        let in_F = |p: Point3<f64>| X_WF.inverse_transform_point(&p).xy();
        members.iter().map(place).map(in_F).collect()
    }

    /// Covariance of (rotation about x_F, about y_F, offset along z_F) of a slope.
    fn covariance_in(&self, X_WF: &Isometry3<f64>, slope: &Slope) -> Matrix3<f64> {
        let R_FV = X_WF.rotation.inverse() * self.X_WV.rotation;
        let n = slope.plane_V.normal;
        // A tilt θ along t is a rotation by θ about n × t; the plane moves against its normal.
        let [a, b] = slope.tangents_V.map(|t| R_FV * n.cross(&t));
        let turn = Matrix3::new(a.x, b.x, 0.0, a.y, b.y, 0.0, 0.0, 0.0, -1.0);
        turn * slope.covariance * turn.transpose()
    }

    /// The parts of the ground that no slope stands on, which share a frame: x_F ahead, in the plane.
    fn ground_faces(&self, slopes: &[Face]) -> Vec<Face> {
        let ground = &self.ground;
        if !ground.seen {
            return Vec::new();
        }
        let n_W = self.X_WV * ground.plane_V.normal;
        let y_W = n_W.cross(&Vector3::x()).normalize();
        let R_WF = Matrix3::from_columns(&[y_W.cross(&n_W), y_W, n_W]);
        let X_WF = pose(&R_WF, ground.centre_W);
        let in_F = |p: &Point3<f64>| X_WF.inverse_transform_point(p).xy();
        let mut points = self.points_in(&X_WF, &ground.members);
        points.push(in_F(&Point3::new(0.0, 0.0, ground.centre_W.z)));
        let Ok(hull) = ConvexPolygon::hull(&points) else {
            return Vec::new();
        };
        let hull = Outline::from_polygon(&hull.simplified_inside(VERTICES_MAX));
        let under = slopes.iter().map(|slope| {
            let ahead = in_F(&(ground.centre_W + slope.X_WF.rotation * Vector3::x())).coords;
            let vertices: Vec<Point2<f64>> = slope.vertices_W().iter().map(in_F).collect();
            rectangle(&vertices, &ahead, BESIDE_M)
        });
        let left = hull.minus_all(under).without_specks(AREA_MIN_M2);
        // From W's axes to F's: both z up, the same origin.
        let R_FW = R_WF.transpose();
        let covariance = rows(&(R_FW * ground.covariance * R_FW.transpose()));
        let part = |(k, mut region): (usize, surfaces::Region)| {
            region.edges_mut().for_each(|ring| ring.fill(edge(EDGE_M)));
            Face {
                plane_covariance: Some(covariance),
                fit: Some(Fit {
                    points: ground.members.len(),
                    rms_m: ground.rms_m,
                }),
                source: Source::Scan,
                ..Face::new(format!("ground{k}"), X_WF, region)
            }
        };
        left.regions().into_iter().enumerate().map(part).collect()
    }
}

/// An edge beyond which rings tell nothing, known to `further_m`.
pub(super) fn edge(further_m: f64) -> Edge {
    Edge {
        further_m,
        ..Edge::new(EdgeKind::Unknown)
    }
}

/// The rectangle along `ahead` around the points, wider by `border_m`, counter-clockwise.
fn rectangle(points: &[Point2<f64>], ahead: &Vector2<f64>, border_m: f64) -> Vec<Point2<f64>> {
    let x = ahead.normalize();
    let axes = [x, Vector2::new(-x.y, x.x)];
    let [[left, right], [low, high]] = axes.map(|axis| {
        let [least, most] = super::surroundings::bounds(points.iter().map(|p| axis.dot(&p.coords)));
        [least - border_m, most + border_m]
    });
    let corners = [[left, low], [right, low], [right, high], [left, high]];
    let at = |[a, b]: [f64; 2]| Point2::from(axes[0] * a + axes[1] * b);
    corners.map(at).to_vec()
}

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
